"""Numbers in another unit: what nearly surely is one is refused, what may be one is printed with what follows."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import substep as ss

SHAKEN = np.sin(0.3 * np.arange(200))


@pytest.mark.parametrize("given", [{"omega": 4 * np.pi}, {"T": 0.5}, {"f": 2.0}, {"f": 2}])
def test_omega_frequency_and_period_are_the_same_oscillator(given: dict[str, float]) -> None:
    oscillator = ss.scene("linear_oscillator", xi=0.05, u0=0.3, **given)
    assert oscillator.parameters["omega"] == pytest.approx(4 * np.pi, rel=1e-15)
    assert oscillator.period == pytest.approx(0.5, rel=1e-15)
    r = ss.march(oscillator, "fox_goodwin", dt=0.005, t_end=0.5)
    damped = 4 * np.pi * np.sqrt(1 - 0.05**2)
    exact = (
        0.3
        * np.exp(-0.05 * 4 * np.pi * r.t)
        * (np.cos(damped * r.t) + 0.05 * 4 * np.pi / damped * np.sin(damped * r.t))
    )
    assert np.abs(r.u[:, 0] - exact).max() < 1e-3


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            {"omega": 1.0, "T": 0.5},
            "exactly one of omega, rad/s, f, Hz, and T, s, of linear_oscillator, got omega and T;",
        ),
        ({"f": 2.0, "T": 0.5}, "got f and T; drop all but one"),
        ({"omega": 1.0, "f": 2.0, "T": 0.5}, "got omega and f and T; drop all but one"),
        ({}, "expected a value for omega of linear_oscillator, got none; .* T, s, or f, Hz, may stand in its place"),
        ({"T": 0.0}, "expected parameter T of linear_oscillator > 0, got 0.0"),
        ({"f": [1.0, 2.0]}, "expected one number for parameter f of linear_oscillator"),
        ({"T": 0.5, "zeta": 0.05}, "got 'zeta'; here it is xi, the damping ratio"),
        ({"T": 0.5, "xi": 5.0}, "xi of linear_oscillator as a ratio, got 5; 5 % is 0.05; if .* add overdamped=True"),
        ({"T": 0.5, "xi": 2}, "2 % is 0.02"),
    ],
)
def test_what_an_oscillator_is_not_given_by(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ss.scene("linear_oscillator", **given)


def test_other_scenes_have_no_period_to_give() -> None:
    with pytest.raises(ValueError, match="a parameter of duffing, .*got 'T'"):
        ss.scene("duffing", T=0.5)
    assert ss.scene("duffing").period is None


def test_an_overdamped_oscillator_is_said_to_be_one() -> None:
    """Up to 2, where schemes are tested, without a word."""
    assert ss.scene("linear_oscillator", T=0.5, xi=1.2).parameters["xi"] == 1.2
    strong = ss.scene("linear_oscillator", T=0.5, xi=5.0, overdamped=True)
    assert strong.parameters["xi"] == 5.0
    assert pickle.loads(pickle.dumps(strong)) == strong
    assert ss.sweep(strong, "bathe", dt=0.1, t_end=1.0, u0=[1.0, 2.0]).sizes["u0"] == 2
    with pytest.raises(ValueError, match="a parameter of duffing"):
        ss.scene("duffing", overdamped=True)


@pytest.mark.parametrize("degrees", [30, -45.5, 90.0])
def test_an_angle_in_degrees_is_asked_about(degrees: float) -> None:
    size = abs(degrees)
    answer = (
        f"u0 of simple_pendulum in rad, within a turn, got {size:g}; {size:g} degrees are {np.pi * size / 180:.5g} rad"
    )
    with pytest.raises(ValueError, match=answer):
        ss.scene("simple_pendulum", u0=degrees)
    with pytest.raises(ValueError, match="within a turn"):
        ss.sweep("simple_pendulum", "bathe", dt=0.1, t_end=1.0, u0=[0.1, degrees])
    ss.scene("simple_pendulum", u0=np.deg2rad(degrees))


def test_an_angle_within_a_turn_is_taken_and_others_mean_the_same() -> None:
    """What the message says of whole turns: the pendulum's motion is the same."""
    with pytest.raises(ValueError, match="and 7 rad are 0.71681 rad but for whole turns"):
        ss.scene("simple_pendulum", u0=7.0, v0=0.1)
    ss.scene("simple_pendulum", u0=-2 * np.pi)
    ss.scene("simple_pendulum", u0=2 * np.pi)
    near, turned = (ss.scene("simple_pendulum", u0=u0, v0=0.1) for u0 in (0.7 - 2 * np.pi, 0.7))
    first, second = (ss.march(s, "bathe", dt=0.1, t_end=5.0) for s in (near, turned))
    assert np.allclose(first.u + 2 * np.pi, second.u, rtol=0.0, atol=1e-9)


def test_a_phase_of_whole_degrees_is_asked_about() -> None:
    with pytest.raises(ValueError, match="expected phase in rad, within a turn, got 90; 90 degrees are 1.5708 rad"):
        ss.Harmonic(1.0, 2.0, phase=90)
    assert ss.Harmonic(1.0, 2.0, phase=-2.0 * 7.3).phase == -14.6  # a delay of 7.3 s
    assert ss.Harmonic(1.0, 2.0, phase=3).phase == 3


