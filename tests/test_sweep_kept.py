"""Sweeps in chunks: stopped, killed and resumed, on a cluster that loses a worker."""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from test_sweep import LOAD, OSCILLATOR, sweep

import substep as ss
from substep.core import threads
from substep.marching import linear
from substep.sweeps.scene_plan import ScenePlan


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Divides sweeps into chunks of a few points."""
    monkeypatch.setattr(ScenePlan, "piece", lambda self, cluster: (1,) * (len(self.shape) - 2) + (2, self.shape[-1]))


@pytest.mark.parametrize("lanes", [1, 3, 7, 20, 1000])
def test_chunks_cover_every_point_once_in_c_order(lanes: int, monkeypatch: pytest.MonkeyPatch) -> None:
    from substep.sweeps import scene_plan

    monkeypatch.setattr(scene_plan, "LANE_STEPS", {True: lanes * 20.0, False: 0.0})
    args = {**OSCILLATOR, "keep": "final"}
    load, dt, t_end, keep = (args.pop(k) for k in ("load", "dt", "t_end", "keep"))
    given = dt, None, t_end, keep, None, None, None, load, "cpu", "float64"
    made = scene_plan.planned("linear_oscillator", "newmark_bdf2", *given, args)
    seen, flat = [], np.arange(48).reshape(made.shape)
    for chunk in made.chunks(made.piece(cluster=False)):
        assert chunk.last - chunk.first <= lanes
        assert np.array_equal(flat[chunk.where].ravel(), np.arange(chunk.first, chunk.last))
        seen += range(chunk.first, chunk.last)
    assert seen == list(range(48))
    assert len(made.chunks(made.piece(cluster=True))) == 1


@pytest.mark.usefixtures("small")
@pytest.mark.parametrize("workers", [1, 2, 3])
def test_many_chunks_are_run_by_threads_that_each_use_one_core(workers: int, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, run, seen = ss.sweep("linear_oscillator", "newmark_bdf2", **OSCILLATOR, workers=1), ScenePlan.run, set()
    monkeypatch.setattr(threads, "_there", lambda: 3)

    def noted(plan: ScenePlan, *span: Any) -> Any:
        seen.add((threading.current_thread() is threading.main_thread(), threads.cores()))
        return run(plan, *span)

    monkeypatch.setattr(ScenePlan, "run", noted)
    xr.testing.assert_identical(ss.sweep("linear_oscillator", "newmark_bdf2", **OSCILLATOR, workers=workers), whole)
    assert seen == {(workers == 1, 1)}
    seen.clear()
    own = {name: x for name, x in OSCILLATOR.items() if name != "amplitude"}
    own["load"] = np.sin  # a function of one's own need not bear to be called by two threads at once
    ss.sweep("linear_oscillator", "newmark_bdf2", **own, workers=workers)
    assert seen == {(True, workers)}


def test_chunks_of_peaks_are_as_large_as_those_of_the_end() -> None:
    """No history of theirs is in memory, whether kernels report accelerations or not."""
    from substep.sweeps import scene_plan

    pieces = {
        (scheme, keep): scene_plan.planned(
            "elastic_pendulum", scheme, 0.01, None, 10.0, keep, None, None, None, None, "cpu", "float64",
            {"EA": 1e4, "v0": np.linspace(6.0, 8.0, 10**5)},
        ).piece(cluster=False)
        for scheme in ("bathe", "rk4") for keep in ("final", "peak")
    }  # fmt: skip
    assert len(set(pieces.values())) == 1
    assert pieces["bathe", "peak"] > (3000,)


@pytest.mark.parametrize("keep", ["final", "peak", "history"])
def test_oscillators_whose_coefficients_are_made_together_do_not_matter(
    keep: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    call: dict[str, Any] = {
        "dt": 0.1,
        "t_end": 1.0,
        "omega": np.linspace(1.0, 9.0, 300),
        "xi": [0.0, 0.1],
        "keep": keep,
    }
    whole, seen, of = ss.sweep("linear_oscillator", "newmark_bdf2", **call), [], linear.ranges
    monkeypatch.setattr(linear, "TOGETHER", 1)
    monkeypatch.setattr(linear, "ranges", lambda *given: (seen.append(len([*of(*given)])), of(*given))[1])
    xr.testing.assert_identical(ss.sweep("linear_oscillator", "newmark_bdf2", **call), whole)
    assert max(seen) > 1


@pytest.mark.usefixtures("small")
@pytest.mark.parametrize("save", [False, True])
def test_ctrl_c_returns_what_is_done(save: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    call = {**OSCILLATOR, **({"save": tmp_path / "s.zarr"} if save else {})}
    whole, run = ss.sweep("linear_oscillator", "newmark_bdf2", **OSCILLATOR), ScenePlan.run

    def interrupted(plan: ScenePlan, first: int, *rest: Any) -> Any:
        if first >= 20:
            raise KeyboardInterrupt
        return run(plan, first, *rest)

    monkeypatch.setattr(ScenePlan, "run", interrupted)
    found = ss.sweep("linear_oscillator", "newmark_bdf2", **call).load()
    assert found.attrs["interrupted"] == 1
    flat = found.stack(point=found["status"].dims)
    assert (flat["status"] == 0).values.tolist() == [True] * 20 + [False] * 28
    assert (flat["status"][20:] == -1).all()
    assert flat["u"][:, 20:].isnull().all()
    xr.testing.assert_equal(whole.where(found["status"] == 0)["u"], found["u"])
    if save:
        seen = []
        monkeypatch.setattr(ScenePlan, "run", lambda plan, *span: (seen.append(span[0]), run(plan, *span))[1])
        xr.testing.assert_identical(ss.sweep("linear_oscillator", "newmark_bdf2", **call).load(), whole)
        assert sorted(seen) == list(range(20, 48, 4))
        monkeypatch.setattr(ScenePlan, "run", None)
        xr.testing.assert_identical(ss.sweep("linear_oscillator", "newmark_bdf2", **call).load(), whole)


@pytest.mark.usefixtures("small")
def test_ctrl_c_while_writing_leaves_nothing_half(monkeypatch: pytest.MonkeyPatch) -> None:
    class Stops(np.ndarray):
        def __setitem__(self, key: Any, value: Any) -> None:
            if key[0].start == 1 and np.ndim(value):
                raise KeyboardInterrupt
            super().__setitem__(key, value)

    full = np.full
    monkeypatch.setattr(
        np, "full", lambda s, x, **k: full(s, x, **k).view(Stops) if isinstance(x, np.int8) else full(s, x, **k)
    )
    found = ss.sweep("linear_oscillator", "newmark_bdf2", **OSCILLATOR)
    assert found.attrs["interrupted"] == 1
    assert (found["status"].isel(dt=1) == -1).all()
    assert found["u"].isel(dt=1).isnull().all()
    assert found["u"].isel(dt=0).notnull().all()


@pytest.mark.usefixtures("small")
def test_an_error_on_the_way_loses_nothing() -> None:
    def load(t: np.ndarray) -> np.ndarray:
        return np.where((t > 0.01) & (t < 0.06), np.nan, 1.0)  # at dt = 0.05 only

    with pytest.raises(ValueError, match="expected a finite load") as caught:
        ss.sweep("linear_oscillator", "newmark", dt=[0.1, 0.05], t_end=0.1, omega=[1.0, 2.0], xi=[0.0, 0.1], load=load)
    done = caught.value.dataset  # type: ignore[attr-defined]
    assert done["status"].isel(dt=0).values.tolist() == [[0, 0], [0, 0]]
    assert (done["status"].isel(dt=1) == -1).all()


@pytest.mark.usefixtures("uncompiled")
def test_a_sweep_of_a_law_that_remembers_goes_on(tmp_path: Path) -> None:
    """What a law remembers is a dimension of the results, not an axis of the sweep."""
    call: dict[str, Any] = {"omega": [1.0, 2.0], "law": "bilinear", "strength": 1.0, "u0": 2.0, "dt": 0.1, "t_end": 1.0}
    first, again = (
        ss.sweep("hysteretic_oscillator", "newmark", **call, save=tmp_path / "s.zarr").load() for _ in range(2)
    )
    assert "remembered" in first.sizes
    xr.testing.assert_identical(first, again)


KILLED = """
import os, signal, sys
import numpy as np, substep as ss
from substep import sweeps
from substep.sweeps.scene_plan import ScenePlan
ScenePlan.piece = lambda self, cluster: (5,)
begun, write = [], sweeps._fill

