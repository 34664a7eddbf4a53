"""Sweeps: every point equals a march of its own, whatever is swept, kept, stopped, resumed or sent to a cluster."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

import substep as ss
from substep.core.response import Response
from substep.sweeps.scene_plan import ScenePlan

RNG = np.random.default_rng(11)
LOAD = ss.Harmonic(1.0, 3.0, 0.2)
OSCILLATOR: dict[str, Any] = {
    "dt": [0.1, 0.05], "t_end": 1.0, "scene_omega": [1.0, 4.0, 9.0], "xi": [0.0, 0.1], "gamma_t": [0.2, 0.4],
    "amplitude": [1.0, 2.0], "load": LOAD,
}  # fmt: skip
PENDULUM: dict[str, Any] = {"dt": 0.05, "t_end": 0.5, "EA": [1e3, 1e4, 1e5], "gamma_t": [0.3, 0.4, 0.5, 0.6]}
KEEPS = [{"keep": "final"}, {"keep": "peak"}, {"keep": "history", "samples": 5}]


def points(found: xr.Dataset, number: int) -> list[dict[str, float]]:
    """Random points of a sweep, as coordinates on its axes."""
    axes = [str(name) for name in found["status"].dims]
    return [{name: float(RNG.choice(found[name].values)) for name in axes} for _ in range(number)]


def agrees(found: xr.Dataset, r: Response, n: int, keep: str) -> None:
    """Assert that a point of a sweep equals the march of its own."""
    done = len(r.newton_iterations)
    assert found["n_done"] == done
    meanings = dict(
        zip(found["status"].attrs["flag_values"], found["status"].attrs["flag_meanings"].split(), strict=True)
    )
    assert meanings[int(found["status"])] == r.status
    kept = {"u": r.u, "v": r.v, "a": r.a, "energy": r.energy[:, None]}
    for name, rows in kept.items():
        size = np.abs(rows).max(axis=0)
        if keep == "peak":
            expected = size if name != "energy" or "peak_energy" in found else None
            swept = found.get(f"peak_{name}")
        elif keep == "final":
            expected, swept = rows[-1] if done == n else np.full(rows.shape[1], np.nan), found[name]
        else:
            swept = found[name]
            stride = n // (swept.sizes["t"] - 1)
            expected = np.full((n // stride + 1, rows.shape[1]), np.nan)
            expected[: done // stride + 1] = rows[::stride]
        if expected is not None:
            assert swept is not None
            finite = np.isfinite(size).all()  # the energy is inf before u is
            close = {"rtol": 0.0, "atol": 1e-11 * np.max(size)} if finite else {"rtol": 1e-11, "atol": 0.0}
            assert np.allclose(np.ravel(swept.values), np.ravel(expected), equal_nan=True, **close)
    if done:
        assert np.allclose(found["newton_iterations"], r.newton_iterations.mean(axis=0))
        assert (found["newton_most"] == r.newton_iterations.max(axis=0)).all()


@pytest.mark.parametrize("more", [*KEEPS, *({**keep, "energy_bound": 8.5} for keep in KEEPS)], ids=str)
def test_oscillators_are_as_each_alone(more: dict[str, Any]) -> None:
    found = ss.sweep("linear_oscillator", "newmark_bdf2", **OSCILLATOR, **more)
    assert found["status"].dims == ("dt", "scene_omega", "xi", "gamma_t", "amplitude")
    for at in points(found, 12):
        load = ss.Harmonic(at["amplitude"], 3.0, 0.2)
        scene = ss.scene("linear_oscillator", omega=at["scene_omega"], xi=at["xi"], load=load)
        s = ss.scheme("newmark_bdf2", gamma_t=at["gamma_t"])
        r = ss.march(scene, s, at["dt"], 1.0, energy_bound=more.get("energy_bound"))
        agrees(found.sel(at), r, round(1.0 / at["dt"]), more["keep"])


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("keep", KEEPS, ids=str)
def test_pendulums_are_as_each_alone(keep: dict[str, Any]) -> None:
    found = ss.sweep("elastic_pendulum", "newmark_bdf2", **PENDULUM, v0=7.0, **keep)
    assert found["status"].dims == ("EA", "gamma_t")
    assert found["coordinate"].values.tolist() == ["x", "y"]
    for at in points(found, 4):
        scene, s = ss.scene("elastic_pendulum", EA=at["EA"], v0=7.0), ss.scheme("newmark_bdf2", gamma_t=at["gamma_t"])
        agrees(found.sel(at), ss.march(scene, s, 0.05, 0.5), 10, keep["keep"])


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("scheme", ["houbolt", "backward_euler"])
@pytest.mark.parametrize("keep", KEEPS, ids=str)
def test_schemes_begun_by_another_and_without_an_acceleration(scheme: str, keep: dict[str, Any]) -> None:
    start = [1.0, 2.0]  # not what the equation of motion gives
    both = {"dt": [0.05, 0.02], "t_end": 0.2, **keep} | ({"samples": 2} if "samples" in keep else {})
    found = ss.sweep("elastic_pendulum", scheme, EA=[1e3, 1e4], a0=start, **both)
    for at in points(found, 3):
        scene = ss.scene("elastic_pendulum", EA=at["EA"], a0=start)
        agrees(found.sel(at), ss.march(scene, ss.scheme(scheme), at["dt"], 0.2), round(0.2 / at["dt"]), keep["keep"])


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("keep", [{"keep": "final"}, {"keep": "peak"}], ids=str)
def test_a_run_that_ends_before_the_scheme_of_the_first_steps(keep: dict[str, Any]) -> None:
    """Houbolt's scheme takes over after two steps: a run of one step has the results of that step alone."""
    for n in (1, 2, 3):
        found = ss.sweep("elastic_pendulum", "houbolt", dt=0.1, t_end=0.1 * n, EA=[1e3, 1e4], **keep)
        for EA in found["EA"].values:
            r = ss.march(ss.scene("elastic_pendulum", EA=EA), ss.scheme("houbolt"), 0.1, 0.1 * n)
            assert len(r.newton_iterations) == n
            agrees(found.sel(EA=EA), r, n, keep["keep"])


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("keep", KEEPS, ids=str)
def test_runs_that_fail_end_alone(keep: dict[str, Any]) -> None:
    """The trapezoidal rule on the stiff pendulum gains energy; Newton's iteration fails in some."""
    call: dict[str, Any] = {"dt": 0.1, "t_end": 4.0, "energy_bound": 1e3, **keep}
    found = ss.sweep("elastic_pendulum", "average_acceleration", EA=[1e3, 1e6, 1e10], **call)
    assert found["status"][0] == 0
    assert found["status"][1:].all()
    for EA in found["EA"].values:
        r = ss.march(ss.scene("elastic_pendulum", EA=EA), ss.scheme("average_acceleration"), 0.1, 4.0, energy_bound=1e3)
        agrees(found.sel(EA=EA), r, 40, keep["keep"])


