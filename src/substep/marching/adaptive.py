"""March in steps that are chosen from the estimated local error."""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cache, partial
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import device
from ..core.arrays import Array, digest
from ..core.kernel_modules import printed
from ..core.loads import ROUNDING, as_numbers, break_points
from ..core.outcome import STATUSES, Statistics
from ..core.response import Response
from ..core.scenes import Scene
from ..core.schemes import Scheme
from ..core.state import State, whose
from ..core.threads import spread
from ..derived import modules
from ..run.clock import Control
from .scene_lanes import TOLERANCE, memory_in, memory_of, put_memory

ROWS = 512  # of the first buffer; each further one holds twice as many
NANOSECONDS = 5e4  # of a run, roughly
FORK = "start", "here", "state", "control"  # what kernels go on from
OWN = "dt_first", "t_begin", "t_end"  # what differs between a run and the one that goes on from its fork
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


_kernels = cache(modules.adaptive_pair)


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
    on = _landed_on(scene, scheme, asked)
    breaks = np.union1d(breaks, on[(on > asked.t_begin) & (on < asked.t_end)])
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


def _landed_on(scene: Scene, scheme: Scheme, asked: Control) -> Array:
    """The times of the grid on which steps end, where the interpolant would lose what they have gained."""
    order, degree = scheme.local_error(scene.info.damped).order, adaptive_kernels(scene, scheme).DEGREE
    if asked.grid is None or order <= degree:
        return NO_GRID
    return asked.grid if asked.start is None else asked.grid[asked.grid > asked.start.t * (1.0 + ROUNDING)]


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
    """One run. bound: energy in J before which it stops; rows: of the first buffer; start: where it goes on from.

    After a run that differs in nothing but its end it goes on from the fork, without the rows until the start.
    """
    module, gridded = adaptive_kernels(scene, scheme), asked.grid is not None
    x = lanes_of(scene, scheme, asked, bound=bound, rows=rows, start=start)
    of, begin, fork = _of(scheme, module, x), x["start"][0], dict[str, Any]()
    if asked.start is not None and asked.start.of == of:
        fork = dict(asked.start.more)
        again = replace(asked, t_begin=float(fork["fork control"][module.TIME]))
        x = lanes_of(scene, scheme, again, bound=bound, rows=rows, start=start)
        _put_fork(module, x, fork, asked, begin)
    counts, control, last = x["counts"][0], x["control"][0], start and partial(replace, start)
    kept: list[tuple[Array, Array, NDArray[np.int64]]] = []
    next_fork = dict[str, Array]()
    counts[module.PAUSES] = 1
    while True:
        module.march(*x.values())
        if x["status"][0] == module.PAUSED:
            counts[module.PAUSES], next_fork = 0, _fork(module, x, _landed_on(scene, scheme, asked))
            continue
        n = counts[module.GRID if gridded else module.ROWS]
        kept.append((x["times"][0, :n], x["out"][0, :n], x["iterations"][0, :n]))
        if x["status"][0] != module.BUFFER_FULL:
            break
        counts[module.ROWS] = 0
        x |= _buffers(1, 2 * x["times"].shape[1], x["here"].shape[1:], module.BALANCES, gridded, x["extremes"])
    times, out, iterations = kept[0] if len(kept) == 1 else (np.concatenate(part) for part in zip(*kept, strict=True))
    before = None
    if fork and not gridded:
        hidden = np.append(False, ~asked.behind(times[1:]))
        k = int(hidden.sum())
        first, motion = (times[k], out[k]) if k else (fork["fork control"][module.TIME], fork["fork here"])
        before = float(first), motion[:3]
        times, out, iterations = times[~hidden], out[~hidden], iterations[~hidden]
    status: str = STATUSES[int(x["status"][0])]
    number, made = control.tolist(), counts.tolist()
    failed = None if status == "completed" else number[module.TIME] + number[module.PROPOSED]
    accepted, rejected, failures = (made[place] for place in (module.ACCEPTED, module.REJECTED, module.FAILED))
    steps = (number[module.SMALLEST], number[module.LARGEST]) if accepted else (math.nan, math.nan)
    iterations_of, most_of = (tuple(row) for row in x["newton"][0].tolist())
    statistics = Statistics(accepted, rejected, failures, iterations_of, most_of, *steps)
    names, here = scene.info.memory, x["here"][0].copy()
    memory = dict(zip(names, memory_in(here, 3, len(names)).tolist(), strict=True))
    if number[module.TIME] > asked.t_begin or last is None:  # else it failed before it came to the start once more
        last = partial(
            State, number[module.TIME], *here[:3], dt_next=number[module.PROPOSED], memory=memory,
            of=of if status == "completed" else "", more=next_fork if status == "completed" else {},
        )  # fmt: skip
    return Response(
        out[:, 0], out[:, 1], iterations[1:], status, failed, scene, scheme, math.nan, out[:, 2], times, statistics,
        started=start, last=last, memories=memory_in(out, 3, len(names)) if names else None, before=before,
    )  # fmt: skip


def _of(scheme: Scheme, module: ModuleType, x: Mapping[str, Any]) -> str:
    """What a state is of: the scheme, and all that a run has in common with one that goes on from its fork."""
    numbers = zip(module.SCALARS, x["numbers"][0].tolist(), strict=True)
    same = [value for name, value in numbers if name not in OWN]
    return whose(scheme, f"chosen steps {digest(module.__name__, module.SCENE, same, x['load'], x['samples'])}")


def _fork(module: ModuleType, x: Mapping[str, Any], grid: Array) -> dict[str, Array]:
    """Where a paused run is, and what its steps are still to end on besides t_end; grid: times of which they are."""
    ahead = np.union1d(x["targets"][0, :-1], grid)
    found = {name: x[name][0].copy() for name in FORK} | {"targets": ahead[ahead > x["control"][0, module.TIME]]}
    return {f"fork {name}": value for name, value in found.items() if value.size}


def _put_fork(module: ModuleType, x: dict[str, Any], fork: Mapping[str, Array], asked: Control, begin: Array) -> None:
    """Have the kernel go on from a fork; begin: the row at the start, in the place of those until then."""
    for name in FORK:
        x[name][0] = fork[f"fork {name}"]
    counts, control = x["counts"][0], x["control"][0]
    control[[module.PEAK, module.SMALLEST, module.LARGEST]] = -np.inf, np.inf, 0.0
    x["targets"] = np.union1d(x["targets"], fork.get("fork targets", NO_GRID))[None]
    known = 1 if asked.grid is None else len(asked.grid) - int(asked.behind(asked.grid).sum())
    x["times"][0, :known], x["out"][0, :known] = asked.t_begin, begin
    counts[module.BEGUN], counts[module.GRID if asked.grid is not None else module.ROWS] = 1, known
