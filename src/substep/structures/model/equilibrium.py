"""The displacements at rest under the loads at t = 0."""

import numpy as np

from ...core.arrays import Array, dot
from .model import Model

ITERATIONS = 60
CLOSE = 1e-12  # last correction, relative to the largest displacement
SHORTEST = 1e-6  # part of a correction


def equilibrium(s: Model) -> Array:
    """Displacements (n,) for which the stiffness, or the internal force, bears the loads at t = 0 without motion.

    Those of an internal force are found from zero by Newton's iteration with its tangent; a correction is halved while
    the residual would grow. Raises ValueError for a singular stiffness, as of a free body, for an internal force
    without a tangent, and where the iteration does not converge.
    """
    load, rest = s.force(0.0), np.zeros(s.size)
    if s.internal is None:
        return s.factorized(s.K, "K, the stiffness matrix, for u0='static'")(load)
    if s.internal.tangent is None:
        raise ValueError("expected tangent= with u0='static', which Newton's iteration takes, got none; give it, or u0")
    u, residual = rest, load - s.internal(0.0, rest, rest)
    for _ in range(ITERATIONS):
        solve = s.factorized(s.internal.stiffness(0.0, u, rest)[0], "the tangent, for u0='static'")
        change, part = solve(residual), 1.0
        if np.abs(change).max() <= CLOSE * np.abs(u + change).max():
            return u + change
        while True:
            new = u + part * change
            left = load - s.internal(0.0, new, rest)
            if dot(left, left) < dot(residual, residual) or part < SHORTEST:
                break
            part *= 0.5
        u, residual = new, left
    raise ValueError(
        f"expected an equilibrium under the loads at t = 0, got a residual of {np.abs(residual).max():.3g} after "
        f"{ITERATIONS} iterations for loads of {np.abs(load).max():.3g}; give u0 as displacements"
    )
