"""Steps that take u and v by one rule -> the rational functions of one variable that they consist of.

The oscillator with the state y = (u, h*v) is y' = L y + (0, h^2 f), with

    L = [[0, 1], [-Omega^2, -2 xi Omega]],    L^2 = -2 xi Omega L - Omega^2.

A Runge-Kutta scheme takes it to y_1 = R(L) y_0 + sum_k S_k(L) (0, h^2 f_k), with R its stability function and S_k(z)
what one step of y' = z y + f makes of the load at the k-th instant (Hairer & Wanner, Solving Ordinary Differential
Equations II (1996), IV.3). As polynomials in z they have a few coefficients each, where the entries of the
amplification matrix, polynomials in Omega and xi, have very many.
"""

from dataclasses import dataclass
from itertools import zip_longest

from sympy import Expr, Integer, Matrix, Poly

from ..algebra import rational
from ..declare.symbols import Omega, xi
from .amplification import Affine
from .stability_polynomial import rate

SQUARE = (-(Omega**2), -2 * xi * Omega)  # L^2 = SQUARE[0] + SQUARE[1]*L
Coefficients = tuple[Expr, ...]  # of a polynomial in z, lowest first


@dataclass(frozen=True)
class OneRule:
    """R = 1 + increment/den, and for each load (S, scale), which stand for S/(scale*den); scale is free of z.

    All coefficients are polynomials in the scheme's parameters.
    """

    den: Coefficients
    increment: Coefficients
    loads: tuple[tuple[Coefficients, Expr], ...]

    @classmethod
    def of(cls, step: Affine) -> "OneRule | None":
        """Of a step from u and h*v to these, the acceleration left to the loads; None where there are no R and S.

        They are read off at Omega^2 = 0, where z = -2 xi Omega is left, and then proved for every Omega and xi.
        """
        if step.N.shape != (2, 2) or not step.N.has(xi):
            return None
        limits = [_without_stiffness(e) for e in (step.den, step.N[1, 1], *step.load_N.row(1))]
        whole, P, *loads = (e for e in limits if e is not None)
        if len(loads) < step.load_N.cols:
            return None
        numerator, Q = _in_lowest_terms(P, whole)
        shares = [_in_lowest_terms(load * Q.as_expr(), whole) for load in loads]
        if any(scale.degree() > 0 for _, scale in shares):
            return None
        found = cls(
            _lowest_first(Q),
            _lowest_first(numerator - Q),
            tuple((_lowest_first(S), scale.as_expr()) for S, scale in shares),
        )
        return found if found._proved(step) else None

    def _proved(self, step: Affine) -> bool:
        """Whether Q(L) (N - den) = den (P - Q)(L) and scale Q(L) (load of f_k) = den S_k(L) (0, 1) for each k."""
        Q, increment = at_oscillator(self.den), at_oscillator(self.increment)
        identity = Matrix([[1, 0], [0, 1]])
        pairs = [(Q * (step.N - step.den * identity), step.den * increment)]
        for k, (S, scale) in enumerate(self.loads):
            pairs.append((scale * Q * step.load_N[:, k], step.den * at_oscillator(S)[:, 1]))
        return all(rational.same(*pair) for pair in pairs)

    @property
    def numerator(self) -> Coefficients:
        """Of R."""
        return tuple((p + q).expand() for p, q in zip_longest(self.den, self.increment, fillvalue=Integer(0)))

    @property
    def degree(self) -> int:
        """Of R: the larger of its numerator's and its denominator's."""
        return max(len(self.den), len(self.increment)) - 1


def at_oscillator(coefficients: Coefficients) -> Matrix:
    """The 2 x 2 matrix p(L)."""
    constant, linear = Integer(0), Integer(0)
    for c in reversed(coefficients):
        constant, linear = c + linear * SQUARE[0], constant + linear * SQUARE[1]
    return Matrix([[constant, linear], [linear * SQUARE[0], constant + linear * SQUARE[1]]])


def _without_stiffness(polynomial: Expr) -> Expr | None:
    """The polynomial at Omega^2 = 0 and -2 xi Omega = z; None where it is none in Omega^2 and xi Omega."""
    found: Expr = Integer(0)
    for (a, b), c in Poly(polynomial, Omega, xi).terms():
        if a < b or (a - b) % 2:
            return None
        found += c * (-rate / 2) ** b if a == b else 0
    return found


def _in_lowest_terms(numerator: Expr, den: Expr) -> tuple[Poly, Poly]:
    (reduced,), common = rational.common_denominator(Matrix([numerator / den]))
    return Poly(reduced, rate), Poly(common, rate)


def _lowest_first(polynomial: Poly) -> Coefficients:
    return tuple(reversed(polynomial.all_coeffs()))
