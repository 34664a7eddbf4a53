"""March in steps that are chosen from the estimated local error."""

import math
from functools import cache, partial
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import device
from ..core.arrays import Array
from ..core.kernel_modules import printed
from ..core.loads import ROUNDING, as_numbers, break_points
from ..core.response import STATUSES, Response, Statistics
from ..core.scenes import Scene
from ..core.schemes import Scheme
from ..core.state import State
from ..core.threads import spread
from ..run.clock import Control
from .scene_lanes import TOLERANCE, memory_in, memory_of, put_memory

ROWS = 512  # of the first buffer; each further one holds twice as many
NANOSECONDS = 5e4  # of a run, roughly
FULL = len(STATUSES)  # the kernels' status for rows that are full: to be called again
NO_GRID = np.empty(0)
NO_LOAD = as_numbers(None)


def adaptive_kernels(scene: Scene, scheme: Scheme) -> ModuleType:
    """The kernels of the scheme on the scene in steps of chosen length, printed to the user's cache on first use.

    Raises ValueError for a scheme without an estimate of its local error, or whose step cannot change.
    """
    return _kernels(*_of_kernels(scene, scheme))


def _of_kernels(scene: Scene, scheme: Scheme) -> tuple[Any, Any, Any, int, bool]:
    """What the kernels depend on."""
    error = scheme.local_error(scene.info.damped)
    return scheme.info.source, scene.info.source, error.terms, error.order, error.always


@cache
def _kernels(scheme: Any, scene: Any, terms: Any, order: int, always: bool) -> ModuleType:
    from ..derived.modules import adaptive_pair  # noqa: PLC0415 (the one door to SymPy)

    return adaptive_pair(scheme, scene, terms, order, always)


