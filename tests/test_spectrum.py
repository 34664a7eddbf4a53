"""Response spectra: against exact responses of others, the filter against the march, and what cannot be had."""

import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from declared import OWN, UNDAMPED
from mpmath import mp
from plain_kernels import uncompiled as plain
from scipy.integrate import solve_ivp
from scipy.signal import StateSpace, lfilter, lsim
from substep_derive.emit.filter_module import filter_module
from substep_derive.emit.march_module import march_module
from substep_derive.kernels.march_shape import shape_of

import substep as ss
from substep.exact.oscillator import exact_peaks, increments
from substep.ground_motion import spectrum
from substep.ground_motion.peaks import at_rest
from substep.marching import digital_filter, linear
from substep.marching.linear import march_linear

Array = np.ndarray
GENERATED = Path(__file__).parents[1] / "generated" / "substep_kernels"
DT = 0.01


@cache
def motion(n: int = 400, dt: float = DT) -> Array:
    """Ground acceleration (n,) in m/s^2: noise through the soil's resonance at 2.5 Hz, in an envelope; starts at 0."""
    noise = np.random.default_rng(1940).normal(size=n)
    a, b = 2 * np.exp(-0.3 * 16 * dt) * np.cos(16 * dt), -np.exp(-0.6 * 16 * dt)
    t = np.arange(n) / n
    return np.sin(np.pi * t) ** 2 * lfilter([1.0, -1.0], [1.0, -a, -b], noise)


def exact_by_scipy(T: float, xi: float, f: Array, dt: float = DT) -> Array:
    """Largest |u|, |v|, |absolute acceleration| at the samples, by lsim, exact for a load linear between them."""
    w = 2 * np.pi / T
    system = StateSpace([[0.0, 1.0], [-(w**2), -2 * xi * w]], [[0.0], [-1.0]], np.eye(2), np.zeros((2, 1)))
    _, y, _ = lsim(system, f, dt * np.arange(len(f)))
    return np.abs([*y.T, w**2 * y[:, 0] + 2 * xi * w * y[:, 1]]).max(axis=1)


def test_the_exact_map_against_50_digits() -> None:
    Omega = np.concatenate([np.geomspace(1e-4, 1e3, 8), 10.0 ** np.random.default_rng(3).uniform(-4, 3, 6)])
    for damping in (0.0, 0.05, 1 - 1e-9, 1.0, 1 + 1e-9, 5.0):
        D, B = increments(Omega, np.full(len(Omega), damping))
        for x, d, b in zip(Omega.tolist(), D, B, strict=True):
            with mp.workdps(50):
                halvings = 20 + int(np.ceil(np.log2(1 + x * x)))
                M = mp.matrix(
                    [[0, 1, 0, 0], [-(mp.mpf(x) ** 2), -2 * mp.mpf(damping) * x, 1, 0], [0, 0, 0, 1], [0] * 4]
                )
                E = mp.expm(M / 2**halvings, method="taylor")
                for _ in range(halvings):
                    E = E * E
                E = np.array((E - mp.eye(4)).tolist()).reshape(4, 4)
            exact, load = E[:2, :2], np.stack([E[:2, 2] - E[:2, 3], E[:2, 3]], axis=1)
            amplitude = np.array([[1, 1 / x], [x, 1]]) if x > 1 else 0.0
            loaded = np.array([[1 / x**2], [1 / x]]) if x > 1 else 0.0
            scale = 1 + (1 + damping) * x
            for mine, true, size in ((d, exact, amplitude), (b, load, loaded)):
                off = np.abs((mine - true).astype(float)) / np.maximum(np.abs(true.astype(float)), size)
                assert off.max() < 1.5e-15 * scale, (damping, x)


