"""Where a march of a structure goes on from, and where it stands."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ...core.arrays import Array, digest
from ...core.loads import behind_jump, values_at
from ...core.schemes import Scheme
from ...core.state import State, bare, whose
from ...run.clock import Begin, ConstantSteps, Control
from ..model.constraints import independent
from ..model.contacts import Contacts
from ..model.held import Held
from ..model.memory import Memory, Recalled, RememberingForce
from ..model.model import Model
from ..model.state_vectors import memory_of, reactions_of, vectors
from ..solvers.combine import combined
from ..solvers.complementarity import NotFound
from ..solvers.matrices import arrays_of
from .holding import Holding
from .newton import Tangent
from .scheme_plan import start_of, step_of
from .steps import Run
from .time_loop import Trial


def kind_of(structure: Model) -> str:
    """Of run, as states name it: what the scheme carries is of these free degrees of freedom."""
    return f"structure {digest(*arrays_of(structure.T))[:12]}"


def begun(run: Run, steps: ConstantSteps | Control, state: State | None) -> tuple[Run, Sequence[Tangent | None]]:
    """The run from where a state stands, and the tangents that its systems keep there; itself without a state."""
    s = run.structure
    if state is None:
        return at_start(run) if isinstance(steps, Control) else first_held(at_start(run)), ()
    start, remembered = vectors(s, state), memory_of(s, state)
    if s.contacts is not None:
        if not state.of and isinstance(s.contacts, Held):  # a scheme's own velocities drift off by its error
            s.contacts.require_kept(start[0], start[1])
        elif not state.of and isinstance(s.contacts, Contacts):
            s.contacts.require_open(start[0])
        run = replace(run, reactions=reactions_of(s, state, start[0], start[1]))
    if isinstance(steps, Control):
        start[2] = _behind_jumps(run.structure, state.t, start, remembered)
        return replace(run, begin=Begin(0, state.t), start=start, remembered=remembered), ()
    rows = _own_rows(state, run)
    moved = replace(run, begin=steps.begin._replace(rows=rows), start=start, remembered=remembered)
    return (first_held(moved), ()) if rows is None else (moved, _tangents(state))


def at_start(run: Run) -> Run:
    """The run with the reactions at the structure's start, where it has any."""
    s = run.structure
    return run if s.contacts is None else replace(run, reactions=s.at_rest(0.0, s.u0, s.v0, s.memory0))


def first_held(run: Run) -> Run:
    """The run with multipliers at its start, and the acceleration with these, that keep nonlinear constraints ahead.

    That is at the first displacement at which an explicit scheme takes forces and that acceleration moves. Raises
    ValueError where none do.
    """
    s, steps = run.structure, step_of(run.scheme, run.h)
    touch = steps.systems[0].touch
    if not isinstance(s.contacts, Held) or touch is None or not touch.later:
        return run
    kinds = [kind for kind, _ in run.scheme.history]
    state = np.eye(3)[kinds] if run.scheme.info.start == "given" else start_of(run.scheme, run.h).out
    rows = [row for system in steps.systems for row in system.displacements if not row[steps.given :].any()]
    row = next((found for found in (row[: steps.given] @ state for row in rows) if found[2] != 0.0), None)
    if row is None:
        return run
    first = Holding(s, s.contacts, 2, None, 1.0, touch._replace(rows=row[None]), np.empty(0), acts=np.eye(3)[0])
    first.begin()
    start = np.array(run.given)
    if run.reactions is not None:
        start[2] -= s.pushed_by(run.reactions, start[0])
    try:
        start[2] = first.settled(start, start[2], s.solve_mass)
    except NotFound as error:
        raise ValueError(
            f"expected steps in the first of which {run.scheme.name} can keep the constraints, got dt = {run.h:g}; "
            "take a smaller one"
        ) from error
    return replace(run, start=start, reactions=first.p)


def _behind_jumps(s: Model, t: float, motion: Array, memory: Memory | None) -> Array:
    """The acceleration (n,) of u, v, a (3, n) at t, under the loads just after it where one of them jumps there.

    A run that has ended at the jump has the one before it, and chosen steps begin anew.
    """
    u, v, a = motion
    behind = [behind_jump(load, t) for _, load in s.loads]
    if all(value is None for value in behind):
        return a
    recalled = None if memory is None else Recalled(memory)
    right = s.force(t) - s.restoring(t, u, v, recalled) - (0.0 if s.C is None else s.damping @ v)
    for (shape, load), value in zip(s.loads, behind, strict=True):
        if value is not None:
            right += (value - float(values_at(load, np.array([t]))[0])) * shape
    a = s.solve_mass(right)
    return a + s.pushed_by(s.contacts.multipliers(u, v, a, s.solve_mass), u) if isinstance(s.contacts, Held) else a


