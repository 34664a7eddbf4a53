"""A sweep of one structure: axes over step, parameters of the scheme, damping, loads, ground motions.

A chunk is one point of the axes that are numbers with one damping, and with all cases of a linear structure, which are
one block of right-hand sides; where there is an internal force each case is a chunk of its own, as its iteration is.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.arrays import Array, named
from ..core.device import Device
from ..core.loads import Record
from ..core.response import STATUSES as ENDED
from ..core.schemes import Scheme
from ..core.schemes import scheme as make_scheme
from ..run.axes import RESERVED, Keep, asked
from ..run.clock import number_of_steps
from ..structures.march.fixed_steps import FixedSteps
from ..structures.march.histories import selection
from ..structures.march.refusals import require_definite_mass, require_suited
from ..structures.march.scheme_plan import step_of
from ..structures.march.steps import Run
from ..structures.march.time_loop import Stretch, steps_taken
from ..structures.model.given import Dof, loads_of
from ..structures.solvers.combine import combined
from ..structures.structure import Structure, damping_of
from .sweep_plan import STATUS, Results, SweepPlan, Variable

if TYPE_CHECKING:
    import xarray

    from ..derived.modules import Declaration

OWN = {"dof", "damping", "case"}  # dimensions that no axis of numbers can be
COMPLETED, FAILED, OVERFLOWED = (ENDED.index(name) for name in ("completed", "newton_failed", "non_finite"))


@dataclass(frozen=True, eq=False, kw_only=True)
class StructurePlan(SweepPlan):
    """cases: structures that differ in their loads only, for each damping. kept: degrees of freedom.

    several: whether there is an axis of dampings, and one of cases.
    """

    cases: tuple[tuple[Structure, ...], ...]
    several: tuple[bool, bool]
    kept: tuple[Dof, ...]

    @property
    def dims(self) -> dict[str, int]:
        """The sizes of all axes, those of dampings and cases last."""
        rest = zip(self.several, ("damping", "case"), (len(self.cases), len(self.cases[0])), strict=True)
        return super().dims | {name: size for there, name, size in rest if there}

    def point(self, place: int) -> tuple[Scheme, float, tuple[Structure, ...]]:
        """Scheme, step and cases of the combination with this number, in C order."""
        *places, damping = np.unravel_index(place, (*(len(axis.values) for axis in self.axes), len(self.cases)))
        at = dict(zip(self.axes, places, strict=True))
        scheme = make_scheme(self.scheme, **self.values("scheme", at))
        return scheme, float(self.values("step", at)["dt"]), self.cases[damping]

    def piece(self, cluster: bool) -> tuple[int, ...]:
        """One point, with all cases of a linear structure."""
        together = len(self.cases[0]) if self.cases[0][0].internal is None else 1
        return (*(1 for _ in self.shape[1:]), together) if self.shape else ()

    @property
    def variables(self) -> dict[str, Variable]:
        """Of u, v and a of the scheme's own as they are kept, and the status."""
        scheme, h, _ = self.point(0)
        dof = "dof", len(self.kept)
        return {**dict(self.motion(name, dof) for name in "uva"[: _kinds(scheme, h)]), "status": STATUS}

    @property
    def labels(self) -> "dict[str, xarray.Variable]":
        """The degrees of freedom."""
        kind = object if self.cases[0][0].names else np.int64
        return {"dof": named("dof", np.array(self.kept, dtype=kind), {})}

    @property
    def attrs(self) -> dict[str, Any]:
        """The scheme, and numbers that are the same in all points."""
        return {"scheme": self.point(0)[0].name, **self.given["step"], **self.given["scheme"]}

    def run(self, first: int, last: int, room: Results) -> Results:
        """See `SweepPlan.run`."""
        place, case = divmod(first, len(self.cases[0]))
        scheme, h, cases = self.point(place)
        some, n = cases[case : case + last - first], number_of_steps(h, self.t_end)
        if some[0].internal is None:
            table, status = _marched(Run(some[0], scheme, h, cases=some), n, self)
            table = np.moveaxis(table, -1, 0)
        else:
            table, status = _marched(Run(some[0], scheme, h), n, self)
            table = table[None]
        *names, _ = self.variables
        found = dict(zip(names, np.moveaxis(table, 1, 0), strict=True))
        return {**found, "status": np.full(len(some), status, np.int8)}


