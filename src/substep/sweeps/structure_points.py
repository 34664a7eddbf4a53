"""The points of a sweep of structures: each marched by itself, or many with springs side by side in one kernel."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..core.arrays import Array
from ..core.outcome import STATUSES as ENDED
from ..core.schemes import Scheme
from ..run.axes import Keep
from ..run.clock import number_of_steps
from ..structures.march.compiled import CompiledSteps, begun_together, kind_of, loads_side_by_side, takes
from ..structures.march.fixed_steps import FixedSteps
from ..structures.march.histories import selection
from ..structures.march.march_structure import march_structure
from ..structures.march.scheme_plan import step_of
from ..structures.march.steps import Run
from ..structures.march.time_loop import Stretch, Trial, steps_taken
from ..structures.model.given import Dof
from ..structures.model.memory import Memory, Recalled, RememberingForce
from ..structures.solvers.combine import combined
from ..structures.structure import Structure
from .lanes import largest_moduli

COMPLETED, FAILED, OVERFLOWED = (ENDED.index(name) for name in ("completed", "newton_failed", "non_finite"))
LANES, ROWS, WORTH = 16, 256, 1e5  # points that a kernel marches side by side, steps it makes at once, and how many ...
# ... steps of all points are worth it: the kernel for one point may be compiled already


class Wanted(NamedTuple):
    """What is kept of each point, at which degrees of freedom, and whether of springs; points: of the whole sweep."""

    t_end: float
    keep: Keep
    dofs: tuple[Dof, ...]
    springs: bool
    points: int


def kinds_of(scheme: Scheme, h: float) -> int:
    """3 where the scheme has an acceleration of its own, else 2: u and v."""
    return 3 if len(step_of(scheme, h).report) == 3 else 2


def side_by_side(runs: Sequence[Run], of: Wanted) -> list[tuple[list[Array], Any]]:
    """What `marched` returns for each run: from one kernel for all, where it takes them and there is much to do."""
    first, n = runs[0], number_of_steps(runs[0].h, of.t_end)
    few = len(runs) < LANES // 4 or n * of.points < WORTH
    if few or first.scheme.starter is not None or not all(map(takes, runs)):
        return [marched(run, number_of_steps(run.h, of.t_end), of) for run in runs]
    kind = kind_of(first)
    if (same := next((k for k, run in enumerate(runs) if kind_of(run) != kind), len(runs))) < len(runs):
        return side_by_side(runs[:same], of) + side_by_side(runs[same:], of)
    begun, strained = begun_together(runs)
    every = [*begun, *[begun[-1]] * (LANES - len(runs))]
    select = selection(first.structure, [first.structure.place(dof) for dof in of.dofs])
    kinds = kinds_of(first.scheme, first.h)
    histories, s = of.keep == "history", first.structure
    shown = s.T[[s.place(dof) for dof in of.dofs]] if of.keep == "peak" else None
    compiled = CompiledSteps.together(every, ROWS if histories else 1, shown=shown)
    lanes = compiled.at([run.started() for run in every], [_memory(run) for run in every])
    lanes.alive[len(runs) :] = False
    loads = loads_side_by_side(every, n)
    found, done = [select(np.stack([run.given[:kinds] for run in begun], axis=-1)), strained], 0
    rows = [np.empty((n + 1, *row.shape)) for row in found] if histories else None
    for table, row in zip(rows or (), found, strict=rows is not None):
        table[0] = row
    peaks = [np.abs(row) for row in found]
    with np.errstate(all="ignore"):  # in lanes that fail
        while done < n and lanes.alive.any():
            last = done + ROWS if histories else n
            made = compiled.made(lanes, [x[:, done:last] for x in loads])
            m = len(made.motion)
            if m == 0:
                continue
            moved = made.motion[:, :kinds, :, : len(runs)]
            moved = select(moved.reshape(-1, *moved.shape[2:])).reshape(m, kinds, -1, len(runs))
            found = [moved, made.springs[:, :2, :, : len(runs)]]
            for table, x in zip(rows or (), found, strict=rows is not None):
                table[done + 1 : done + m + 1] = x
            done, found = done + made.done, [x[-1] for x in found]
    if rows is not None:
        tables = [np.moveaxis(table, 0, 1) for table in rows]
    elif of.keep == "peak":
        peaks = [np.maximum(x, y[..., : len(runs)]) for x, y in zip(peaks, compiled.largest, strict=True)]
        tables = [peaks[0], np.concatenate([peaks[1], found[1][:1]])]
    else:
        tables = found
    return [
        ([table[..., k] for table in tables], COMPLETED) if lanes.alive[k] else marched(run, n, of)
        for k, run in enumerate(runs)
    ]


def _memory(run: Run) -> Memory:
    """What springs remember where a run begins."""
    assert run.memory is not None
    return run.memory


def marched(run: Run, n: int, of: Wanted) -> tuple[list[Array], Any]:
    """Tables of motion (kinds, k) or (kinds, n+1, k), with the axis of cases last where there are any, and a status.

    Another table is of springs: elongations and forces, (2, s) or (2, n+1, s), and of peaks the elongations at the end.
    One more is of contacts or constraints: reactions and gaps, (2, d) or (2, n+1, d).
    """
    select = selection(run.structure, [run.structure.place(dof) for dof in of.dofs])
    kinds, springs = kinds_of(run.scheme, run.h), of.springs
    latest = _begun(run, select(run.given[:kinds]), springs=springs)
    rows = [np.full((n + 1, *row.shape), np.nan) for row in latest] if of.keep == "history" else None
    for table, row in zip(rows or (), latest, strict=rows is not None):
        table[0] = row
    peaks, status = [np.abs(row) for row in latest], COMPLETED
    clock = FixedSteps(run, n, to_end=True)
    with np.errstate(all="ignore"):
        for step in steps_taken(clock):
            last = clock.done == n
            if not last and of.keep == "final":
                continue
            made = _motion(run, step, kinds, select, springs=springs)
            if last:
                u = step.motion[-1] if isinstance(step, Stretch) else combined(step.march.steps.report[:1], step.X)
                status = np.where(np.isfinite(u[0].sum(axis=0)), COMPLETED, OVERFLOWED)
            latest = [x[-1] for x in made]
            for k, x in enumerate(made):
                if rows is not None:
                    rows[k][clock.done - len(x) + 1 : clock.done + 1] = x
                if of.keep == "peak":
                    np.maximum(peaks[k], largest_moduli(np.array(x)[None], np.maximum)[0], out=peaks[k])
    if rows is not None:
        found = [np.moveaxis(table, 0, 1) for table in rows]
    elif of.keep == "peak":
        found = peaks
        if springs:
            found[1] = np.concatenate([peaks[1], latest[1][:1]])
    else:
        found = latest
    if clock.status != "completed":
        status = FAILED
        found = found if rows is not None else [np.full_like(x, np.nan) for x in found]
    return [np.where(np.isfinite(x), x, np.nan) for x in found], status


def chosen(
    s: Structure, scheme: Scheme, tol: float, of: Wanted, asked: Mapping[str, Any]
) -> tuple[list[Array], int, tuple[int, int, float]]:
    """What `marched` returns of a run that chooses its steps, but for histories; and how many it accepted and rejected,
    and the end of the one that could not be made, NaN if none; asked: of `march`, by name.
    """
    r = march_structure(s, scheme, None, of.t_end, dofs=of.dofs, account=False, progress=False, tol=tol, **asked)
    if r.status == "interrupted":
        raise KeyboardInterrupt
    rows = [np.array([getattr(r, name) for name in "uva"[: kinds_of(scheme, of.t_end)]])]
    if of.springs:
        assert r.springs is not None
        rows.append(np.array([r.springs.elongations, r.springs.forces]))
    if r.touched is not None:
        rows.append(np.moveaxis(r.touched, 1, 0))
    found = [np.abs(x).max(axis=1) if of.keep == "peak" else x[:, -1] for x in rows]
    if of.springs and of.keep == "peak":
        found[1] = np.concatenate([found[1], rows[1][:1, -1]])
    if r.status != "completed":
        found = [np.full_like(x, np.nan) for x in found]
    assert r.statistics is not None
    cost = r.statistics.accepted, r.statistics.rejected, np.nan if r.t_failed is None else r.t_failed
    return found, ENDED.index(r.status), cost


def _begun(run: Run, motion: Array, *, springs: bool) -> list[Array]:
    """The rows of the tables of `marched` where a run begins."""
    found = [motion]
    if springs:
        assert run.memory is not None
        found.append(_strained(run, run.given, run.memory))
    return found if run.reactions is None else [*found, run.touched]


def _motion(
    run: Run, step: Trial | Stretch, kinds: int, select: Callable[[Array], Array], *, springs: bool
) -> list[Array]:
    """The rows of the tables of `marched` after each of the steps: (m, kinds, k), (m, 2, s) and (m, 2, d)."""
    if isinstance(step, Stretch):
        motion = step.motion[:, :kinds]
        made = select(motion.reshape(-1, motion.shape[-1])).reshape(len(motion), kinds, -1)
        return [made, step.springs[:, :2]] if springs else [made]
    rows = combined(step.march.steps.report[:kinds], step.X)
    found = [select(rows)[None]]
    if springs:
        assert step.march.memory is not None
        found.append(_strained(run, rows, step.march.memory)[None])
    if run.reactions is not None:
        found.append(step.march.touched(step.X)[None])
    return found


def _strained(run: Run, rows: Array, memory: Memory) -> Array:
    """Elongations and forces (2, s) of springs at u, v, the first of the rows, where the memory was committed."""
    force = run.structure.internal
    assert isinstance(force, RememberingForce)
    found = force.answer(0.0, rows[0], rows[1], Recalled(memory)).of_springs
    assert found is not None
    return np.array([found.e, found.force])
