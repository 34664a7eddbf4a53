"""Spectra in steps that are halved where the record's are too long, and the history of one oscillator."""

import pickle
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.signal import StateSpace, lfilter, lsim

import substep as ss
from substep.ground_motion.history import SpectralResponse
from substep.ground_motion.peaks import refined

Array = np.ndarray
DT, XI = 0.01, 0.05
PEAKS = ("displacement", "velocity", "acceleration")
T = np.array([0.004, 0.01, 0.023, 0.05, 0.11, 0.3, 1.1])


@cache
def motion(n: int = 600) -> Array:
    """Ground acceleration (n,), m/s^2: noise through a soil that swings at 2.5 Hz, in an envelope."""
    noise = np.random.default_rng(1952).normal(size=n)
    a, b = 2.0 * np.exp(-0.05) * np.cos(0.16), -np.exp(-0.1)
    return np.sin(np.pi * np.arange(n) / n) ** 2 * lfilter([1.0, -1.0], [1.0, -a, -b], noise)


def exact_history(period: float, f: Array, parts: int, xi: float = XI) -> Array:
    """u, v, absolute acceleration (3, rows) at `parts` instants a sample, by lsim, exact where f is linear between."""
    w, rows = 2 * np.pi / period, (len(f) - 1) * parts + 1
    system = StateSpace([[0.0, 1.0], [-(w**2), -2 * xi * w]], [[0.0], [-1.0]], np.eye(2), np.zeros((2, 1)))
    ground = np.interp(np.arange(rows) / parts, np.arange(len(f)), f)
    _, y, _ = lsim(system, ground, DT / parts * np.arange(rows))
    return np.array([y[:, 0], y[:, 1], -(w**2) * y[:, 0] - 2 * xi * w * y[:, 1]])


@cache
def true_peaks(offset: float = 0.0) -> Array:
    """The largest of each (3, P) at all times, at 300 instants a period and 1 a sample at least."""
    parts = np.ceil(300 * DT / T).astype(int).tolist()
    pairs = zip(T.tolist(), parts, strict=True)
    return np.array([np.abs(exact_history(t, motion() + offset, k)).max(axis=1) for t, k in pairs]).T


@pytest.mark.matrix
@pytest.mark.parametrize("offset", [0.0, 0.5], ids=["from 0", "from a jump"])
@pytest.mark.parametrize("scheme", ["average_acceleration", "central_difference", "three_substep", "houbolt"])
def test_values_are_within_1_percent_of_the_exact_response_at_all_times(scheme: str, offset: float) -> None:
    record = motion() + offset
    s = ss.response_spectrum(record, DT, T, XI, scheme, refine="auto")
    coarse = ss.response_spectrum(record, DT, T, XI, scheme)
    for name, true in zip(PEAKS, true_peaks(offset), strict=True):
        assert np.abs(s[name] / true - 1.0).max() < 0.0105, name  # the reference of the package is good to 0.05 %
        assert np.allclose(s[name] / true - 1.0, s[f"{name}_error"], rtol=0.0, atol=5e-4), name
        assert np.abs(coarse[name] / true - 1.0).max() > 0.05, name  # what it is a cure of
    assert (s.good_from, s.unstable) == (T[0], 0)