@pytest.mark.parametrize("keep", KEEPS, ids=str)
def test_oscillators_that_overflow(keep: dict[str, Any]) -> None:
    found = ss.sweep("linear_oscillator", "central_difference", dt=50.0, t_end=50.0 * 400, omega=[0.01, 1.0], **keep)
    assert found["status"].values.tolist() == [0, 2]
    for omega in found["omega"].values:
        r = ss.march(ss.scene("linear_oscillator", omega=omega), ss.scheme("central_difference"), 50.0, 50.0 * 400)
        agrees(found.sel(omega=omega), r, 400, keep["keep"])


def test_a_family_is_an_axis_and_defaults_follow() -> None:
    scene, rho = ss.scene("linear_oscillator", omega=5.0), [0.0, 0.5, 1.0]
    named = ss.sweep(scene, "generalized_alpha", dt=0.1, t_end=1.0, rho_inf=rho)
    handle = ss.sweep(scene, ss.scheme("generalized_alpha", rho_inf=0.2), dt=0.1, t_end=1.0, rho_inf=rho)
    xr.testing.assert_identical(named, handle)
    for x in rho:
        agrees(named.sel(rho_inf=x), ss.march(scene, ss.scheme("generalized_alpha", rho_inf=x), 0.1, 1.0), 10, "final")
    assert "scheme_beta" not in named.attrs
    kept = ss.sweep(scene, ss.scheme("generalized_alpha", beta=0.4), dt=0.1, t_end=1.0, rho_inf=rho)
    assert kept.attrs["scheme_beta"] == 0.4
    for x in rho:
        alone = ss.scheme("generalized_alpha", beta=0.4, rho_inf=x)
        agrees(kept.sel(rho_inf=x), ss.march(scene, alone, 0.1, 1.0), 10, "final")
    found = ss.sweep(scene, ss.scheme("newmark_bdf2"), dt=0.1, t_end=1.0, gamma_t=[0.3], gamma=[0.5, 0.7])
    alone = ss.scheme("newmark_bdf2", gamma_t=0.3, gamma=0.7)
    agrees(found.sel(gamma_t=0.3, gamma=0.7), ss.march(scene, alone, 0.1, 1.0), 10, "final")


