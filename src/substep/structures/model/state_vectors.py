"""The motion that a march of a structure goes on from, in its free degrees of freedom."""

import numpy as np

from ...core.arrays import Array
from ...core.state import State
from .constraints import independent
from .memory import Memory, RememberingForce
from .model import Model


def vectors(structure: Model, state: State) -> Array:
    """u, v, a (3, n) of the free degrees of freedom; a from the equation of motion where the state has none.

    Raises ValueError for numbers of another count than all degrees of freedom, and for those that the constraints do
    not allow.
    """
    given = ("u", state.u), ("v", state.v), ("a", state.a)
    found = [independent(f"{name} of start", x, structure.T, structure.names) for name, x in given if x is not None]
    if len(found) < 3:
        found.append(structure.acceleration(state.t, *found, memory=memory_of(structure, state)))
    return np.array(found)


def memory_of(structure: Model, state: State) -> Memory | None:
    """What its internal force remembers in the state; None for one that remembers nothing.

    Raises ValueError where the state does not say it, or says it of another structure.
    """
    if isinstance(structure.internal, RememberingForce):
        return structure.internal.remembered(state.memory)
    if state.memory:
        raise ValueError(
            f"expected no memory of start for a structure that remembers nothing, got {', '.join(state.memory)}; leave "
            "it out, or go on with the structure that has these springs"
        )
    return None
