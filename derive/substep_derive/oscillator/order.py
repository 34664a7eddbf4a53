"""Scheme -> order of accuracy of u, v and a on the linear oscillator, with leading error constants.

Free vibration: from the exact state of the mode e^(s t/h), s^2 + 2*xi*Omega*s + Omega^2 = 0, started as the scheme
says, the numerical solution is a sum of modes. Those last whose eigenvalues do not tend into the unit circle: the mode
next to the exact one, its conjugate, and perhaps others. The error of u, v or a consists of the drift of the mode's
eigenvalue, the deviation of its amplitude, and the amplitudes of the others. Forced vibration: the response to the load
e^(kappa omega t) minus the exact one, and the amplitudes of the modes that a start from the exact one excites. Each
error is a power series in Omega; the power of its first term that is not zero is the order.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import Any, cast

from sympy import QQ, Expr, Matrix, Mul, Poly, Rational, Set, Symbol, factor, factor_list, fraction, groebner

from ..algebra.power_series import Modal, PowerSeries, total
from ..declare.scheme import Scheme
from ..declare.symbols import lam
from .amplification import Affine, in_lambda
from .evaluation import Evaluation
from .mode import exponential, logarithm
from .spectrum import on_circle
from .start_up import start_up

FEWEST_TERMS, MOST_TERMS = 10, 66  # of the series: tried first, and at most
LOST = 5  # terms by which the series of a forced error of a is shorter, one more than that of a free one
KEPT = 3  # terms of a series of which the lowest powers are left out
KAPPA = QQ(1, 3)  # any rate of the load that is in no special relation to the oscillator
Triple = tuple[int, int, int]


class AtLeast(int):
    """A lower bound of an order: every term of the error series that was computed is zero."""

    def __str__(self) -> str:
        return f"at least {int(self)}"

    __repr__ = __str__


@dataclass(frozen=True)
class Order:
    """Orders of (u, v, a), and in free vibration the leading error constants of each: constant * (omega h)^order.

    The constants are pairs (alpha, beta) for alpha + beta*zeta, zeta^2 = -2*xi*zeta - 1, relative to the exact mode
    (its drift over a span of one radian). An order is `AtLeast` the length of its series if all
    terms are zero.
    """

    free: Triple
    forced: Triple
    free_constants: tuple[Any, ...]

    @property
    def uva(self) -> Triple:
        """For each of u, v, a the smaller of the orders in free and in forced vibration."""
        u, v, a = (min(pair) for pair in zip(self.free, self.forced, strict=True))
        return u, v, a


class _Expansion:
    """Makes series in Omega with this number of terms, at one damping ratio, over an evaluation's field."""

    def __init__(self, evaluation: Evaluation, damping: Rational, terms: int) -> None:
        self.evaluation, self.terms = evaluation, terms
        domain = evaluation.field.domain
        self.one, self.zero = domain.one, domain.zero
        self.xi = domain.convert(QQ(int(damping.p), int(damping.q)))

    @cached_property
    def modes(self) -> "_Modes":
        """Of one step."""
        return _Modes(self)

    def modal(self, alpha: Any, beta: Any) -> Modal:
        return Modal(self.zero + alpha, self.zero + beta, self.xi)

    def power(self, first: Modal, k: int) -> PowerSeries:
        """The series first*Omega^k."""
        return PowerSeries([first if i == k else self.modal(0, 0) for i in range(self.terms)])

    def polynomial(self, expression: Expr) -> PowerSeries:
        """The series of a polynomial in Omega and the parameters."""
        found = self.evaluation.coefficients(expression, self.xi)
        return PowerSeries(self.modal(found.get((i, 0), 0), 0) for i in range(self.terms))

    def exponential(self, exponent: Modal) -> PowerSeries:
        """The series of exp(exponent*Omega)."""
        return exponential(exponent, self.one, self.terms)

    def s(self, k: int) -> PowerSeries:
        """The series of s^k = (Omega*zeta)^k."""
        power = self.modal(1, 0)
        for _ in range(k):
            power = power * self.modal(0, 1)
        return self.power(power, k)

    def over(self, left: PowerSeries, right: PowerSeries) -> PowerSeries:
        return left.over(right, right.c[right.valuation].inverse(self.one))

    def apply(self, affine: Affine, x: Sequence[PowerSeries], _: object = None) -> list[PowerSeries]:
        """The series of N x/den, which leaves the loads of the affine map out."""
        return self.product(self.rows(affine.N, affine.den), x)

    def driven(self, affine: Affine, x: Sequence[PowerSeries], instants: Sequence[Expr]) -> list[PowerSeries]:
        """The same with the load e^(kappa omega t) at these instants."""
        own, load = self.apply(affine, x), self.load(instants)
        more = self.product(self.rows(affine.load_N, affine.den), load) if load else []
        return [a + b for a, b in zip(own, more, strict=True)] if more else own

    def load(self, instants: Sequence[Expr]) -> list[PowerSeries]:
        """h^2 e^(kappa omega t) at instants in steps after t = 0."""
        return [self.exponential(self.modal(KAPPA * self.evaluation.number(tau), 0)).shifted(2) for tau in instants]

    def rows(self, numerators: Matrix, den: Expr) -> list[list[PowerSeries]]:
        below = self.polynomial(den)
        return [[self.over(self.polynomial(e), below) for e in numerators.row(i)] for i in range(numerators.rows)]

    @staticmethod
    def product(rows: Sequence[Sequence[PowerSeries]], x: Sequence[PowerSeries]) -> list[PowerSeries]:
        return [total([entry * value for entry, value in zip(row, x, strict=True)]) for row in rows]


