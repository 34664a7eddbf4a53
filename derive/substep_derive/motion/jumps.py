"""EquationsOfMotion -> forces that jump, as dry friction does that is declared by a sign."""

from sympy import Expr, Integer, Max, Min, Symbol, ordered

from ..declare.branches import larger, sign_of, smaller, where_at_least
from ..declare.symbols import t
from .equations import EquationsOfMotion


def jumps(motion: EquationsOfMotion) -> list[tuple[Symbol, Expr]]:
    """Each coordinate whose force jumps, with that whose sign it jumps by: linear in a coordinate or a rate.

    Not what is 0 there, as |v| v = v^2 sign(v) is.
    """
    found = list[tuple[Symbol, Expr]]()
    moving = (*motion.coordinates, *motion.scene.rates)
    _, whole = motion.equation(list(motion.coordinates), list(motion.scene.rates), t)
    for q, e in zip(motion.coordinates, whole, strict=True):
        for branch in ordered(e.atoms(sign_of, where_at_least)):
            of, above, below = _sides(branch)
            slopes = {x: of.diff(x) for x in moving if x in of.free_symbols}
            x = next((x for x, slope in slopes.items() if slope != 0 and x not in slope.free_symbols), None)
            if x is not None:
                change = e.xreplace({branch: above}) - e.xreplace({branch: below})
                there = change.subs(x, x - of / slopes[x]).replace(larger, Max).replace(smaller, Min)
                if there.expand() != 0:
                    found.append((q, of))
    return found


def _sides(branch: Expr) -> tuple[Expr, Expr, Expr]:
    """That whose sign decides, and what the branch is where it is positive and where it is negative."""
    if isinstance(branch, sign_of):
        return branch.args[0], Integer(1), Integer(-1)
    a, b, above, below = branch.args
    return a - b, above, below
