"""Any declaration on M a + C v + K u = f, stepped densely from its own equations, without the derivation.

All relations and balances of a step are one linear system in the new symbols, solved at once by LAPACK.
"""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import mpmath
import numpy as np
from declared_steps import Array, Marcher, System
from declared_steps import march as march_system
from substep_derive import Scheme
from substep_derive.declare.symbols import N
from sympy import Symbol


class LinearMarcher(Marcher):
    """As `Marcher`, for a force K u and steps of any length."""

    def step(self, state: Mapping[Symbol, Array], t: Any) -> dict[Symbol, Array]:
        """All symbols after a step that begins at t."""
        loads = [self.value([(term[0], self.eye, [])], {}, t) for term in self.loads]
        forces = [0 * self.eye[0]] * len(self.forces)
        found = self.solution @ np.concatenate([*(state[s] for s in self.state), *forces, *loads])
        return {**state, **dict(zip(self.unknowns, found.reshape(-1, self.d), strict=True))}

    @cached_property
    def solution(self) -> Array:
        """The new symbols from the state and loads, with columns for the forces too, which are not used."""
        K, d = self.matrices[2], self.d
        m, size = len(self.unknowns) * d, self.of_force.stop + len(self.loads) * d
        matrix, right = np.eye(m), by_columns(self.known, size)
        known = right
        for k, ((atom, _, _), (by_new, by_given)) in enumerate(zip(self.forces, self.where, strict=True)):
            by_force = known[:, self.of_force.start + k * d :][:, :d]
            share = 1.0 if isinstance(atom, N) else 0.5  # the discrete gradient is the force at the midpoint
            where = by_columns(by_new, m), by_columns(by_given, size)
            for row in range(0, len(where[0]), d):
                part = share * by_force @ K
                matrix = matrix - part @ where[0][row : row + d]
                right = right + part @ where[1][row : row + d]
        return self.inverted(matrix) @ right


def by_columns(product: Callable[[Array], Array], size: int) -> Array:
    """The matrix of a product with vectors (size,)."""
    return np.array([product(unit) for unit in np.eye(size)]).T


def march(
    scheme: Scheme, values: Mapping[Symbol, Any], M: Array, C: Array, K: Array, load: Callable[[float], Array],
    h: float, n: int, u: Array, v: Array,
) -> list[list[Array]]:  # fmt: skip
    """Rows (u, v, a) at 0, h, ..., n h; in mpmath's precision where all are its numbers, with dtype object."""
    by_mass = np.array(mpmath.inverse(mpmath.matrix(M.tolist())).tolist()) if M.dtype == object else np.linalg.inv(M)
    system = System(
        lambda x: by_mass @ K @ x, lambda x: by_mass @ K, lambda old, new: by_mass @ K @ (old + new) / 2, by_mass @ C,
        lambda t: by_mass @ load(t),
    )  # fmt: skip
    return march_system(scheme, values, system, h, n, u, v, LinearMarcher)