def _characteristic(e: _Expansion) -> list[PowerSeries]:
    """The characteristic polynomial in lambda, from the constant term up, its leading coefficient 1."""
    p = in_lambda(e.evaluation.amplification.charpoly)
    lead = e.polynomial(p.LC())
    return [e.over(e.polynomial(c), lead) for c in reversed(p.all_coeffs())]


def _drift(e: _Expansion, p: list[PowerSeries]) -> PowerSeries:
    """L, from the characteristic polynomial without roots that are 0 for every Omega."""
    first = next(j for j, c in enumerate(p) if c.valuation < len(c))
    return logarithm(e.evaluation.scheme.name, p[first:], e.xi, e.one, lambda number: number.inverse(e.one))


class _Modes:
    """Modes of one step: adj(lambda I - A) x and p(lambda), p'(lambda) as series."""

    def __init__(self, e: _Expansion) -> None:
        self.e, amplification = e, e.evaluation.amplification
        step, outputs = amplification.step, amplification.outputs
        self.A, self.B = e.rows(step.N, step.den), e.rows(step.load_N, step.den)
        self.O, self.P = e.rows(outputs.N, outputs.den), e.rows(outputs.load_N, outputs.den)
        self.in_state = amplification.in_state
        self.p = _characteristic(e)

    def polynomial(self, at: PowerSeries, derivative: bool = False) -> PowerSeries:
        found, power = [], self.e.power(self.e.modal(1, 0), 0)
        for j, c in enumerate(self.p[1:] if derivative else self.p, start=int(derivative)):
            found.append((c * power).scaled(QQ(j if derivative else 1)))
            power = power * at
        return total(found)

    def adjugate(self, at: PowerSeries, x: list[PowerSeries]) -> list[PowerSeries]:
        """adj(at*I - A) x = sum_k A^k x sum_{j > k} p_j at^(j - 1 - k)."""
        terms = []
        for k in range(len(self.p) - 1):
            weights, power = [], self.e.power(self.e.modal(1, 0), 0)
            for c in self.p[k + 1 :]:
                weights.append(c * power)
                power = power * at
            terms.append([total(weights) * entry for entry in x])
            x = self.e.product(self.A, x)
        return [total(entries) for entries in zip(*terms, strict=True)]

    @cached_property
    def drift(self) -> PowerSeries:
        """L of the mode next to the exact one."""
        return _drift(self.e, self.p)

    @cached_property
    def principal(self) -> list[tuple[Modal, PowerSeries, PowerSeries]]:
        """Exponent of the exact mode, lambda and p'(lambda) of the mode next to it; and of the conjugate one."""
        e, own, zeta = self.e, self.drift, self.e.modal(0, 1)
        conjugate, found = PowerSeries(c.conjugate for c in own.c), []
        for shift, exponent in ((own, zeta), (conjugate, zeta.conjugate)):
            growth = power = e.power(e.modal(1, 0), 0)
            for k in range(1, len(shift)):
                power = (power * shift).scaled(QQ(1, k))
                growth = growth + power
            at = e.exponential(exponent) * growth
            found.append((exponent, at, self.polynomial(at, derivative=True)))
        return found

    @cached_property
    def fading(self) -> Poly | None:
        """The polynomial of parasitic eigenvalues that tend into the unit circle; None where none tends to it."""
        domain = self.e.evaluation.field.domain
        parasitic = Poly.from_list([c.c[0].alpha for c in reversed(self.p)], lam, domain=domain)
        parasitic = parasitic.quo(Poly((lam - 1) ** 2, lam, domain=domain))
        lasting = on_circle(parasitic)
        return parasitic.quo(lasting) if lasting.degree() else None

    def combined(self, polynomial: Poly, x: list[PowerSeries]) -> list[PowerSeries]:
        """A polynomial in A times a state, by Horner's rule."""
        found = [entry.scaled(self.e.zero) for entry in x]
        for c in polynomial.rep.to_list():
            found = [a + entry.scaled(c) for a, entry in zip(self.e.product(self.A, found), x, strict=True)]
        return found

    def reported(
        self, before: list[PowerSeries], after: list[PowerSeries], load: list[PowerSeries] | None = None
    ) -> list[PowerSeries]:
        """The u, h*v, h^2*a that the step from the state `before` to the state `after` reports."""
        rows = self.e.product(self.O, before)
        if load:
            rows = [row + more for row, more in zip(rows, self.e.product(self.P, load), strict=True)]
        others = iter(rows)
        return [after[place] if place >= 0 else next(others) for place in self.in_state]