def _own_rows(state: State, run: Run) -> Array | None:
    """What the scheme carries, in the free degrees of freedom; a user may give it in all of them.

    Raises ValueError for rows of another length.
    """
    s = run.structure
    if state.history and not state.of:
        rows = {label: x if len(x) == s.size else independent(f"{label} of the history of start", x, s.T, s.names)
                for label, x in state.history.items()}  # fmt: skip
        motion = independent("u of start", state.u, s.T, s.names), independent("v of start", state.v, s.T, s.names)
        state = replace(state, history=rows, u=motion[0], v=motion[1])
    return state.rows(bare(run.scheme.state), whose(run.scheme, kind_of(s)), run.h)


def _tangents(state: State) -> list[Tangent | None]:
    """Those that systems kept where a march of the same scheme ended."""
    return tangents_in(state.more)


def tangents_in(more: Mapping[str, Array], first: str = "") -> list[Tangent | None]:
    """Those that `tangent_arrays` has named, beginning with `first`."""
    names = [name.removeprefix(first) for name in more if name.startswith(f"{first}tangent ")]
    numbers = [int(name.split()[1]) for name in names if name.endswith(" at")]
    found: list[Tangent | None] = [None] * (max(numbers, default=-1) + 1)
    for k in numbers:
        t, largest = more[f"{first}tangent {k}"].tolist()
        found[k] = Tangent(t, more[f"{first}tangent {k} at"], largest)
    return found


def tangent_arrays(tangents: Sequence[Tangent | None], first: str = "") -> dict[str, Array]:
    """The tangents that systems keep as arrays, whose names begin with `first`."""
    kept = [(f"{first}tangent {k}", x) for k, x in enumerate(tangents) if x is not None]
    at = {f"{name} at": x.at for name, x in kept}
    return at | {name: np.array([x.t, x.largest]) for name, x in kept}


def stands(
    last: Trial,
    run: Run,
    done: int,
    steps: ConstantSteps,
    tangents: Sequence[Tangent | None],
    memory: Memory | None,
    reactions: Array | None,
) -> Callable[[], State]:
    """The state after so many steps and the last of them, after which systems kept these tangents, with this memory."""
    march, rows = last.march, None
    if march.run is run:  # and not the run of the scheme that starts this one
        rows = combined(march.steps.out, last.X)
    return stood(combined(march.steps.report, last.X), rows, run, done, steps, tangents, memory, reactions)


def stood(
    motion: Array, rows: Array | None, run: Run, done: int, steps: ConstantSteps, tangents: Sequence[Tangent | None],
    memory: Memory | None, reactions: Array | None = None,
) -> Callable[[], State]:  # fmt: skip
    """The same from u, v, a (2 or 3, n) there, and from the rows (S, n) that the scheme carries if it is under way."""
    return partial(_state, run.structure, run.scheme, steps, done, motion, rows, tangents, memory, reactions)


def _state(
    structure: Model,
    scheme: Scheme,
    steps: ConstantSteps,
    done: int,
    motion: Array,
    rows: Array | None,
    tangents: Sequence[Tangent | None],
    memory: Memory | None,
    reactions: Array | None,
) -> State:
    """The state with u, v and, where the scheme has its own, a, and what the scheme carries, if it is under way."""
    u, v, *a = (structure.T @ x for x in motion)
    here = steps.state(done, u, v, a[0] if a else None)
    if memory is not None and isinstance(structure.internal, RememberingForce):
        here = replace(here, memory=structure.internal.named(memory))
    if reactions is not None:
        here = replace(here, memory={**here.memory, **named_reactions(structure, reactions)})
    if rows is None:
        return here
    history, of = dict(zip(bare(scheme.state), rows, strict=True)), whose(scheme, kind_of(structure))
    return replace(here, history=history, of=of, more=tangent_arrays(tangents))


def named_reactions(structure: Model, reactions: Array) -> dict[str, Any]:
    """The reactions (d,) that a later step takes, by name; none where they are not remembered."""
    if structure.contacts is None or not structure.contacts.remembered:
        return {}
    named = structure.contacts.by_name(reactions[None])
    return {name: x[0] if x.ndim > 1 else float(x[0]) for name, x in named.items()}
