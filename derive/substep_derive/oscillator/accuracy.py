"""Amplification -> numerical damping and period error at small Omega, exactly.

With s = h*(exact eigenvalue) and e^(s + L) the numerical eigenvalue next to e^s (see `mode`), L = A + B*s with A, B
real. Then phi = Omega*sqrt(1 - xi^2)*(1 + B) and

    numerical damping = -A/phi,    period error = -B/(1 + B),

so that both follow from one series, at any damping.
"""

from dataclasses import dataclass
from typing import Any, cast

from sympy import Dummy, Expr, Integer, Poly, factor, fraction, sqrt, together

from ..algebra import rational
from ..algebra.algebraic import Algebraic
from ..algebra.power_series import Modal, PowerSeries
from ..declare.parameter import Root
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, lam, xi
from .amplification import Amplification
from .mode import logarithm
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

    def __repr__(self) -> str:
        powers = (
            f"{name} of Omega^{', '.join(map(str, terms))}"
            for name, terms in (("numerical_damping", self.numerical_damping), ("period_error", self.period_error))
            if terms
        )
        return f"<leading terms, {'; '.join(powers)}>"


@dataclass(frozen=True)
class _Coefficients:
    """Coefficients of series as polynomials over Q in xi, the parameters, and symbols that stand for reciprocals.

    reciprocals: symbol -> the polynomial of which it is the reciprocal.
    """

    ring: Any
    reciprocals: dict[Any, Any]

    def expression(self, coefficient: Any) -> Expr:
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


def _logarithm(amplification: Amplification, terms: int) -> tuple[list[Modal], _Coefficients]:
    """The coefficients of L for Omega^0 to Omega^(terms - 1). Raises InconsistentScheme."""
    p = live(amplification.charpoly)
    w, q = Dummy("w"), Dummy("q")  # reciprocals of c (see inverse_of) and of xi^2 - 1
    ring, *_ = rational.polynomial_ring([*sorted((p.as_expr().free_symbols | {xi}) - {lam, Omega}, key=str), w, q])
    damping, w_, q_ = (ring.from_expr(symbol) for symbol in (xi, w, q))
    if not amplification.scheme.takes_damping:
        damping = ring.zero
    rows = []
    for coefficient in reversed(p.all_coeffs()):
        by_power = Poly(coefficient, Omega)
        row = [ring.from_expr(by_power.coeff_monomial(Omega**i)) for i in range(terms + 1)]
        rows.append(PowerSeries(Modal(x, ring.zero, damping) for x in row))
    leading: list[Any] = []

    def inverse_of(number: Modal) -> Modal:
        """The reciprocal of c*(zeta + xi), by (zeta + xi)^2 = xi^2 - 1."""
        leading.append(number.beta)
        assert number.alpha == number.beta * damping
        return Modal(damping * w_ * q_, w_ * q_, damping)

    found = logarithm(amplification.scheme.name, rows, damping, ring.one, inverse_of)
    return found.c, _Coefficients(ring, {w_: leading[0], q_: damping**2 - 1})


def _vanishing(scheme: Scheme) -> list[Expr]:
    """Polynomials that vanish where implicit defaults are taken; irreducible where they hold one parameter alone."""
    found = []
    for p in scheme.parameters:
        if isinstance(p.default, Root):
            root = None if p.default_symbols else p.root({})
            irreducible = isinstance(root, Algebraic)
            found.append(
                root.polynomial.as_expr(p.symbol) if irreducible else fraction(together(p.default.equation))[0]
            )
    return found


def leading_terms(amplification: Amplification, highest: int = 3) -> LeadingTerms:
    """The leading terms up to Omega^highest, or two powers further at a time while all of them vanish.

    A term that vanishes where a parameter has its implicit default is left out, since that default is what it has.
    Raises InconsistentScheme when no eigenvalue tends to the exact one.
    """
    L, over = _logarithm(amplification, highest + 2)
    B = PowerSeries(c.beta for c in L[1:])
    frequency = B + PowerSeries([over.ring.one] + [over.ring.zero] * (len(B) - 1))
    damping = PowerSeries(c.alpha for c in L[1:]).over(frequency, over.ring.one)
    period = B.over(frequency, over.ring.one)
    root = sqrt(1 - xi**2) if amplification.scheme.takes_damping else Integer(1)
    vanish = _vanishing(amplification.scheme)

    def kept(series: PowerSeries) -> dict[int, Expr]:
        found = {k: over.expression(c) for k, c in enumerate(series.c)}
        return {
            k: -e
            for k, e in found.items()
            if e != 0 and all(rational.quotient(fraction(e)[0], p) is None for p in vanish)
        }

    added = {k: e / root for k, e in kept(damping).items()}
    elongation = kept(period)
    if not added and not elongation:
        return leading_terms(amplification, highest + 2)
    return LeadingTerms(added, elongation, min((*added, *elongation)), highest)
