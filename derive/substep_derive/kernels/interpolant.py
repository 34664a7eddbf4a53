"""The motion between two steps: Hermite's polynomial in displacement, velocity and acceleration at both ends.

Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), II.6. A derivative of it divides the local
error of a step by h, or by h^2. The polynomial of least degree through velocities and accelerations alone divides that
of v by h: it gives the acceleration of a scheme of low order more exactly.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from sympy import Expr, Integer, Matrix, Symbol, horner, symbols

from ..declare.symbols import Knot, h

share = Symbol("share")  # (t - t_n)/h


@dataclass(frozen=True)
class Interpolant:
    """u, v, a at t_n + share*h, functions of share, h and of the values at both ends.

    degree: motions t^k, k <= degree, are reproduced in u; so its error is O(h^(degree + 1)) where the values are exact.
    """

    u: Expr
    v: Expr
    a: Expr
    degree: int

    @classmethod
    def of(cls, begin: Knot, end: Knot, order: int) -> "Interpolant":
        """For a scheme whose local errors of u and v are O(h^(order + 1)).

        The degree of u minus 1, 2 bounds the order of v, a as its derivatives, the local error over h, h^2 another.
        """
        u, degree = _polynomial(begin, end)
        v, degree_of_v = _polynomial(begin[1:], end[1:])
        by_u, by_v = min(degree - 1, order - 1), min(degree_of_v, order)
        a = u.diff(share, 2) / h**2 if by_u >= by_v else v.diff(share) / h
        return cls(_nested(u), _nested(u.diff(share)) / h, _nested(a), degree)


def _nested(e: Expr) -> Expr:
    return horner(e.expand(), share)


def _polynomial(begin: Sequence[Symbol], end: Sequence[Symbol]) -> tuple[Expr, int]:
    """The polynomial in share of least degree with these values and derivatives by time at 0 and 1; and its degree."""
    degree = len(begin) + len(end) - 1
    coefficients = symbols(f"p:{degree + 1}")
    polynomial = sum((c * share**k for k, c in enumerate(coefficients)), Integer(0))
    equations: list[Expr] = []
    for values, place in ((begin, 0), (end, 1)):
        equations += [
            polynomial.diff(share, order).subs(share, place) - value * h**order for order, value in enumerate(values)
        ]
    right = -Matrix(equations).subs(dict.fromkeys(coefficients, 0))
    solved = Matrix(equations).jacobian(coefficients).solve(right)
    return polynomial.subs(dict(zip(coefficients, solved, strict=True))), degree
