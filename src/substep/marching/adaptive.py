"""March in steps that are chosen from the estimated local error."""

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core.arrays import Array
from ..core.errors import real_array, real_number
from ..core.kernel_modules import printed
from ..core.loads import as_numbers, break_points
from ..core.response import STATUSES, Response, Statistics
from ..core.scenes import Scene
from ..core.schemes import Scheme
from ..core.threads import spread
from .scene_lanes import TOLERANCE

ROWS = 512  # of the first buffer; each further one holds twice as many
NANOSECONDS = 5e4  # of a run, roughly
FULL = len(STATUSES)  # the kernels' status for rows that are full: to be called again
NO_GRID = np.empty(0)
NO_LOAD = as_numbers(None)


@dataclass(frozen=True)
class Control:
    """What is asked of chosen steps; rtol, atol_u and share_v may be (P,), for lanes.

    A step is accepted if the root of the mean square of its estimated errors, each over its scale, is at most 1. The
    scale of a component of u is atol_u + rtol*|u|, that of v is atol_v + share_v*(largest |v| so far) + rtol*|v|.
    dt_first: 0 to choose it from the first accelerations; dt_min, dt_max: bounds, s. grid (n,): times at which rows are
    wanted, None for a row a step. rung: ratio of the lengths between which steps move, 0 for any length, None for what
    the kernels' derivation says.
    """

    rtol: Any
    atol_u: Any
    atol_v: float
    share_v: Any
    dt_first: float = 0.0
    dt_min: float = 0.0
    dt_max: float = math.inf
    grid: Array | None = None
    rung: float | None = None

    @classmethod
    def of(
        cls,
        length: float,
        tol: float,
        t_end: float,
        *,
        rtol: float | None = None,
        atol: float | Sequence[float] | None = None,
        dt_first: float | None = None,
        dt_min: float | None = None,
        dt_max: float | None = None,
        grid: ArrayLike | None = None,
        rung: float | None = None,
    ) -> "Control":
        """Checked arguments of `march`; length: of the scene. Raises ValueError, with the cure."""
        tol = real_number("tol", tol, positive=True)
        rtol = tol if rtol is None else real_number("rtol", rtol)
        atol_u, atol_v, share_v = tol * length, 0.0, tol
        if atol is not None:
            given = real_array("atol", atol)
            if given.shape not in ((), (2,)):
                raise ValueError(f"expected atol of u, or of u and v, got shape {given.shape}; give one or two numbers")
            atol_u = float(given.flat[0])
            if given.ndim:
                atol_v, share_v = float(given[1]), 0.0
        if min(rtol, atol_u, atol_v) < 0 or (rtol == 0 and atol_u == 0) or (rtol == 0 and atol_v + share_v == 0):
            raise ValueError(
                f"expected rtol >= 0 and atol >= 0, not both 0, got {rtol} and {atol}; one of them must bound the error"
            )
        found = {"dt_first": dt_first, "dt_min": dt_min, "dt_max": dt_max}
        steps = {name: real_number(name, x, positive=True) for name, x in found.items() if x is not None}
        low, high = steps.get("dt_min", 0.0), steps.get("dt_max", math.inf)
        if low > high:
            raise ValueError(f"expected dt_min <= dt_max, got {low} > {high}; exchange them or drop one")
        if "dt_first" in steps and not low <= steps["dt_first"] <= high:
            raise ValueError(
                f"expected dt_first between dt_min = {low} and dt_max = {high}, got {steps['dt_first']}; "
                "change it, or leave it out"
            )
        if rung is not None and (rung := real_number("rung", rung)) != 0.0 and not 1.0 < rung <= 10.0:
            raise ValueError(
                f"expected rung between 1 and 10, the ratio of two lengths of steps, or 0 for any length, got {rung}; "
                "take 2**0.5, or leave it out"
            )
        rows = None if grid is None else _grid(grid, t_end)
        return cls(rtol, atol_u, atol_v, share_v, **steps, grid=rows, rung=rung)

    def over(self, length: Any, tol: Any, given: Collection[str]) -> "Control":
        """The same for lanes: scene's lengths and tolerances (P,); given: arguments that stay as they are."""
        own: dict[str, Any] = {} if "rtol" in given else {"rtol": tol}
        if "atol" not in given:
            own["atol_u"] = tol * length
        return replace(self, **own, share_v=tol if self.share_v else 0.0)


