"""March in steps that are chosen from the estimated local error."""

import math
from collections.abc import Callable
from functools import cache, partial
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Array
from ..core.kernel_modules import printed
from ..core.loads import ROUNDING, as_numbers, break_points
from ..core.response import STATUSES, Response, Statistics
from ..core.scenes import Scene
from ..core.schemes import Scheme
from ..core.state import State
from ..core.threads import spread
from ..run.clock import Control
from .scene_lanes import TOLERANCE

ROWS = 512  # of the first buffer; each further one holds twice as many
NANOSECONDS = 5e4  # of a run, roughly
FULL = len(STATUSES)  # the kernels' status for rows that are full: to be called again
NO_GRID = np.empty(0)
NO_LOAD = as_numbers(None)


def adaptive_kernels(scene: Scene, scheme: Scheme) -> ModuleType:
    """The kernels of the scheme on the scene in steps of chosen length, printed to the user's cache on first use.

    Raises ValueError for a scheme without an estimate of its local error, or whose step cannot change.
    """
    error = scheme.local_error(scene.info.damped)
    return _kernels(scheme.info.source, scene.info.source, error.terms, error.order, error.always)


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
) -> dict[str, Any]:
    """The arguments of the kernel, by name, for P runs of one scene and scheme; rows: of the buffers without a grid.

    start: where they go on from, in place of the scene's start.
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
    vectors = np.empty((P, 3, d))
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
        "here": np.empty((P, 3, d)),
        "control": np.zeros((P, module.CONTROL)),
        "counts": np.zeros((P, module.COUNTS), np.int64),
        "newton": np.zeros((P, 2, module.BALANCES), np.int64),
        **_buffers(P, size, d, module.BALANCES, bool(grid.size)),
        "status": np.empty(P, np.int64),
    }


def _buffers(P: int, rows: int, d: int, balances: int, gridded: bool) -> dict[str, NDArray[Any]]:
    return {
        "times": np.empty((P, rows)),
        "out": np.empty((P, rows, 3, d)),
        "iterations": np.zeros((P, 0 if gridded else rows, balances), np.int64),
    }


RowReader = Callable[[int, Array], None]  # takes rows (rows, 3, d) of u, v, a of a lane, those not yet given to it


def march_lanes_adaptive(
    scene: Scene, scheme: Scheme, asked: Control, P: int, *, bound: float = math.inf,
    reader: RowReader | None = None,
) -> tuple[ModuleType, dict[str, Any]]:  # fmt: skip
    """P runs by threads, each with steps of its own; the kernels and their arguments by name.

    scene: parameters that are arrays are (P,). Rows are those of the grid, in `out`, NaN where a run did not reach it;
    reader: without a grid, called by several threads at once with all rows of a lane, part by part.
    """
    module = adaptive_kernels(scene, scheme)
    x = lanes_of(scene, scheme, asked, P, bound=bound, rows=ROWS if reader else 0)
    shared = {name for name, value in x.items() if name in ("samples", "grid") or len(value) != P}
    if asked.grid is not None:
        x["out"][:] = np.nan

    def part(first: int, last: int) -> None:
        own = {name: value if name in shared else value[first:last] for name, value in x.items()}
        module.march(*own.values())
        if reader is None:
            return
        for k in range(last - first):
            lane = {name: value if name in shared else value[k : k + 1] for name, value in own.items()}
            while True:
                n = lane["counts"][0, module.ROWS]
                reader(first + k, lane["out"][0, :n])
                if lane["status"][0] != FULL:
                    break
                lane["counts"][0, module.ROWS] = 0
                module.march(*lane.values())

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
        x |= _buffers(1, 2 * x["times"].shape[1], scene.u0.shape[-1], module.BALANCES, gridded)
    times, out, iterations = kept[0] if len(kept) == 1 else (np.concatenate(part) for part in zip(*kept, strict=True))
    status: str = STATUSES[int(x["status"][0])]
    number, made = control.tolist(), counts.tolist()
    failed = None if status == "completed" else number[module.TIME] + number[module.PROPOSED]
    accepted, rejected, failures = (made[place] for place in (module.ACCEPTED, module.REJECTED, module.FAILED))
    steps = (number[module.SMALLEST], number[module.LARGEST]) if accepted else (math.nan, math.nan)
    iterations_of, most_of = (tuple(row) for row in x["newton"][0].tolist())
    statistics = Statistics(accepted, rejected, failures, iterations_of, most_of, *steps)
    last = partial(State, number[module.TIME], *x["here"][0].copy(), dt_next=number[module.PROPOSED])
    return Response(
        out[:, 0], out[:, 1], iterations[1:], status, failed, scene, scheme, math.nan, out[:, 2], times, statistics,
        started=start, last=last,
    )  # fmt: skip
