"""Scheme and exact parameters -> a polynomial in s whose roots say where the eigenvalues lie.

lambda = (1 + s)/(1 - s) takes the characteristic polynomial p, of degree n, to h(s) = (1 - s)^n p(lambda):
the unit disk becomes Re s < 0, lambda = 1 becomes s = 0, and lambda = -1 a missing leading coefficient.
Eigenvalues that stay on the circle whatever Omega are roots of the part A(s) = G(s^2) that the even and the
odd terms of h share. They are on it, and simple, exactly if A + dA/ds is a Hurwitz polynomial (Hermite and
Biehler); those of the rest B = h/A are inside exactly if B is one. Coefficients are polynomials in Omega
over K, where Omega^2 is the variable if only even powers occur, or in Omega and xi.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache, reduce
from math import comb
from typing import Any

from sympy import QQ, Symbol

from ..algebra.algebraic import Field, sign_of
from ..algebra.points import Point, ring_over
from ..declare.errors import DeclarationError
from ..declare.parameter_set import ParameterSet
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, lam, xi
from ..oscillator.amplification import Pencil

even_part = Symbol("x")  # s^2


# --- polynomials -------------------------------------------------------------------------------------


@cache
def characteristic(scheme: Scheme) -> Any:
    """det(new, old) of the scheme's pencil: polynomial over Q in its constant, parameters, xi, Omega and lambda."""
    constant = () if scheme.constant is None else (scheme.constant,)
    ring = ring_over(Field(), *constant, *scheme.values, xi, Omega, lam)
    return ring.from_expr(Pencil.of(scheme).characteristic)


