"""Amplification -> what happens at small and at infinite Omega, exactly.

With s = h*(exact eigenvalue), s^2 + 2*xi*Omega*s + Omega^2 = 0, the numerical eigenvalue next to e^s is
e^(s + L), and L = A + B*s with A, B real. Then phi = Omega*sqrt(1 - xi^2)*(1 + B) and

    numerical damping = -A/phi,    period error = -B/(1 + B),

so that both follow from one series, at any damping. Numbers in s are pairs (alpha, beta) standing
for alpha + beta*zeta with zeta = s/Omega, zeta^2 = -2*xi*zeta - 1.
"""

from dataclasses import dataclass
from functools import reduce
from math import comb, factorial
from typing import Any, cast

from sympy import QQ, Dummy, Expr, Poly, factor, sqrt

from ..algebra import rational
from ..algebra.power_series import Series, powers_of_zeta
from ..declare.errors import InconsistentScheme
from ..declare.symbols import Omega, lam, xi
from .amplification import Amplification
from .spectrum import live


@dataclass(frozen=True)
class LeadingTerms:
    """numerical_damping and period_error at small Omega, up to Omega^highest.

    Each maps the power of Omega to its coefficient, a function of xi and the parameters; powers
    whose coefficient vanishes are left out. order: of the free vibration's frequency and decay, the
    largest p with numerical eigenvalue = exact eigenvalue + O(Omega^(p+1)).
    """

    numerical_damping: dict[int, Expr]
    period_error: dict[int, Expr]
    order: int
    highest: int


@dataclass(frozen=True)
class LogarithmDefect:
    """L = A + B*s with e^(s+L) an eigenvalue; A and B as coefficients of powers of Omega.

    The coefficients are polynomials over `ring`, in xi, the parameters, w = 1/c and q = 1/(xi^2 - 1).
    """

    A: list[Any]
    B: list[Any]
    ring: Any
    reciprocals: dict[Any, Any]  # generator -> the polynomial it is the reciprocal of

    def expr(self, coefficient: Any) -> Expr:
        """A coefficient as a factored rational function of xi and the parameters."""
        numerator: Any = coefficient
        denominator: Any = self.ring.one
        for generator, polynomial in self.reciprocals.items():
            index = self.ring.gens.index(generator)
            top = max((monomial[index] for monomial in numerator), default=0)
            parts = [self.ring.zero] * (top + 1)
            for monomial, value in numerator.terms():
                power = monomial[index]
                parts[power] += self.ring.term_new((*monomial[:index], 0, *monomial[index + 1 :]), value)
            numerator = sum((part * polynomial ** (top - i) for i, part in enumerate(parts)), self.ring.zero)
            denominator *= polynomial**top
        numerator, denominator = numerator.cancel(denominator)
        return cast(Expr, factor(numerator.as_expr()) / factor(denominator.as_expr()))


def logarithm_defect(amplification: Amplification, terms: int, at: Expr = xi) -> LogarithmDefect:
    """A up to Omega^(terms-1), B up to Omega^(terms-2), at one damping ratio or any.

    Raises InconsistentScheme when the scheme is not consistent: no eigenvalue tends to e^s.
    """
    p = live(amplification.charpoly)
    p = Poly(p.as_expr().subs(xi, at), lam)
    w, q = Dummy("w"), Dummy("q")
    symbols = [*sorted((p.as_expr().free_symbols | at.free_symbols) - {lam, Omega}, key=str), w, q]
    polynomials, *_ = rational.polynomial_ring(symbols)
    damping, w_, q_ = (polynomials.from_expr(s) for s in (at, w, q))
    zero = polynomials.zero
    n = terms + 2
    zeta = powers_of_zeta(n, damping)

    def exponential(j: int) -> Series:
        return Series(
            [(a * QQ(j**k, factorial(k)), b * QQ(j**k, factorial(k))) for k, (a, b) in enumerate(zeta)], damping
        )

    # p(e^s (1 + delta)) = sum_i F[i] delta^i; delta is small, of order two at least
    summands: list[Series] = []
    for j, coefficient in enumerate(reversed(p.all_coeffs())):
        by_power = Poly(coefficient, Omega)
        row = [polynomials.from_expr(by_power.coeff_monomial(Omega**i)) for i in range(n)]
        summands.append(Series([(x, zero) for x in row], damping) * exponential(j))
    F = [_sum([t.scaled(QQ(comb(j, i))) for j, t in enumerate(summands) if j >= i]) for i in range(len(summands))]
    c = F[1].c[1][1]
    consistent = all(F[0].c[i] == (zero, zero) for i in range(3)) and F[1].c[0] == (zero, zero)
    if not consistent or c == 0 or F[1].c[1][0] != c * damping:
        raise InconsistentScheme(f"{amplification.scheme.name} is not consistent: no eigenvalue tends to the exact one")
    inverse = (damping * w_ * q_, w_ * q_)  # of c*(zeta + xi), since (zeta + xi)^2 = xi^2 - 1
    delta = F[0].over(F[1], 1, inverse).scaled(QQ(-1))
    for _ in range(terms - 3):  # F[0]/F[1] starts with Omega^2, each turn gains a power
        power, correction = delta, F[0]
        for higher in F[2:]:
            power = power * delta
            correction = correction + higher * power
        delta = correction.over(F[1], 1, inverse).scaled(QQ(-1))
    logarithm, power = delta, delta
    for k in range(2, (terms + 1) // 2):
        power = power * delta
        logarithm = logarithm + power.scaled(QQ((-1) ** (k + 1), k))
    pairs = logarithm.c[:terms]
    return LogarithmDefect([a for a, _ in pairs], [b for _, b in pairs[1:]], polynomials, {w_: c, q_: damping**2 - 1})


def _sum(series: list[Series]) -> Series:
    return reduce(lambda total, other: total + other, series)


def leading_terms(amplification: Amplification, highest: int = 3) -> LeadingTerms:
    """Up to Omega^highest, two powers further for a scheme whose error starts beyond.

    Raises InconsistentScheme when the scheme is not consistent.
    """
    L = logarithm_defect(amplification, highest + 2)
    zero, one = L.ring.zero, L.ring.one
    xi_ = L.ring.from_expr(xi)
    frequency = Series([(b + (one if k == 0 else zero), zero) for k, b in enumerate(L.B)], xi_)
    damping = Series([(a, zero) for a in L.A[1:]], xi_).over(frequency, 0, (one, zero))
    period = Series([(b, zero) for b in L.B], xi_).over(frequency, 0, (one, zero))
    root = sqrt(1 - xi**2)
    added = {k: -e / root for k, (a, _) in enumerate(damping.c) if (e := L.expr(a)) != 0}
    elongation = {k: -e for k, (b, _) in enumerate(period.c) if (e := L.expr(b)) != 0}
    if not added and not elongation and highest == 3:
        return leading_terms(amplification, 5)
    return LeadingTerms(added, elongation, min((*added, *elongation), default=highest + 1), highest)
