"""Sweeps: every point as a march of its own, whatever is swept, kept, stopped, resumed or sent away."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import substep as ss
from substep import sweeps
from substep.response import Response
from substep.sweeps.plan import Plan

RNG = np.random.default_rng(11)
LOAD = ss.Harmonic(1.0, 3.0, 0.2)
OSCILLATOR: dict[str, Any] = {
    "dt": [0.1, 0.05], "t_end": 1.0, "scene_omega": [1.0, 4.0, 9.0], "xi": [0.0, 0.1], "gamma_t": [0.2, 0.4],
    "amplitude": [1.0, 2.0], "load": LOAD,
}  # fmt: skip
PENDULUM: dict[str, Any] = {"dt": 0.05, "t_end": 0.5, "EA": [1e3, 1e4, 1e5], "gamma_t": [0.3, 0.4, 0.5, 0.6]}
KEEPS = [{"keep": "final"}, {"keep": "peak"}, {"keep": "history", "samples": 5}]


def points(found: xr.Dataset, number: int) -> list[dict[str, float]]:
    """Random ones, by the coordinates of the axes."""
    axes = [str(name) for name in found["status"].dims]
    return [{name: float(RNG.choice(found[name].values)) for name in axes} for _ in range(number)]


def agrees(found: xr.Dataset, r: Response, n: int, keep: str) -> None:
    """A point of a sweep with the march of its own."""
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
            mine = found.get(f"peak_{name}")
        elif keep == "final":
            expected, mine = rows[-1] if done == n else np.full(rows.shape[1], np.nan), found[name]
        else:
            mine = found[name]
            stride = n // (mine.sizes["t"] - 1)
            expected = np.full((n // stride + 1, rows.shape[1]), np.nan)
            expected[: done // stride + 1] = rows[::stride]
        if expected is not None:
            assert mine is not None
            finite = np.isfinite(size).all()  # the energy is inf before u is
            close = {"rtol": 0.0, "atol": 1e-11 * np.max(size)} if finite else {"rtol": 1e-11, "atol": 0.0}
            assert np.allclose(np.ravel(mine.values), np.ravel(expected), equal_nan=True, **close)
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
    """A number is no dimension; prefixes; a handle's start; the load's own parameters; what attributes tell."""
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
    assert one["u"].item() == by_name["u"].sel(load_omega=2.0).item()
    assert by_name.attrs["scheme_beta"] == 0.25
    assert "load_omega" not in by_name.attrs
    assert by_name["u"].attrs == {"units": "m", "long_name": "displacement at t_end"}
    strain = ss.sweep("linear_oscillator", "newmark", dt=[0.1, 0.2], t_end=1.0, omega=[])
    assert strain["u"].shape == (2, 0, 1)


def test_the_start_follows_the_parameters() -> None:
    """Of a handle too: the consistent acceleration, and a start made of parameters."""
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
    monkeypatch.setattr(sweeps, "run", None)  # nothing is run before
    with pytest.raises(ValueError, match=message):
        call()


def test_a_handle_changed_by_hand_is_refused() -> None:
    from dataclasses import replace

    changed = replace(ss.scene("linear_oscillator", omega=1.0), u0=np.array([5.0]))
    with pytest.raises(ValueError, match=r"u0 = \[1.\], got \[5.\]; set parameters"):
        ss.sweep(changed, "newmark", dt=0.1, t_end=1.0)


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks of a few points."""
    monkeypatch.setattr(Plan, "piece", lambda self, cluster: (1,) * (len(self.shape) - 2) + (2, self.shape[-1]))


@pytest.mark.parametrize("lanes", [1, 3, 7, 20, 1000])
def test_chunks_cover_every_point_once_in_c_order(lanes: int, monkeypatch: pytest.MonkeyPatch) -> None:
    from substep.sweeps import plan

    monkeypatch.setattr(plan, "LANE_STEPS", {True: lanes * 20.0, False: 0.0})
    args = {**OSCILLATOR, "keep": "final"}
    load, dt, t_end, keep = (args.pop(k) for k in ("load", "dt", "t_end", "keep"))
    made = plan.planned("linear_oscillator", "newmark_bdf2", dt, t_end, keep, None, None, None, load, args)
    seen, flat = [], np.arange(48).reshape(made.shape)
    for chunk in made.chunks(made.piece(cluster=False)):
        assert chunk.last - chunk.first <= lanes
        assert np.array_equal(flat[chunk.where].ravel(), np.arange(chunk.first, chunk.last))
        seen += range(chunk.first, chunk.last)
    assert seen == list(range(48))
    assert len(made.chunks(made.piece(cluster=True))) == 1


