"""A material of the user's own with a memory: f(t, u, v, state) -> force, tangent, new state."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.errors import float_array, real_array
from ..solvers.matrices import Matrix, checked, reduced

States = Mapping[str, Array]
STATE = "state"  # the name of a state that is one array


@dataclass(eq=False)
class Material:
    """The function, of all N displacements, and its state before the start, an array or a dictionary of arrays."""

    force: Callable[..., Any]
    first: Any

    @cached_property
    def states(self) -> States:
        """The state at the start, by name. Raises ValueError for what is neither an array nor a dictionary of them."""
        return self._named("state", self.first)

    def answer(
        self, t: float, u: Array, v: Array, states: States, T: Matrix
    ) -> tuple[Array, Matrix | None, Matrix | None, States]:
        """Force (n,), its slopes by u and by v (n, n) in the free degrees of freedom, and the state to commit.

        Raises ValueError for a function that returns something else, or changes the state that it is given.
        """
        given = {name: x.copy() for name, x in states.items()}
        found = self.force(t, u, v, given if isinstance(self.first, Mapping) else given[STATE])
        if not isinstance(found, tuple) or len(found) != 3:
            raise ValueError(
                "expected internal_force with state= to return three things, force, tangent and new state, got "
                f"{type(found).__name__ if not isinstance(found, tuple) else len(found)}; return all three"
            )
        if changed := [name for name, x in given.items() if not np.array_equal(x, states[name], equal_nan=True)]:
            raise ValueError(
                f"expected internal_force to leave the {changed[0]} that it is given as it is, got one that changes "
                "it; return a new one, as state.copy()"
            )
        force, tangent, new = found
        N = float_array("the force that internal_force returns", force)
        if N.shape != (len(u),):
            raise ValueError(
                f"expected internal_force to return a force of {len(u)} numbers, one for each degree of freedom, got "
                f"shape {N.shape}; return an array"
            )
        pair = tangent if isinstance(tangent, tuple) else (tangent, None)
        K, C = (None if x is None else reduced(checked("the tangent", x, len(u)), T) for x in pair)
        if K is None:
            raise ValueError(
                "expected internal_force with state= to return its tangent, a matrix or a pair, got None; return it"
            )
        return T.T @ N, K, C, self._same(self._named("the new state", new))

    def _named(self, what: str, state: Any) -> States:
        if isinstance(state, Mapping):
            return {str(name): np.array(real_array(f"{what} {name}", x)) for name, x in state.items()}
        return {STATE: np.array(real_array(what, state))}

    def _same(self, new: States) -> States:
        """The new state, if it is of the names and shapes of the first one."""
        shapes, wanted = ({name: x.shape for name, x in found.items()} for found in (new, self.states))
        if shapes != wanted:
            raise ValueError(
                f"expected internal_force to return a new state of names and shapes {wanted}, as state= has them, got "
                f"{shapes}; return one of the same kind"
            )
        return new
