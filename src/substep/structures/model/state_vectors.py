"""The motion that a march of a structure goes on from, in its free degrees of freedom."""

import numpy as np

from ...core.arrays import Array
from ...core.state import State
from .constraints import independent
from .contacts import Contacts
from .memory import WORK, Memory, RememberingForce
from .model import Model


def vectors(structure: Model, state: State) -> Array:
    """u, v, a (3, n) of the free degrees of freedom; a from the equation of motion where the state has none.

    Raises ValueError for numbers of another count than all degrees of freedom, and for those that the constraints do
    not allow.
    """
    given = ("u", state.u), ("v", state.v), ("a", state.a)
    found = [independent(f"{name} of start", x, structure.T, structure.names) for name, x in given if x is not None]
    if len(found) < 3:
        a = structure.acceleration(state.t, *found, memory=memory_of(structure, state))
        if structure.contacts is not None:
            a += structure.pushed_by(reactions_of(structure, state, *found), found[0])
        found.append(a)
    return np.array(found)


def reactions_of(structure: Model, state: State, u: Array, v: Array) -> Array:
    """The reactions (d,) of contacts that a step remembers, at u, v (n,): as the state says, else of those at rest.

    Raises ValueError for reactions of another shape.
    """
    contacts = structure.contacts
    assert contacts is not None
    if not contacts.remembered or not contacts.names.keys() <= state.memory.keys():
        return structure.at_rest(state.t, u, v, memory_of(structure, state))
    found = np.zeros(contacts.size)
    for name, where in contacts.names.items():
        if np.shape(x := state.memory[name]) != found[where].shape:
            raise ValueError(
                f"expected {name} in the memory of start of shape {found[where].shape}, got {np.shape(x)}; give "
                "what r.state.memory has"
            )
        found[where] = x
    return contacts.reported(found) if isinstance(contacts, Contacts) else found


def memory_of(structure: Model, state: State) -> Memory | None:
    """What its internal force remembers in the state; None for one that remembers nothing.

    Raises ValueError where the state does not say it, or says it of another structure.
    """
    contacts = {} if structure.contacts is None else structure.contacts.names
    memory = {name: x for name, x in state.memory.items() if name not in contacts and name != WORK}
    if isinstance(structure.internal, RememberingForce):
        return structure.internal.remembered(memory)
    if memory:
        raise ValueError(
            f"expected no memory of start for a structure that remembers nothing, got {', '.join(memory)}; leave "
            "it out, or go on with the structure that has these springs"
        )
    return None