@pytest.mark.parametrize("damping", [0.0, 0.05, 1.0, 1.7])
@pytest.mark.parametrize("offset", [0.0, 0.7], ids=["from 0", "from a jump"])
def test_exact_peaks_are_those_of_scipy_and_of_30_digits(damping: float, offset: float) -> None:
    T, f = np.array([0.0047, 0.021, 0.3, 2.0, 40.0]), motion() + offset
    found = exact_peaks(2 * np.pi / T, np.full(len(T), damping), ss.Record(DT, f))
    by_scipy = np.array([exact_by_scipy(t, damping, f) for t in T.tolist()]).T
    assert np.allclose(found / by_scipy, 1.0, rtol=0, atol=1e-10)
    for t, mine in zip(T.tolist(), found.T, strict=True):
        with mp.workdps(40):
            w = 2 * mp.pi / mp.mpf(t)
            x = mp.mpf(damping)
            A = mp.matrix([[0, 1, 0, 0], [-w * w, -2 * x * w, 1, 0], [0, 0, 0, 1 / mp.mpf(DT)], [0, 0, 0, 0]])
            E, y, peak = mp.expm(A * mp.mpf(DT) / 2**12, method="taylor"), mp.zeros(4, 1), [mp.mpf(0)] * 3
            for _ in range(12):
                E = E * E
            for before, after in zip(f[:-1].tolist(), f[1:].tolist(), strict=True):
                y[2], y[3] = before, mp.mpf(after) - before
                y = E * y
                now = (abs(y[0]), abs(y[1]), abs(w * w * y[0] + 2 * x * w * y[1]))
                peak = [max(pair) for pair in zip(peak, now, strict=True)]
        off = [abs(float(p / q - 1)) for p, q in zip(mine.tolist(), peak, strict=True)]
        assert max(off) < 1e-12 * max(1.0, 2 * np.pi * DT / t), (t, off)


def test_the_spectrum_is_a_dataset_that_tells_units_and_errors() -> None:
    f, T = motion(), np.array([0.1, 0.5, 1.0, 3.0])
    bathe = ss.scheme("newmark_bdf2", gamma_t=0.5, beta=0.25, gamma=0.5)
    s = ss.response_spectrum(f, DT, T, [0.02, 0.05], bathe)
    assert dict(s.sizes) == {"xi": 2, "period": 4}
    assert s.displacement.dims == ("xi", "period")
    assert s.attrs == {
        "scheme": "newmark_bdf2", "parameters": "gamma_t = 0.5, beta = 0.25, gamma = 0.5", "dt": DT, "samples": 400,
        "unit": "m/s^2",
        "source": "array", "unstable": 0, "good_from": 0.5,
    }  # fmt: skip
    assert {name: s[name].units for name in s.variables} == {
        "displacement": "m", "velocity": "m s-1", "acceleration": "m s-2", "pseudo_velocity": "m s-1",
        "pseudo_acceleration": "m s-2", "displacement_error": "1", "velocity_error": "1", "acceleration_error": "1",
        "period": "s", "xi": "1",
    }  # fmt: skip
    assert all("long_name" in s[name].attrs for name in s.variables)
    for i, damping in enumerate((0.02, 0.05)):
        exact = np.array([exact_by_scipy(t, damping, f) for t in T.tolist()]).T
        for name, true in zip(spectrum.QUANTITIES, exact, strict=True):
            reported = s[name].to_numpy()[i] / (1 + s[f"{name}_error"].to_numpy()[i])
            assert np.allclose(reported / true, 1.0, rtol=0, atol=1e-10)
    assert np.allclose(s.pseudo_velocity, s.displacement * 2 * np.pi / T, rtol=1e-15)
    assert np.allclose(s.pseudo_acceleration, s.displacement * (2 * np.pi / T) ** 2, rtol=1e-15)
    alone = ss.response_spectrum(f, DT, T, 0.02, "bathe", errors=False)
    assert alone.displacement.dims == ("period",)
    assert float(alone.xi) == 0.02
    assert np.allclose(alone.acceleration, s.acceleration[0], rtol=1e-12)
    assert not [name for name in alone.variables if str(name).endswith("error")]
    assert "good_from" not in alone.attrs
    assert ss.response_spectrum(f, DT).sizes["period"] == 200


def test_an_integrator_that_knows_nothing_of_steps_finds_the_same() -> None:
    f, T, damping = motion(), 0.8, 0.05
    w, t = 2 * np.pi / T, DT * np.arange(400)
    run = solve_ivp(
        lambda time, y: (y[1], -(w**2) * y[0] - 2 * damping * w * y[1] - np.interp(time, t, f)),
        (0.0, t[-1]), (0.0, 0.0), "DOP853", t, rtol=1e-10, atol=1e-14, max_step=DT,
    )  # fmt: skip
    s = ss.response_spectrum(f, DT, [T], damping)
    exact = s.displacement / (1 + s.displacement_error)
    assert np.isclose(exact, np.abs(run.y[0]).max(), rtol=1e-7)


