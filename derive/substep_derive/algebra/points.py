"""Exact signs of polynomials at rational and at algebraic points, and their positive roots.

Polynomials are in one variable over K = Q or K = Q(r). Algebra (a remainder, a gcd) decides whether a value is
zero; only if it is not, its sign is found by narrowing an interval around the point.
"""

from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Any, Protocol

from sympy import QQ, Poly, Symbol
from sympy import ring as polynomial_ring

from .algebraic import Field, RealRoot, enclose, real_roots, sign_of

NARROW = QQ(1, 2**64)  # width of an interval below which algebra decides whether the value is zero


class Point(Protocol):
    """A place on the real line at which polynomials over K have values with signs."""

    def value(self, polynomial: Any) -> Any:
        """The value of a polynomial in one variable, as an object with +, - and *."""
        ...

    def reduced(self, number: Any) -> Any:
        """The same number in the short form in which `value` returns it."""
        ...

    def sign(self, number: Any) -> int:
        """-1, 0 or 1, exactly."""
        ...


class RationalPoint:
    """The point at a rational x, where values are elements of K."""

    def __init__(self, field: Field, x: Any) -> None:
        self.field, self.x = field, x

    def value(self, polynomial: Any) -> Any:
        """The polynomial's value."""
        return polynomial.evaluate(polynomial.ring.gens[0], self.field.domain.convert(self.x))

    def reduced(self, number: Any) -> Any:
        """The number itself, which has only one form."""
        return number

    def sign(self, number: Any) -> int:
        """The sign of an element of K."""
        return self.field.sign(number)


class RootPoint:
    """The point at an irrational real root: values are remainders modulo a polynomial over K that vanishes there."""

    def __init__(self, field: Field, root: RealRoot, ring: Any) -> None:
        self.field, self.root = field, root
        self._modulus = ring.from_list([field.domain.convert(QQ.convert(c)) for c in root.polynomial.all_coeffs()])

    def value(self, polynomial: Any) -> Any:
        """The polynomial's remainder, which has the same value at the root."""
        return polynomial.rem(self._modulus)

    def reduced(self, number: Any) -> Any:
        """The remainder of a product of remainders."""
        return number.rem(self._modulus)

    def sign(self, number: Any) -> int:
        """The sign of the number a remainder stands for."""
        number = number.rem(self._modulus)
        known_nonzero = not self.field.algebraic  # the modulus is irreducible over Q, perhaps not over Q(r)
        while number:
            x = self.root.low, self.root.high
            low, high = enclose(map(self.field.enclose, number.to_dense()), x)
            if low > 0 or high < 0:
                return sign_of(low + high)
            if not known_nonzero and x[1] - x[0] < NARROW:
                if self._is_zero(number):
                    return 0
                known_nonzero = True
            self.root.narrow()
            self.field.narrow()
        return 0

    def _is_zero(self, number: Any) -> bool:
        """Whether the number vanishes at the root; replaces the modulus by its factor that has the root.

        Where the number is of a low degree, its norm decides sooner than that factor is found.
        """
        if 2 * number.degree() <= self._modulus.degree() and (known := self._by_norm(number)) is not None:
            return known
        shared = _gcd(self._modulus, _monic(number))
        if shared.degree() < 1:
            return False
        ends = [self.field.sign(shared.evaluate(shared.ring.gens[0], self.field.domain.convert(end)))
                for end in (self.root.low, self.root.high)]  # fmt: skip
        vanishes = ends[0] * ends[1] < 0  # the gcd has at most one root in the interval, a simple one
        self._modulus = shared if vanishes else self._modulus.exquo(shared)
        return vanishes

    def _by_norm(self, number: Any) -> bool | None:
        """The same from the norm, the product of the number's conjugates; None for a multiple root of the norm.

        The norm's roots are those of the conjugates, so that a simple one at which the number vanishes is a simple
        root of the number alone: there it changes its sign.
        """
        factors = _norm_factors(_monic(number))
        own = self.root.polynomial.all_coeffs()
        power = next((power for factor, power in factors if factor.all_coeffs() == own), 0)
        if power != 1:
            return None if power else False
        alone = RealRoot(self.root.polynomial, self.root.low, self.root.high)
        others = (factor for factor, _ in factors if factor.all_coeffs() != own)
        separate([alone, *(root for factor in others for root in real_roots(factor))])
        x = number.ring.gens[0]
        ends = (self.field.sign(number.evaluate(x, self.field.domain.convert(end))) for end in (alone.low, alone.high))
        return sign_of(next(ends) * next(ends)) < 0


