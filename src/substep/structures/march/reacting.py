"""The contacts, or the nonlinear constraints, of a structure in the systems of a scheme's steps."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...core.arrays import Array
from ..model.contacts import Contacts
from ..model.held import Held
from ..model.model import Model
from .holding import Holding
from .pressing import Pressing
from .scheme_plan import Steps, System


def suited(structure: Model, steps: Steps) -> Model:
    """The structure, with contacts whose reactions are remembered where the scheme is explicit.

    They act in one of its steps alone, as they move displacements at instants between which velocities do.
    """
    contacts = structure.contacts
    if not isinstance(contacts, Contacts) or not any(x.touch is not None and x.touch.later for x in steps.systems):
        return structure
    return replace(structure, contacts=replace(contacts, remembered=True))


def pressed(structure: Model, steps: Steps, before: Steps) -> tuple[Steps, tuple[Pressing | None, ...]]:
    """The steps with a vector more for each balance, behind the unknowns, and the contacts in their systems.

    before: the steps as they are without what their last unknown is less by: see `Steps.less`. Accelerations of the new
    state, and what is reported of a, are without those of reactions.
    """
    contacts, one_of = structure.contacts, Pressing if isinstance(structure.contacts, Contacts) else Holding
    if isinstance(contacts, Held) and any(len(group) > 1 for group in steps.groups):
        return steps, _held_together(structure, contacts, steps)
    touched = [k for k, system in enumerate(steps.systems) if system.touch is not None]
    if contacts is None or not touched:
        return steps, (None,) * len(steps.systems)
    V, places = steps.vectors, [steps.systems[k].place for k in touched]
    found: list[Pressing | None] = [None] * len(steps.systems)
    for at, k in enumerate(touched, V):
        system = steps.systems[k]
        assert system.touch is not None
        own, none = float(system.inertia[system.place]), np.zeros(contacts.size)
        kept = None if contacts.remembered else at
        found[k] = one_of(structure, contacts, system.place, kept, own, system.touch, none)
    if contacts.remembered:
        _remember([(before.systems[k], x) for k, x in enumerate(found) if x is not None], before)
        return steps, tuple(found)

    def wider(rows: Array, old: Array, of: Array) -> Array:
        return np.concatenate([rows, np.where(of[:, None], -old[:, places], 0.0)], axis=1)

    none = np.zeros(len(places))
    every = {name: np.append(row, none) for name, row in steps.rows.items()}
    reports = np.arange(len(steps.report)) == 2
    out, report = wider(steps.out, before.out, steps.accelerations), wider(steps.report, before.report, reports)
    return replace(steps, out=out, report=report, rows=every, more=len(places)), tuple(found)


def _held_together(structure: Model, held: Held, steps: Steps) -> tuple[Pressing | None, ...]:
    """Nonlinear constraints in the last of the systems that are solved together, which are all of the step."""
    (group,) = steps.groups
    stages = tuple((force.u, force.w) for system in group for force in system.forces)
    last = group[-1]
    assert last.touch is not None
    one = Holding(structure, held, last.place, None, 1.0, last.touch, np.zeros(held.size), stages=stages)
    return *(None for _ in group[1:]), one


def _remember(pairs: Sequence[tuple[System, Pressing]], steps: Steps) -> None:
    """Give contacts that are remembered the weights of the forces, and the reactions that are known."""
    forces = [force for system, _ in pairs for force in system.forces]
    known = list[tuple[Array, Pressing]]()
    if any(np.array_equal(force.u, steps.out[0]) for force in forces):  # else a force at u_0 is of another reaction
        known.append((steps.rows["u_0"], pairs[-1][1]))
    for system, one in pairs:
        one.weight, own = sum(w for w, _, _ in system.differences), None
        for force in system.forces:
            at = next((x for row, x in known if np.array_equal(row, force.u)), None)
            if at is None:
                one.weight, own = one.weight + force.w, force.u
            else:
                one.known.append((force.w, at))
        if system.touch is not None:
            later = system.touch.later and own is not None
            known.append((own if later else system.touch.rows[0], one))
            if later and isinstance(one, Holding):
                one.acts = own