def _excited(e: _Expansion, x: Sequence[PowerSeries], steps: int) -> list[list[PowerSeries]]:
    """u, h*v, h^2*a at t = 0 of each mode that a state excites after some steps, the principal one's first.

    Last, where there is one, is the sum of all others that do not die out, each times a number.
    """
    modes, parts = e.modes, list[list[PowerSeries]]()
    # a power of Omega that is left out to keep series short; one more is lost where principal eigenvalues part from 1
    power = max(0, min(len(x[0]) - KEPT, *(entry.valuation - 1 for entry in x)))
    x = rest = [PowerSeries(entry.c[power:]) for entry in x]
    for exponent, at, slope in modes.principal:
        component = [e.over(entry, slope) for entry in modes.adjugate(at, x)]
        after = [at * entry for entry in component]
        back = e.exponential(exponent * QQ(-(steps + 1)))
        parts.append([back * entry for entry in modes.reported(component, after)])
        rest = [a - b for a, b in zip(rest, component, strict=True)]
    if modes.fading is not None:
        for _ in range(len(rest[0])):  # each time the lowest power of what dies out vanishes
            rest = modes.combined(modes.fading, rest)
        parts.append(modes.reported(rest, e.product(modes.A, rest)))
    return [[PowerSeries([e.modal(0, 0)] * power + entry.c) for entry in part] for part in parts]


def _free(e: _Expansion) -> list[list[PowerSeries]]:
    """Free vibration's errors of u, v, a: drift per unit of omega*t, deviation of amplitude, amplitudes of others."""
    x, steps = start_up(e.evaluation.amplification, [e.s(k) for k in range(3)], e.apply)
    parts, drifting = _excited(e, x, steps), PowerSeries(e.modes.drift.c[1:])
    found: list[list[PowerSeries]] = []
    for k in range(3):
        errors = parts[0][k] - e.s(k), *(part[k] for part in parts[1:])
        found.append([drifting, *(_relative(e, error, k) for error in errors)])
    return found


def _forced(e: _Expansion) -> list[list[PowerSeries]]:
    """Forced vibration's errors of u, v, a, relative to 1, omega, omega^2 times the static displacement."""
    modes, kappa = e.modes, e.modal(KAPPA, 0)
    at = e.exponential(kappa)
    amplification = e.evaluation.amplification
    load = e.load(amplification.stencil)
    p = modes.polynomial(at)
    driven = e.product(modes.B, load) if load else [e.power(e.modal(0, 0), 0) for _ in modes.B]
    response = [e.over(entry, p) for entry in modes.adjugate(at, driven)]
    reported = modes.reported(response, [at * entry for entry in response], load)
    back = e.exponential(kappa * QQ(-1))
    gain = e.one / (KAPPA**2 + 2 * e.xi * KAPPA + 1)
    exact = [e.power(e.modal(gain * KAPPA**k, 0), k) for k in range(3)]
    x, steps = start_up(amplification, exact, e.driven)
    ahead = e.exponential(kappa * QQ(steps))
    parts = _excited(e, [own - ahead * entry for own, entry in zip(x, response, strict=True)], steps)
    found = []
    for k, value in enumerate(reported):
        errors = back * value - exact[k], *(part[k] for part in parts)
        found.append([_relative(e, error, k) for error in errors])
    return found


def _relative(e: _Expansion, error: PowerSeries, k: int) -> PowerSeries:
    """An error of u, h*v or h^2*a over Omega^k; of order 0 where it is even larger."""
    return e.over(error, e.power(e.modal(1, 0), k)) if error.valuation >= k else e.power(e.modal(1, 0), 0)