def test_the_error_is_of_the_schemes_order() -> None:
    """A record twice as fine, linear between the same samples: the trapezoidal rule's error falls by four."""
    coarse = motion()
    errors = []
    for times in (8, 16):
        fine = np.interp(np.arange(399 * times + 1) / times, np.arange(400), coarse)
        errors.append(ss.response_spectrum(fine, DT / times, [0.31, 0.9, 2.0]).displacement_error.to_numpy())
    assert np.allclose(errors[0] / errors[1], 4.0, rtol=0.1)


@pytest.fixture
def uncompiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every kernel of a scheme's peaks as plain Python."""

    @cache
    def module(name: str) -> Any:
        return plain((GENERATED / f"{name.replace('.', '/')}.py").read_text(encoding="utf-8"))

    @cache
    def march(name: str, K: int, in_single: bool) -> tuple[object, object, int]:
        assert not in_single
        kernels = plain(march_module(shape_of(name), (2, 4, 6, 8, 10)))
        return getattr(kernels, f"march_{K}"), getattr(kernels, f"run_{K}"), kernels.WIDTH

    filters = plain(filter_module())
    monkeypatch.setattr(sys.modules["substep.core.kernel_modules"], "committed", module)
    monkeypatch.setattr(linear, "_kernels", march)
    monkeypatch.setattr(digital_filter, "_kernel", lambda d, k: (getattr(filters, f"peaks_{d}_{k}"), filters.WIDTH))


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("offset", [0.0, 0.5], ids=["from 0", "from 0.5"])
@pytest.mark.parametrize("name", OWN)
def test_peaks_are_those_of_histories(name: str, offset: float) -> None:
    """By the digital filter where there is one, which needs a first sample of 0, else by a march without histories."""
    s, load = ss.scheme(name), ss.Record(DT, motion(31) + offset)
    xi = np.array([0.0, 0.05, 0.3, 0.05]) * (name not in UNDAMPED)
    omega = 2 * np.pi / np.array([5.0, 1.0, 0.4, 2.0]) * (1.0 if name != "forward_euler" else 0.1)
    o = at_rest(omega, xi, load)
    for lanes in (o, o.lane(1)):
        with np.errstate(all="ignore"):  # a block's unused lanes
            u, v, _ = march_linear(s, lanes, 30, load).out.transpose(1, 0, 2)
            found = march_linear(s, lanes, 30, load, keep="peak_absolute").peak
            filtered = digital_filter.peaks_from_rest(s, lanes, 30, load, 3, absolute=True)
        expected = [np.abs(x).max(axis=0) for x in (u, v, 2.0 * lanes.xi * lanes.omega * v + lanes.omega**2 * u)]
        assert np.allclose(found / expected, 1.0, rtol=0, atol=1e-11)
        if offset == 0.0 and filtered is None:
            outside = (s.stencil() < 0).any() or (s.stencil() > 1).any()  # of a step's ends
            larger = len(s.state) > 3 or max(lag for _, lag in s.history) >= 1  # several steps, an auxiliary state
            assert name in ("chang", "gsse") or larger or outside
        assert offset == 0.0 or filtered is None


@pytest.mark.usefixtures("plain_marches")
def test_schemes_and_records_without_a_filter() -> None:
    f, T = motion(), [0.2, 1.0]
    for scheme, record in (("houbolt", f), ("average_acceleration", f + 0.5), ("bathe", f - 1.0)):
        s = ss.response_spectrum(record, DT, T, scheme=scheme)
        exact = np.array([exact_by_scipy(t, 0.05, record) for t in T]).T
        for name, true in zip(spectrum.QUANTITIES, exact, strict=True):
            assert np.allclose(s[name] / (1 + s[f"{name}_error"]), true, rtol=1e-10)
            assert np.abs(s[f"{name}_error"]).max() < 0.12


def test_where_the_scheme_is_unstable_values_and_errors_are_infinite() -> None:
    T = np.array([0.5, 0.9, 1.1, 2.0]) * np.pi * DT  # the limit is T = pi dt
    s = ss.response_spectrum(motion(), DT, T, 0.0, "central_difference")
    assert s.attrs["unstable"] == 2
    for name in s.data_vars:
        assert np.array_equal(np.isinf(s[name]), [True, True, False, False]), name
    assert ss.response_spectrum(motion(), DT, T[:2], 0.0, "central_difference", errors=False).attrs["unstable"] == 2


