"""Amplification -> order of accuracy of u, v and a, with leading error constants.

Free vibration: from the exact state of the mode e^(s t/h), s^2 + 2*xi*Omega*s + Omega^2 = 0, started
as the scheme says, the numerical solution is a sum of modes. What stays for all times is the mode
next to the exact one and its conjugate; the error of u, v or a is the drift of that mode's eigenvalue,
its amplitude's deviation, and the conjugate's amplitude. Forced: the response to the load e^(kappa omega t)
against the exact one. All are power series in Omega whose first non-zero term is the order.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import factorial
from typing import Any, cast

from sympy import QQ, Expr, Integer, Matrix, Poly, Rational, Symbol, factor, factor_list, fraction, prod

from ..algebra import rational
from ..algebra.power_series import Series
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, knot_of, lam, lattice, mu, xi
from .accuracy import logarithm_defect
from .amplification import Affine, Amplification

TERMS = 9
KAPPA = QQ(1, 3)
Triple = tuple[int, int, int]
Error = list[tuple[Any, Any]]  # coefficients of powers of Omega


@dataclass(frozen=True)
class Order:
    """Orders of (u, v, a), the leading error constant of each: error = constant * (omega h)^order.

    The constants are relative to omega^2 times the load for a forced response, and to the exact mode
    for a free one (its largest part over a span of one radian).
    """

    free: Triple
    forced: Triple
    free_constants: tuple[Any, ...]
    forced_constants: tuple[Any, ...]

    @property
    def uva(self) -> Triple:
        """The smaller of both for each of u, v, a."""
        u, v, a = (min(pair) for pair in zip(self.free, self.forced, strict=True))
        return u, v, a


class _Expansion:
    """Series at one damping ratio; coefficients rational, or rational functions of free parameters."""

    def __init__(self, damping: Rational, symbols: Sequence[Symbol] = (), terms: int = TERMS) -> None:
        self.field = rational.rational_functions(symbols)
        self.terms = terms
        self.xi = self.number(damping)
        self.zero = 0 * self.xi
        self.damping = damping

    def constant(self, value: Any) -> Series:
        one = self.zero + 1
        return Series([(one * value, self.zero)] + [(self.zero, self.zero)] * (self.terms - 1), self.xi)

    def number(self, value: Expr) -> Any:
        return QQ(value.p, value.q) if self.field is None else self.field.from_expr(value)

    def polynomial(self, expression: Expr) -> Series:
        """A polynomial in Omega with the damping ratio put in."""
        poly = Poly(expression.subs(xi, self.damping), Omega)
        row = [self.number(poly.coeff_monomial(Omega**i)) for i in range(self.terms)]
        return Series([(x, self.zero) for x in row], self.xi)

    def exponential(self, a: Any, b: Any) -> Series:
        """exp((a + b*zeta) Omega)."""
        total, power = self.constant(1), self.constant(1)
        step = Series([(self.zero, self.zero), (a + self.zero, b + self.zero)], self.xi)
        step = Series(step.c + [(self.zero, self.zero)] * (self.terms - 2), self.xi)
        for k in range(1, self.terms):
            power = power * step
            total = total + power.scaled(QQ(1, factorial(k)))
        return total

    def power_of_s(self, k: int, conjugate: bool = False) -> Series:
        """s^k, or the conjugate's."""
        s = (-2 * self.xi, self.zero - 1) if conjugate else (self.zero, self.zero + 1)
        base = Series([(self.zero, self.zero), s] + [(self.zero, self.zero)] * (self.terms - 2), self.xi)
        result = self.constant(1)
        for _ in range(k):
            result = result * base
        return result

    def over(self, left: Series, right: Series) -> Series:
        """left/right; loses as many terms as right starts late."""
        k = _leading(right)
        a, b = right.c[k]
        norm = a * a - 2 * self.xi * a * b + b * b
        return left.over(right, k, ((a - 2 * self.xi * b) / norm, -b / norm))

    def matrix(self, affine: Affine) -> tuple[list[list[Series]], list[list[Series]]]:
        """N/den and load_N/den."""
        den = self.polynomial(affine.den)

        def rational(matrix: Matrix) -> list[list[Series]]:
            return [
                [self.over(self.polynomial(matrix[i, j]), den) for j in range(matrix.cols)] for i in range(matrix.rows)
            ]

        return rational(affine.N), rational(affine.load_N)