def _first(errors: list[PowerSeries]) -> tuple[int | AtLeast, tuple[Any, ...]]:
    """The lowest power of Omega in any of the errors, and its coefficients; `AtLeast` their length if all are zero."""
    order = min(error.valuation for error in errors)
    if order >= min(map(len, errors)):
        return AtLeast(min(map(len, errors))), ()
    return order, tuple((error.c[order].alpha, error.c[order].beta) for error in errors if error.c[order])


def drift(evaluation: Evaluation, damping: Rational, terms: int) -> PowerSeries:
    """The series L in Omega, `terms` - 1 coefficients long, with e^(s + L) the numerical eigenvalue next to e^s.

    Raises InconsistentScheme for a scheme of which no eigenvalue tends to the exact one.
    """
    e = _Expansion(evaluation, damping, terms)
    return _drift(e, _characteristic(e))


def order_of(evaluation: Evaluation, damping: Rational) -> Order:
    """Orders at one rational damping ratio, sought in series of up to about 60 terms.

    Raises InconsistentScheme for a scheme of which no eigenvalue tends to the exact one.
    """
    terms = FEWEST_TERMS
    while True:
        e = _Expansion(evaluation, damping, terms)
        free, forced = ([_first(errors) for errors in errors_of(e)] for errors_of in (_free, _forced))
        orders = [order for order, _ in (*free, *forced)]
        if not any(isinstance(order, AtLeast) for order in orders) or terms >= MOST_TERMS:
            return Order(
                *(cast(Triple, tuple(k for k, _ in found)) for found in (free, forced)),
                tuple(c for _, c in free),
            )
        terms = min(2 * terms - 1, MOST_TERMS)


def dampings_of(scheme: Scheme) -> tuple[Rational, ...]:
    """Damping ratios at which orders are looked for: none, and one that is in no special relation to anything."""
    return (Rational(0), Rational(1, 4)) if scheme.takes_damping else (Rational(0),)


def order_conditions(scheme: Scheme, order: int = 2) -> dict[str, tuple[Expr, ...]]:
    """The polynomials in the free parameters that must vanish for u, v and a to be of that order.

    Under "u", "v", "a": the coefficients of lower powers of Omega in the errors, free and forced, at the damping ratios
    of `dampings_of`, the start included. Without any, all parameters give that order; 1 alone if none do. Factors
    that do not vanish in the intervals of the parameters are left out. Raises InconsistentScheme.
    """
    domains = {p.symbol: p.domain for p in scheme.parameters}
    evaluation = Evaluation.free(scheme)
    found: dict[str, set[Expr]] = {"u": set(), "v": set(), "a": set()}
    for damping in dampings_of(scheme):
        for errors_of, lost in ((_free, LOST - 1), (_forced, LOST)):
            errors_at = errors_of(_Expansion(evaluation, damping, order + lost))
            for name, errors in zip(found, errors_at, strict=True):
                assert all(len(error) >= order for error in errors)
                coefficients = chain.from_iterable(error.c[:order] for error in errors)
                parts = (part for c in coefficients for part in (c.alpha, c.beta) if part)
                found[name] |= {_condition(evaluation.field.expression(part), domains) for part in parts}
    return {name: _together(conditions, domains) for name, conditions in found.items()}


def _condition(coefficient: Expr, domains: Mapping[Symbol, Set]) -> Expr:
    """The factors of a coefficient's numerator that can vanish, each once; 1 where none can."""
    factors = factor_list(fraction(factor(coefficient))[0])[1]
    return Mul(*(base for base, _ in factors if _can_vanish(base, domains)))


def _can_vanish(polynomial: Expr, domains: Mapping[Symbol, Set]) -> bool:
    """Whether a polynomial has a root in the interval of its symbol; one of several symbols is taken to have."""
    symbols = polynomial.free_symbols & domains.keys()
    return len(symbols) != 1 or any(root in domains[s] for s in symbols for root in Poly(polynomial, s).real_roots())


def _together(polynomials: Collection[Expr], domains: Mapping[Symbol, Set]) -> tuple[Expr, ...]:
    """A shorter system with the same roots, a Groebner basis; 1 alone where there are none."""
    symbols = sorted(set().union(*(p.free_symbols for p in polynomials)), key=str)
    basis = groebner(polynomials, *symbols).exprs if symbols else polynomials
    return tuple(sorted({_condition(e, domains) for e in basis}, key=str))