@dataclass(frozen=True)
class Spectrum:
    """p and h at given parameters, coefficients from the lowest, with roots lambda = 0 left out.

    in_square: the variable is Omega^2. common: the factor that all coefficients shared and that was taken
    out; at its roots the equations of the step are dependent.
    """

    parameter_set: ParameterSet
    ring: Any
    in_square: bool
    common: Any
    p: list[Any]
    h: list[Any]

    @classmethod
    def of(cls, parameter_set: ParameterSet, *, in_square: bool = True) -> "Spectrum":
        """With in_square, Omega^2 is the variable where only even powers of Omega occur.

        Raises DeclarationError where the equations are dependent for every Omega.
        """
        field = parameter_set.field
        free = (Omega,) if parameter_set.damping is not None else (Omega, xi)
        given = [*parameter_set.values.values(), *([] if parameter_set.damping is None else [parameter_set.damping])]
        rows = _collect(characteristic(parameter_set.scheme), [field.number(value) for value in given], field)
        in_square = in_square and len(free) == 1 and all(m[0] % 2 == 0 for row in rows.values() for m in row)
        ring = ring_over(field, *free)
        if in_square:
            rows = {j: {(m[0] // 2,): c for m, c in row.items()} for j, row in rows.items()}
        p = [ring.from_dict(rows.get(j, {})) for j in range(max(rows, default=0) + 1)]
        if len(p) <= len(parameter_set.scheme.state):
            raise DeclarationError(f"{parameter_set.title}: the relations and balances are dependent for every Omega")
        while not p[0]:
            p = p[1:]
        common = reduce(lambda a, b: a.gcd(b), p)
        p = tidy([c.exquo(common) for c in p], field)
        return cls(parameter_set, ring, in_square, common, p, tidy(bilinear(p), field))


def _collect(polynomial: Any, numbers: Sequence[Any], field: Field) -> dict[int, dict[tuple[int, ...], Any]]:
    """Power of lambda -> coefficients, the first symbols replaced by numbers; (Omega,) or (Omega, xi) are left."""
    rows: dict[int, dict[tuple[int, ...], Any]] = {}
    powers = [[field.domain.one] for _ in numbers]
    for monomial, coefficient in polynomial.terms():
        value = field.domain.convert(coefficient)
        for table, number, power in zip(powers, numbers, monomial, strict=False):
            while len(table) <= power:
                table.append(table[-1] * number)
            value *= table[power]
        *damping, omega, degree = monomial[len(numbers) :]
        row = rows.setdefault(degree, {})
        row[(omega, *damping)] = row.get((omega, *damping), field.domain.zero) + value
    return {j: kept for j, row in rows.items() if (kept := {m: c for m, c in row.items() if c})}


def tidy(polynomials: Sequence[Any], field: Field) -> list[Any]:
    """All divided by one rational, to coprime integers and a last polynomial not negative at small Omega (and xi)."""
    numbers = (QQ.convert(part) for q in polynomials for c in q.values() for part in field.parts(c))
    shared = reduce(QQ.gcd, numbers, QQ(0))
    last = next((q for q in reversed(polynomials) if q), None)
    if last is None:
        return list(polynomials)
    _, lowest = min(last.terms(), key=lambda term: term[0][::-1])
    if field.sign(lowest) * sign_of(shared) < 0:
        shared = -shared
    return [q.mul_ground(field.domain.convert(1 / shared)) for q in polynomials]


def bilinear(p: Sequence[Any]) -> list[Any]:
    """(1 - s)^n p((1 + s)/(1 - s)), coefficients from the lowest."""
    n = len(p) - 1
    rows = [[sum((-1) ** (i - k) * comb(j, k) * comb(n - j, i - k) for k in range(i + 1)) for j in range(n + 1)]
            for i in range(n + 1)]  # fmt: skip
    return [sum((c * weight for c, weight in zip(p, row, strict=True)), 0 * p[0]) for row in rows]


# --- decisions ---------------------------------------------------------------------------------------


class Verdict(Enum):
    """Where the eigenvalues lie at one Omega."""

    INSIDE = "inside the circle"
    SIMPLE = "simple on the circle, the others inside"
    MULTIPLE = "multiple on the circle, none outside"
    OUTSIDE = "outside the circle"
    UNDEFINED = "step not defined"

    @property
    def stable(self) -> bool:
        """No eigenvalue outside the circle, and those on it simple."""
        return self in (Verdict.INSIDE, Verdict.SIMPLE)


def verdict(h: Sequence[Any], at: Point) -> Verdict:
    """Where the eigenvalues lie at a point, by Routh's array of h.

    A row of zeros means that the row before is a factor of h with pairs of roots +s, -s; the derivative of
    that factor replaces the zeros and tests it. A second row of zeros means multiple roots on the axis.
    """
    signed = [(number := at.value(c), at.sign(number)) for c in h]
    kept = [i for i, (_, sign) in enumerate(signed) if sign]
    if not kept:
        return Verdict.UNDEFINED
    at_one, at_minus_one = kept[0], len(h) - 1 - kept[-1]
    descending = [number * signed[kept[-1]][1] for number, _ in signed[kept[0] : kept[-1] + 1]][::-1]
    upper, lower = descending[0::2], descending[1::2]
    rows_of_zeros = 0
    for degree in range(len(descending) - 1, 0, -1):
        if not any(at.sign(number) for number in lower):
            rows_of_zeros += 1
            lower = [number * (degree - 2 * j) for j, number in enumerate(upper[: (degree + 1) // 2])]
        if at.sign(lower[0]) <= 0:
            return Verdict.OUTSIDE
        padded = [*lower, 0 * lower[0]]
        below = [at.reduced(lower[0] * upper[j] - upper[0] * padded[j]) for j in range(1, len(upper))]
        upper, lower = lower, below
    on_circle = (at_one, at_minus_one, rows_of_zeros)
    return Verdict.MULTIPLE if max(on_circle) > 1 else Verdict.SIMPLE if any(on_circle) else Verdict.INSIDE


@dataclass(frozen=True)
class Hurwitz:
    """A polynomial in s, coefficients from the lowest, that is to have all its roots in Re s < 0."""

    name: str
    coefficients: list[Any]

    @property
    def degree(self) -> int:
        """The degree in s."""
        return len(self.coefficients) - 1

    def determinant(self, order: int) -> Any:
        """The leading principal minor, of this order, of Hurwitz's matrix."""
        return minor(self._rows(order, order), 0 * self.coefficients[0] + 1)

    def _rows(self, count: int, width: int) -> list[list[Any]]:
        """The upper left part of Hurwitz's matrix."""
        n, zero = self.degree, 0 * self.coefficients[0]
        places = [[n - 2 * j + i - 1 for j in range(width)] for i in range(count)]
        return [[self.coefficients[k] if 0 <= k <= n else zero for k in row] for row in places]

    def shared(self, pairs: int) -> list[Any]:
        """The gcd of the even and the odd terms as a polynomial in s^2, if its degree is `pairs` (a subresultant).

        Its degree is the least number of pairs for which determinant(degree - 1 - 2*pairs) does not vanish.
        """
        order = self.degree - 1 - 2 * pairs
        if order < 1:
            return self.coefficients[self.degree % 2 :: 2]
        rows = self._rows(order, order + pairs)
        one = 0 * self.coefficients[0] + 1
        return [minor([[*row[: order - 1], row[order - 1 + pairs - j]] for row in rows], one) for j in range(pairs + 1)]

    @property
    def conditions(self) -> dict[str, Any]:
        """All positive exactly if the polynomial, with a positive first coefficient, is Hurwitz (Lienard, Chipart)."""
        named = (
            {f"{self.name.lower()}_{i}": self.coefficients[i] for i in range(self.degree, -1, -1)}
            if self.degree
            else {}
        )
        return named | {f"D_{k}({self.name})": self.determinant(k) for k in range(self.degree - 1, 1, -2)}

    @property
    def boundaries(self) -> list[Any]:
        """Polynomials at whose roots alone a root s can reach the imaginary axis (Orlando)."""
        if self.degree < 1:
            return []
        ends = [self.coefficients[0], self.coefficients[-1]]
        return [*ends, self.determinant(self.degree - 1)] if self.degree > 1 else ends


def minor(rows: Sequence[Sequence[Any]], one: Any) -> Any:
    """A small determinant without division, expanded along its first row."""
    if not rows:
        return one
    total = 0 * one
    for j, entry in enumerate(rows[0]):
        if entry:
            rest = minor([[*row[:j], *row[j + 1 :]] for row in rows[1:]], one)
            total += entry * rest if j % 2 == 0 else -entry * rest
    return total


@dataclass(frozen=True)
class Parts:
    """h = s^at_one * A(s) * B(s) over K(Omega), with at_minus_one leading coefficients missing.

    circle: G of A(s) = G(s^2), coefficients from the lowest; [one] if no pair stays on the circle.
    """

    at_one: int
    at_minus_one: int
    circle: list[Any]
    rest: Hurwitz

    @classmethod
    def of(cls, spectrum: Spectrum) -> "Parts":
        """The parts at generic Omega (and xi)."""
        h, ring, field = spectrum.h, spectrum.ring, spectrum.parameter_set.field
        kept = [i for i, c in enumerate(h) if c]
        inner = h[kept[0] : kept[-1] + 1]
        both = ring_over(field, even_part, *ring.symbols)
        even, odd = (_with_power(inner[k::2], both) for k in (0, 1))
        shared = even.gcd(odd) if odd else even
        circle = tidy(_by_power(shared, ring), field)
        shared = _with_power(circle, both)
        halves = [_by_power(part.exquo(shared), ring) for part in (even, odd)]
        rest = [ring.zero] * (len(inner) - 2 * (len(circle) - 1))
        for k, half in enumerate(halves):
            for i, c in enumerate(half):
                if c:
                    rest[2 * i + k] = c
        return cls(kept[0], len(h) - 1 - kept[-1], circle, Hurwitz("B", tidy(rest, field)))

    @property
    def tests(self) -> tuple[Hurwitz, ...]:
        """What has to be Hurwitz: the rest, and A + dA/ds."""
        if len(self.circle) == 1:
            return (self.rest,)
        return (Hurwitz("A", with_derivative(self.circle)), self.rest)


def with_derivative(circle: Sequence[Any]) -> list[Any]:
    """A + dA/ds for A = G(s^2), coefficients from the lowest."""
    coefficients = []
    for j, c in enumerate(circle):
        if j:
            coefficients.append(c * (2 * j))
        coefficients.append(c)
    return coefficients


def _with_power(coefficients: Iterable[Any], both: Any) -> Any:
    """The polynomial in one variable more whose powers have these coefficients."""
    return both.from_dict({(j, *m): v for j, c in enumerate(coefficients) for m, v in c.items()})


def _by_power(polynomial: Any, ring: Any) -> list[Any]:
    """The coefficients of the powers of the first variable, from the lowest: the inverse of `_with_power`."""
    rows: dict[int, dict[tuple[int, ...], Any]] = {}
    for (j, *m), v in polynomial.terms():
        rows.setdefault(j, {})[tuple(m)] = v
    return [ring.from_dict(rows.get(j, {})) for j in range(max(rows, default=0) + 1)]
