"""One chunk of a sweep: its points are the lanes of as few marches as possible; results are arrays (P, ...)."""

from typing import Any

import numpy as np

from ..core.scenes import Scene
from ..core.schemes import Array, Scheme
from ..core.threads import serial
from ..marching.run import march_oscillators, number_of_steps
from ..marching.scene_lanes import march_lanes
from .plan import Plan

Results = dict[str, Any]


def run_chunk(plan: Plan, first: int, last: int) -> Results:
    """Results of the points first to last - 1, by the variables' names in the Dataset, each (last - first, ...)."""
    found: Results = {}
    for places, scene, scheme, dt in plan.groups(np.arange(first, last)):
        group = _march_group(plan, scene, scheme, dt, len(places))
        if len(places) == last - first:
            return group
        for name, values in group.items():
            found.setdefault(name, np.empty((last - first, *values.shape[1:]), values.dtype))[places] = values
    return found


def run_on_one_core(span: tuple[int, int], plan: Plan) -> Results:
    """`run_chunk` for span = (first, last) on one core, in a worker of a cluster whose other cores run other chunks."""
    with serial():
        return run_chunk(plan, *span)


def _march_group(plan: Plan, scene: Scene, scheme: Scheme, dt: float, P: int) -> Results:
    """Results of P points that share the step, and a load of the user's own."""
    n = number_of_steps(dt, plan.t_end)
    stride = {"final": n, "peak": 1, "history": plan.stride(n)}[plan.keep]
    if scene.info.oscillator:
        keep = "peak" if plan.keep == "peak" else "history"
        linear = march_oscillators(scene, scheme, dt, n, P, bound=plan.bound, stride=stride, keep=keep)
        n_done, status = linear.n_done, linear.status
        newton = np.zeros((P, 2, scheme.balances), dtype=np.int64)
        rows = np.moveaxis(linear.out, -1, 0)[..., None]  # (P, rows, 3, 1)
        peaks = {f"peak_{name}": peak[:, None] for name, peak in zip("uva", linear.peak, strict=False)}
    else:
        steps = np.full(P, dt), np.full(P, n)
        lanes = march_lanes(scene, scheme, *steps, bound=plan.bound, stride=stride, history=True)
        n_done, status, newton = lanes.n_done, lanes.status, lanes.newton
        if (n_done < n).any():
            lanes.out[np.arange(lanes.out.shape[1]) > n_done[:, None] // stride] = np.nan
        rows, peaks = lanes.out, {"peak_energy": lanes.peak}
    with np.errstate(invalid="ignore"):
        mean = newton[:, 0] / n_done[:, None]  # NaN if no step was completed
    common = {
        "newton_iterations": mean,
        "newton_most": newton[:, 1],
        "n_done": n_done,
        "status": status.astype(np.int8),
    }
    if plan.keep == "peak" and scene.info.oscillator:
        return {**peaks, **common}
    t = np.arange(rows.shape[1]) * (stride * dt)
    u, v = rows[:, :, 0], rows[:, :, 1]
    a = rows[:, :, 2] if rows.shape[2] > 2 else _accelerations(scene, t, u, v)
    if plan.keep == "peak":
        return {
            **{f"peak_{k}": np.nanmax(np.abs(x), axis=1) for k, x in zip("uva", (u, v, a), strict=True)},
            **peaks,
            **common,
        }
    if plan.keep == "final":
        t, u, v, a = t[1:], u[:, 1:], v[:, 1:], a[:, 1:]
    energy = scene.energy(t, u, v)
    chosen = (slice(None), 0) if plan.keep == "final" else ()
    return {**{name: x[chosen] for name, x in {"u": u, "v": v, "a": a, "energy": energy}.items()}, **common}


def _accelerations(scene: Scene, t: Array, u: Array, v: Array) -> Array:
    """Accelerations (P, rows, d) of a scheme without its own: from the equation of motion, the start's as given."""
    a = scene.acceleration(t, u, v)
    a[:, 0] = scene.a0
    return a
