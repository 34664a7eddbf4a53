"""A sweep of structures: axes over step, parameters of the scheme, structures, damping, loads, ground motions, scales.

A chunk is one point of the axes that are numbers with one damping, and with all cases of a linear structure, which are
one block of right-hand sides; where there is an internal force, or contacts, each case is a chunk of its own, as its
iteration is.
Structures with springs of laws are marched by kernels: chunks of them hold many points, which threads share out.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.arrays import Array, named
from ..core.device import Device
from ..core.errors import real_array
from ..core.loads import Record, of_ground
from ..core.schemes import Scheme
from ..core.schemes import scheme as make_scheme
from ..core.threads import spread
from ..run.axes import RESERVED, Keep, asked
from ..run.clock import Control, number_of_steps
from ..structures.march.asked_again import asked_anew
from ..structures.march.going_on import at_start, first_held
from ..structures.march.march_structure import chosen_clock
from ..structures.march.reacting import suited
from ..structures.march.refusals import require_definite_mass, require_suited
from ..structures.march.scheme_plan import step_of
from ..structures.march.steps import Run
from ..structures.model.given import Dof, loads_of
from ..structures.model.memory import RememberingForce
from ..structures.model.springs import Springs
from ..structures.structure import Structure, damped_by
from .structure_points import LANES, Wanted, chosen, kinds_of, marched, side_by_side
from .sweep_plan import OF_CHOSEN, STATUS, Results, SweepPlan, Variable

if TYPE_CHECKING:
    import xarray

    from ..derived.modules import Declaration

INNER = ("structure", "damping", "case", "scale")  # dimensions after those of numbers, as far as they are there
TOUCHED = ("contact", "constraint", "reaction", "gap", "peak_reaction", "peak_gap")
OWN = {"dof", "spring", "elongation", "force", "peak_elongation", "peak_force", *TOUCHED, *INNER}  # no axis of numbers
TOGETHER, STEP = 64, 2000.0  # points with springs in a chunk, and about how many ns one of their steps takes


@dataclass(frozen=True, eq=False, kw_only=True)
class StructurePlan(SweepPlan):
    """cases: structures that differ in their loads only, for each structure and damping. kept: degrees of freedom.

    inner: the sizes of the dimensions of INNER that there are. scales: the values of that one. latest: the number of
    the combination of numbers that was asked for last, with its scheme and step, or tolerance; as a rule the next point
    has it too.
    """

    cases: tuple[tuple[Structure, ...], ...]
    inner: Mapping[str, int]
    scales: Array | None
    kept: tuple[Dof, ...]
    latest: list[tuple[int, Scheme, float]] = field(default_factory=list)

    @property
    def dims(self) -> dict[str, int]:
        """The sizes of all axes, those of INNER last."""
        return super().dims | dict(self.inner)

    def point(self, place: int) -> tuple[Scheme, float, tuple[Structure, ...]]:
        """Scheme, step, or with tol that, and cases of the combination with this number, in C order."""
        outer, which = divmod(place, len(self.cases))
        if (known := self.latest[:1]) and known[0][0] == outer:
            return *known[0][1:], self.cases[which]
        on = dict(zip(super().dims, np.unravel_index(outer, tuple(super().dims.values())), strict=True))
        at = {axis: on[axis.dim] for axis in self.axes}
        scheme = make_scheme(self.scheme, **self.values("scheme", at))
        h = float(self.values("step", at)["tol" if self.by_tol else "dt"])
        self.latest[:] = [(outer, scheme, h)]
        return scheme, h, self.cases[which]

    def piece(self, cluster: bool) -> tuple[int, ...]:
        """One point, with all cases of a linear structure; or many points of structures with springs, but with tol."""
        if self.in_block:
            return tuple(size if name in ("case", "scale") else 1 for name, size in self.dims.items())
        room, sizes = 1 if self.springs is None or self.by_tol else TOGETHER, list[int]()
        for size in reversed(self.shape):
            sizes.insert(0, min(size, room))
            room //= sizes[0]
        return tuple(sizes)

    @property
    def in_block(self) -> bool:
        """Whether all cases are one block of right-hand sides: with dt, of linear structures without reactions."""
        first = self.cases[0][0]
        return first.internal is None and first.contacts is None and not self.by_tol

    @property
    def touched(self) -> tuple[str, list[str]]:
        """The dimension of reactions, "contact" or "constraint", and their names, with the row if one has several."""
        contacts = self.cases[0][0].contacts
        if contacts is None:
            return "contact", []
        found = list[str]()
        for name, place in contacts.names.items():
            found += [name] if isinstance(place, int) else [f"{name}[{k}]" for k in range(place.stop - place.start)]
        return contacts.kind[:-1], found

    @property
    def springs(self) -> Springs | None:
        """Those of the first structure, of which all have as many; None where a force of the user's is asked too."""
        force = self.cases[0][0].internal
        return force.springs if isinstance(force, RememberingForce) and force.material is None else None

    @property
    def variables(self) -> dict[str, Variable]:
        """Of u, v and a of the scheme's own as they are kept, what springs do, and the status.

        With peaks of springs there are their elongations at the end too, which remain.
        """
        scheme, h, _ = self.point(0)
        dof = "dof", len(self.kept)
        found = dict(self.motion(name, dof) for name in "uva"[: kinds_of(scheme, self.t_end if self.by_tol else h)])
        if self.springs is not None:
            spring = "spring", self.springs.size
            found |= dict(self.motion(name, spring) for name in ("elongation", "force"))
            if self.keep == "peak":
                found["elongation"] = Variable.of(np.float64(np.nan), spring, long_name="elongation at t_end")
        name, of = self.touched
        found |= dict(self.motion(x, (name, len(of))) for x in ("reaction", "gap") if of)
        return {**found, **(OF_CHOSEN if self.by_tol else {}), "status": STATUS}

    @property
    def labels(self) -> "dict[str, xarray.Variable]":
        """The degrees of freedom, and the factors of ground motions."""
        kind = object if self.cases[0][0].names else np.int64
        found = {"dof": named("dof", np.array(self.kept, dtype=kind), {})}
        name, of = self.touched
        found |= {name: named(name, np.array(of, dtype=object), {})} if of else {}
        return found if self.scales is None else {**found, "scale": named("scale", self.scales, {})}

    @property
    def attrs(self) -> dict[str, Any]:
        """The scheme, and numbers that are the same in all points."""
        return {"scheme": self.point(0)[0].name, **self.given["step"], **self.chosen, **self.given["scheme"]}

    def run(self, first: int, last: int, room: Results) -> Results:
        """See `SweepPlan.run`."""
        names, count = [name for name in self.variables if name != "status"], last - first
        place, case = divmod(first, len(self.cases[0]))
        scheme, h, cases = self.point(place)
        of = Wanted(self.t_end, self.keep, self.kept, self.springs is not None, math.prod(self.shape))
        if self.in_block:
            run = Run(cases[0], scheme, h, cases=cases[case : case + count])
            (table,), status = marched(run, number_of_steps(h, self.t_end), of)
            found = dict(zip(names, np.moveaxis(np.moveaxis(table, -1, 0), 1, 0), strict=True))
            return {**found, "status": np.full(count, status, np.int8)}
        rows, status = list[list[Any]]([] for _ in range(count)), np.empty(count, np.int8)

        def march_chosen(number: int) -> None:
            place, case = divmod(first + number, len(self.cases[0]))
            scheme, tol, cases = self.point(place)
            tables, status[number], cost = chosen(cases[case], scheme, tol, of, self.chosen)
            rows[number] = [*(x for table in tables for x in table), *cost]

        def march(begin: int, end: int) -> None:
            runs = list[Run]()
            for k in range(begin, end):
                place, case = divmod(first + k, len(self.cases[0]))
                scheme, h, cases = self.point(place)
                runs.append(first_held(at_start(Run(suited(cases[case], step_of(scheme, h)), scheme, h))))
            for k in range(0, end - begin, LANES):
                for number, (tables, ended) in enumerate(side_by_side(runs[k : k + LANES], of), begin + k):
                    rows[number], status[number] = [x for table in tables for x in table], ended

        if self.by_tol:
            for number in range(count):
                march_chosen(number)
        else:
            cost = STEP * count * max(self.steps) if self.springs is not None else 0.0
            spread(march, count, LANES, nanoseconds=cost)
        columns = zip(*rows, strict=True)
        return {**dict(zip(names, map(np.array, columns), strict=True)), "status": status}


