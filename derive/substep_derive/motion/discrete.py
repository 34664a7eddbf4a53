"""EquationsOfMotion -> discrete gradients of its potential and constraints, for schemes that take forces so."""

from collections.abc import Sequence
from dataclasses import replace

from sympy import Expr, Integer, Matrix

from ..declare.errors import DeclarationError
from ..declare.symbols import t
from .differences import discrete_slopes
from .equations import EquationsOfMotion


def discrete_gradient(motion: EquationsOfMotion, u0: Sequence[Expr], u1: Sequence[Expr]) -> Matrix:
    """Simo & Tarnow (1992), Gonzalez (1996): N with N.(u1 - u0) = V(u1) - V(u0), formed in the invariants.

    Forces of coordinates that have no potential are taken at the midpoint.

    An invariant is at most quadratic, so its own discrete gradient is the gradient at the midpoint;
    angular momentum is conserved because |u|^2 enters as one invariant.
    """
    at = [dict(zip(motion.coordinates, u, strict=True)) for u in (u0, u1)]
    old, new = ({q: e.subs(where, simultaneous=True) for q, e in motion.invariants.items()} for where in at)
    slopes = discrete_slopes(motion.potential, old, new)
    middle = {q: (a + b) / 2 for q, a, b in zip(motion.coordinates, u0, u1, strict=True)}
    gradient = [
        sum((slopes[q] * e.diff(x).subs(middle, simultaneous=True) for q, e in motion.invariants.items()), Integer(0))
        for x in motion.coordinates
    ]
    return Matrix(gradient) + motion.of_terms(False, True).subs(middle, simultaneous=True)


def discrete_equation(
    motion: EquationsOfMotion, old: Sequence[Expr], new: Sequence[Expr], v: Sequence[Expr], at: Expr
) -> tuple[Matrix, Matrix]:
    """As `equation`, with the discrete gradient of the potential between two displacements, and else their mean."""
    middle = [(a + b) / 2 for a, b in zip(old, new, strict=True)]
    given = dict(zip((*motion.coordinates, *motion.scene.rates, t), (*middle, *v, at), strict=True))
    others = (motion.damping * Matrix(motion.scene.rates) + motion.rate_force).subs(given, simultaneous=True)
    return motion.mass, discrete_gradient(motion, old, new).subs(t, at) + others


def discrete_directions(motion: EquationsOfMotion, u0: Sequence[Expr], u1: Sequence[Expr]) -> Matrix:
    """Discrete gradients (c, d) of the constraints between two displacements: see `discrete_gradient`.

    Raises DeclarationError for one whose direction depends on the time, which has none.
    """
    rows, middle = [], [(a + b) / 2 for a, b in zip(u0, u1, strict=True)]
    for k, (name, g) in enumerate(motion.held.by_name.items()):
        if motion.held.of_rates[k] and not motion.held.directions[k, :].has(t):
            rows.append(motion.held.directions_at(middle, Integer(0))[k, :])
            continue
        if motion.held.directions[k, :].has(t):
            raise DeclarationError(
                f"{motion.scene.name}: expected {name} without time, for a scheme that takes forces as "
                f"discrete gradients, got {g}; take another scheme"
            )
        alone = replace(
            motion.scene, potential=g.subs(t, 0), constraints={}, contacts={}, frictions={}, laws={}, forces={}, load={}
        )  # fmt: skip
        rows.append(discrete_gradient(EquationsOfMotion(alone), u0, u1).T)
    return Matrix.vstack(*rows)
