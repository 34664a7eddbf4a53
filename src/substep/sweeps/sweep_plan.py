"""What a sweep runs: its axes, the points of their outer product in C order, and chunks of points.

A point is one run. Points that share the step, and a load of the user's own, can be the lanes of one march.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core.errors import real_array, real_number
from ..core.loads import Load, LoadLanes, Record, as_numbers, is_known
from ..core.scenes import Scene, checked_parameters, make_scene, scene_info
from ..core.schemes import Scheme
from ..core.schemes import scheme as make_scheme
from ..marching.adaptive import ROWS, adaptive_kernels
from ..marching.linear import LOADED
from ..run.axes import RESERVED, Axis, Keep, Owner, asked, checked_end, step_asked
from ..run.clock import Control, number_of_steps

if TYPE_CHECKING:
    from ..derived.modules import Declaration, SceneDeclaration

MEMORY = 64e6  # bytes that a chunk takes while it is run
LANE_STEPS = {True: 5e7, False: 4e6}  # linear march or not -> steps of all lanes of a chunk: about 0.2 s on one core
CHOSEN_STEPS = 2000  # taken for the number of steps of a run that chooses them
FOR_A_CLUSTER = 2e6  # fewest such steps of a chunk for another process: sending it must take little of the time


class Chunk(NamedTuple):
    """Points first to last - 1 in C order, and where they stand in the outer product."""

    first: int
    last: int
    where: tuple[slice, ...]


@dataclass(frozen=True, eq=False)
class Plan:
    """A checked sweep as plain data, which is all that a worker is sent.

    scene, scheme: name, or a declaration of the user's own. given: parameters that are the same in all points, by
    owner. a0, load, t_end (s), keep, samples: as in `substep.sweep`. bound: energy in J, inf for none. chosen: what is
    asked of steps that runs choose, as in `substep.march`, by name.
    """

    scene: "str | SceneDeclaration"
    scheme: "str | Declaration"
    given: Mapping[Owner, Mapping[str, Any]]
    a0: ArrayLike | str | None
    load: Load | None
    axes: tuple[Axis, ...]
    t_end: float
    keep: Keep
    samples: int | None
    bound: float
    chosen: Mapping[str, Any]

    @property
    def by_tol(self) -> bool:
        """Whether each run chooses its steps."""
        return "tol" in self.given["step"] or any((axis.owner, axis.key) == ("step", "tol") for axis in self.axes)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """How many values each axis has."""
        return tuple(len(axis.values) for axis in self.axes)

    @cached_property
    def steps(self) -> tuple[int, ...]:
        """How many steps a run takes, for each dt; none where runs choose their steps."""
        if self.by_tol:
            return ()
        swept = [axis.values for axis in self.axes if axis.owner == "step"]
        return tuple(
            number_of_steps(float(dt), self.t_end) for dt in (swept[0] if swept else [self.given["step"]["dt"]])
        )

    @cached_property
    def scheme_of_all(self) -> Scheme:
        """The scheme with parameters that broadcast over its axes; making it checks all combinations of values."""
        swept = [axis for axis in self.axes if axis.owner == "scheme"]
        spread = (axis.values.reshape(-1, *(1,) * (len(swept) - 1 - k)) for k, axis in enumerate(swept))
        return make_scheme(
            self.scheme, **self.given["scheme"], **{a.key: x for a, x in zip(swept, spread, strict=True)}
        )

    @cached_property
    def scene_of_one(self) -> Scene:
        """The scene at the first value of each axis, NaN for an axis without values; making it checks all values."""
        swept = {axis.key: axis.values for axis in self.axes if axis.owner == "scene"}
        info = scene_info(self.scene, {})
        values = checked_parameters(info, {**self.given["scene"], **swept}, real_array)
        ones = {key: float(x[0] if np.size(x) else np.nan) if np.ndim(x) else x for key, x in values.items()}
        return make_scene(info, ones, self.a0, self.load)

    @property
    def oscillator(self) -> bool:
        """Whether the scene is a linear oscillator, which the linear march runs."""
        return self.scene_of_one.info.oscillator is not None

    def stride(self, n: int) -> int:
        """How many of n steps lie between two rows of the history."""
        return 1 if self.samples is None else n // self.samples

    @property
    def rows(self) -> int:
        """How many rows a history has, with that of the start or on the grid."""
        if self.by_tol:
            return len(self.chosen["grid"])
        return 1 + (self.samples or max(self.steps, default=0))

    def __getstate__(self) -> dict[str, Any]:
        """Only the fields: cached handles of scheme and scene hold functions, which cannot be pickled."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def groups(self, points: NDArray[np.int64]) -> Iterator[tuple[NDArray[np.int64], Scene, Scheme, Any]]:
        """The points in groups that can be the lanes of one march: their places, scene, scheme, and dt or tol.

        Points of a group share the step, and a load of the user's own. Where they choose their steps, they share the
        load and the scheme's parameters, on which its estimate depends.
        """
        at = dict(zip(self.axes, np.unravel_index(points, (1, *self.shape))[1:], strict=True))
        common = ("scheme", "load") if self.by_tol else ("step",) if is_known(self.load) else ("step", "load")
        keys = [at[axis] for axis in self.axes if axis.owner in common]
        if not keys:
            yield np.arange(len(points)), *self._lanes(at)
            return
        order = np.lexsort(keys)
        changes = [np.diff(key[order]) != 0 for key in keys]
        for places in np.split(order, np.flatnonzero(np.any(changes, axis=0)) + 1):
            yield places, *self._lanes({axis: index[places] for axis, index in at.items()})

    def _lanes(self, at: Mapping[Axis, NDArray[np.int64]]) -> tuple[Scene, Scheme, Any]:
        """Scene and scheme of points given by their index on each axis, arrays for what is swept; and dt or tol."""
        one = {
            owner: {a.key: float(a.values[i[0]]) for a, i in at.items() if a.owner == owner}
            for owner in get_args(Owner)
        }
        load = self.load
        if one["load"] and is_known(load) and not self.by_tol:
            own = {f.name: getattr(load, f.name) for f in fields(load)}  # type: ignore[arg-type]
            load = LoadLanes(type(load), self._values("load", at, own))  # type: ignore[arg-type]
        elif one["load"]:
            load = replace(load, **one["load"])  # type: ignore[type-var]
        info = scene_info(self.scene, {})
        values = checked_parameters(info, self._values("scene", at, self.given["scene"]), real_array)
        of_scheme = self._values("scheme", at, self.given["scheme"])
        if self.by_tol:
            scheme = make_scheme(self.scheme, **{**of_scheme, **one["scheme"]})
            return make_scene(info, values, self.a0, load), scheme, self._values("step", at, self.given["step"])["tol"]
        step = {**self.given["step"], **one["step"]}["dt"]
        return make_scene(info, values, self.a0, load), make_scheme(self.scheme, **of_scheme), step

    def _values(self, owner: Owner, at: Mapping[Axis, NDArray[np.int64]], given: Mapping[str, Any]) -> dict[str, Any]:
        return {**given, **{axis.key: axis.values[i] for axis, i in at.items() if axis.owner == owner}}

    def piece(self, cluster: bool) -> tuple[int, ...]:
        """Shape of a chunk: one value of each leading axis, a piece of one axis, the whole of each trailing axis."""
        n = max(self.steps, default=CHOSEN_STEPS if self.by_tol else 1)
        lanes = min(LANE_STEPS[self.oscillator and not self.by_tol] / n, MEMORY / self._bytes_of_a_lane(n))
        lanes = max(1.0, lanes, FOR_A_CLUSTER / n if cluster else 0.0)
        piece: list[int] = []
        for size in (max(size, 1) for size in reversed(self.shape)):
            here = max(1, min(size, int(lanes)))
            piece.append(-(-size // -(-size // here)))  # pieces of nearly equal size
            lanes = lanes / size if here == size else 0.0
        return tuple(reversed(piece))

    def _bytes_of_a_lane(self, n: int) -> float:
        """Memory in bytes that a run takes: its rows, a copy of them to compute results from, and loads."""
        d, scheme = len(self.scene_of_one.coordinates), self.scheme_of_all
        if self.by_tol:
            rows = {"final": 1, "peak": ROWS, "history": self.rows if self.keep == "history" else 0}[self.keep]
            return 8.0 * (rows * (6 * d + 4) + 100)
        whole = self.bound < math.inf or (self.keep == "peak" and not self.oscillator)
        rows = n + 1 if whole else {"final": 2, "peak": 0, "history": self.rows}[self.keep]
        own_load = any(axis.owner in ("scheme", "load") for axis in self.axes) or not self.oscillator
        sampled = min(n, LOADED) if self.oscillator and is_known(self.load) else n  # steps at a time
        loads = 2 * sampled * scheme.info.loads if self.load is not None and own_load else 0
        return 8.0 * (rows * (6 * d + 2) + loads + 50)

    def chunks(self, piece: tuple[int, ...]) -> list[Chunk]:
        """All chunks of that shape, in C order."""
        if not math.prod(self.shape):
            return []
        chunks: list[Chunk] = []
        for corner in product(*(range(0, size, step) for size, step in zip(self.shape, piece, strict=True))):
            where = tuple(slice(i, min(i + p, n)) for i, p, n in zip(corner, piece, self.shape, strict=True))
            first = int(np.ravel_multi_index((0, *corner), (1, *self.shape)))
            chunks.append(Chunk(first, first + math.prod(s.stop - s.start for s in where), where))
        return chunks


def planned(
    scene: "Scene | str | SceneDeclaration", scheme: "Scheme | str | Declaration", dt: ArrayLike | None,
    tol: ArrayLike | None, t_end: float, keep: Keep, samples: int | None, energy_bound: float | None,
    a0: ArrayLike | str | None, load: Load | None, values: dict[str, Any],
) -> Plan:  # fmt: skip
    """The checked plan of the arguments of `sweep`. Raises ValueError before anything is run."""
    step, chosen, values = step_asked(dt, tol, values)
    of_handle: Mapping[str, Any] = {}
    if isinstance(scene, Scene):
        if a0 is not None or load is not None:
            raise ValueError(
                f"expected {'a0' if a0 is not None else 'load'} in the scene's handle; give it to ss.scene"
            )
        a0, load, of_handle = scene.a0_asked, scene.load, scene.parameters
        _check_scene(scene)
        of_scene = scene.info
    else:
        strain = {"strain": values.pop("strain")} if scene == "elastic_pendulum" and "strain" in values else {}
        of_scene = scene_info(scene, strain)
    own_load = is_dataclass(load) and not isinstance(load, (Record, type))
    owned: dict[Owner, list[str]] = {
        "scene": [*of_scene.parameters],
        "load": [f.name for f in fields(load) if f.init] if own_load else [],  # type: ignore[arg-type]
    }
    of_scheme, axes, given = asked(
        scheme, {**step, **values}, owned, of_handle, f"{of_scene.name}, their load or the step", RESERVED
    )
    if given["load"]:
        load = replace(load, **given.pop("load"))  # type: ignore[type-var]
    t_end = checked_end(keep, t_end)
    bound = math.inf if energy_bound is None else real_number("energy_bound", energy_bound)
    samples = int(samples) if isinstance(samples, np.integer) else samples
    plan = Plan(of_scene.source, of_scheme.source, given, a0, load, axes, t_end, keep, samples, bound, chosen)
    _check(plan)
    return plan


def _check_scene(scene: Scene) -> None:
    """Raise ValueError for a scene that `dataclasses.replace` changed: a sweep makes scenes from their parameters."""
    again = make_scene(scene.info, scene.parameters, scene.a0_asked, scene.load)
    for name in ("u0", "v0", "a0"):
        given, made = getattr(scene, name), getattr(again, name)
        if not np.array_equal(given, made, equal_nan=True):
            raise ValueError(
                f"expected a scene as ss.scene makes it, {name} = {made}, got {given}; set parameters instead"
            )


def _check(plan: Plan) -> None:
    """Raise ValueError for a bad value, before anything is run."""
    for axis in plan.axes:
        if axis.owner == "load":
            known = is_known(plan.load) and axis.values.size > 0  # then what is allowed is an interval
            for value in (axis.values.min(), axis.values.max()) if known else axis.values:
                replace(plan.load, **{axis.key: float(value)})  # type: ignore[type-var]
    steps = plan.steps
    plan.scheme_of_all  # noqa: B018 (making it checks it)
    plan.scene_of_one  # noqa: B018
    if plan.by_tol:
        _check_chosen(plan)
        return
    swept_dt = any(axis.owner == "step" for axis in plan.axes)
    if plan.samples is None:
        if swept_dt and plan.keep == "history":
            raise ValueError(
                "expected samples=N for histories of several dt, which share one grid of N intervals, got none; "
                f"N has to divide the numbers of steps, so that {math.gcd(*steps)} is the finest"
            )
        return
    if plan.keep != "history":
        raise ValueError(f"expected samples with keep='history' only, got keep='{plan.keep}'; drop samples")
    N = plan.samples
    if not isinstance(N, int) or N < 1:
        raise ValueError(f"expected samples to be a whole number of intervals >= 1, got {N!r}")
    for n in steps:
        if n % N:
            common = math.gcd(*steps)
            fit = [next(k for k in range(min(N, common), 0, -1) if common % k == 0)]
            fit += [next(k for k in range(N, common + 1) if common % k == 0)] if common > N else []
            near = [f"{plan.t_end / (k * N):.12g}" for k in (n // N + 1, n // N) if k]
            raise ValueError(
                f"expected samples = {N} to divide the number of steps, got {n} steps for dt = {plan.t_end / n:.12g}; "
                f"take samples = {' or '.join(map(str, fit))}, or dt = {' or '.join(near)}"
            )


def _check_chosen(plan: Plan) -> None:
    """Raise ValueError for what runs that choose their steps cannot be asked for, or a scheme that cannot change it."""
    if plan.samples is not None:
        raise ValueError(
            f"expected samples with dt only, got samples = {plan.samples}; give the times you want as grid="
        )
    if (plan.keep == "history") != ("grid" in plan.chosen):
        got = "none" if plan.keep == "history" else f"it with keep='{plan.keep}'"
        raise ValueError(
            f"expected grid=, the times of the rows, with keep='history' where runs choose their steps, got {got}; "
            "each has steps of its own: " + ("give grid=np.linspace(0, t_end, 101)" if got == "none" else "drop it")
        )
    tolerances = [axis.values for axis in plan.axes if axis.owner == "step"]
    tol = tolerances[0][:1] if tolerances else [plan.given["step"]["tol"]]
    Control.of(1.0, float(tol[0]) if len(tol) else 1.0, plan.t_end, **plan.chosen)
    as_numbers(plan.load)
    swept = {axis.key: axis.values for axis in plan.axes if axis.owner == "scheme"}
    if all(map(len, swept.values())):
        first = {key: float(values[0]) for key, values in swept.items()}
        adaptive_kernels(plan.scene_of_one, make_scheme(plan.scheme, **plan.given["scheme"], **first))