def test_names_and_numbers() -> None:
    """A number makes no dimension; names take prefixes; handles keep their start; attributes hold what was fixed."""
    by_name = ss.sweep(
        "linear_oscillator", "newmark", dt=0.1, t_end=1.0, scene_omega=4.0, load_omega=[1.0, 2.0], load=LOAD, a0=[1.0]
    )
    scene = ss.scene("linear_oscillator", omega=3.0, load=LOAD, a0=1.0)
    by_handle = ss.sweep(scene, ss.scheme("newmark"), dt=0.1, t_end=1.0, load_omega=[1.0, 2.0], scene_omega=4.0)
    assert by_name.identical(by_handle.assign_attrs(scene_a0=[1.0]))
    assert by_name["u"].dims == ("load_omega", "coordinate")
    alone = ss.scene("linear_oscillator", omega=4.0, load=ss.Harmonic(1.0, 2.0, 0.2), a0=1.0)
    agrees(by_name.sel(load_omega=2.0), ss.march(alone, ss.scheme("newmark"), 0.1, 1.0), 10, "final")
    one = ss.sweep(alone, "newmark", dt=0.1, t_end=1.0)
    assert one["status"].dims == ()
    xr.testing.assert_allclose(one["u"], by_name["u"].sel(load_omega=2.0, drop=True), rtol=1e-14)  # alone; a lane
    assert by_name.attrs["scheme_beta"] == 0.25
    assert "load_omega" not in by_name.attrs
    assert by_name["u"].attrs == {"units": "m", "long_name": "displacement at t_end"}
    strain = ss.sweep("linear_oscillator", "newmark", dt=[0.1, 0.2], t_end=1.0, omega=[])
    assert strain["u"].shape == (2, 0, 1)


def test_the_start_follows_the_parameters() -> None:
    """The consistent acceleration, and a start that is a function of parameters, also where a handle is swept."""
    found = ss.sweep(
        ss.scene("linear_oscillator", omega=1.0), "bathe", dt=0.1, t_end=1.0, keep="history", omega=[2.0], u0=[1.0, 3.0]
    )
    assert found["a"].sel(omega=2.0).isel(t=0).values.ravel().tolist() == [-4.0, -12.0]
    assert found["t"].values == pytest.approx(np.arange(11) * 0.1)
    assert found["t"].attrs["units"] == "s"


STEPS: dict[str, Any] = {"dt": 0.1, "t_end": 1.0}


