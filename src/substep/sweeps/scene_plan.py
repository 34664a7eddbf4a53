"""A sweep of a scene: points that can be the lanes of one march, and how many of them a chunk has."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, ClassVar, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core.arrays import named
from ..core.device import Device, found
from ..core.errors import real_array, real_number, whole
from ..core.loads import Load, LoadLanes, Record, as_numbers, is_known
from ..core.scene_catalogue import WITH_LAW, checked_parameters, scene_info
from ..core.scenes import Scene, make_scene, require_made
from ..core.schemes import Scheme, scheme_info
from ..core.schemes import scheme as make_scheme
from ..core.single import Dtype, require_possible
from ..core.threads import cores
from ..core.units import require_ratio
from ..marching.adaptive import adaptive_kernels
from ..marching.decay import require_decay
from ..marching.linear import LOADED
from ..marching.scene_events import require_events
from ..marching.scene_lanes import pair_kernels
from ..run.axes import RESERVED, Axis, Keep, Owner, asked
from ..run.clock import Control
from .description import description, name_of
from .draws import require_allowed
from .lanes import march_group
from .sweep_plan import MEANINGS, OF_CHOSEN, STATUS, Results, SweepPlan, Variable

if TYPE_CHECKING:
    import xarray

    from ..derived.modules import Declaration, SceneDeclaration

MEMORY = 64e6  # bytes that a chunk takes while it is run
LANE_STEPS = {True: 5e7, False: 4e6}  # linear march or not -> steps of all lanes of a chunk: 0.05 to 0.1 s on one core
TO_EVENTS = 2e3  # the same where steps end at events, which Python runs
ON_DEVICE = 1e9  # the same for a chunk that a GPU runs, whose threads are 10^5 lanes at once
SINCE = "since"  # an argument of kernels that take the time itself, which would lose its digits in single precision
CHOSEN_STEPS = 2000  # taken for the number of steps of a run that chooses them
Index = NDArray[np.int64] | slice | int  # of points along a dimension
FOR_A_CLUSTER = 2e6  # fewest such steps of a chunk for another process: sending it must take little of the time


@dataclass(frozen=True, eq=False, kw_only=True)
class ScenePlan(SweepPlan):
    """scene: name, or a declaration of the user's own. a0, load: as in `substep.sweep`."""

    scene: "str | SceneDeclaration"
    a0: ArrayLike | str | None
    load: Load | None
    time_attrs: ClassVar[dict[str, str]] = {"units": "s", "long_name": "time"}

    @property
    def variables(self) -> dict[str, Variable]:
        """Of u, v, a and energy as they are kept, Newton's iterations, steps and the status."""
        units = {unit for _, unit in self.scene_of_one.coordinates}
        unit = units.pop() if len(units) == 1 else "of the coordinate"
        unit_of = {"u": unit, "v": f"{unit}/s", "a": f"{unit}/s^2"}
        coordinate = "coordinate", len(self.scene_of_one.coordinates)
        balance = "balance", self.scheme_of_all.balances
        found = dict(
            self.motion(name, coordinate, largest="largest modulus of", units=unit_of[name])
            for name in MEANINGS if name != "energy"
        )  # fmt: skip
        if self.keep != "peak" or self.by_tol or not self.oscillator:
            found |= [self.motion("energy", units="J")]
        remembered = self.scene_of_one.info.memory
        if remembered and self.keep != "peak":
            found |= [self.motion("memory", ("remembered", len(remembered)))]
        nan, none, one = np.float64(np.nan), np.int64(0), {"units": "1"}
        mean, most = (f"Newton's iterations, {x}" for x in ("mean of the steps done", "most of any step"))
        found["newton_iterations"] = Variable.of(nan, balance, **one, long_name=mean)
        found["newton_most"] = Variable.of(none, balance, **one, long_name=most)
        more = OF_CHOSEN if self.by_tol else {"n_done": Variable.of(none, **one, long_name="steps completed")}
        return {**found, **more, "status": STATUS}

    @property
    def labels(self) -> "dict[str, xarray.Variable]":
        """The coordinates of the scene, and the balances of the scheme."""
        scene, scheme = self.scene_of_one, self.scheme_of_all
        names, balances = np.array([name for name, _ in scene.coordinates], dtype=object), np.arange(scheme.balances)
        remembered = np.array(scene.info.memory, dtype=object)
        of_laws = {"remembered": named("remembered", remembered, {"long_name": f"memory of {scene.name}"})}
        return {
            **(of_laws if len(remembered) and self.keep != "peak" else {}),
            "coordinate": named("coordinate", names, {"long_name": f"coordinate of {scene.name}"}),
            "balance": named("balance", 1 + balances, {"long_name": f"balance of {scheme.name}"}),
        }

    @property
    def attrs(self) -> dict[str, Any]:
        """See `description`."""
        return description(self, self.scene_of_one, self.scheme_of_all, self.a0, self.load)

    def about(self, axis: Axis) -> dict[str, Any]:
        """Its unit, and whose parameter it is."""
        if axis.owner == "step":
            return {"units": "s", "long_name": "step"} if axis.key == "dt" else {"units": "1", "long_name": "tolerance"}
        load = f"the load {name_of(self.load)}"
        whose = {"scheme": self.scheme_of_all.name, "scene": self.scene_of_one.name, "load": load}
        return {"long_name": f"{axis.key} of {whose[axis.owner]}"}

    def run(self, first: int, last: int, room: Results) -> Results:
        """See `SweepPlan.run`."""
        return self._marched(self._along(first, last), last - first, room)

    def at(self, points: NDArray[np.int64]) -> Results:
        """The same of any points."""
        return self._marched(self._indices(points), len(points), {})

    def _marched(self, on: Mapping[str, Index], P: int, room: Results) -> Results:
        """Results of P points given by their index along each dimension."""
        found: Results = {}
        for places, scene, scheme, step in self.groups(on):
            if places is None:
                return march_group(self, scene, scheme, step, P, room)
            for name, values in march_group(self, scene, scheme, step, len(places), {}).items():
                found.setdefault(name, np.empty((P, *values.shape[1:]), values.dtype))[places] = values
        return found

    def _indices(self, points: NDArray[np.int64]) -> dict[str, Index]:
        """The index of points along each dimension."""
        return dict(zip(self.dims, np.unravel_index(points, (1, *self.shape))[1:], strict=True))

    def _along(self, first: int, last: int) -> dict[str, Index]:
        """The same of the points first to last - 1: where they lie in one row, numbers and then a range."""
        *outer, size = self.shape or (1,)
        row, start = divmod(first, size)
        if not self.shape or start + last - first > size or [*self.dims][-1] in self._common:
            return self._indices(np.arange(first, last))
        of_row = np.unravel_index(row, (1, *outer))[1:]
        return dict(zip(self.dims, [*map(int, of_row), slice(start, start + last - first)], strict=True))

    @cached_property
    def scheme_of_all(self) -> Scheme:
        """The scheme with parameters that broadcast over its axes; making it checks all combinations of values."""
        swept = [axis for axis in self.axes if axis.owner == "scheme"]
        dims = list(dict.fromkeys(axis.dim for axis in reversed(swept)))  # the last is the first from the right
        spread = {axis.key: axis.values.reshape(-1, *(1,) * dims.index(axis.dim)) for axis in swept}
        return make_scheme(self.scheme, **self.given["scheme"], **spread)

    @cached_property
    def scene_of_one(self) -> Scene:
        """The scene at the first value of each axis, NaN for an axis without values; making it checks all values."""
        swept = {axis.key: axis.values for axis in self.axes if axis.owner == "scene"}
        info = scene_info(self.scene, {})
        values = checked_parameters(info, {**self.given["scene"], **swept}, real_array)
        ones = {key: float(x[0] if np.size(x) else np.nan) if np.ndim(x) else x for key, x in values.items()}
        return make_scene(info, ones, self.a0, self.load)

    @property
    def in_threads(self) -> bool:
        """See `SweepPlan.in_threads`."""
        return is_known(self.load) and not self.to_events

    @property
    def to_events(self) -> bool:
        """Whether the steps of runs end where what acts changes, so that they are marched one after another."""
        return self.by_tol and bool(self.scene_of_one.info.reactions)

    @property
    def oscillator(self) -> bool:
        """Whether the scene is a linear oscillator, which the linear march runs."""
        return self.scene_of_one.info.oscillator is not None

    def allows(self, axis: Axis) -> Callable[[float], Any]:
        """What raises ValueError for a number that the axis's parameter does not allow by itself."""
        if axis.owner == "load":
            return lambda x: replace(self.load, **{axis.key: x})  # type: ignore[type-var]
        scheme, scene = scheme_info(self.scheme), scene_info(self.scene, {})
        of = scheme if axis.owner == "scheme" else scene
        parameter = of.parameters[axis.key] if axis.key in of.parameters else scheme.families[axis.key].argument
        return partial(parameter.inside, f"parameter {axis.key} of {of.name}")

    @cached_property
    def _common(self) -> tuple[str, ...]:
        """The dimensions along which points of one march do not differ.

        They share the step, and a load of the user's own. Where they choose their steps, they share the load and the
        scheme's parameters, on which its estimate depends.
        """
        common = ("scheme", "load") if self.by_tol else ("step",) if is_known(self.load) else ("step", "load")
        return tuple(dict.fromkeys(axis.dim for axis in self.axes if axis.owner in common))

    def groups(self, on: Mapping[str, Index]) -> Iterator[tuple[NDArray[np.int64] | None, Scene, Scheme, Any]]:
        """Points in groups that can be the lanes of one march: their places, scene, scheme, and dt or tol.

        on: the index of the points along each dimension. The places are None where there is one group.
        """
        at = {axis: on[axis.dim] for axis in self.axes}
        keys = [index for dim, index in on.items() if dim in self._common and isinstance(index, np.ndarray)]
        order = np.lexsort(keys) if keys else np.arange(0)
        begins = np.flatnonzero(np.any([np.diff(key[order]) for key in keys], axis=0)) + 1 if keys else ()
        if not len(begins):
            yield None, *self._lanes(at)
            return
        for places in np.split(order, begins):
            some = {axis: index[places] if isinstance(index, np.ndarray) else index for axis, index in at.items()}
            yield places, *self._lanes(some)

    def _lanes(self, at: Mapping[Axis, Index]) -> tuple[Scene, Scheme, Any]:
        """Scene and scheme of points given by their index on each axis, arrays for what is swept; and dt or tol."""
        first = {a: i.start if isinstance(i, slice) else i if isinstance(i, int) else i[0] for a, i in at.items()}
        one = {owner: self.values(owner, first) for owner in get_args(Owner)}
        load, of_load = self.load, self.values("load", at)
        if any(map(np.ndim, of_load.values())) and is_known(load) and not self.by_tol:
            own = {f.name: getattr(load, f.name) for f in fields(load)}  # type: ignore[arg-type]
            load = LoadLanes(type(load), {**own, **of_load})  # type: ignore[arg-type]
        elif of_load:
            load = replace(load, **{name: float(x) for name, x in one["load"].items()})  # type: ignore[type-var]
        own = {key: x if np.ndim(x) else float(x) for key, x in self.values("scene", at).items()}
        values, later = {**self.scene_of_one.parameters, **own}, self.oscillator and not self.by_tol
        scene = make_scene(self.scene_of_one.info, values, self.a0, load, later)
        of_scheme = one["scheme"] if self.by_tol else self.values("scheme", at)
        swept = any(axis.owner == "scheme" for axis in self.axes)
        scheme = make_scheme(self.scheme, **of_scheme) if swept else self.scheme_of_all
        return scene, scheme, self.values("step", at)["tol"] if self.by_tol else float(one["step"]["dt"])

    def piece(self, cluster: bool) -> tuple[int, ...]:
        """Shape of a chunk: one value of each leading axis, a piece of one axis, the whole of each trailing axis."""
        n = max(self.steps, default=CHOSEN_STEPS if self.by_tol else 1)
        on_device = self.device == "cuda" if cluster else found(self.device)
        most = TO_EVENTS if self.to_events else LANE_STEPS[self.oscillator and not self.by_tol]
        most = math.inf if on_device else most / n
        lanes = min(most, (ON_DEVICE if on_device else MEMORY) / self._bytes_of_a_lane(n))
        lanes = max(1.0, lanes, FOR_A_CLUSTER / n if cluster else 0.0)
        piece: list[int] = []
        for size in (max(size, 1) for size in reversed(self.shape)):
            here = max(1, min(size, int(lanes)))
            pieces = -(-size // here)
            if pieces > 1 and not (cluster or on_device):
                pieces += -pieces % cores()  # none is left that one core runs alone
            piece.append(-(-size // pieces))  # pieces of nearly equal size
            lanes = lanes / size if here == size else 0.0
        return tuple(reversed(piece))

    def _bytes_of_a_lane(self, n: int) -> float:
        """Memory in bytes that a run takes: its rows, a copy of them to compute results from, and loads."""
        d, scheme = len(self.scene_of_one.coordinates), self.scheme_of_all
        if self.by_tol:
            rows = self.rows if self.keep == "history" else int(self.keep == "final")
            return 8.0 * (rows * (6 * d + 4) + 100)
        whole = self.oscillator and self.bound < math.inf
        rows = n + 1 if whole else self.rows if self.keep == "history" else 2 * (self.keep == "final")
        own_load = any(axis.owner in ("scheme", "load") for axis in self.axes) or not self.oscillator
        sampled = min(n, LOADED) if self.oscillator and is_known(self.load) else n  # steps at a time
        loads = 2 * sampled * scheme.info.loads if self.load is not None and own_load else 0
        return 8.0 * (rows * (6 * d + 2) + loads + (16 if self.oscillator else 50))


def planned(
    scene: "Scene | str | SceneDeclaration", scheme: "Scheme | str | Declaration", dt: ArrayLike | None,
    tol: ArrayLike | None, t_end: float, keep: Keep, samples: int | None, energy_bound: float | None,
    a0: ArrayLike | str | None, load: Load | None, device: Device, dtype: Dtype, values: dict[str, Any],
) -> ScenePlan:  # fmt: skip
    """The checked plan of the arguments of `sweep`. Raises ValueError before anything is run."""
    of_handle: Mapping[str, Any] = {}
    if isinstance(scene, Scene):
        if a0 is not None or load is not None:
            raise ValueError(
                f"expected {'a0' if a0 is not None else 'load'} in the scene's handle; give it to ss.scene"
            )
        a0, load, of_handle = scene.a0_asked, scene.load, scene.parameters
        require_made(scene)
        of_scene = scene.info
    else:
        which = {"elastic_pendulum": "strain", WITH_LAW: "law"}.get(scene, "") if isinstance(scene, str) else ""
        of_scene = scene_info(scene, {which: values.pop(which)} if which in values else {})
    if "xi" in of_scene.parameters and not values.pop("overdamped", False):
        for name in values.keys() & {"xi", "scene_xi"}:
            require_ratio(f"{name} of {of_scene.name}", real_array(name, values[name]))
    own_load = is_dataclass(load) and not isinstance(load, (Record, type))
    owned: dict[Owner, list[str]] = {
        "scene": [*of_scene.parameters],
        "load": [f.name for f in fields(load) if f.init] if own_load else [],  # type: ignore[arg-type]
    }
    others = f"{of_scene.name}, their load or the step"
    request = asked(scheme, dt, tol, t_end, keep, values, owned, of_handle, others, RESERVED)
    if own := request.given.pop("load"):
        load = replace(load, **own)  # type: ignore[type-var]
    bound = math.inf if energy_bound is None else real_number("energy_bound", energy_bound)
    samples = int(samples) if isinstance(samples, np.integer) else samples
    require_possible(dtype, {"where runs choose their steps": dt is None})
    plan = ScenePlan(
        **vars(request), samples=samples, bound=bound, device=device, dtype=dtype, scene=of_scene.source, a0=a0,
        load=load,
    )  # fmt: skip
    _check(plan)
    return plan


def _check(plan: ScenePlan) -> None:
    """Raise ValueError for a bad value, before anything is run."""
    for axis in plan.axes:
        if "distribution" in axis.attrs:
            require_allowed(axis, plan.allows(axis))
        if axis.owner == "load":
            known = is_known(plan.load) and axis.values.size > 0  # then what is allowed is an interval
            for value in (axis.values.min(), axis.values.max()) if known else axis.values:
                replace(plan.load, **{axis.key: float(value)})  # type: ignore[type-var]
    steps = plan.steps
    one, scheme = plan.scene_of_one, plan.scheme_of_all  # making them checks them
    if one.info.multipliers or one.info.contacts:
        require_decay(one.name, scheme)
    if plan.by_tol:
        _check_chosen(plan)
        return
    if plan.dtype == "float32" and not plan.oscillator:
        timed = SINCE in pair_kernels(plan.scene_of_one, plan.scheme_of_all).SCALARS
        require_possible("float32", {"for a scene whose energies depend on time": timed})
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
    N = whole("samples", plan.samples, 1, "intervals", "leave it out for every step")
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


def _check_chosen(plan: ScenePlan) -> None:
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
    for axis in plan.axes:
        if axis.owner == "scheme" and "distribution" in axis.attrs:
            raise ValueError(
                f"expected {axis.name} as a number or a few values where runs choose their steps, got a distribution: "
                "each value has an estimate of its own, which has to be derived; give dt in place of tol"
            )
    tolerances = [axis.values for axis in plan.axes if axis.owner == "step"]
    tol = tolerances[0][:1] if tolerances else [plan.given["step"]["tol"]]
    asked = Control.of(1.0, float(tol[0]) if len(tol) else 1.0, plan.t_end, **plan.chosen)
    if not plan.to_events:
        as_numbers(plan.load)
    swept = {axis.key: axis.values for axis in plan.axes if axis.owner == "scheme"}
    if all(map(len, swept.values())):
        first = {key: float(values[0]) for key, values in swept.items()}
        one = plan.scene_of_one, make_scheme(plan.scheme, **plan.given["scheme"], **first)
        require_events(*one, asked) if plan.to_events else adaptive_kernels(*one)
