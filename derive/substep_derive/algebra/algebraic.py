"""Exact real algebraic numbers, which a scheme's parameters may be, and the field K = Q(r) that such an r generates.

Algebra decides whether an element of K is zero. If it is not, its sign is found by narrowing a rational interval
around r until the interval around the element excludes zero. Nothing is rounded.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from typing import Any

from sympy import (
    QQ,
    Add,
    CRootOf,
    Expr,
    Integer,
    Interval,
    Mul,
    NotAlgebraic,
    Poly,
    Pow,
    Rational,
    Symbol,
    cancel,
    fraction,
    minimal_polynomial,
    sqrt,
    sqrtdenest,
    sympify,
)

from .exact_number import exact_number

# the algebraic number r of which parameters may be functions; its assumption keeps it distinct from a parameter named r
generator = Symbol("r", algebraic=True)

Enclosure = tuple[Any, Any]  # two rational numbers (of QQ) with a real number between them


def sign_of(number: Any) -> int:
    """-1, 0 or 1 for a rational."""
    return (number > 0) - (number < 0)


def horner(coefficients: Iterable[Any], x: Any) -> Any:
    """A polynomial's value at x, its coefficients given from the highest power down."""
    value: Any = 0
    for c in coefficients:
        value = value * x + c
    return value


def enclose(coefficients: Iterable[Enclosure], x: Enclosure) -> Enclosure:
    """An enclosure of a polynomial's value, from enclosures of its coefficients (highest power first) and of x."""
    low = high = QQ(0)
    for bottom, top in coefficients:
        corners = (low * x[0], low * x[1], high * x[0], high * x[1])
        low, high = min(corners) + bottom, max(corners) + top
    return low, high


class RealRoot:
    """A real root of a primitive polynomial irreducible over Q: the one in a rational interval that `narrow` halves."""

    def __init__(self, polynomial: Poly, low: Any, high: Any) -> None:
        self.polynomial = polynomial
        self.low, self.high = QQ.convert(low), QQ.convert(high)
        self._coefficients = [QQ.convert(c) for c in polynomial.all_coeffs()]
        if polynomial.degree() == 1:
            self.low = self.high = -self._coefficients[1] / self._coefficients[0]
        self._sign_left = self._sign(self.low)

    @property
    def rational(self) -> Any:
        """The root's value if it is rational, else None."""
        return self.low if self.low == self.high else None

    def _sign(self, x: Any) -> int:
        return sign_of(horner(self._coefficients, x))

    def narrow(self) -> None:
        """Halve the interval. An irrational root never falls on its middle, which is rational."""
        middle = (self.low + self.high) / 2
        if self._sign(middle) == self._sign_left:
            self.low = middle
        else:
            self.high = middle

    @cached_property
    def rank(self) -> int:
        """How many real roots of the polynomial are smaller."""
        own = RealRoot(self.polynomial, self.low, self.high)
        while True:
            near = [k for k, (low, high) in enumerate(isolated(self.polynomial)) if low <= own.high and own.low <= high]
            if len(near) == 1:
                return near[0]
            own.narrow()

    def is_same(self, other: "RealRoot") -> bool:
        """Whether both are the same number."""
        return self.polynomial == other.polynomial and self.rank == other.rank

    def approximation(self) -> Fraction:
        """A rational number that agrees with the root to about 15 digits, for display."""
        while (self.high - self.low) * 10**15 > max(abs(self.low), abs(self.high)):
            self.narrow()
        middle = (self.low + self.high) / 2
        return Fraction(int(middle.numerator), int(middle.denominator))


@cache
def isolated(polynomial: Poly) -> tuple[Enclosure, ...]:
    """Intervals with one real root each of a polynomial irreducible over Q, in ascending order."""
    return tuple((QQ.convert(low), QQ.convert(high)) for low, high in polynomial.intervals(sqf=True))


def closed_form(root: RealRoot, variable: Symbol, *, in_square: bool = False) -> Expr:
    """A root, or with in_square its square root, in radicals for a polynomial up to degree two, else as a CRootOf."""
    polynomial = root.polynomial
    if polynomial.degree() > 2:
        if not in_square:
            return CRootOf(Poly(polynomial.as_expr(variable), variable), root.rank)
        negative = sum(high <= 0 for _, high in isolated(polynomial))  # an interval has 0 at most as an end
        positive = len(isolated(polynomial)) - negative
        return CRootOf(Poly(polynomial.as_expr(variable**2), variable), positive + root.rank - negative)
    coefficients = [Rational(int(c)) for c in polynomial.all_coeffs()]
    if len(coefficients) == 2:
        number = -coefficients[1] / coefficients[0]
    else:
        a, b, c = coefficients
        upper = (root.rank == 1) == (a > 0)
        number = (-b + (1 if upper else -1) * sqrt(b**2 - 4 * a * c)) / (2 * a)
    return sqrtdenest(sqrt(number)) if in_square else number


