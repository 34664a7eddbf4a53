"""Sweeps whose runs choose their steps: every point equals a march of its own, to the last bit."""

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import substep as ss
from substep.core import threads
from substep.marching import adaptive

PLAIN = pytest.mark.usefixtures("plain_adaptive")
PENDULUM: dict[str, Any] = {"tol": [1e-3, 1e-5], "t_end": 0.6, "EA": [1e3, 1e4], "progress": False}
GRID = np.linspace(0.0, 0.6, 7)


def march(scheme: Any, tol: float, EA: float, **more: Any) -> ss.Response:
    return ss.march(ss.scene("elastic_pendulum", EA=EA), scheme, tol=tol, t_end=0.6, **more)


def agrees(found: Any, r: ss.Response, keep: str) -> None:
    """Assert that a point of a sweep is the march of its own."""
    assert r.statistics is not None
    assert (found.accepted, found.rejected) == (r.statistics.accepted, r.statistics.rejected)
    assert found.status == 0
    assert np.isnan(found.t_failed)
    assert np.allclose(found.newton_iterations * found.accepted, r.statistics.newton_iterations)
    assert (found.newton_most == r.statistics.newton_most).all()
    for name, rows in {"u": r.u, "v": r.v, "a": r.a, "energy": r.energy}.items():
        if (keep, name) == ("peak", "energy"):  # of the kernel, which sums in another order
            assert found.peak_energy == pytest.approx(rows.max(), rel=1e-13)
        elif keep == "peak":
            assert np.array_equal(found[f"peak_{name}"], np.abs(rows).max(axis=0)), name
        else:
            assert np.array_equal(found[name], rows if keep == "history" else rows[-1]), name


@PLAIN
@pytest.mark.parametrize("keep", ["final", "peak", "history"])
@pytest.mark.parametrize("scheme", ["average_acceleration", "backward_euler", "dormand_prince"])
def test_points_are_as_each_alone(scheme: str, keep: str) -> None:
    more = {"grid": GRID} if keep == "history" else {}
    found = ss.sweep("elastic_pendulum", scheme, keep=keep, **PENDULUM, **more)  # type: ignore[arg-type]
    assert found["status"].dims == ("tol", "EA")
    if keep == "history":
        assert np.array_equal(found["t"], GRID)
    for tol in PENDULUM["tol"]:
        for EA in PENDULUM["EA"]:
            agrees(found.sel(tol=tol, EA=EA), march(scheme, tol, EA, **more), keep)


@PLAIN
def test_parameters_of_scheme_and_load_are_axes_beside_the_tolerance() -> None:
    """The estimate is another one for each value: at gamma = 1/2 it needs the step before."""
    found = ss.sweep(
        "linear_oscillator", "newmark", tol=1e-4, t_end=1.0, gamma=[0.5, 0.6], amplitude=[1.0, 2.0], beta=0.3025,
        scene_omega=[2.0, 5.0], load=ss.HalfSine(1.0, 0.4), progress=False, rtol=1e-3, dt_max=0.05,
    )  # fmt: skip
    assert found["status"].dims == ("gamma", "amplitude", "scene_omega")
    assert found.attrs["tol"] == 1e-4
    for values in product((0.5, 0.6), (1.0, 2.0), (2.0, 5.0)):
        at = dict(zip(("gamma", "amplitude", "scene_omega"), values, strict=True))
        load = ss.HalfSine(at["amplitude"], 0.4)
        scene = ss.scene("linear_oscillator", omega=at["scene_omega"], load=load)
        s = ss.scheme("newmark", gamma=at["gamma"], beta=0.3025)
        agrees(found.sel(at), ss.march(scene, s, tol=1e-4, t_end=1.0, rtol=1e-3, dt_max=0.05), "final")