@pytest.mark.thorough
def test_it_says_how_many_steps_each_period_took_and_takes_no_more_than_it_needs() -> None:
    s = ss.response_spectrum(motion(), DT, [*T, 0.0], [0.02, 0.2], refine="auto")
    assert s.steps.dims == ("xi", "period")
    assert s.steps.dtype == np.int64
    assert (s.steps.sel(period=[0.0, 1.1]) == 1).all()
    assert (s.steps.sel(period=0.01) >= 8).all()
    powers = np.log2(s.steps.to_numpy())
    assert (powers == powers.round()).all()
    for j, xi in enumerate((0.02, 0.2)):  # half as many would have left a larger error
        for i in np.flatnonzero(s.steps[j, :-1] > 1).tolist():
            half = refined(ss.Record(DT, motion()), int(s.steps[j, i]) // 2)
            found = ss.response_spectrum(half, periods=[T[i]], xi=xi)
            true = np.abs(exact_history(T[i], motion(), int(np.ceil(300 * DT / T[i])), xi)).max(axis=1)
            assert max(abs(float(found[name][0]) / x - 1.0) for name, x in zip(PEAKS, true, strict=True)) > 0.0095


def test_it_is_off_by_default_and_changes_no_period_that_is_good() -> None:
    record = motion()
    plain, s = ss.response_spectrum(record, DT, T), ss.response_spectrum(record, DT, T, refine="auto")
    assert "steps" not in plain
    same = (s.steps == 1).to_numpy()
    assert same.any()
    assert all(np.array_equal(s[name][same], plain[name][same]) for name in PEAKS)
    assert "acceleration_error" not in ss.response_spectrum(record, DT, T, refine="auto", errors=False)


def test_a_refined_record_is_the_same_function_of_time() -> None:
    record = ss.Record(DT, motion(), unit="g")
    fine, t = refined(record, 7), np.linspace(0.0, 599 * DT, 12_345)
    assert fine.dt == DT / 7
    assert np.array_equal(fine.samples[::7], record.samples)
    assert np.allclose(fine(t), np.interp(t, DT * np.arange(600), record.samples), rtol=1e-11, atol=1e-12)


def test_what_is_too_stiff_for_any_step_keeps_its_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("substep.ground_motion.peaks.MOST", 2500)  # 4 steps a sample
    s = ss.response_spectrum(motion(), DT, [0.004, 1.1], 0.0, "central_difference", refine="auto")
    assert s.steps.to_numpy().tolist() == [4, 1]
    assert np.isinf(s.acceleration_error[0])
    assert (s.unstable, s.good_from) == (1, 1.1)


@pytest.mark.parametrize("refine", [4, "automatic", True])
def test_another_choice_of_steps_is_refused(refine: Any) -> None:
    with pytest.raises(ValueError, match='expected refine="auto", or none for the steps of the record, got'):
        ss.response_spectrum(motion(), DT, T, refine=refine)


@pytest.mark.parametrize("refine", [None, "auto"])
@pytest.mark.parametrize("scheme", ["fox_goodwin", "bathe", "houbolt"])
def test_the_history_of_an_oscillator_has_the_peaks_of_the_spectrum(scheme: str, refine: str | None) -> None:
    periods = T if refine else T[T > 0.1]
    s = ss.response_spectrum(motion(), DT, periods, XI, scheme, refine=refine)
    for i, period in enumerate(periods.tolist()):
        r = s.history(T=period)
        assert isinstance(r, ss.Response)
        assert r.status == "completed"
        steps = int(s.steps[i]) if refine else 1
        assert r.t.shape == (599 * steps + 1,)
        assert r.t[-1] == pytest.approx(599 * DT)
        found = [np.abs(x).max() for x in (r.u, r.v, r.absolute_acceleration)]
        assert found == pytest.approx([float(s[name][i]) for name in PEAKS], rel=1e-10)


@pytest.mark.parametrize(("period", "xi"), [(0.05, 0.05), (0.77, 0.0), (0.77, 0.3), (40.0, 0.05)])
def test_a_history_of_any_period_against_the_exact_one(period: float, xi: float) -> None:
    """With its sign: u is relative to the ground, whose acceleration the mass lags behind."""
    s = ss.response_spectrum(motion() + 0.5, DT, [1.0], 0.02, "fox_goodwin", refine="auto")
    r = s.history(period, xi=xi)
    assert isinstance(r, SpectralResponse)
    exact = exact_history(period, motion() + 0.5, round(DT / r.step), xi)
    for mine, true in zip((r.u[:, 0], r.v[:, 0], r.absolute_acceleration), exact, strict=True):
        assert np.abs(mine - true).max() < 0.03 * np.abs(true).max()
    ground = np.interp(r.t, DT * np.arange(600), motion() + 0.5)
    assert np.allclose(r.a[:, 0] + ground, r.absolute_acceleration, rtol=0.0, atol=1e-6 * np.abs(ground).max())


def test_a_history_is_exported_with_the_absolute_acceleration() -> None:
    r = ss.response_spectrum(motion(), DT, [1.0]).history(T=0.8)
    assert np.array_equal(r.to_xarray().absolute_acceleration, r.absolute_acceleration)
    assert r.outputs["absolute_acceleration"] is r.absolute_acceleration
    assert len(r.plot("u", "absolute_acceleration").axes) == 2


def test_damping_is_the_spectrums_own_where_it_has_one() -> None:
    one, several = (ss.response_spectrum(motion(), DT, [1.0], xi) for xi in (0.02, [0.02, 0.1]))
    assert np.array_equal(one.history(T=0.8).u, several.history(T=0.8, xi=0.02).u)
    assert one.history(T=0.8).scene.parameters["xi"] == 0.02
    with pytest.raises(ValueError, match=r"expected xi, one of the spectrum's \[0.02, 0.1\] or any other, got none"):
        several.history(T=0.8)
    with pytest.raises(ValueError, match="expected xi as a ratio, at most 1, got 5; 5 % is 0.05"):
        one.history(T=0.8, xi=5.0)


def test_a_spectrum_knows_its_record_or_says_that_it_does_not(tmp_path: Path) -> None:
    s = ss.response_spectrum(motion(), DT, [0.5, 1.0])
    sent = pickle.loads(pickle.dumps(s))
    assert sent.identical(s)
    assert np.array_equal(sent.history(T=0.7).u, s.history(T=0.7).u)
    for changed in (s.sel(period=0.5), s.copy(), 2.0 * s):
        with pytest.raises(ValueError, match="expected the spectrum that response_spectrum returned, got one made fr"):
            changed.history(T=0.5)
    s.to_netcdf(tmp_path / "s.nc", engine="scipy")
    assert ss.load(tmp_path / "s.nc").identical(s)


def test_a_history_that_cannot_be_had_is_refused() -> None:
    s = ss.response_spectrum(motion(), DT, [1.0], 0.0, "central_difference")
    for period in (0.0, -1.0):
        with pytest.raises(ValueError, match="expected T > 0"):
            s.history(T=period)
    with pytest.raises(ValueError, match=r"central_difference to be stable at T = 0.02 s in steps of 0.01 s; give ref"):
        s.history(T=0.02)
    refined_one = ss.response_spectrum(motion(), DT, [1.0], 0.0, "central_difference", refine="auto")
    assert refined_one.history(T=0.02).status == "completed"