def irreducible(polynomial: Poly) -> list[Poly]:
    """The distinct irreducible factors over Q of a polynomial over Q, each with coprime integer coefficients."""
    return [factor.primitive()[1] for factor, _ in polynomial.factor_list()[1]]


def real_roots(polynomial: Poly, above: Any = None) -> list[RealRoot]:
    """Real roots of a polynomial irreducible over Q, those below `above` left out, in ascending order."""
    return [RealRoot(polynomial, *ends) for ends in polynomial.intervals(inf=above, sqf=True)]


@dataclass(frozen=True)
class Algebraic:
    """A real algebraic number: `value`, a rational function of r, where r is a root of a polynomial.

    coefficients: integers, those of the polynomial from the highest power down. interval: two rationals
    (int, Fraction or text such as '1/2') between which the polynomial has exactly one root, r. Arithmetic
    with rationals and with other functions of the same r gives functions of that r: with
    r = Algebraic((1, 0, -3), (1, 2)), which is sqrt(3), Wilson's threshold is (1 + r)/2.

    Raises ValueError if the interval does not hold exactly one root, TypeError for a float.
    """

    coefficients: tuple[int, ...]
    interval: tuple[Any, Any]
    value: Expr = generator

    def __post_init__(self) -> None:
        exact = tuple(exact_number(c) for c in self.coefficients)
        low, high = (exact_number(end) for end in self.interval)
        polynomial = Poly(exact, generator, domain=QQ)
        if polynomial.degree() < 1 or any(c.q != 1 for c in exact):
            raise ValueError(f"expected a polynomial's integer coefficients, highest first; got {self.coefficients}")
        holding = [factor for factor in irreducible(polynomial) if factor.count_roots(low, high)]
        if low > high or len(holding) != 1 or holding[0].count_roots(low, high) != 1:
            count = sum(factor.count_roots(low, high) for factor in holding) if low <= high else 0
            raise ValueError(
                f"{polynomial.as_expr()} has {count} distinct roots in [{low}, {high}], expected one; "
                f"choose another interval"
            )
        object.__setattr__(self, "coefficients", tuple(int(c) for c in holding[0].all_coeffs()))
        object.__setattr__(self, "value", sympify(self.value).subs(Symbol(generator.name), generator))
        object.__setattr__(self, "interval", (low, high))

    @classmethod
    def of(cls, number: Expr) -> "Algebraic":
        """The Algebraic of a real number that SymPy writes in radicals or as a root of a polynomial.

        Raises ValueError for what is no real algebraic number.
        """
        try:
            polynomial = Poly(minimal_polynomial(number, generator), generator, domain=QQ)
        except (NotAlgebraic, NotImplementedError) as error:
            raise ValueError(f"expected an algebraic number, got {number}") from error
        for root in real_roots(polynomial.primitive()[1]):
            low, high = (Rational(int(end.numerator), int(end.denominator)) for end in (root.low, root.high))
            if low == high or ((number - low).is_positive and (high - number).is_positive):
                return cls(tuple(polynomial.primitive()[1].all_coeffs()), (low, high))
        raise ValueError(f"expected a real number, got {number}")

    @property
    def polynomial(self) -> Poly:
        """The irreducible polynomial of r."""
        return Poly(self.coefficients, generator, domain=QQ)

    @cached_property
    def index(self) -> int:
        """How many real roots of the polynomial are less than r."""
        return self.polynomial.count_roots(None, self.interval[0]) - (self.polynomial.eval(self.interval[0]) == 0)

    def shares_generator(self, other: "Algebraic") -> bool:
        """Whether both are functions of the same r."""
        return (self.coefficients, self.index) == (other.coefficients, other.index)

    @property
    def definition(self) -> str:
        """What r is, in words."""
        low, high = self.interval
        return f"r is the root of {self.polynomial.as_expr()} in [{low}, {high}]"

    def __str__(self) -> str:
        return f"{self.value} where {self.definition}"

    def __float__(self) -> float:
        """The nearest float."""
        field = Field(self)
        return field.nearest(field.number(self.value))

    def _with(self, other: Any, combine: Callable[..., Expr], *, swapped: bool = False) -> "Algebraic":
        if isinstance(other, Algebraic) and not self.shares_generator(other):
            raise ValueError(f"two different algebraic numbers: {self} and {other}; use functions of a single one")
        right = other.value if isinstance(other, Algebraic) else exact_number(other)
        operands = (right, self.value) if swapped else (self.value, right)
        return Algebraic(self.coefficients, self.interval, cancel(combine(*operands)))

    def __add__(self, other: Any) -> "Algebraic":
        return self._with(other, Add)

    def __mul__(self, other: Any) -> "Algebraic":
        return self._with(other, Mul)

    def __sub__(self, other: Any) -> "Algebraic":
        return self._with(other, lambda a, b: a - b)

    def __rsub__(self, other: Any) -> "Algebraic":
        return self._with(other, lambda a, b: a - b, swapped=True)

    def __truediv__(self, other: Any) -> "Algebraic":
        return self._with(other, lambda a, b: a / b)

    def __rtruediv__(self, other: Any) -> "Algebraic":
        return self._with(other, lambda a, b: a / b, swapped=True)

    def __pow__(self, power: int) -> "Algebraic":
        return self._with(power, Pow)

    def __neg__(self) -> "Algebraic":
        return self * -1

    __radd__, __rmul__ = __add__, __mul__


