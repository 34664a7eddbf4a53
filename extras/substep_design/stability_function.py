"""The stability function R(z) = P(z)/(1 - gamma z)^n of n sub-steps with one effective stiffness, as polynomials.

Order p fixes the coefficients of P up to z^p: they are those of e^z (1 - gamma z)^n. |R(iy)| <= 1 for every y is a
statement on one polynomial, E(y) = |1 - i gamma y|^(2n) - |P(iy)|^2 >= 0 (Hairer & Wanner II, IV.3), and together with
gamma > 0 it is A-stability: no undamped or damped oscillation grows at any step.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import pairwise
from math import comb, factorial
from typing import Any

from substep_derive.algebra.algebraic import Algebraic, Field, generator, irreducible, real_roots
from substep_derive.algebra.points import count_real_roots
from substep_derive.declare.symbols import gamma
from sympy import QQ, Expr, Integer, Poly, Rational, Symbol, cancel, discriminant, expand, factor, fraction, together

W = Symbol("w")  # y^2


def coefficient(k: int, n: int) -> Expr:
    """That of z^k in e^z (1 - gamma z)^n."""
    terms = (Rational((-1) ** j * comb(n, j), factorial(k - j)) * gamma**j for j in range(min(k, n) + 1))
    return sum(terms, Integer(0))


@dataclass(frozen=True)
class StabilityFunction:
    """P, coefficients from z^0 to z^n in gamma and perhaps rho_inf, of a scheme of this order."""

    numerator: tuple[Expr, ...]
    order: int

    @property
    def n(self) -> int:
        """The number of sub-steps."""
        return len(self.numerator) - 1

    @property
    def at_infinity(self) -> Expr:
        """R(oo)."""
        return factor(self.numerator[-1] / (-gamma) ** self.n)

    @cached_property
    def excess(self) -> tuple[Expr, ...]:
        """Coefficients of E in w = y^2, from w^0 to w^n."""
        n, p = self.n, self.numerator
        found = []
        for k in range(n + 1):
            square = sum(
                ((-1) ** (k + j) * p[j] * p[2 * k - j] for j in range(max(0, 2 * k - n), min(n, 2 * k) + 1)), Integer(0)
            )
            found.append(expand(comb(n, k) * gamma ** (2 * k) - square))
        return tuple(found)

    def error(self, k: int) -> Expr:
        """The coefficient of z^k in e^z - R(z) for k = order + 1 or order + 2."""
        rest = [expand(coefficient(j, self.n) - (self.numerator[j] if j <= self.n else 0)) for j in range(k + 1)]
        if any(rest[: min(self.order, self.n) + 1]):  # at order n + 1 the last condition holds at certain gamma alone
            raise ValueError(f"expected a stability function of order {self.order}, got {self.numerator}")
        return rest[k] if k == self.order + 1 else expand(rest[k] + self.n * gamma * rest[k - 1])

    def least(self, criterion: str) -> Expr:
        """What the criterion asks to be least in size: a polynomial in gamma, and perhaps rho_inf.

        log(R e^-z) = -c_1 z^(p+1) - (c_2 - c_1) z^(p+2) - ..., where e^z - R = c_1 z^(p+1) + c_2 z^(p+2) + ...; on the
        imaginary axis odd powers turn and even powers damp.
        """
        p = self.order
        if criterion == "error_constant" or (criterion == "period_error") == (p % 2 == 0):
            return self.error(p + 1)
        return expand(self.error(p + 2) - self.error(p + 1))


def numbers_with(equation: Expr, low: Any = 0, high: Any = None) -> list[Algebraic]:
    """The roots gamma of a polynomial equation that are larger than low, and smaller than high if it is given."""
    numerator = Poly(fraction(together(equation))[0], gamma)
    low, high = (None if end is None else QQ(int(Rational(end).p), int(Rational(end).q)) for end in (low, high))
    found = []
    for part in irreducible(numerator) if not numerator.is_zero else []:
        for root in real_roots(part):
            for end in (low, high):
                while end is not None and root.rational is None and root.low <= end <= root.high:
                    root.narrow()
            if root.low <= low or (high is not None and root.high >= high):
                continue
            ends = tuple(Rational(int(x.numerator), int(x.denominator)) for x in (root.low, root.high))
            found.append(Algebraic(tuple(int(c) for c in root.polynomial.all_coeffs()), ends))
    return sorted(found, key=approximate)


@cache
def approximate(number: Algebraic, digits: int = 40) -> Expr:
    """The root r of an Algebraic as a decimal number, with which others are put in order."""
    polynomial, (low, high) = number.polynomial, number.interval
    if polynomial.degree() == 1:
        return Rational(-number.coefficients[1], number.coefficients[0])
    if low != high:
        low, high = polynomial.refine_root(low, high, eps=Rational(1, 10**digits))
    return (low + high) / 2


def value_at(number: Algebraic, expression: Expr) -> tuple[Field, Any]:
    """The field of a number gamma, and the value of a rational function of gamma in it."""
    field = Field(number)
    return field, field.number(cancel(expression.subs(gamma, generator)))


def sign_at(number: Algebraic, expression: Expr) -> int:
    """The sign of a rational function of gamma at a number, exactly."""
    field, value = value_at(number, expression)
    return field.sign(value)


def is_stable(excess: Sequence[Expr], number: Algebraic) -> bool:
    """Whether E >= 0 for every y at a number gamma: no positive root of odd multiplicity, and positive at last."""
    field = Field(number)
    values = [field.number(cancel(e.subs(gamma, generator))) for e in excess]
    while values and not values[-1]:
        values.pop()
    while values and not values[0]:
        values.pop(0)
    if not values:
        return True
    if field.sign(values[-1]) < 0:
        return False
    p = Poly.from_list(values[::-1], W, domain=field.domain)
    for part, power in p.sqf_list()[1]:
        if power % 2 and part.degree():
            # a positive root w is a pair of real roots of part(x^2)
            spread = [c for one in part.rep.to_list() for c in (one, field.domain.zero)][:-1]
            if count_real_roots(field, spread):
                return False
    return True


def rational_number(value: Rational) -> Algebraic:
    """A rational as an Algebraic."""
    return Algebraic((value.q, -value.p), (value, value))


def stable_intervals(excess: Sequence[Expr]) -> list[tuple[Algebraic, Algebraic | None]]:
    """The maximal intervals of gamma > 0 in which E >= 0 for every y, closed; None for an end at oo.

    The sign of E changes only where its first or last coefficient or its discriminant in y^2 vanishes; one rational
    settles each cell between these.
    """
    inner = list(excess)
    while inner and inner[0] == 0:
        inner.pop(0)
    while inner and inner[-1] == 0:
        inner.pop()
    if not inner:
        return []
    edges = [inner[0], inner[-1]]
    if len(inner) > 2:
        edges.append(discriminant(Poly(inner[::-1], W).as_expr(), W))
    cuts = _distinct(x for e in edges if e.has(gamma) for x in numbers_with(e))
    found: list[tuple[Algebraic, Algebraic | None]] = []
    for low, high in pairwise([None, *cuts, None]):
        start = Integer(0) if low is None else approximate(low)
        middle = start + 1 if high is None else (start + approximate(high)) / 2
        open_cell = is_stable(inner, rational_number(Rational(middle)))
        if open_cell and low is not None:
            if found and found[-1][1] is low:
                found[-1] = (found[-1][0], high)
            else:
                found.append((low, high))
        elif low is not None and not (found and found[-1][1] is low) and is_stable(inner, low):
            found.append((low, low))
    return found


def _distinct(numbers: Iterable[Algebraic]) -> list[Algebraic]:
    kept: list[Algebraic] = []
    for number in sorted(numbers, key=approximate):
        if not kept or not number.shares_generator(kept[-1]):
            kept.append(number)
    return kept