@lru_cache(maxsize=64)  # all roots of one polynomial ask for the same
def _gcd(p: Any, q: Any) -> Any:
    """The greatest common divisor over a field, by Euclid's algorithm; remainders with a leading 1 stay short."""
    while q:
        q = _monic(q)
        p, q = q, p.rem(q)
    return p


def _monic(p: Any) -> Any:
    """The polynomial over its leading coefficient: one division in the field, where SymPy's own has one for each."""
    one = p.ring.domain.one
    return p if one == p.LC else p.mul_ground(one / p.LC)


@lru_cache(maxsize=64)
def _norm_factors(polynomial: Any) -> tuple[tuple[Poly, int], ...]:
    """The irreducible factors over Q, and their powers, of the norm of a polynomial in one variable; over Q, of itself.

    Each has coprime integer coefficients.
    """
    x, domain = Symbol("x"), polynomial.ring.domain
    over_k = Poly.from_dict(dict(polynomial), x, domain=domain)
    factors = (over_k if domain is QQ else over_k.norm()).factor_list()[1]
    return tuple((factor.primitive()[1], power) for factor, power in factors)


def point(field: Field, root: RealRoot, ring: Any) -> Point:
    """The point at a real root, rational or irrational."""
    return RootPoint(field, root, ring) if root.rational is None else RationalPoint(field, root.rational)


def separate(roots: Iterable[RealRoot]) -> list[RealRoot]:
    """Distinct roots in ascending order, their intervals narrowed until a rational fits between any two."""
    ordered = sorted(roots, key=lambda root: (root.low, root.high))
    i = 1
    while i < len(ordered):
        left, right = ordered[i - 1], ordered[i]
        if left.high < right.low:
            i += 1
            continue
        for root in (left, right):
            if root.rational is None:
                root.narrow()
        ordered.sort(key=lambda root: (root.low, root.high))
        i = max(i - 1, 1)
    return ordered


def simplest_between(low: Any, high: Any) -> Any:
    """The rational of smallest denominator strictly between two rationals 0 <= low < high."""
    whole = low.numerator // low.denominator
    if whole + 1 < high:
        return QQ(whole + 1)
    if low == whole:  # here low = whole < high <= whole + 1
        gap = high - whole
        return whole + QQ(1, gap.denominator // gap.numerator + 1)
    above = low - whole, high - whole
    return whole + 1 / simplest_between(1 / above[1], 1 / above[0])


def positive_roots(field: Field, polynomials: Sequence[Any], ring: Any) -> list[RealRoot]:
    """The positive roots of nonzero polynomials over K, each once, separated from 0 and each other, ascending.

    Over Q(r) these are found among the roots of the norm, a polynomial over Q.
    """
    found: dict[Poly, list[Any]] = {}
    for polynomial in dict.fromkeys(map(_monic, polynomials)):
        for factor, _ in _norm_factors(polynomial):
            if factor.eval(0) != 0:
                found.setdefault(factor, []).append(polynomial)
    roots = []
    for factor, sources in found.items():
        for root in real_roots(factor, above=0):
            while root.low <= 0:
                root.narrow()
            at = point(field, root, ring)
            if not field.algebraic or any(at.sign(at.value(source)) == 0 for source in sources):
                roots.append(root)
    return separate(roots)


def ring_over(field: Field, *symbols: Symbol) -> Any:
    """The ring of sparse polynomials over K in these symbols."""
    return polynomial_ring(list(symbols), field.domain)[0]


def count_real_roots(field: Field, coefficients: Sequence[Any]) -> int:
    """The number of distinct real roots of a polynomial over K (highest power first), by Sturm's theorem."""
    chain, signs = [list(coefficients)], []
    p = chain[0]
    chain.append([c * (len(p) - 1 - i) for i, c in enumerate(p[:-1])])
    while len(chain[-1]) > 1:
        rest = _remainder(chain[-2], chain[-1])
        if not rest:
            break
        chain.append([-c for c in rest])
    for at in (-1, 1):  # the signs of the chain at -oo and at oo
        row = [field.sign(q[0]) * (at if len(q) % 2 == 0 else 1) for q in chain if q]
        signs.append(sum(a != b for a, b in pairwise(row)))
    return signs[0] - signs[1]


def _remainder(p: Sequence[Any], divisor: Sequence[Any]) -> list[Any]:
    """The remainder of a division of polynomials over K, highest power first; the list is empty for 0."""
    rest = list(p)
    while len(rest) >= len(divisor):
        factor = rest[0] / divisor[0]
        rest = [c - factor * d for c, d in zip(rest, [*divisor, *[0 * c for c in rest[len(divisor) :]]], strict=True)]
        while rest and not rest[0]:
            rest = rest[1:]
    return rest