@pytest.mark.usefixtures("small")
@pytest.mark.parametrize("save", [False, True])
def test_ctrl_c_returns_what_is_done(save: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    call = {**OSCILLATOR, **({"save": tmp_path / "s.zarr"} if save else {})}
    whole, run = ss.sweep("linear_oscillator", "newmark_bdf2", **OSCILLATOR), sweeps.run

    def interrupted(plan: Plan, first: int, last: int) -> Any:
        if first >= 20:
            raise KeyboardInterrupt
        return run(plan, first, last)

    monkeypatch.setattr(sweeps, "run", interrupted)
    found = ss.sweep("linear_oscillator", "newmark_bdf2", **call).load()
    assert found.attrs["interrupted"] == 1
    flat = found.stack(point=found["status"].dims)
    assert (flat["status"] == 0).values.tolist() == [True] * 20 + [False] * 28
    assert (flat["status"][20:] == -1).all()
    assert flat["u"][:, 20:].isnull().all()
    xr.testing.assert_equal(whole.where(found["status"] == 0)["u"], found["u"])
    if save:
        seen = []
        monkeypatch.setattr(sweeps, "run", lambda plan, first, last: (seen.append(first), run(plan, first, last))[1])
        xr.testing.assert_identical(ss.sweep("linear_oscillator", "newmark_bdf2", **call).load(), whole)
        assert seen == list(range(20, 48, 4))
        monkeypatch.setattr(sweeps, "run", None)
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


KILLED = """
import os, signal, sys
import numpy as np, substep as ss
from substep import sweeps
from substep.sweeps.plan import Plan
Plan.piece = lambda self, cluster: (5,)
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
    path, run, call = tmp_path / "sweep.zarr", sweeps.run, {"dt": 0.1, "t_end": 1.0, "omega": np.arange(1.0, 23.0)}
    done = subprocess.run([sys.executable, "-c", KILLED, str(path)], capture_output=True, check=False)
    assert done.returncode == -signal.SIGKILL, done.stderr
    left = xr.open_zarr(path, chunks=None, consolidated=False)
    assert left.attrs["interrupted"] == 1
    assert (left["status"] == 0).values.tolist() == [True] * 10 + [False] * 12
    for other, message in (
        ({"t_end": 2.0}, "whose t_end is 1.0, got 2.0; give save another path"),
        ({"omega": np.append(call["omega"][:-1], 99.0)}, r"expected omega\[21\] = 22.0 as in .*, got 99.0"),
        ({"omega": np.arange(1.0, 24.0)}, "expected 22 values of omega .* got 23"),
        ({"omega": 1.0, "xi": call["omega"]}, "whose scene_omega is not given, got 1.0"),
        ({"beta": 0.3}, "whose scheme_beta is 0.25, got 0.3"),
        ({"load": LOAD, "scene_omega": call["omega"], "omega": None}, "whose load is not given, got Harmonic"),
        ({"xi": [0.1, 0.2]}, "whose scene_xi is 0.0, got not given"),
        ({"keep": "peak"}, "whose keep is final, got peak"),
    ):
        changed = {k: x for k, x in {**call, **other}.items() if x is not None}
        with pytest.raises(ValueError, match=message):
            ss.sweep("linear_oscillator", "newmark", **changed, save=path)
    seen = []
    monkeypatch.setattr(sweeps, "run", lambda plan, first, last: (seen.append(first), run(plan, first, last))[1])
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

    def ramp(sign: float) -> Any:
        made = make_dataclass("Ramp", [("rate", float)], namespace={"__call__": lambda self, t: sign * self.rate * t})
        return made(2.0)

    call: dict[str, Any] = {"dt": 0.1, "t_end": 1.0, "omega": 2.0, "save": tmp_path / "s.zarr"}
    first = ss.sweep("linear_oscillator", "newmark", load=ramp(1.0), **call)
    assert first.attrs["load_rate"] == 2.0
    xr.testing.assert_identical(first, ss.sweep("linear_oscillator", "newmark", load=ramp(1.0), **call))
    with pytest.raises(ValueError, match="whose load_samples_sha256 is"):
        ss.sweep("linear_oscillator", "newmark", load=ramp(-1.0), **call)


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
    from substep.sweeps import progress

    monkeypatch.setenv("FORCE_COLOR", "1")  # rich takes it for a terminal
    sweep()
    assert capsys.readouterr() == ("", "")
    monkeypatch.setattr(progress, "AFTER", 0.0)
    monkeypatch.setattr(Plan, "piece", lambda self, cluster: (1,))
    sweep(progress=False)
    assert capsys.readouterr() == ("", "")
    sweep()
    assert "sweep" in capsys.readouterr().err
    monkeypatch.delenv("FORCE_COLOR")
    sweep()
    assert capsys.readouterr() == ("", "")
