"""Points of a sweep of a scene as the lanes of one march; results are arrays (P, ...)."""

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import copy_rows
from ..core.loads import is_known
from ..core.outcome import STATUSES
from ..core.response import Response
from ..core.scenes import Scene, make_scene
from ..core.schemes import Array, Scheme
from ..marching.adaptive import march_lanes_adaptive
from ..marching.run import march_oscillators, marched
from ..marching.scene_lanes import march_lanes, memory_in, pair_kernels
from ..run.clock import Control, number_of_steps
from .sweep_plan import Results, SweepPlan


class Marched(NamedTuple):
    """What is kept by name; Newton's iterations (P, 2, balances); steps completed (P,); status (P,) as in `Lanes`."""

    kept: Results
    newton: NDArray[np.int64]
    done: NDArray[np.int64]
    status: NDArray[np.int64]


def march_group(plan: SweepPlan, scene: Scene, scheme: Scheme, step: Any, P: int, room: Results) -> Results:
    """Results of P points that share dt, or with tol the scheme, and a load of the user's own; step: dt or tol.

    scene: what is swept is (P,), and so may be tol. room: as in `SweepPlan.run`.
    """
    if plan.by_tol:
        group = _chosen(plan, scene, scheme, step, P)
    else:
        n = number_of_steps(step, plan.t_end)
        stride = {"final": n, "peak": 1, "history": plan.stride(n)}[plan.keep]
        march = _oscillators if scene.info.oscillator else _others
        group = march(plan, scene, scheme, step, n, stride, P, room)
        group.kept["n_done"] = group.done
    newton, done = group.newton, group.done
    if not (newton.strides[0] or done.strides[0]):  # one for all lanes
        newton, done = newton[:1], done[:1]
    mean = np.empty((len(newton), newton.shape[2]))
    with np.errstate(invalid="ignore"):
        for k, of_balance in enumerate(newton[:, 0].T):
            np.divide(of_balance, done, out=mean[:, k])  # NaN if no step was completed
    of_newton = {"newton_iterations": np.broadcast_to(mean, (P, mean.shape[1])), "newton_most": group.newton[:, 1]}
    return {**group.kept, **of_newton, "status": group.status.astype(np.int8)}


def _oscillators(
    plan: SweepPlan, scene: Scene, scheme: Scheme, dt: float, n: int, stride: int, P: int, room: Results
) -> Marched:  # fmt: skip
    """March linear oscillators."""
    keep = "peak" if plan.keep == "peak" else "history"
    peaks = [room[f"peak_{name}"].reshape(P) for name in "uva"] if room and keep == "peak" else None
    peaks = None if plan.bound < math.inf else peaks
    lanes = march_oscillators(scene, scheme, dt, n, P, bound=plan.bound, stride=stride, keep=keep, peaks=peaks)
    of_march = np.broadcast_to(np.int64(0), (P, 2, scheme.balances)), lanes.n_done, lanes.status
    if keep == "peak":
        found = peaks or lanes.peak
        return Marched({f"peak_{name}": x[:, None] for name, x in zip("uva", found, strict=True)}, *of_march)
    t, first = np.arange(len(lanes.out)) * (stride * dt), int(plan.keep == "final")
    u, v, a = (lanes.out[first:, kind].T[..., None] for kind in range(3))
    found = {"u": u, "v": v, "a": a, "energy": scene.energy(t[first:], u, v)}
    return Marched({name: x[:, 0] if first else x for name, x in found.items()}, *of_march)