@pytest.mark.parametrize("dt", [5.0, 10, 100.0])
def test_a_step_of_a_ground_motion_in_milliseconds_is_asked_about(dt: float, tmp_path: Path) -> None:
    answer = f"in s, got {dt:g}; {dt:g} ms are {dt / 1000:g} s, {dt:g} samples a second are dt = {1 / dt:g}"
    alone, columns = tmp_path / "alone.txt", tmp_path / "columns.txt"
    np.savetxt(alone, SHAKEN)
    np.savetxt(columns, np.column_stack([dt * np.arange(200), SHAKEN]))
    for call in (
        lambda: ss.response_spectrum(SHAKEN, dt=dt),
        lambda: ss.response_spectrum_rotated(SHAKEN, SHAKEN, dt=dt),
        lambda: ss.intensity(SHAKEN, dt=dt),
        lambda: ss.read_record(alone, dt=dt),
        lambda: ss.read_record(columns),
        lambda: ss.response_spectrum(columns),
        lambda: ss.response_spectrum(ss.Record(dt, SHAKEN)),
    ):
        with pytest.raises(ValueError, match=answer):
            call()
    meant = ss.Record(dt, SHAKEN, unit="m/s^2")  # as the message says
    assert ss.response_spectrum(meant, periods=[200.0]).dt == dt


@pytest.mark.parametrize(("scale", "reading"), [(981.0, "1 g in cm/s\\^2"), (1e-5, "1e-05 g in g")])
def test_an_array_whose_unit_cannot_be_m_per_s_2_is_asked_about(scale: float, reading: str) -> None:
    record = scale * SHAKEN / np.abs(SHAKEN).max()
    for given in ({"record": record, "dt": 0.02}, {"record": ss.Record(0.02, record)}):
        with pytest.raises(ValueError, match=f"the record: expected the unit of accelera.*{reading}.*ss.Record"):
            ss.response_spectrum(**given)
        assert ss.response_spectrum(**given, unit="m/s^2", periods=[1.0]).unit == "m/s^2"
    assert ss.intensity(record, dt=0.02, unit="cm/s^2").pga == pytest.approx(0.01 * scale)


SHAKEN_FOR_4_S = ss.Record(0.02, SHAKEN)


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.matrix
@pytest.mark.parametrize(
    ("load", "dt", "what"),
    [
        (SHAKEN_FOR_4_S, 5.0, "the whole record, 3.98 s"),
        (ss.HalfSine(1.0, 0.5), 1.0, "the whole pulse, 0.5 s"),
        (ss.Harmonic(1.0, -2.0), 2.0, "half the period of the load, 1.571 s"),
        (ss.Step(1.0), 2.0, "half the period of the oscillator, 0.5236 s"),
        (SHAKEN_FOR_4_S, 2.0, "half the period of the oscillator, 0.5236 s"),
    ],
)
def test_a_step_that_passes_over_what_it_is_to_follow_is_read_in_milliseconds(load: Any, dt: float, what: str) -> None:
    answer = rf"dt = {dt:g} s is longer than {what}, so that .* take a shorter one: {dt:g} ms are dt = {dt / 1000:g}$"
    oscillator = ss.scene("linear_oscillator", omega=6.0, load=load)
    with pytest.warns(UserWarning, match=answer):
        ss.march(oscillator, "bathe", dt=dt, t_end=10 * dt)
    ss.march(oscillator, "bathe", dt=0.1, t_end=1.0)
    ss.march(oscillator, "bathe", tol=1e-3, t_end=1.0)
    if "oscillator" not in what:
        frame = ss.structure(np.eye(2), np.diag([4.0, 9.0]), load=[([1.0, 0.0], load)])
        for model in (frame, frame.modes(2)):
            with pytest.warns(UserWarning, match=answer):
                ss.march(model, "bathe", dt=dt, t_end=10 * dt, account=False)
            ss.march(model, "bathe", dt=0.1, t_end=1.0, account=False)


def test_a_short_step_is_not_read_in_milliseconds_and_a_free_oscillator_may_have_any() -> None:
    pulsed = ss.scene("linear_oscillator", omega=2.0, load=ss.HalfSine(1.0, 0.01))
    with pytest.warns(UserWarning, match=r"dt = 0.02 s is longer than the whole pulse, 0.01 s, .* a shorter one$"):
        ss.march(pulsed, "bathe", dt=0.02, t_end=1.0)
    ss.march(ss.scene("linear_oscillator", omega=2.0), "bathe", dt=1e3, t_end=1e4)


def test_where_nothing_can_be_decided_what_is_printed_shows_it() -> None:
    """A step in ms, and an omega that was a frequency in Hz."""
    in_ms = ss.march(ss.scene("linear_oscillator", omega=6.0), "bathe", dt=10.0, t_end=100.0)
    assert "T=1.0472 s" in repr(in_ms.scene)
    assert "11 rows to t = 100 s, 0.105 rows a period, completed" in repr(in_ms)
    in_s = ss.march(ss.scene("linear_oscillator", f=2.0), "bathe", dt=0.01, t_end=1.0)
    assert "50 rows a period" in repr(in_s)
    assert "rows a period" not in repr(ss.march("duffing", "bathe", dt=0.1, t_end=1.0))
    assert "T=3.1416 s" in repr(ss.Harmonic(1.0, 2.0, 0.5))