def lanes_of(
    scene: Scene,
    scheme: Scheme,
    asked: Control,
    P: int = 1,
    *,
    bound: Any = math.inf,
    rows: int = 0,
    start: State | None = None,
    extremes: bool = False,
) -> dict[str, Any]:
    """The arguments of the kernel, by name, for P runs of one scene and scheme; rows: of the buffers without a grid.

    start: where they go on from, in place of the scene's start. extremes: whether the largest moduli are looked for.
    """
    error, d = scheme.local_error(scene.info.damped), scene.u0.shape[-1]
    module = adaptive_kernels(scene, scheme)
    grid = NO_GRID if asked.grid is None else asked.grid
    breaks = NO_GRID if scene.load is None else break_points(scene.load, asked.t_end)
    breaks = breaks[breaks > asked.t_begin * (1.0 + ROUNDING)]
    if grid.size and error.order > module.DEGREE:  # the interpolant would lose what the steps have gained
        breaks = np.union1d(breaks, grid[(grid > asked.t_begin) & (grid < asked.t_end)])
    load, samples = NO_LOAD if scene.load is None else as_numbers(scene.load)
    length, weights = scene.length, enumerate(error.weights)
    named = {
        **printed({**scene.parameters, **scheme.parameters}), **{f"weight_{k}": x for k, x in weights}, **vars(asked),
        "tolerance": TOLERANCE * length, "power": 0.5 / (error.order + 1), "length": length,
        "bound": bound, "rung": module.RUNG if asked.rung is None else asked.rung,
    }  # fmt: skip
    numbers = np.empty((P, len(module.SCALARS)))
    for k, name in enumerate(module.SCALARS):
        numbers[:, k] = named[name]
    remembered = len(scene.info.memory)
    vectors = np.zeros((P, 3 - (-remembered // d), d))
    if remembered:
        put_memory(vectors, 3, scene.memory0 if start is None else memory_of(scene, start))
    for k, (name, x) in enumerate((("u", scene.u0), ("v", scene.v0), ("a", scene.a0))):
        vectors[:, k] = x if start is None else getattr(start, name)
    targets = np.empty((1, len(breaks) + 1))
    targets[0, :-1], targets[0, -1] = breaks, asked.t_end
    size = grid.size or rows
    return {
        "numbers": numbers,
        "start": vectors,
        "load": load,
        "samples": samples,
        "targets": targets,
        "grid": grid,
        "state": np.empty((P, module.STATE, d)),
        "here": np.empty(vectors.shape),
        "control": np.zeros((P, module.CONTROL)),
        "counts": np.zeros((P, module.COUNTS), np.int64),
        "newton": np.zeros((P, 2, module.BALANCES), np.int64),
        **_buffers(P, size, vectors.shape[1:], module.BALANCES, bool(grid.size), np.abs(vectors[:, : 3 * extremes])),
        "status": np.empty(P, np.int64),
    }


def _buffers(
    P: int, rows: int, of_row: tuple[int, ...], balances: int, gridded: bool, largest: Array
) -> dict[str, NDArray[Any]]:
    return {
        "times": np.empty((P, rows)),
        "out": np.empty((P, rows, *of_row)),
        "extremes": largest,
        "iterations": np.zeros((P, 0 if gridded else rows, balances), np.int64),
    }


def march_lanes_adaptive(
    scene: Scene, scheme: Scheme, asked: Control, P: int, *, bound: float = math.inf, extremes: bool = False
) -> tuple[ModuleType, dict[str, Any]]:  # fmt: skip
    """P runs by threads, each with steps of its own; the kernels and their arguments by name.

    scene: parameters that are arrays are (P,). Rows are those of the grid, in `out`, NaN where a run did not reach it;
    extremes: whether the largest |u|, |v|, |a| of the steps are found, in `extremes` (P, 3, d).
    """
    module = adaptive_kernels(scene, scheme)
    x = lanes_of(scene, scheme, asked, P, bound=bound, extremes=extremes)
    if asked.grid is not None:
        x["out"][:] = np.nan
    if device.is_on():
        device.adaptive_march(*_of_kernels(scene, scheme), tuple(x))(*x.values())
        return module, x
    shared = {name for name, value in x.items() if name in device.SHARED or len(value) != P}

    def part(first: int, last: int) -> None:
        module.march(*(value if name in shared else value[first:last] for name, value in x.items()))

    spread(part, P, 1, nanoseconds=P * NANOSECONDS)
    return module, x


def march_adaptive(
    scene: Scene,
    scheme: Scheme,
    asked: Control,
    *,
    bound: float = math.inf,
    rows: int = ROWS,
    start: State | None = None,
) -> Response:
    """One run. bound: energy in J before which it stops; rows: of the first buffer; start: where it goes on from."""
    module = adaptive_kernels(scene, scheme)
    x = lanes_of(scene, scheme, asked, bound=bound, rows=rows, start=start)
    counts, control, gridded = x["counts"][0], x["control"][0], asked.grid is not None
    kept: list[tuple[Array, Array, NDArray[np.int64]]] = []
    while True:
        module.march(*x.values())
        n = counts[module.GRID if gridded else module.ROWS]
        kept.append((x["times"][0, :n], x["out"][0, :n], x["iterations"][0, :n]))
        if x["status"][0] != FULL:
            break
        counts[module.ROWS] = 0
        x |= _buffers(1, 2 * x["times"].shape[1], x["here"].shape[1:], module.BALANCES, gridded, x["extremes"])
    times, out, iterations = kept[0] if len(kept) == 1 else (np.concatenate(part) for part in zip(*kept, strict=True))
    status: str = STATUSES[int(x["status"][0])]
    number, made = control.tolist(), counts.tolist()
    failed = None if status == "completed" else number[module.TIME] + number[module.PROPOSED]
    accepted, rejected, failures = (made[place] for place in (module.ACCEPTED, module.REJECTED, module.FAILED))
    steps = (number[module.SMALLEST], number[module.LARGEST]) if accepted else (math.nan, math.nan)
    iterations_of, most_of = (tuple(row) for row in x["newton"][0].tolist())
    statistics = Statistics(accepted, rejected, failures, iterations_of, most_of, *steps)
    names, here = scene.info.memory, x["here"][0].copy()
    memory = dict(zip(names, memory_in(here, 3, len(names)).tolist(), strict=True))
    last = partial(State, number[module.TIME], *here[:3], dt_next=number[module.PROPOSED], memory=memory)
    return Response(
        out[:, 0], out[:, 1], iterations[1:], status, failed, scene, scheme, math.nan, out[:, 2], times, statistics,
        started=start, last=last, memories=memory_in(out, 3, len(names)) if names else None,
    )  # fmt: skip