def _others(
    plan: SweepPlan, scene: Scene, scheme: Scheme, dt: float, n: int, stride: int, P: int, room: Results
) -> Marched:  # fmt: skip
    """March lanes of any other scene; their rows are read block by block, while they are in the cache.

    The largest moduli come from the kernel, but for accelerations that follow from u and v.
    """
    steps = np.full(P, dt), np.full(P, n)
    if plan.keep == "peak" and pair_kernels(scene, scheme).REPORTED == "uva":
        lanes = march_lanes(scene, scheme, *steps, bound=plan.bound, extremes="uva")
        found = {f"peak_{name}": lanes.extremes[:, k] for k, name in enumerate("uva")}
        return Marched({**found, "peak_energy": lanes.peak}, lanes.newton, lanes.n_done, lanes.status)
    t, d, rows = np.arange(n // stride + 1) * (stride * dt), scene.u0.shape[-1], n // stride + 1
    shapes = {f"peak_{name}": (P, d) for name in "uva"}
    if plan.keep != "peak":
        rows = 1 if plan.keep == "final" else rows
        shapes = {**dict.fromkeys("uva", (P, rows, d)), "energy": (P, rows)}
        shapes |= {"memory": (P, rows, k)} if (k := len(scene.info.memory)) else {}
    kept = {name: room[name].reshape(shape) if room else np.empty(shape) for name, shape in shapes.items()}
    of_rows = scene
    if not is_known(scene.load):  # threads evaluate only what is known
        forces = scene.forces(t)
        of_rows = replace(scene, load=lambda _: forces)

    def read(where: slice, out: Array, memory: Array) -> None:
        some, own = of_rows.lanes(where), out.shape[2] > 2
        u, v = out[:, :, 0], out[:, :, 1]
        a = out[:, :, 2] if own else _accelerations(some, t, u, v, memory)
        if plan.keep == "peak":
            for name, x in zip("uva", [*largest_moduli(out).swapaxes(0, 1), largest_moduli(a)], strict=True):
                kept[f"peak_{name}"][where] = x
            return
        u, v, a = (x[:, -rows:] for x in (u, v, a))
        for name, x in zip("uva", (u, v, a), strict=True):
            copy_rows(x, kept[name][where])
        kept["energy"][where] = some.energy(t[-rows:], u, v, memory[:, -rows:])
        if memory.shape[-1]:
            kept["memory"][where] = memory[:, -rows:]

    lanes = march_lanes(scene, scheme, *steps, bound=plan.bound, stride=stride, reader=read)
    if plan.keep == "peak":
        kept["peak_energy"] = lanes.peak
    found = {name: x[:, 0] if plan.keep == "final" else x for name, x in kept.items()}
    return Marched(found, lanes.newton, lanes.n_done, lanes.status)


def _chosen(plan: SweepPlan, scene: Scene, scheme: Scheme, tol: Any, P: int) -> Marched:
    """March lanes that choose their steps; they share the scheme and the load."""
    grid = {"final": np.array([plan.t_end]), "peak": None, "history": plan.chosen.get("grid")}[plan.keep]
    more = {name: value for name, value in plan.chosen.items() if name != "grid"}
    if scene.info.reactions:
        return _to_events(plan, scene, scheme, tol, P, more if grid is None else {**more, "grid": grid})
    one = Control.of(1.0, float(np.max(tol)), plan.t_end, **more, grid=grid)
    asked = one.over(scene.length, tol, {*more})
    peak = plan.keep == "peak"
    module, x = march_lanes_adaptive(scene, scheme, asked, P, bound=plan.bound, extremes=peak)
    counts, control, status = x["counts"], x["control"], x["status"]
    if peak:
        memory = np.broadcast_to(scene.memory0, (P, k)) if (k := len(scene.info.memory)) else None
        start = scene.energy(np.zeros(P), *(np.broadcast_to(x, (P, x.shape[-1])) for x in (scene.u0, scene.v0)), memory)
        found = {f"peak_{name}": x["extremes"][:, k] for k, name in enumerate("uva")}
        found["peak_energy"] = np.fmax(control[:, module.PEAK], start)
    else:
        out = x["out"]
        assert asked.grid is not None
        rows = {name: np.ascontiguousarray(out[:, :, k]) for k, name in enumerate("uva")}
        memory = memory_in(out, 3, len(scene.info.memory))
        rows["energy"] = scene.energy(asked.grid, rows["u"], rows["v"], memory)
        rows |= {"memory": memory} if memory.shape[-1] else {}
        found = {name: value[:, 0] if plan.keep == "final" else value for name, value in rows.items()}
    ended, made = control[:, module.TIME] + control[:, module.PROPOSED], counts[:, module.ACCEPTED]
    found |= {"accepted": made, "rejected": counts[:, module.REJECTED]}
    found["t_failed"] = np.where(status == STATUSES.index("completed"), np.nan, ended)
    return Marched(found, x["newton"], made, status)


def _to_events(
    plan: SweepPlan, scene: Scene, scheme: Scheme, tol: Any, P: int, chosen: Mapping[str, Any]
) -> Marched:  # fmt: skip
    """March one after another, since steps that end at events are no lanes of a kernel."""
    bound = None if plan.bound == math.inf else plan.bound
    runs = list[Response]()
    for k in range(P):
        own = {name: x[k] if np.ndim(x) else x for name, x in scene.parameters.items()}
        one = make_scene(scene.info, own, scene.a0_asked, scene.load)
        runs.append(marched(one, scheme, None, plan.t_end, 1, bound, np.broadcast_to(tol, P)[k], None, chosen))
    status = np.array([STATUSES.index(r.status) for r in runs])
    statistics = [r.statistics for r in runs if r.statistics]
    newton = np.array([(x.newton_iterations, x.newton_most) for x in statistics])
    made, rejected = (np.array([getattr(x, name) for x in statistics]) for name in ("accepted", "rejected"))
    rows = [{**{name: getattr(r, name) for name in ("u", "v", "a", "energy")}, "memory": r.memories} for r in runs]
    if plan.keep == "peak":
        found = {f"peak_{name}": np.array([np.fmax.reduce(np.abs(r[name])) for r in rows]) for name in "uva"}
        found["peak_energy"] = np.array([np.fmax.reduce(r["energy"]) for r in rows])
    else:
        of = {name: (P, len(chosen["grid"]), *np.shape(x)[1:]) for name, x in rows[0].items()}
        found = {name: np.full(shape, np.nan) for name, shape in of.items()}
        for name, k in product(found, range(P)):
            found[name][k, : len(rows[k][name])] = rows[k][name]
        found = {name: x[:, 0] if plan.keep == "final" else x for name, x in found.items()}
    found |= {"accepted": made, "rejected": rejected}
    found["t_failed"] = np.array([np.nan if r.t_failed is None else r.t_failed for r in runs])
    return Marched(found, newton, made, status)


def largest_moduli(x: Array, larger: Any = np.fmax) -> Array:
    """Largest modulus over the second axis of x (P, rows, ...), contiguous, which is overwritten.

    larger: of two arrays; by default NaN is left out.
    """
    np.abs(x, out=x)
    rows = x.shape[1]
    while rows > 1:  # the later half onto the earlier one: contiguous, as a maximum over the axis itself is not
        half = (rows + 1) // 2
        larger(x[:, : rows - half], x[:, half:rows], out=x[:, : rows - half])
        rows = half
    return x[:, 0]


def _accelerations(scene: Scene, t: Array, u: Array, v: Array, memory: Array) -> Array:
    """Accelerations (P, rows, d) of a scheme without its own: from the equation of motion, the start's as given.

    Where a run did not come they are NaN, also of coordinates on which nothing but constants and reactions acts.
    """
    a = np.where(np.isnan(u), np.nan, scene.acceleration(t, u, v, memory))
    a[:, 0] = scene.a0
    return a
