"""One chunk of a sweep: its points are the lanes of as few marches as possible; results are arrays (P, ...)."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import copy_rows
from ..core.loads import is_known
from ..core.scenes import Scene
from ..core.schemes import Array, Scheme
from ..core.threads import serial
from ..marching.run import march_oscillators
from ..marching.scene_lanes import march_lanes
from ..run.clock import number_of_steps
from .chosen_lanes import march_chosen
from .sweep_plan import Chunk, Plan

Results = dict[str, Any]


def run_chunk(plan: Plan, first: int, last: int, room: Results | None = None) -> Results:
    """Results of the points first to last - 1, by the variables' names in the Dataset, each (last - first, ...).

    room: where some of them may be put, by name and of that shape; the others are new arrays.
    """
    found: Results = {}
    for places, scene, scheme, step in plan.groups(np.arange(first, last)):
        whole = len(places) == last - first
        if plan.by_tol:
            group = march_chosen(plan, scene, scheme, step, len(places))
        else:
            group = _march_group(plan, scene, scheme, step, len(places), room if whole and room else {})
        if whole:
            return group
        for name, values in group.items():
            found.setdefault(name, np.empty((last - first, *values.shape[1:]), values.dtype))[places] = values
    return found


def run_on_one_core(chunk: Chunk, plan: Plan) -> Results:
    """`run_chunk` on one core, in a worker of a cluster whose other cores run other chunks."""
    with serial():
        return run_chunk(plan, chunk.first, chunk.last)


def _march_group(plan: Plan, scene: Scene, scheme: Scheme, dt: float, P: int, room: Results) -> Results:
    """Results of P points that share the step, and a load of the user's own."""
    n = number_of_steps(dt, plan.t_end)
    stride = {"final": n, "peak": 1, "history": plan.stride(n)}[plan.keep]
    if scene.info.oscillator:
        kept, newton, n_done, status = _oscillators(plan, scene, scheme, dt, n, stride, P)
    else:
        kept, newton, n_done, status = _others(plan, scene, scheme, dt, n, stride, P, room)
    with np.errstate(invalid="ignore"):
        mean = newton[:, 0] / n_done[:, None]  # NaN if no step was completed
    return {
        **kept,
        "newton_iterations": mean,
        "newton_most": newton[:, 1],
        "n_done": n_done,
        "status": status.astype(np.int8),
    }


# what is kept by name; Newton's iterations (P, 2, balances), steps completed (P,), status (P,) as in `Lanes`
Marched = tuple[Results, NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]


def _oscillators(plan: Plan, scene: Scene, scheme: Scheme, dt: float, n: int, stride: int, P: int) -> Marched:
    """March linear oscillators."""
    keep = "peak" if plan.keep == "peak" else "history"
    lanes = march_oscillators(scene, scheme, dt, n, P, bound=plan.bound, stride=stride, keep=keep)
    of_march = np.zeros((P, 2, scheme.balances), dtype=np.int64), lanes.n_done, lanes.status
    if keep == "peak":
        return {f"peak_{name}": peak[:, None] for name, peak in zip("uva", lanes.peak, strict=True)}, *of_march
    t, first = np.arange(len(lanes.out)) * (stride * dt), int(plan.keep == "final")
    u, v, a = (lanes.out[first:, kind].T[..., None] for kind in range(3))
    found = {"u": u, "v": v, "a": a, "energy": scene.energy(t[first:], u, v)}
    return {name: x[:, 0] if first else x for name, x in found.items()}, *of_march


def _others(
    plan: Plan, scene: Scene, scheme: Scheme, dt: float, n: int, stride: int, P: int, room: Results
) -> Marched:  # fmt: skip
    """March lanes of any other scene; their rows are read block by block, while they are in the cache."""
    t, d, rows = np.arange(n // stride + 1) * (stride * dt), scene.u0.shape[-1], n // stride + 1
    shapes = {f"peak_{name}": (P, d) for name in "uva"}
    if plan.keep != "peak":
        rows = 1 if plan.keep == "final" else rows
        shapes = {**dict.fromkeys("uva", (P, rows, d)), "energy": (P, rows)}
    kept = {name: room[name].reshape(shape) if room else np.empty(shape) for name, shape in shapes.items()}
    of_rows = scene
    if not is_known(scene.load):  # threads evaluate only what is known
        forces = scene.forces(t)
        of_rows = replace(scene, load=lambda _: forces)

    def read(where: slice, out: Array) -> None:
        some, own = of_rows.lanes(where), out.shape[2] > 2
        u, v = out[:, :, 0], out[:, :, 1]
        a = out[:, :, 2] if own else _accelerations(some, t, u, v)
        if plan.keep == "peak":
            largest = [*_largest(out).swapaxes(0, 1), *([] if own else [_largest(a)])]
            for name, x in zip("uva", largest, strict=True):
                kept[f"peak_{name}"][where] = x
            return
        u, v, a = (x[:, -rows:] for x in (u, v, a))
        for name, x in zip("uva", (u, v, a), strict=True):
            copy_rows(x, kept[name][where])
        kept["energy"][where] = some.energy(t[-rows:], u, v)

    steps = np.full(P, dt), np.full(P, n)
    lanes = march_lanes(scene, scheme, *steps, bound=plan.bound, stride=stride, reader=read)
    if plan.keep == "peak":
        kept["peak_energy"] = lanes.peak
    found = {name: x[:, 0] if plan.keep == "final" else x for name, x in kept.items()}
    return found, lanes.newton, lanes.n_done, lanes.status


def _largest(x: Array) -> Array:
    """Largest modulus over the second axis of x (P, rows, ...), NaN left out; x, contiguous, is overwritten."""
    np.abs(x, out=x)
    rows = x.shape[1]
    while rows > 1:  # the later half onto the earlier one: contiguous, as a maximum over the axis itself is not
        half = (rows + 1) // 2
        np.fmax(x[:, : rows - half], x[:, half:rows], out=x[:, : rows - half])
        rows = half
    return x[:, 0]


def _accelerations(scene: Scene, t: Array, u: Array, v: Array) -> Array:
    """Accelerations (P, rows, d) of a scheme without its own: from the equation of motion, the start's as given."""
    a = scene.acceleration(t, u, v)
    a[:, 0] = scene.a0
    return a