def sweep(**more: Any) -> xr.Dataset:
    return ss.sweep("linear_oscillator", "newmark", **{**STEPS, "omega": [1.0, 2.0], **more})


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sweep(omga=[1.0]), "got 'omga'; did you mean 'omega'"),
        (lambda: sweep(load=LOAD), "write scene_omega or load_omega"),
        (lambda: sweep(scene_omega=[1.0]), "expected omega of the scene once, got omega and scene_omega"),
        (lambda: sweep(omega=[[1.0]]), r"a number or a row of them, got shape \(1, 1\)"),
        (lambda: sweep(omega=[1.0, -2.0]), r"omega of linear_oscillator in \(0.0, inf\), got -2.0"),
        (lambda: sweep(omega=[1.0, np.nan]), r"finite, got nan at index \(1,\)"),
        (lambda: sweep(omega="much"), "real number"),
        (lambda: sweep(gamma=[0.5, -1.0]), r"gamma of newmark in \[0.0, inf\), got -1.0"),
        (lambda: sweep(dt=[0.1, 0.3]), "multiple of dt = 0.3, got 1; the nearest are 0.9 and 1.2"),
        (lambda: sweep(dt=[0.1, -0.1]), r"dt in \(0.0, inf\), got -0.1"),
        (lambda: sweep(dt=0.0), "dt > 0"),
        (lambda: sweep(t_end=[1.0, 2.0]), "one number for t_end"),
        (lambda: sweep(dt=[0.1, 0.05], keep="history"), "samples=N .* so that 10 is the finest"),
        (
            lambda: sweep(dt=[0.1, 0.05], keep="history", samples=4),
            "got 10 steps for dt = 0.1; take samples = 2 or 5, or dt = 0.0833333333333 or 0.125",
        ),
        (lambda: sweep(samples=4), "keep='history' only"),
        (lambda: sweep(keep="history", samples=2.0), "whole number of intervals"),
        (lambda: sweep(keep="peaks"), "did you mean 'peak'"),
        (lambda: sweep(load=ss.HalfSine(1.0, 1.0), duration=[1.0, 0.0]), "duration > 0, got 0.0"),
        (lambda: sweep(load=ss.Record(0.1, [1.0, 2.0]), load_dt=[0.1]), "got 'load_dt'"),
        (lambda: ss.sweep("linear_oscillator", "newmark", dt=0.1, t_end=1.0), "a value for omega"),
        (lambda: ss.sweep(ss.scene("duffing"), "newmark", **STEPS, a0=0.0), "expected a0 in the scene's handle"),
        (lambda: ss.sweep("duffing", ss.scheme("newmark", beta=[0.2, 0.3]), **STEPS), "give it as an axis"),
        (lambda: ss.sweep("duffing", "generalized_alpha", alpha_m=0.3, rho_inf=[0.5], **STEPS), "through a family"),
        (lambda: ss.sweep("duffing", "newmark", **STEPS, load=LOAD), "expected no load for duffing"),
        (lambda: sweep(client="me"), "synchronous dask.distributed.Client"),
    ],
)  # fmt: skip
def test_wrong_input_says_what_was_expected_and_the_cure(
    call: Any, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ScenePlan, "run", None)  # nothing is run before
    with pytest.raises(ValueError, match=message):
        call()


def test_a_handle_changed_by_hand_is_refused() -> None:
    from dataclasses import replace

    changed = replace(ss.scene("linear_oscillator", omega=1.0), u0=np.array([5.0]))
    with pytest.raises(ValueError, match=r"u0 = \[1.\], got \[5.\]; set parameters"):
        ss.sweep(changed, "newmark", dt=0.1, t_end=1.0)


@pytest.mark.usefixtures("uncompiled")
def test_accelerations_end_where_a_run_ends() -> None:
    """Of a scheme without its own: what does not depend on u and v stood in rows after the end."""
    call: dict[str, Any] = {"dt": 0.05, "t_end": 3.0, "v0": [1.0, 5.0], "energy_bound": 10.0}
    ds, last, peak = (
        ss.sweep("rigid_pendulum", "energy_momentum", keep=keep, **call) for keep in ("history", "final", "peak")
    )
    for k, v0 in enumerate(call["v0"]):
        r = ss.march(ss.scene("rigid_pendulum", v0=v0), "energy_momentum", 0.05, 3.0, energy_bound=10.0)
        n = len(r.t)
        assert np.allclose(ds.a[k, :n], r.a, rtol=1e-9, atol=1e-9)
        assert np.isnan(ds.a[k, n:]).all()
        assert np.isnan(last.a[k]).all() == (r.status != "completed")
        assert np.allclose(peak.peak_a[k], np.abs(r.a).max(axis=0), rtol=1e-9, atol=1e-9)