def planned_structure(
    structure: Structure,
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
    C: Sequence[Any] | None = None,
    **parameters: Any,
) -> StructurePlan:
    """The checked plan of a sweep of a structure; `substep.sweep` calls it.

    Axes are dt and parameters of the scheme, where they are rows of values; C, a sequence of dampings; load, a sequence
    of what `substep.structure` takes as load, or ground, one of records for `Structure.ground_motion` in a direction:
    dimensions dt, the parameters by name, "damping", and "case". The cases of a linear structure are one block of
    right-hand sides, for which an effective matrix is factorized once. keep: "final", u, v and, if the scheme has its
    own, a at t_end; "peak", their largest moduli from t = 0 on; "history", all steps, for one dt. A run that overflows,
    or whose iteration fails, is NaN from there on, and its status says so; -1 is that of a run not yet made. Raises
    ValueError for names and values that do not fit, and, before anything is marched, for a damping or a structure that
    the scheme does not take, as `march` does.
    """
    if dt is None:
        raise ValueError("expected dt, a step or several, for a sweep of a structure, got none; march each with tol")
    if device == "cuda":
        raise ValueError("expected device='cpu' for a sweep of a structure, got 'cuda'; a GPU marches scenes alone")
    if "account" in parameters:
        raise ValueError("a sweep of a structure keeps no account of energy: march the point with account=True")
    others = {"tol": tol, "samples": samples, "energy_bound": energy_bound, "a0": a0, "save": save}
    if refused := [name for name, x in others.items() if x is not None]:
        raise ValueError(f"expected a sweep of a structure without {refused[0]}, got one; march each point with it")
    if load is not None and ground is not None:
        raise ValueError("expected load or ground as the axis of cases, got both; give one")
    loads, records, dampings = (_listed(name, x) for name, x in (("load", load), ("ground", ground), ("C", C)))
    text = "or an argument of the sweep of a structure"
    request = asked(scheme, dt, None, t_end, keep, parameters, {}, {}, text, RESERVED | OWN)
    if keep == "history" and any(axis.owner == "step" for axis in request.axes):
        raise ValueError("expected one dt where histories are kept, got several; keep 'final' or 'peak', or sweep each")
    damped = [structure] if dampings is None else [replace(structure, C=damping_of(structure, c)) for c in dampings]
    cases = tuple(_cases(s, loads, records, direction) for s in damped)
    if not all(map(len, (*(axis.values for axis in request.axes), cases, *cases))):
        raise ValueError("expected at least one value on each axis of a sweep, got an axis without; leave it out")
    several = C is not None, load is not None or ground is not None
    plan = StructurePlan(**vars(request), cases=cases, several=several, kept=tuple(structure.kept(dofs)))
    require_definite_mass(structure)
    plan.steps  # noqa: B018 (raises for an end that is no multiple of a step)
    for one, h, (first, *_) in map(plan.point, range(math.prod(plan.shape) // (len(cases[0])))):
        require_suited(first, one, h)
    return plan


def _listed(name: str, values: Any) -> Sequence[Any] | None:
    """The values of an axis that are not numbers. Raises ValueError for one value that is in no list."""
    pair = isinstance(values, tuple) and len(values) == 2 and callable(values[1]) and not callable(values[0])
    whole = getattr(values, "ndim", 1) == 2 or isinstance(values, str | Mapping)  # a matrix, dense or sparse
    if values is None or (isinstance(values, Iterable) and not pair and not whole):
        return values if values is None else list(values)
    one = f"{type(values).__name__}, one value"
    raise ValueError(f"expected {name} as a list, an axis of the sweep, got {one}; give a list [{name}], also of one")


def _cases(
    s: Structure, load: Sequence[Any] | None, ground: Sequence[Record] | None, direction: ArrayLike | None
) -> tuple[Structure, ...]:
    if ground is not None:
        if direction is None:
            raise ValueError("expected direction with ground, got none; give displacements of a unit motion, or names")
        return tuple(s.ground_motion(record, direction) for record in ground)
    return (s,) if load is None else tuple(replace(s, loads=loads_of(s.T, s.names, case)) for case in load)


def _kinds(scheme: Scheme, h: float) -> int:
    """3 where the scheme has an acceleration of its own, else 2: u and v."""
    return 3 if len(step_of(scheme, h).report) == 3 else 2


def _marched(run: Run, n: int, plan: StructurePlan) -> tuple[Array, Any]:
    """(kinds, k) or (kinds, n+1, k), and a status, each with the axis of cases last where there are any."""
    select = selection(run.structure, [run.structure.place(dof) for dof in plan.kept])
    kinds = _kinds(run.scheme, run.h)
    row = select(run.given[:kinds])
    rows = np.full((n + 1, *row.shape), np.nan) if plan.keep == "history" else None
    peak, status = np.abs(row), COMPLETED
    if rows is not None:
        rows[0] = row
    clock = FixedSteps(run, n, to_end=True)
    with np.errstate(all="ignore"):
        for step in steps_taken(clock):
            last = clock.done == n
            if not last and plan.keep == "final":
                continue
            if isinstance(step, Stretch):
                motion = step.motion[:, :kinds]
                made = select(motion.reshape(-1, motion.shape[-1])).reshape(len(motion), kinds, -1)
            else:
                motion = combined(step.march.steps.report[:kinds], step.X)[None]
                made = select(motion[0])[None]
            if last:
                status = np.where(np.isfinite(motion[-1, 0].sum(axis=0)), COMPLETED, OVERFLOWED)
            row = made[-1]
            if rows is not None:
                rows[clock.done - len(made) + 1 : clock.done + 1] = made
            np.maximum(peak, np.abs(made).max(axis=0), out=peak)
    if clock.status != "completed":
        if rows is None:
            return np.full_like(row, np.nan), FAILED
        status = FAILED
    out = peak if plan.keep == "peak" else row if rows is None else np.moveaxis(rows, 0, 1)
    return np.where(np.isfinite(out), out, np.nan), status