@PLAIN
@pytest.mark.parametrize("keep", ["final", "peak", "history"])
def test_a_run_that_fails_ends_alone_with_its_time(keep: str) -> None:
    more = {"grid": GRID} if keep == "history" else {}
    call = {"dt_min": 1e-2, "dt_first": 1e-2, **more}
    found = ss.sweep("elastic_pendulum", "bathe", keep=keep, **PENDULUM, **call)  # type: ignore[arg-type]
    r = march("bathe", 1e-5, 1e4, **call)
    assert r.status == "step_too_small"
    point = found.sel(tol=1e-5, EA=1e4)
    names = point.status.attrs["flag_meanings"].split()
    assert names[list(point.status.attrs["flag_values"]).index(int(point.status))] == r.status
    assert point.t_failed == r.t_failed
    if keep == "final":
        assert np.isnan(point.u).all()
    elif keep == "history":
        assert np.array_equal(point.u[: len(r.t)], r.u)
        assert np.isnan(point.u[len(r.t) :]).all()
        assert np.isnan(point.energy[len(r.t) :]).all()
    else:
        assert np.isfinite(point.peak_u).all()
    assert found.sel(tol=1e-3, EA=1e3).status == 0


@PLAIN
def test_peaks_of_more_steps_than_a_buffer_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = ss.sweep("elastic_pendulum", "bathe", keep="peak", **PENDULUM)
    monkeypatch.setattr(adaptive, "ROWS", 5)
    parts = ss.sweep("elastic_pendulum", "bathe", keep="peak", **PENDULUM)
    assert (whole.accepted > 10).all()
    assert parts.equals(whole)


@PLAIN
def test_a_stored_sweep_goes_on_where_it_was_and_knows_its_tolerance(tmp_path: Path) -> None:
    call = PENDULUM | {"keep": "history", "grid": GRID}
    whole = ss.sweep("elastic_pendulum", "bathe", **call)
    stored = ss.sweep("elastic_pendulum", "bathe", **call, save=tmp_path / "s.zarr")
    assert stored.load().drop_attrs().equals(whole.drop_attrs())
    assert ss.sweep("elastic_pendulum", "bathe", **call, save=tmp_path / "s.zarr").attrs["interrupted"] == 0
    with pytest.raises(ValueError, match="tol"):
        ss.sweep("elastic_pendulum", "bathe", **(call | {"tol": [1e-3, 1e-4]}), save=tmp_path / "s.zarr")
    with pytest.raises(ValueError, match="grid"):
        ss.sweep("elastic_pendulum", "bathe", **(call | {"grid": GRID[1:]}), save=tmp_path / "s.zarr")


@PLAIN
@pytest.mark.parametrize(
    ("scheme", "arguments", "words"),
    [
        ("bathe", {"dt": 0.1}, "either dt"),
        ("bathe", {"tol": None}, "either dt"),
        ("bathe", {"tol": [1e-3, 0.0]}, "expected tol in"),
        ("bathe", {"tol": -1.0}, "tol > 0"),
        ("bathe", {"tol": None, "dt": 0.1, "dt_max": 0.1}, "dt_max with tol only"),
        ("bathe", {"keep": "history"}, "grid=np.linspace"),
        ("bathe", {"keep": "peak", "grid": GRID}, "drop it"),
        ("bathe", {"keep": "history", "grid": GRID, "samples": 3}, "samples with dt only"),
        ("bathe", {"dt_min": 0.1, "dt_max": 0.01}, "dt_min <= dt_max"),
        ("houbolt", {}, "give dt in place of tol"),
    ],
)
def test_wrong_calls_are_refused_before_anything_is_run(scheme: str, arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ss.sweep("elastic_pendulum", scheme, **{**PENDULUM, **arguments})


@pytest.mark.thorough
def test_compiled_kernels_of_march_and_sweep_agree_to_the_last_bit(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """One pair, compiled: threads of the sweep, the march, and the same kernel as plain Python."""
    from plain_kernels import plain_adaptive as kernels

    monkeypatch.setenv("SUBSTEP_CACHE", str(tmp_path))
    monkeypatch.setattr(threads, "WORTH_THREADS", 0.0)
    tolerances, t_end = [1e-3, 1e-4, 1e-6], 0.5
    found = ss.sweep("duffing", "average_acceleration", tol=tolerances, t_end=t_end, progress=False)
    for tol in tolerances:
        r = ss.march("duffing", "average_acceleration", tol=tol, t_end=t_end)
        agrees(found.sel(tol=tol), r, "final")
    monkeypatch.setattr(adaptive, "_kernels", kernels)
    with np.errstate(all="ignore"):
        plain = ss.march("duffing", "average_acceleration", tol=tolerances[-1], t_end=t_end)
    assert plain.statistics is not None
    assert abs(len(plain.t) - int(found.accepted[-1]) - 1) <= 2
    assert np.allclose(plain.u[-1], found.u[-1], rtol=1e-6)