class Deadly(dict):  # of the third chunk u is written, the status is not
    def __getitem__(self, name):
        begun.append(name)
        if begun.count("u") == 3 and name == "status":
            os.kill(os.getpid(), signal.SIGKILL)
        return super().__getitem__(name)

sweeps._fill = lambda targets, *rest: write(Deadly(targets), *rest)
ss.sweep("linear_oscillator", "newmark", dt=0.1, t_end=1.0, omega=np.arange(1.0, 23.0), save=sys.argv[1])
"""


def test_a_killed_sweep_is_resumed_and_another_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, run = tmp_path / "sweep.zarr", ScenePlan.run
    call = {"dt": 0.1, "t_end": 1.0, "omega": np.arange(1.0, 23.0)}
    done = subprocess.run([sys.executable, "-c", KILLED, str(path)], capture_output=True, check=False)
    assert done.returncode == -signal.SIGKILL, done.stderr
    left = xr.open_zarr(path, chunks=None, consolidated=False)
    assert left.attrs["interrupted"] == 1
    assert (left["status"] == 0).values.tolist() == [True] * 10 + [False] * 12
    for other, message in (
        ({"t_end": 2.0}, "whose t_end is 1.0, got 2.0; give save another path"),
        ({"omega": np.append(call["omega"][:-1], 99.0)}, r"expected omega\[21\] = 22.0 as in .*, got 99.0"),
        ({"omega": np.arange(1.0, 24.0)}, "expected 22 values of omega .* got 23"),
        ({"omega": 1.0, "xi": 0.01 * call["omega"]}, "whose scene_omega is not given, got 1.0"),
        ({"beta": 0.3}, "whose scheme_beta is 0.25, got 0.3"),
        ({"load": LOAD, "scene_omega": call["omega"], "omega": None}, "whose load is not given, got Harmonic"),
        ({"xi": [0.1, 0.2]}, "whose scene_xi is 0.0, got not given"),
        ({"keep": "peak"}, "whose keep is final, got peak"),
    ):
        changed = {k: x for k, x in {**call, **other}.items() if x is not None}
        with pytest.raises(ValueError, match=message):
            ss.sweep("linear_oscillator", "newmark", **changed, save=path)
    seen = []
    monkeypatch.setattr(ScenePlan, "run", lambda plan, first, *rest: (seen.append(first), run(plan, first, *rest))[1])
    found = ss.sweep("linear_oscillator", "newmark", **call, save=path).load()
    assert seen == [10, 15, 20]
    monkeypatch.undo()
    xr.testing.assert_identical(found, ss.sweep("linear_oscillator", "newmark", **call))
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("mine")
    xr.Dataset({"status": ("x", [1])}).to_zarr(tmp_path / "zarr", consolidated=False)
    for other in ("folder", "file", "zarr"):
        with pytest.raises(ValueError, match="expected a sweep or nothing at"):
            ss.sweep("linear_oscillator", "newmark", **call, save=tmp_path / other)


def test_a_load_of_ones_own_whose_code_changed_is_another(tmp_path: Path) -> None:
    from dataclasses import make_dataclass

    def ramp(sign: float, rate: float = 2.0) -> Any:
        made = make_dataclass(
            "Ramp", [("rate", float)], namespace={"__call__": lambda self, t: 0.0 + sign * self.rate * t}
        )
        return made(rate)

    call: dict[str, Any] = {"dt": 0.1, "t_end": 1.0, "omega": 2.0, "save": tmp_path / "s.zarr"}
    first = ss.sweep("linear_oscillator", "newmark", load=ramp(1.0), **call)
    assert first.attrs["load_rate"] == 2.0
    xr.testing.assert_identical(first, ss.sweep("linear_oscillator", "newmark", load=ramp(1.0), **call))
    with pytest.raises(ValueError, match="whose load_samples_sha256 is"):
        ss.sweep("linear_oscillator", "newmark", load=ramp(-1.0), **call)
    call |= {"save": tmp_path / "swept.zarr", "rate": [0.0, 1.0]}  # in place of 0, at which all of them are alike
    ss.sweep("linear_oscillator", "newmark", load=ramp(1.0, 0.0), **call)
    with pytest.raises(ValueError, match="whose load_samples_sha256 is"):
        ss.sweep("linear_oscillator", "newmark", load=ramp(-1.0, 0.0), **call)


def test_rows_along_another_dimension_are_another_sweep(tmp_path: Path) -> None:
    call: dict[str, Any] = {"dt": 0.1, "t_end": 1.0, "save": tmp_path / "sweep.zarr"}
    call |= {"omega": xr.DataArray([1.0, 2.0], dims="p"), "xi": xr.DataArray([0.0, 0.1], dims="q")}
    ss.sweep("linear_oscillator", "newmark", **call, u0=xr.DataArray([1.0, 3.0], dims="p"))
    with pytest.raises(ValueError, match=r"expected u0 along p as in .*, got it along q"):
        ss.sweep("linear_oscillator", "newmark", **call, u0=xr.DataArray([1.0, 3.0], dims="q"))


@pytest.mark.usefixtures("small")
def test_a_cluster_that_loses_a_worker_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from distributed import Client, LocalCluster

    monkeypatch.setattr(sys.modules["substep.sweeps.cluster"], "AHEAD", 1)  # chunks are still waiting
    flag, here = tmp_path / "killed", os.getpid()

    class Deadly:
        """A load that kills the first worker to reach a later instant."""

        def __call__(self, t: np.ndarray) -> np.ndarray:
            if os.getpid() != here and np.max(t) > 1.2 and not flag.exists():
                flag.touch()
                os.kill(os.getpid(), signal.SIGKILL)
            return np.sin(t)

    call: dict[str, Any] = {
        "dt": [0.1, 0.05],
        "t_end": 1.5,
        "omega": np.arange(1.0, 9.0),
        "gamma": [0.5, 0.6],
        "load": Deadly(),
    }
    two = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with LocalCluster(**two) as cluster, Client(cluster) as client:
        found = ss.sweep("linear_oscillator", "newmark", **call, client=client)
        saved = ss.sweep("linear_oscillator", "newmark", **call, client=client, save=tmp_path / "s.zarr").load()
    assert flag.exists()
    local = ss.sweep("linear_oscillator", "newmark", **call)
    xr.testing.assert_identical(found, local)
    xr.testing.assert_identical(saved, local)


def test_a_bar_on_a_terminal_after_a_second_only(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from substep.core import progress

    monkeypatch.setenv("FORCE_COLOR", "1")  # rich takes it for a terminal
    sweep()
    assert capsys.readouterr() == ("", "")
    monkeypatch.setattr(progress, "AFTER", 0.0)
    monkeypatch.setattr(ScenePlan, "piece", lambda self, cluster: (1,))
    sweep(progress=False)
    assert capsys.readouterr() == ("", "")
    sweep()
    assert "sweep" in capsys.readouterr().err
    monkeypatch.delenv("FORCE_COLOR")
    sweep()
    assert capsys.readouterr() == ("", "")
