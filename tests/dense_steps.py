"""Any declaration on M a + C v + K u = f, stepped densely from its own equations, without the derivation.

All relations and balances of a step are one linear system in the new symbols, solved at once by LAPACK.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from declared_steps import Array, Marcher, System
from substep_derive import Scheme
from substep_derive.declare.symbols import N
from sympy import Symbol


class LinearMarcher(Marcher):
    """As `Marcher`, for a force K u and steps of any length."""

    def step(self, state: Mapping[Symbol, Array], t: Any) -> dict[Symbol, Array]:
        """All symbols after a step that begins at t."""
        K, d = self.system.tangent(np.zeros(self.d)), self.d
        loads = [self.value([(term[0], self.eye, [])], {}, t) for term in self.loads]
        given = np.concatenate([*(state[s] for s in self.state), np.zeros(len(self.forces) * d), *loads])
        m = len(self.unknowns) * d
        matrix, right, units = np.eye(m), self.known(given), np.eye(len(given))
        known = self.known(units)
        for k, ((atom, _, _), (by_new, by_given)) in enumerate(zip(self.forces, self.where, strict=True)):
            by_force = known[:, self.of_force.start + k * d :][:, :d]
            share = 1.0 if isinstance(atom, N) else 0.5  # the discrete gradient is the force at the midpoint
            where = by_new(np.eye(m)), by_given(units)
            for row in range(0, len(where[0]), d):
                part = share * by_force @ K
                matrix = matrix - part @ where[0][row : row + d]
                right = right + part @ where[1][row : row + d] @ given
        found = np.linalg.solve(matrix, right).reshape(-1, d)
        return {**state, **dict(zip(self.unknowns, found, strict=True))}


def march(
    scheme: Scheme, values: Mapping[Symbol, Any], M: Array, C: Array, K: Array, load: Callable[[float], Array],
    h: float, n: int, u: Array, v: Array,
) -> list[list[Array]]:  # fmt: skip
    """Rows (u, v, a) at 0, h, ..., n h."""
    by_mass = np.linalg.inv(M)
    system = System(
        lambda x: by_mass @ K @ x, lambda x: by_mass @ K, lambda old, new: by_mass @ K @ (old + new) / 2, by_mass @ C,
        lambda t: by_mass @ load(t),
    )  # fmt: skip
    return _march(scheme, values, system, h, n, u, v)


def _march(
    scheme: Scheme, values: Mapping[Symbol, Any], system: System, h: float, n: int, u: Array, v: Array
) -> list[list[Array]]:
    from substep_derive.declare.symbols import knot_of, lattice

    rows = [[u, v, system.acceleration(u, v, 0.0)]]
    marcher = LinearMarcher(scheme, values, system, h, u)
    if scheme.start_scheme is not None:
        at = {s: (int(lattice(knot_of(s)[1])), "uva".index(s.name[0])) for s in scheme.state}  # type: ignore[index, arg-type]
        lag = -min(step for step, _ in at.values())
        rows = _march(scheme.start_scheme, {}, system, h, lag, u, v)
        state = {s: rows[lag + step][kind] for s, (step, kind) in at.items()}
    else:
        state = marcher.started(u, v)
    for i in range(len(rows) - 1, n):
        x = marcher.step(state, i * h)
        rows.append(marcher.reported(x, i * h))
        state = marcher.after(x)
    return rows
