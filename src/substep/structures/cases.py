"""Many runs of one structure in one call: axes over step, parameters of the scheme, damping, loads, ground motions."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..core.arrays import Array, named
from ..core.errors import number_or_row, require_numbers, unknown_name
from ..core.loads import Record
from ..core.progress import shown
from ..core.schemes import Scheme
from ..core.schemes import scheme as make_scheme
from ..marching.run import number_of_steps
from .combine import combined
from .histories import selection
from .plan import step_of
from .refusals import require_definite_mass, require_suited
from .steps import Run
from .structure import Dof, Structure, damping_of, loads_of

if TYPE_CHECKING:
    import xarray

    from ..derived.modules import Declaration

KEEP = ("final", "peak", "history")
LONG = {"u": "displacement", "v": "velocity", "a": "acceleration"}


def sweep_structure(
    structure: Structure,
    scheme: "Scheme | str | Declaration",
    *,
    t_end: float,
    dt: ArrayLike | None = None,
    keep: Literal["final", "peak", "history"] = "final",
    dofs: Iterable[Dof] | None = None,
    load: Sequence[Any] | None = None,
    ground: Sequence[Record] | None = None,
    direction: ArrayLike | None = None,
    C: Sequence[Any] | None = None,
    progress: bool = True,
    **parameters: Any,
) -> "xarray.Dataset":
    """March every combination of the axes; `substep.sweep` calls it for a structure.

    Axes are dt and parameters of the scheme, where they are rows of values; C, a sequence of dampings; load, a sequence
    of what `substep.structure` takes as load, or ground, one of records for `Structure.ground_motion` in a direction:
    dimensions dt, the parameters by name, "damping", and "case". The cases of a linear structure are one block of
    right-hand sides, for which an effective matrix is factorized once. keep: "final", u, v and, if the scheme has its
    own, a at t_end; "peak", their largest moduli from t = 0 on; "history", all steps, for one dt. A run that overflows,
    or whose iteration fails, is NaN from there on. Raises ValueError for names and values that do not fit, and, before
    anything is marched, for a damping or a structure that the scheme does not take, as `march` does.
    """
    if dt is None:
        raise ValueError("expected dt, a step or several, for a sweep of a structure, got none; march each with tol")
    if keep not in KEEP:
        raise unknown_name("a choice of what to keep", keep, KEEP)
    given = make_scheme(scheme)
    if load is not None and ground is not None:
        raise ValueError("expected load or ground as the axis of cases, got both; give one")
    require_numbers(given.name, given.parameters, "give it as an axis")
    values = {name: number_or_row(name, x) for name, x in {"dt": dt, **parameters}.items()}
    axes = {name: x for name, x in values.items() if x.ndim}
    if keep == "history" and "dt" in axes:
        raise ValueError("expected one dt where histories are kept, got several; keep 'final' or 'peak', or sweep each")
    damped = [structure] if C is None else [replace(structure, C=damping_of(structure, c)) for c in C]
    cases = [_cases(s, load, ground, direction) for s in damped]
    kept = structure.kept(dofs)
    places = [structure.place(dof) for dof in kept]
    points: list[tuple[int, Scheme, float]] = []
    for *point, which in product(*(x.tolist() for x in axes.values()), range(len(damped))):
        at = {name: float(x) for name, x in values.items() if not x.ndim} | dict(zip(axes, point, strict=True))
        h = at.pop("dt")
        points.append((which, make_scheme(given.info.source, **{**_numbers(given), **at}), h))
    if not points or not cases[0]:
        raise ValueError("expected at least one value on each axis of a sweep, got an axis without; leave it out")
    require_definite_mass(structure)
    for which, one, h in points:
        require_suited(damped[which], one, h)
    found = []
    with shown(len(points), 0, progress, "sweep", "blocks of runs") as advance:
        for which, one, h in points:
            found.append(_block(damped[which], cases[which], one, h, t_end, keep, places))
            advance(1)
    several = C is not None, load is not None or ground is not None
    sizes = [*(len(x) for x in axes.values()), len(damped), len(cases[0])]  # of all axes, dampings and cases
    table = np.array(found).reshape(*sizes, *found[0].shape[1:])
    table = table.squeeze(tuple(len(axes) + place for place, there in enumerate(several) if not there))
    return _dataset(structure, given, table, axes, several, values, kept, keep)


def _numbers(scheme: Scheme) -> Mapping[str, float]:
    return {name: float(x) for name, x in scheme.given.items()}


def _cases(
    s: Structure, load: Sequence[Any] | None, ground: Sequence[Record] | None, direction: ArrayLike | None
) -> tuple[Structure, ...]:
    if ground is not None:
        if direction is None:
            raise ValueError("expected direction with ground, got none; give displacements of a unit motion, or names")
        return tuple(s.ground_motion(record, direction) for record in ground)
    return (s,) if load is None else tuple(replace(s, loads=loads_of(s, case)) for case in load)


def _block(
    s: Structure, cases: tuple[Structure, ...], scheme: Scheme, h: float, t_end: float, keep: str, places: list[int]
) -> Array:
    """Results (L, kinds, k), or (L, kinds, n+1, k) of histories, of L cases."""
    n = number_of_steps(h, t_end)
    if s.internal is not None:  # Newton's iteration is one of each case
        runs = [Run(case, scheme, h) for case in cases]
        return np.concatenate([_marched(run, n, keep, places)[None] for run in runs])
    together = _marched(Run(s, scheme, h, cases=cases), n, keep, places)
    return np.moveaxis(together, -1, 0)


def _marched(run: Run, n: int, keep: str, places: list[int]) -> Array:
    """(kinds, k) or (kinds, n+1, k), each with the axis of cases last where there are any."""
    select = selection(run.structure, places)
    kinds = 3 if len(step_of(run.scheme, run.h).report) == 3 else 2
    row = select(run.given[:kinds])
    rows = np.full((n + 1, *row.shape), np.nan) if keep == "history" else None
    peak = np.abs(row)
    done = 0
    if rows is not None:
        rows[0] = row
    try:
        with np.errstate(all="ignore"):
            for X, march in run.marched(n):
                done += 1
                if keep == "final" and done < n:
                    continue
                row = select(combined(march.steps.report[:kinds], X))
                if rows is not None:
                    rows[done] = row
                np.maximum(peak, np.abs(row), out=peak)
    except ArithmeticError:
        if rows is None:
            return np.full_like(row, np.nan)
    out = peak if keep == "peak" else row if rows is None else np.moveaxis(rows, 0, 1)
    return np.where(np.isfinite(out), out, np.nan)


def _dataset(
    structure: Structure, scheme: Scheme, table: Array, axes: Mapping[str, Array], several: tuple[bool, bool],
    values: Mapping[str, Array], kept: list[Dof], keep: str,
) -> "xarray.Dataset":  # fmt: skip
    import xarray  # noqa: PLC0415 (on first use)

    names = [*axes, *(["damping"] if several[0] else []), *(["case"] if several[1] else [])]
    kinds = table.shape[len(names)]
    inner = ("t", "dof") if keep == "history" else ("dof",)
    variables = {}
    for kind, name in zip(range(kinds), "uva", strict=False):
        long = f"{'largest ' if keep == 'peak' else ''}{LONG[name]}{' at t_end' if keep == 'final' else ''}"
        values_of = np.take(table, kind, axis=len(names))
        variables[f"peak_{name}" if keep == "peak" else name] = named((*names, *inner), values_of, {"long_name": long})
    coordinates = {name: named(name, x, {}) for name, x in axes.items()}
    coordinates["dof"] = named("dof", np.array(kept, dtype=object if structure.names else np.int64), {})
    if keep == "history":
        h = float(values["dt"])
        coordinates["t"] = named("t", np.arange(table.shape[len(names) + 1]) * h, {"long_name": "time"})
    attrs = {"scheme": scheme.name} | {name: float(x) for name, x in values.items() if not x.ndim}
    return xarray.Dataset(variables, coordinates, attrs)