def _grid(grid: ArrayLike, t_end: float) -> Array:
    times = real_array("grid", grid).copy()
    if times.ndim != 1 or not times.size or (np.diff(times) <= 0).any():
        raise ValueError(f"expected grid to be a row of ascending times, got shape {times.shape}; sort it, each once")
    if times[0] < 0.0 or times[-1] > t_end * (1.0 + 1e-12):
        raise ValueError(
            f"expected grid within 0 and t_end = {t_end:.12g}, got {times[0]:.12g} to {times[-1]:.12g}; cut it, or "
            "change t_end"
        )
    return np.minimum(times, t_end)


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
    scene: Scene, scheme: Scheme, asked: Control, t_end: float, P: int = 1, *, bound: Any = math.inf, rows: int = 0
) -> dict[str, Any]:
    """The arguments of the kernel, by name, for P runs of one scene and scheme; rows: of the buffers without a grid."""
    error, d = scheme.local_error(scene.info.damped), scene.u0.shape[-1]
    module = adaptive_kernels(scene, scheme)
    grid = NO_GRID if asked.grid is None else asked.grid
    breaks = NO_GRID if scene.load is None else break_points(scene.load, t_end)
    if grid.size and error.order > module.DEGREE:  # the interpolant would lose what the steps have gained
        breaks = np.union1d(breaks, grid[(grid > 0.0) & (grid < t_end)])
    load, samples = NO_LOAD if scene.load is None else as_numbers(scene.load)
    length, weights = scene.length, enumerate(error.weights)
    named = {
        **printed({**scene.parameters, **scheme.parameters}), **{f"weight_{k}": x for k, x in weights}, **vars(asked),
        "tolerance": TOLERANCE * length, "power": 0.5 / (error.order + 1), "length": length, "t_end": t_end,
        "bound": bound, "rung": module.RUNG if asked.rung is None else asked.rung,
    }  # fmt: skip
    numbers = np.empty((P, len(module.SCALARS)))
    for k, name in enumerate(module.SCALARS):
        numbers[:, k] = named[name]
    start = np.empty((P, 3, d))
    start[:, 0], start[:, 1], start[:, 2] = scene.u0, scene.v0, scene.a0
    targets = np.empty((1, len(breaks) + 1))
    targets[0, :-1], targets[0, -1] = breaks, t_end
    size = grid.size or rows
    return {
        "numbers": numbers,
        "start": start,
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
    scene: Scene, scheme: Scheme, asked: Control, t_end: float, P: int, *, bound: float = math.inf,
    reader: RowReader | None = None,
) -> tuple[ModuleType, dict[str, Any]]:  # fmt: skip
    """P runs from t = 0 to t_end (s) by threads, each with steps of its own; the kernels and their arguments by name.

    scene: parameters that are arrays are (P,). Rows are those of the grid, in `out`, NaN where a run did not reach it;
    reader: without a grid, called by several threads at once with all rows of a lane, part by part.
    """
    module = adaptive_kernels(scene, scheme)
    x = lanes_of(scene, scheme, asked, t_end, P, bound=bound, rows=ROWS if reader else 0)
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
    scene: Scene, scheme: Scheme, asked: Control, t_end: float, *, bound: float = math.inf, rows: int = ROWS
) -> Response:
    """One run from t = 0 to t_end (s). bound: energy in J before which it stops; rows: of the first buffer."""
    module = adaptive_kernels(scene, scheme)
    x = lanes_of(scene, scheme, asked, t_end, bound=bound, rows=rows)
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
    return Response(
        out[:, 0], out[:, 1], iterations[1:], status, failed, scene, scheme, math.nan, out[:, 2], times, statistics
    )  # fmt: skip