class Field:
    """The field K = Q, or K = Q(r) for the r of an Algebraic, whose interval says which real root r is."""

    def __init__(self, r: Algebraic | None = None) -> None:
        self.r = r
        if r is None or len(r.coefficients) == 2:
            self.domain: Any = QQ
            self.root = None if r is None else RealRoot(r.polynomial, *r.interval)
        else:
            self.domain = QQ.alg_field_from_poly(r.polynomial, alias=generator.name)
            self.root = RealRoot(r.polynomial, *r.interval)

    @property
    def algebraic(self) -> bool:
        """Whether K is larger than Q."""
        return self.domain is not QQ

    def number(self, value: Expr) -> Any:
        """A rational function of r as an element of K.

        Raises ValueError for anything else, such as a radical of r, and where a denominator vanishes.
        """
        if isinstance(value, Rational):
            return self.domain.convert(QQ(value.p, value.q))
        numerator, denominator = (
            Poly(part, generator, domain=QQ)
            if part.is_polynomial(generator) and part.free_symbols <= {generator}
            else None
            for part in ((value, Integer(1)) if value.is_polynomial(generator) else fraction(cancel(value)))
        )
        if numerator is None or denominator is None or self.root is None:
            raise ValueError(f"expected a rational function of r, got {value}")
        r = self.domain.unit if self.algebraic else self.root.rational
        top, bottom = (horner(map(self.domain.convert, part.rep.to_list()), r) for part in (numerator, denominator))
        if not bottom:
            raise ValueError(f"{value} has no value at r = {self.r}")
        return self.domain.convert(top) / self.domain.convert(bottom)

    def parts(self, number: Any) -> list[Any]:
        """The coefficients of an element as a polynomial in r, from the highest power down."""
        return number.to_list() if self.algebraic else [number]

    def enclose(self, number: Any) -> Enclosure:
        """Two rationals with the element between them; they are closer after `narrow`."""
        if not self.algebraic:
            return number, number
        assert self.root is not None
        return enclose([(c, c) for c in self.parts(number)], (self.root.low, self.root.high))

    def narrow(self) -> None:
        """Halve the interval around r."""
        if self.algebraic and self.root is not None:
            self.root.narrow()

    def sign(self, number: Any) -> int:
        """The sign of an element of K."""
        if not number:
            return 0
        while True:
            low, high = self.enclose(number)
            if low > 0 or high < 0:
                return sign_of(low + high)
            self.narrow()

    def near(self, number: Any, share: int) -> Fraction:
        """A fraction that differs from an element by at most 1/share of it."""
        low, high = self.enclose(number)
        while (high - low) * share > max(abs(low), abs(high)):
            self.narrow()
            low, high = self.enclose(number)
        middle = (low + high) / 2
        return Fraction(int(middle.numerator), int(middle.denominator))

    def nearest(self, number: Any) -> float:
        """The float of an element, from an enclosure of 20 digits."""
        return float(self.near(number, 10**20))

    def expression(self, number: Any) -> Expr:
        """An element as an expression in r."""
        return sum((Rational(int(c.numerator), int(c.denominator)) * generator**k
                    for k, c in enumerate(reversed(self.parts(number)))), Integer(0))  # fmt: skip

    def inside(self, value: Expr, domain: Interval) -> bool:
        """Whether a value lies in an interval with rational or infinite ends."""
        number = self.number(value)
        for end, is_open, side in ((domain.start, domain.left_open, 1), (domain.end, domain.right_open, -1)):
            if end.is_finite and self.sign(number - self.number(end)) * side < bool(is_open):
                return False
        return True