@pytest.mark.parametrize("xi", [0.05, [0.0, 0.2]], ids=["one xi", "two"])
def test_a_period_of_0_is_the_ground_itself(xi: Any) -> None:
    """Other periods keep their values to the bit; a stiff oscillator, exactly solved, tends to the ground."""
    f = motion()
    others = ss.response_spectrum(f, DT, [0.5, 1e-5], xi)
    s = ss.response_spectrum(f, DT, [0.5, 0.0, 1e-5], xi)
    assert s.isel(period=[0, 2]).equals(others)
    ground, stiff = s.sel(period=0.0), others.sel(period=1e-5)
    for name, error in (("acceleration", "acceleration_error"), ("pseudo_acceleration", "displacement_error")):
        assert (ground[name] == np.abs(f).max()).all()
        assert np.allclose(stiff[name] / (1.0 + stiff[error]), ground[name], rtol=1e-3)
    for name in ("displacement", "velocity", "pseudo_velocity", *(f"{name}_error" for name in spectrum.QUANTITIES)):
        assert (ground[name] == 0.0).all(), name
    alone = ss.response_spectrum(f, DT, [0.0], xi)
    assert alone.equals(s.isel(period=[1]))
    assert (alone.unstable, alone.good_from) == (0, 0.0)


def test_frequencies_in_place_of_periods() -> None:
    f, hertz = motion(), [8.0, 0.5, 2.0]
    s = ss.response_spectrum(f, DT, frequencies=hertz, xi=[0.02, 0.05])
    assert s.frequency.dims == ("period",)
    assert s.frequency.units == "Hz"
    assert s.frequency.to_numpy().tolist() == hertz
    assert s.drop_vars("frequency").identical(ss.response_spectrum(f, DT, [0.125, 2.0, 0.5], [0.02, 0.05]))


def test_from_which_period_on_values_are_good_to_1_percent() -> None:
    f, T = motion(), np.geomspace(4.0, 0.05, 60)
    for xi in (0.05, [0.01, 0.1]):
        s = ss.response_spectrum(f, DT, T, xi)
        errors = np.abs(np.atleast_2d(s.acceleration_error)).max(axis=0)
        good = [float(t) for i, t in enumerate(T) if max(errors[: i + 1]) <= 0.01]
        assert 0.05 < s.good_from == min(good) < 4.0
        bad = ss.response_spectrum(f, DT, T[errors > 0.01], xi)
        assert np.isnan(bad.good_from)
        mixed = np.random.default_rng(5).permutation(T)
        assert ss.response_spectrum(f, DT, mixed, xi).good_from == s.good_from
    assert ss.response_spectrum(f, DT, [0.0, 0.05], 0.05).good_from != 0.0  # the ground is good, what follows is not
    assert np.isnan(ss.response_spectrum(f, DT, [0.01], 0.0, "central_difference").good_from)  # not stable


def test_a_record_of_zeros_has_no_error() -> None:
    s = ss.response_spectrum(np.zeros(10), DT, [0.1, 1.0])
    assert (s.displacement == 0.0).all()
    assert (s.displacement_error == 0.0).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"dt": None}, "expected dt of the record, got none"),
        ({"dt": -1.0}, "expected dt of the record > 0"),
        ({"record": np.ones((3, 2))}, "at least two samples in one row"),
        ({"record": [0.0, np.nan]}, "values of the record to be finite"),
        ({"periods": [0.0, -1.0]}, "expected periods >= 0, got -1.0; give positive periods, in s, or 0 for the ground"),
        ({"periods": 1.0}, r"expected periods in one row, got shape \(\)"),
        ({"frequencies": [2.0, 0.0]}, "expected frequencies > 0, got 0.0; .* the ground is periods=0"),
        ({"frequencies": [[2.0]]}, r"expected frequencies in one row, got shape \(1, 1\).* in Hz"),
        ({"frequencies": [1.0], "periods": [1.0]}, "expected either periods or frequencies, got both; leave one"),
        ({"xi": -0.1}, "expected xi >= 0"),
        ({"xi": [[0.1]]}, "expected xi to be a number or a row"),
        ({"scheme": "bath"}, "did you mean 'bathe'"),
        ({"scheme": ss.scheme("newmark", beta=[0.25, 0.3])}, "expected one value for beta of newmark"),
    ],
)
def test_what_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ss.response_spectrum(**{"record": motion(), "dt": DT, **change})


def test_a_record_of_a_march_is_one() -> None:
    f = motion(200)
    found = ss.response_spectrum(ss.Record(DT, f), periods=[0.5, 1.0])
    assert found.equals(ss.response_spectrum(f, DT, [0.5, 1.0]))
    with pytest.raises(ValueError, match="the record's own dt"):
        ss.response_spectrum(ss.Record(DT, f), 2 * DT)