def _leading(series: Series) -> int:
    """The first power with a coefficient that is not 0; the number of terms if there is none."""
    return next((k for k, (a, b) in enumerate(series.c) if a != 0 or b != 0), len(series.c))


def _times(matrix: list[list[Series]], vector: list[Series]) -> list[Series]:
    return [_sum([entry * x for entry, x in zip(row, vector, strict=True)]) for row in matrix]


def _sum(series: Sequence[Series]) -> Series:
    total = series[0]
    for other in series[1:]:
        total = total + other
    return total


class _Modes:
    """Modes of one step: adj(lambda I - A) x and p(lambda), p'(lambda) as series."""

    def __init__(self, amplification: Amplification, expansion: _Expansion) -> None:
        self.e = expansion
        self.A, self.B = expansion.matrix(amplification.step)
        self.O, self.P = expansion.matrix(amplification.outputs)
        self.in_state = amplification.in_state
        p = Poly(amplification.charpoly.as_expr().subs(mu, lam - 1), lam)
        lead = expansion.polynomial(p.LC())
        self.p = [expansion.over(expansion.polynomial(c), lead) for c in reversed(p.all_coeffs())]

    def polynomial(self, at: Series, derivative: bool = False) -> Series:
        total, power = self.e.constant(0), self.e.constant(1)
        for j, c in enumerate(self.p):
            if derivative and j == 0:
                continue
            total = total + (c * power).scaled(QQ(j if derivative else 1))
            power = power * at
        return total

    def adjugate(self, at: Series, x: list[Series]) -> list[Series]:
        """adj(at*I - A) x = sum_k A^k x sum_{j > k} p_j at^(j - 1 - k)."""
        total = [self.e.constant(0) for _ in x]
        for k in range(len(self.p) - 1):
            weight, power = self.e.constant(0), self.e.constant(1)
            for c in self.p[k + 1 :]:
                weight = weight + c * power
                power = power * at
            total = [t + weight * entry for t, entry in zip(total, x, strict=True)]
            x = _times(self.A, x)
        return total

    def told(self, before: list[Series], after: list[Series], load: list[Series] | None = None) -> list[Series]:
        """Reported u, h*v, h^2*a after a step from the one state to the other."""
        rest = iter(range(len(self.O)))
        result = []
        for place in self.in_state:
            if place >= 0:
                result.append(after[place])
            else:
                k = next(rest)
                row = _times([self.O[k]], before)[0]
                result.append(row if load is None else row + _times([self.P[k]], load)[0])
        return result


def _free(amplification: Amplification, expansion: _Expansion) -> list[list[Error]]:
    """For u, v and a: drift per unit of omega*t, amplitude's deviation, amplitude of the conjugate."""
    modes, e = _Modes(amplification, expansion), expansion
    scheme = amplification.scheme
    x, steps = _start(scheme, amplification, e)
    L = logarithm_defect(amplification, min(7, e.terms), expansion.damping)
    pairs = list(zip(L.A, [L.ring.zero, *L.B], strict=True))
    drift = Series(
        [(e.number(L.expr(a)), e.number(L.expr(b))) for a, b in pairs] + [(e.zero, e.zero)] * (e.terms - len(pairs)),
        e.xi,
    )
    conjugate = Series([(a - 2 * e.xi * b, -b) for a, b in drift.c], e.xi)
    found: list[list[Error]] = []
    parts = []
    for shift, s in ((drift, (e.zero, e.zero + 1)), (conjugate, (-2 * e.xi, e.zero - 1))):
        growth, power = e.constant(1), e.constant(1)
        for k in range(1, 5):
            power = power * shift
            growth = growth + power.scaled(QQ(1, factorial(k)))
        at = e.exponential(*s) * growth
        slope = modes.polynomial(at, derivative=True)
        component = [e.over(entry, slope) for entry in modes.adjugate(at, x)]
        after = [at * entry for entry in component]
        back = e.exponential(*(-(steps + 1) * part for part in s))
        parts.append([back * entry for entry in modes.told(component, after)])
    for k in range(3):
        exact = e.power_of_s(k)
        amplitude = e.over(parts[0][k] + exact.scaled(QQ(-1)), exact)
        other = e.over(parts[1][k], exact)
        found.append([drift.c[1:], amplitude.c, other.c])
    return found


