"""Rows of pendulums read block by block as they are written, and what a sweep takes from them."""

import threading
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from by_hand import SCENES, push
from declared import BY_NAME
from plain_kernels import variant
from test_pairs import PARAMETERS

import substep as ss
from substep.core.arrays import copy_rows
from substep.marching import scene_lanes
from substep.marching.scene_lanes import march_lanes
from substep.sweeps import lanes as sweep_lanes
from substep.sweeps.scene_plan import ScenePlan

Array = np.ndarray
P = 5


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("stride", [1, 2, 3])
@pytest.mark.parametrize("name", BY_NAME)
def test_rows_are_those_of_the_history(name: str, stride: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two lanes at a time, few and many: lengths of run differ, one lane is stopped by its bound, another one fails."""
    hand, s = SCENES["elastic_pendulum"], ss.scheme(name, **PARAMETERS.get(name, {}))
    scene = variant("elastic_pendulum", **hand.parameters)
    dt, n = hand.dt * np.array([1.0, 0.7, 40.0, 1.3, 0.9]), np.array([7, 2, 6, 5, 1])
    bound = np.array([np.inf, np.inf, 1e300, 0.5 * scene.E0, np.inf])
    monkeypatch.setattr(scene_lanes, "LEAST", 2)
    monkeypatch.setattr(scene_lanes, "NEAR", 1)
    for few in (100, 0):
        monkeypatch.setattr(scene_lanes, "FEW", few)
        whole = march_lanes(scene, s, dt, n, bound=bound, stride=stride, history=True)
        found, seen = np.full_like(whole.out, 7.0), np.zeros(P, dtype=int)

        def read(where: slice, rows: Array, memory: Array, found: Array = found, seen: Array = seen) -> None:
            found[where] = rows
            seen[where] += 1
            rows[...] = 3.0  # a reader may change them

        lanes = march_lanes(scene, s, dt, n, bound=bound, stride=stride, reader=read, extremes="uva")
        assert (seen == 1).all()
        assert not lanes.out.shape[1] or s.starter is not None
        reached = np.arange(found.shape[1]) <= whole.n_done[:, None] // stride
        assert np.array_equal(found[reached], whole.out[reached])
        assert np.isnan(found[~reached]).all()
        assert np.array_equal(lanes.extremes, np.nanmax(np.abs(found), axis=1))
        alone = march_lanes(scene, s, dt, n, bound=bound, stride=stride, extremes="u")
        assert np.array_equal(alone.extremes, lanes.extremes[:, :1])
        for kept in ("state", "newton", "peak", "n_done", "status"):
            assert np.array_equal(getattr(lanes, kept), getattr(whole, kept), equal_nan=True), kept


@pytest.mark.usefixtures("plain_marches", "uncompiled")
@pytest.mark.parametrize("name", ["newmark_bdf2", "rk4", "park"])  # own a, none, a starter
@pytest.mark.parametrize("keep", ["peak", "history"])
def test_a_sweep_is_its_points_also_where_runs_end_early(
    name: str, keep: Any, monkeypatch: pytest.MonkeyPatch
) -> None:  # fmt: skip
    """Lanes in blocks of LEAST, chunks of two sizes, one of few lanes; fast runs end at their bound at once."""
    v0, dt, n = np.linspace(1.0, 8.0, 23), 0.02, 12
    bound = ss.scene("elastic_pendulum", EA=1e3, v0=4.1).E0
    monkeypatch.setattr(scene_lanes, "NEAR", 1)
    monkeypatch.setattr(ScenePlan, "piece", lambda self, cluster: (17,))
    more: dict[str, Any] = {"energy_bound": bound, "keep": keep, "progress": False}
    found = ss.sweep("elastic_pendulum", name, dt=dt, t_end=n * dt, EA=1e3, v0=v0, **more)
    done = found["n_done"].values
    for k in range(0, len(v0), 2):
        scene = ss.scene("elastic_pendulum", EA=1e3, v0=v0[k])
        r = ss.march(scene, ss.scheme(name), dt, n * dt, energy_bound=bound)
        assert done[k] == len(r.newton_iterations)
        for key, own in {"u": r.u, "v": r.v, "a": r.a}.items():
            scale = np.abs(own).max()
            if keep == "peak":
                assert np.abs(found[f"peak_{key}"].values[k] - np.abs(own).max(axis=0)).max() <= 1e-11 * scale
            else:
                assert np.abs(found[key].values[k, : done[k] + 1] - own).max() <= 1e-11 * scale
                assert np.isnan(found[key].values[k, done[k] + 1 :]).all()
    assert done.min() < n == done.max()


def test_histories_of_chunks_that_were_not_run_are_reset(monkeypatch: pytest.MonkeyPatch) -> None:
    run = ScenePlan.run

    def interrupted(plan: ScenePlan, first: int, *rest: Any) -> Any:
        if first:
            for x in rest[1].values():
                x[...] = 5  # half written
            raise KeyboardInterrupt
        return run(plan, first, *rest)

    monkeypatch.setattr(ScenePlan, "run", interrupted)
    monkeypatch.setattr(ScenePlan, "piece", lambda self, cluster: (2,))
    found = ss.sweep("elastic_pendulum", "newmark", dt=0.1, t_end=0.3, EA=[1e3, 1e4, 1e5], keep="history")
    assert found["status"].values.tolist() == [0, 0, -1]
    assert found.attrs["interrupted"] == 1
    for name in ("u", "v", "a", "energy", "newton_iterations"):
        assert found[name].values[:2].size > 0
        assert not np.isnan(found[name].values[:2]).any()
        assert np.isnan(found[name].values[2:]).all()
    assert (found["n_done"].values[2:] == 0).all()


@pytest.mark.usefixtures("uncompiled")
def test_a_load_of_the_users_own_is_evaluated_by_the_calling_thread_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """A scheme without its own acceleration takes it from the equation of motion, which has the load in it."""
    callers = set()

    def load(t: Array) -> Array:
        callers.add(threading.get_ident())
        return push(t)

    def elsewhere(part: Any, size: int, block: int, *, nanoseconds: float) -> None:
        with ThreadPoolExecutor(1) as pool:
            pool.submit(part, 0, size).result()

    hand, s, lanes, n = SCENES["linear_oscillator"], ss.scheme("rk4"), 3, 6
    scene = variant("linear_oscillator", load=load, **hand.parameters)
    monkeypatch.setattr(scene_lanes, "spread", elsewhere)
    for keep in ("peak", "history"):
        plan: Any = SimpleNamespace(keep=keep, bound=np.inf)
        found, _, n_done, _ = sweep_lanes._others(plan, scene, s, hand.dt, n, 1, lanes, {})
        assert (n_done == n).all()
        assert callers == {threading.get_ident()}
        whole = march_lanes(scene, s, np.full(lanes, hand.dt), np.full(lanes, n), history=True)
        t = np.arange(n + 1) * hand.dt
        assert whole.out.shape[2] == 2
        a = scene.acceleration(t, whole.out[:, :, 0], whole.out[:, :, 1])
        a[:, 0] = scene.a0
        expected = np.abs(a).max(axis=1) if keep == "peak" else a
        assert np.allclose(found["peak_a" if keep == "peak" else "a"], expected, rtol=1e-14, atol=0.0)


@pytest.mark.parametrize("d", [1, 2, 3])
def test_rows_are_copied_and_folded(d: int) -> None:
    rng = np.random.default_rng(d)
    for rows in (1, 2, 5, 8, 13):
        x = rng.normal(size=(4, rows, 3, d))
        to = np.empty((4, rows, d))
        copy_rows(x[:, :, 1], to)
        assert np.array_equal(to, x[:, :, 1])
        x[1, rows // 2 + 1 :] = np.nan
        expected = np.nanmax(np.abs(x), axis=1)
        assert np.array_equal(sweep_lanes.largest_moduli(x.copy()), expected)