def planned_structure(
    structure: Structure | Sequence[Structure],
    scheme: "Scheme | str | Declaration",
    *,
    t_end: float,
    dt: ArrayLike | None = None,
    keep: Keep = "final",
    tol: ArrayLike | None = None,
    samples: int | None = None,
    energy_bound: float | None = None,
    a0: ArrayLike | str | None = None,
    save: str | Path | None = None,
    dofs: Iterable[Dof] | None = None,
    load: Sequence[Any] | None = None,
    device: Device = "cpu",
    ground: Sequence[Record] | None = None,
    direction: ArrayLike | None = None,
    scale: ArrayLike | None = None,
    C: Sequence[Any] | None = None,
    **parameters: Any,
) -> StructurePlan:
    """The checked plan of a sweep of a structure; `substep.sweep` calls it.

    Axes are dt, or tol, and parameters of the scheme, where they are rows of values; a sequence of structures, with as
    many degrees of freedom and springs; C, a sequence of dampings; load, a sequence of what `substep.structure` takes
    as load, each in place of the structure's own, beside motions of its base and supports; or ground, one of records
    for `Structure.ground_motion` in a direction, beside its loads; scale, factors (F,) of all records: dimensions dt or
    tol, the parameters by name, "structure", "damping", "case" and "scale". The cases of a linear structure are one
    block of right-hand sides, for which an effective matrix is factorized once; structures with springs of laws are
    marched on all cores, up to `workers` of `sweep`. With tol each run chooses its steps, with rtol, atol, dt_first,
    dt_min, dt_max and rung as in `march`, and is marched by itself; there are its numbers of steps accepted and
    rejected, and t_failed. keep: "final", u, v and, if the scheme has its own, a at t_end; "peak", their largest moduli
    from t = 0 on; "history", all steps, for one dt. Of springs there are elongation and force, kept so too, and with
    "peak" also the elongation at t_end, which remains. A run that overflows, or whose iteration fails, is NaN from
    there on, and its status says so; -1 is that of a run not yet made. Raises ValueError for names and values that do
    not fit, and, before anything is marched, for a damping or a structure that the scheme does not take, as `march`
    does.
    """
    if device == "cuda":
        raise ValueError("expected device='cpu' for a sweep of a structure, got 'cuda'; a GPU marches scenes alone")
    if "account" in parameters:
        raise ValueError("a sweep of a structure keeps no account of energy: march the point with account=True")
    others = {"samples": samples, "energy_bound": energy_bound, "a0": a0, "save": save}
    if refused := [name for name, x in others.items() if x is not None]:
        raise ValueError(f"expected a sweep of a structure without {refused[0]}, got one; march each point with it")
    if load is not None and ground is not None:
        raise ValueError("expected load or ground as the axis of cases, got both; give one")
    loads, records, dampings = (_listed(name, x) for name, x in (("load", load), ("ground", ground), ("C", C)))
    models = [asked_anew(s) for s in _alike(structure)]
    factors = None if scale is None else np.atleast_1d(real_array("scale", scale))
    if factors is not None and (records is None or factors.ndim != 1):
        got = "no ground" if records is None else f"shape {factors.shape}"
        raise ValueError(f"expected scale as a row of factors of the records in ground, got {got}; give both as lists")
    text = "or an argument of the sweep of a structure"
    request = asked(scheme, dt, tol, t_end, keep, parameters, {}, {}, text, RESERVED | OWN)
    if tol is not None and (keep == "history" or "grid" in request.chosen):
        raise ValueError(
            "expected 'final' or 'peak' of structures that choose their steps, got "
            f"{'grid' if 'grid' in request.chosen else 'history'}: the rows of each are its own steps; march each, or "
            "give dt"
        )
    if keep == "history" and any(axis.owner == "step" for axis in request.axes):
        raise ValueError("expected one dt where histories are kept, got several; keep 'final' or 'peak', or sweep each")
    damped = models if dampings is None else [damped_by(s, c) for s in models for c in dampings]
    records = _records(records, factors)
    cases = tuple(_cases(s, loads, records, direction) for s in damped)
    several = (
        None if isinstance(structure, Structure) else models,
        dampings,
        loads if ground is None else ground,
        factors,
    )
    inner = {name: len(x) for name, x in zip(INNER, several, strict=True) if x is not None}
    if not all((*(len(axis.values) for axis in request.axes), *inner.values())):
        raise ValueError("expected at least one value on each axis of a sweep, got an axis without; leave it out")
    plan = StructurePlan(**vars(request), cases=cases, inner=inner, scales=factors, kept=tuple(models[0].kept(dofs)))
    for s in models:
        require_definite_mass(s)
    plan.steps  # noqa: B018 (raises for an end that is no multiple of a step)
    for one, h, (first, *_) in map(plan.point, range(math.prod(plan.shape) // (len(cases[0])))):
        require_suited(first, one, plan.t_end if plan.by_tol else h)
        if plan.by_tol:
            run = at_start(Run(suited(first, step_of(one, plan.t_end)), one, plan.t_end))
            chosen_clock(run, Control.of(1.0, h, plan.t_end, **plan.chosen), absolute="atol" in plan.chosen)
    return plan


def _alike(given: Structure | Sequence[Structure]) -> list[Structure]:
    """The structures.

    Raises ValueError where they are none, or of other degrees of freedom, contacts or numbers of springs.
    """
    models = [given] if isinstance(given, Structure) else list(given)

    def size(s: Structure) -> tuple[Any, ...]:
        force, contacts = s.internal, s.contacts
        springs = force.springs if isinstance(force, RememberingForce) else None
        touched = None if contacts is None else [(name, repr(x)) for name, x in contacts.names.items()]
        return s.T.shape[0], s.names, force is None, 0 if springs is None else springs.size, touched

    if not models or not all(isinstance(s, Structure) and size(s) == size(models[0]) for s in models):
        raise ValueError(
            "expected structures with the same degrees of freedom and contacts and as many springs, got "
            f"{'none' if not models else 'others'}; sweep those of each kind by themselves"
        )
    return models


def _listed(name: str, values: Any) -> Sequence[Any] | None:
    """The values of an axis that are not numbers. Raises ValueError for one value that is in no list."""
    pair = isinstance(values, tuple) and len(values) == 2 and callable(values[1]) and not callable(values[0])
    whole = getattr(values, "ndim", 1) == 2 or isinstance(values, str | Mapping)  # a matrix, dense or sparse
    if values is None or (isinstance(values, Iterable) and not pair and not whole):
        return values if values is None else list(values)
    one = f"{type(values).__name__}, one value"
    raise ValueError(f"expected {name} as a list, an axis of the sweep, got {one}; give a list [{name}], also of one")


def _records(ground: Sequence[Any] | None, factors: Array | None) -> list[Record] | None:
    """The records in m/s^2, each with each factor. Structures share them, and their samples."""
    if ground is None:
        return None
    found = [of_ground(record) for record in ground]
    if factors is None:
        return found
    return [Record(r.dt, float(x) * r.samples, unit="m/s^2", source=r.source) for r in found for x in factors]


def _cases(
    s: Structure, load: Sequence[Any] | None, ground: Sequence[Record] | None, direction: ArrayLike | None
) -> tuple[Structure, ...]:
    if ground is not None:
        if direction is None:
            raise ValueError("expected direction with ground, got none; give displacements of a unit motion, or names")
        return tuple(s.ground_motion(record, direction) for record in ground)
    if load is None:
        return (s,)
    if s.static:
        raise ValueError(
            "expected loads as an axis of a structure whose start is given, got u0='static', the equilibrium with its "
            "own load; give a list of structures, each with its load and u0='static'"
        )
    given = (loads_of(s.T, s.names, case) for case in load)
    return tuple(replace(s, loads=(*own, *s.loads[s.given_loads :]), given_loads=len(own)) for own in given)