def _start(scheme: Scheme, amplification: Amplification, e: _Expansion) -> tuple[list[Series], int]:
    """The state from which the scheme itself marches, and after how many steps."""
    given = [e.power_of_s(k) for k in range(3)]
    if isinstance(scheme.start, Scheme):
        first = Amplification.of(scheme.start)
        matrix, _ = e.matrix(first.step)
        history = [given]
        at = [knot_of(s) or ("u", "0") for s in scheme.state]
        steps = int(max(-(lattice(label) or 0) for _, label in at))
        for _ in range(steps):
            history.append(_times(matrix, history[-1]))
        return [history[steps + int(lattice(label) or 0)]["uva".index(kind)] for kind, label in at], steps
    if amplification.start is None:
        return [given["uva".index(s.name[0])] for s in scheme.state], 0
    return _times(e.matrix(amplification.start)[0], given), 0


def _forced(amplification: Amplification, expansion: _Expansion) -> list[list[Error]]:
    """For u, v and a: the error relative to the power of omega that belongs to it."""
    modes, e = _Modes(amplification, expansion), expansion
    at = e.exponential(KAPPA, QQ(0))
    load = [e.exponential(KAPPA * e.number(tau), QQ(0)) for tau in amplification.stencil]
    square = Series([(e.zero, e.zero)] * 2 + [(e.zero + 1, e.zero)] + [(e.zero, e.zero)] * (e.terms - 3), e.xi)
    load = [square * entry for entry in load]  # h^2 times a load of omega^2
    adjugate = modes.adjugate(at, _times(modes.B, load))
    p = modes.polynomial(at)
    response = [e.over(entry, p) for entry in adjugate]
    told = modes.told(response, [at * entry for entry in response], load)
    back = e.exponential(-KAPPA, QQ(0))
    gain = 1 / (KAPPA**2 + 2 * e.xi * KAPPA + 1)
    found = []
    for k, value in enumerate(told):
        power = Series([(e.zero, e.zero)] * k + [(e.zero + 1, e.zero)] + [(e.zero, e.zero)] * (e.terms - 1 - k), e.xi)
        exact = power.scaled(gain * KAPPA**k)
        error = e.over(back * value + exact.scaled(QQ(-1)), power)
        found.append([error.c])
    return found


def _first(errors: list[Error], terms: int) -> tuple[int, tuple[Any, ...]]:
    """The lowest power in any of the errors, and their coefficients of it; terms - 3 are right."""
    order = next((k for k in range(terms - 3) if any(tuple(e[k]) != (0, 0) for e in errors)), terms - 3)
    return order, tuple(e[order] for e in errors if order < terms - 3 and tuple(e[order]) != (0, 0))


def order_of(amplification: Amplification, damping: Rational) -> Order:
    """Orders at one rational damping ratio; all parameters of the scheme must have values.

    Raises ValueError for an inconsistent scheme.
    """
    expansion = _Expansion(damping)
    free, forced = ([_first(errors, TERMS) for errors in of(amplification, expansion)] for of in (_free, _forced))
    return Order(
        *(cast(Triple, tuple(k for k, _ in found)) for found in (free, forced)),
        *(tuple(c for _, c in found) for found in (free, forced)),
    )


def order_conditions(amplification: Amplification, order: int = 2) -> dict[str, tuple[Expr, ...]]:
    """What must vanish, as polynomials in the free parameters, for u, v and a to be of that order.

    For "u", "v", "a": coefficients of the powers of Omega below it, free and forced, at xi = 0 and 1/4 (the
    start included); none: it has that order for all parameters. Raises ValueError for an inconsistent scheme.
    """
    found: dict[str, set[Expr]] = {"u": set(), "v": set(), "a": set()}
    for damping in (Rational(0), Rational(1, 4)):
        expansion = _Expansion(damping, amplification.scheme.values, order + 5)
        for of in (_free, _forced):
            for name, errors in zip(found, of(amplification, expansion), strict=True):
                for error in errors:
                    for pair in error[:order]:
                        found[name] |= {_polynomial(part) for part in pair if part != 0}
    return {name: tuple(sorted(conditions, key=str)) for name, conditions in found.items()}


def _polynomial(coefficient: Any) -> Expr:
    """The squarefree part of a coefficient's numerator, numbers left out; 1 for a number."""
    if not hasattr(coefficient, "as_expr"):
        return Integer(1)
    factors = factor_list(fraction(factor(coefficient.as_expr()))[0])[1]
    return cast(Expr, prod(base for base, _ in factors))
