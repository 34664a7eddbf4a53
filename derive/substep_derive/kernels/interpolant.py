"""The motion between two steps: Hermite's polynomial in displacement, velocity and acceleration at both ends.

Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), II.6.
"""

from dataclasses import dataclass

from sympy import Expr, Integer, Matrix, Symbol, horner, symbols

from ..declare.symbols import Knot, h

share = Symbol("share")  # (t - t_n)/h


@dataclass(frozen=True)
class Interpolant:
    """u, v, a at t_n + share*h, functions of share, h and of the values at both ends.

    degree: motions t^k, k <= degree, are reproduced; so the error of u is O(h^(degree + 1)) where the values are exact.
    """

    u: Expr
    v: Expr
    a: Expr
    degree: int

    @classmethod
    def of(cls, begin: Knot, end: Knot) -> "Interpolant":
        """The polynomial of least degree through the values at both ends."""
        degree = len(begin) + len(end) - 1
        coefficients = symbols(f"p:{degree + 1}")
        polynomial = sum((c * share**k for k, c in enumerate(coefficients)), Integer(0))
        equations = []
        for knot, place in ((begin, 0), (end, 1)):
            equations += [
                polynomial.diff(share, order).subs(share, place) - value * h**order for order, value in enumerate(knot)
            ]
        matrix = Matrix(equations).jacobian(coefficients)
        right = -Matrix(equations).subs(dict.fromkeys(coefficients, 0))
        solved = polynomial.subs(dict(zip(coefficients, matrix.solve(right), strict=True)))
        u, v, a = (horner(solved.diff(share, order).expand(), share) / h**order for order in range(3))
        return cls(u, v, a, degree)
