"""A real algebraic number as a symbol, and polynomials and matrices whose coefficients are numbers of its field.

A table's irrational number need not be a parameter: it has one value. As a Constant it is a symbol whose powers from
the degree of its equation on are reduced by that equation, so that expressions in it stay short, and those that vanish
are 0.
"""

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

from sympy import QQ, Add, Expr, Integer, Matrix, Mul, Poly, Rational, Symbol, fraction, together

from . import elimination
from .algebraic import Algebraic, Field, generator
from .expanded import polynomial_in, terms

DIGITS = 2**120  # an approximation's relative error is below 1/DIGITS: a pair of doubles holds 2^106


class Constant(Symbol):
    """The symbol of a real algebraic number, which SymPy writes in radicals, or given as an Algebraic r.

    Raises ValueError for what is no real algebraic number, for a rational one, which needs no symbol, and for another
    function of r than r itself.
    """

    __slots__ = ("number",)
    number: Algebraic

    def __new__(cls, name: str, number: Algebraic | Expr) -> "Constant":  # noqa: D102 (the class says it)
        number = number if isinstance(number, Algebraic) else Algebraic.of(number)
        if number.value != generator or number.polynomial.degree() < 2:
            raise ValueError(f"expected an irrational number r itself, got {number}")
        self = Symbol.__xnew__(cls, name, algebraic=True, real=True)
        self.number = number
        return self

    def __getnewargs_ex__(self) -> Any:
        return (self.name, self.number), {}

    def _hashable_content(self) -> tuple[Any, ...]:
        return (*super()._hashable_content(), self.number.coefficients, self.number.index)

    def _sympyrepr(self, printer: Any) -> str:
        return f"Constant({self.name!r}, {self.number.coefficients}, {self.number.interval})"

    @property
    def definition(self) -> str:
        """What it is, in words."""
        low, high = self.number.interval
        return f"{self.name} is the root of {self.number.polynomial.as_expr(Symbol(self.name))} in [{low}, {high}]"

    @property
    def approximation(self) -> Rational:
        """A rational number near it."""
        found = field_of(self).root
        assert found is not None
        value = found.approximation()
        return Rational(value.numerator, value.denominator)


@cache
def field_of(constant: Constant) -> Field:
    """The field of the number."""
    return Field(constant.number)


def constants_of(expressions: Iterable[Expr]) -> tuple[Constant, ...]:
    """The constants in some expressions."""
    found = {s for e in expressions for s in e.free_symbols if isinstance(s, Constant)}
    return tuple(sorted(found, key=str))


def constant_of(expressions: Iterable[Expr]) -> Constant | None:
    """The only constant in some expressions; None where there is none. Raises ValueError for more."""
    found = constants_of(expressions)
    if len(found) > 1:
        raise ValueError(f"expected one algebraic constant, got {', '.join(map(str, found))}; write all in one of them")
    return found[0] if found else None


class Polynomials:
    """Polynomials in some symbols over the field of a constant, and rational functions as pairs of them."""

    def __init__(self, constant: Constant, symbols: Iterable[Symbol]) -> None:
        self.constant = constant
        self.symbols = sorted(set(symbols) - {constant}, key=str) or [Symbol("unused")]
        self.field = field_of(constant)
        self.domain = self.field.domain.poly_ring(*self.symbols)
        self.ring = self.domain.ring

    @classmethod
    def of(cls, expressions: Sequence[Expr], *more: Symbol) -> "Polynomials | None":
        """Those in which the expressions can be written; None where these hold no constant."""
        constant = constant_of(expressions)
        return None if constant is None else cls(constant, {s for e in expressions for s in e.free_symbols} | {*more})

    def read(self, e: Expr) -> Any:
        """An expression that is a polynomial."""
        found: dict[tuple[int, ...], dict[int, Any]] = {}
        for (*powers, k), c in terms(e, (*self.symbols, self.constant)).items():
            found.setdefault(tuple(powers), {})[k] = c
        K = self.field.domain
        element = {  # times 1, since only a product is reduced by the constant's equation
            powers: K([by_power.get(k, QQ(0)) for k in range(max(by_power), -1, -1)]) * K.one
            for powers, by_power in found.items()
        }
        return self.ring.from_dict({powers: c for powers, c in element.items() if c})

    def fraction(self, e: Expr) -> tuple[Any, Any]:
        """Numerator and denominator of a rational function, the denominator without a factor from the field."""
        if e.is_polynomial(*e.free_symbols):
            return self.read(e), self.ring.one
        numerator, den = map(self.read, fraction(together(e)))
        inverse = self.field.domain.one / den.LC
        return numerator.mul_ground(inverse), den.mul_ground(inverse)

    def expression(self, element: Any) -> Expr:
        """A polynomial as an expression."""
        terms = [
            Mul(
                Rational(int(x.numerator), int(x.denominator)),
                self.constant**k,
                *(s**n for s, n in zip(self.symbols, powers, strict=True)),
            )
            for powers, c in element.terms()
            for k, x in enumerate(reversed(c.to_list()))
        ]
        return Add(*terms)

    def cleared(self, matrix: Matrix) -> list[list[Any]]:
        """The rows, each multiplied by its common denominator."""
        rows = []
        for row in matrix.tolist():
            pairs = [self.fraction(e) for e in row]
            den = self.common([d for _, d in pairs])
            rows.append([numerator * den.exquo(d) for numerator, d in pairs])
        return rows

    def common(self, dens: Iterable[Any]) -> Any:
        """The least common multiple."""
        found = self.ring.one
        for d in dens:
            if not d.is_ground and found.rem([d]) != 0:
                found = found * d.exquo(found.gcd(d))
        return found

    def solve(self, matrix: Matrix, right: Matrix) -> tuple[Matrix, Expr]:
        """As `rational.solve`."""
        rows, den = elimination.solution(self.cleared(matrix.row_join(right)), matrix.cols, self.domain)
        return self._reduced(rows, right.cols, den)

    def _reduced(self, rows: list[list[Any]], columns: int, den: Any) -> tuple[Matrix, Expr]:
        """(numerators, den) without common factors, den with a rational first coefficient."""
        common = den
        for e in (e for row in rows for e in row):
            if common.is_ground:
                break
            common = common.gcd(e)
        inverse = self.field.domain.one / den.exquo(common).LC
        entries = [self.expression(e.exquo(common).mul_ground(inverse)) for row in rows for e in row]
        return Matrix(len(rows), columns, entries), self.expression(den.exquo(common).mul_ground(inverse))

    def cancelled(self, numerators: Matrix, den: Expr) -> tuple[Matrix, Expr]:
        """As `rational.cancelled`."""
        (*entries, below) = self.cleared(Matrix([[*numerators, den]]))[0]
        n = numerators.cols
        return self._reduced([entries[i : i + n] for i in range(0, len(entries), n)], n, below)

    def common_denominator(self, matrix: Matrix) -> tuple[Matrix, Expr]:
        """As `rational.common_denominator`."""
        pairs = [[self.fraction(e) for e in row] for row in matrix.tolist()]
        den = self.common(d for row in pairs for _, d in row)
        return self._reduced([[n * den.exquo(d) for n, d in row] for row in pairs], matrix.cols, den)

    def determinant(self, matrix: Matrix) -> Expr:
        """As `rational.determinant`."""
        return self.expression(elimination.determinant(self.cleared(matrix), self.domain))

    def quotient(self, a: Expr, b: Expr) -> Expr | None:
        """As `rational.quotient`."""
        (found,), rest = self.read(a).div([self.read(b)])
        return None if rest else self.expression(found)

    def primitive(self, e: Expr, variable: Symbol) -> Poly:
        """As `rational.primitive`; the highest coefficient has a rational first coefficient."""
        numerator = self.fraction(e)[0]
        place = self.symbols.index(variable)
        parts: dict[int, Any] = {}
        for powers, c in numerator.terms():
            rest = tuple(0 if k == place else p for k, p in enumerate(powers))
            parts.setdefault(powers[place], self.ring.zero)
            parts[powers[place]] += self.ring.from_dict({rest: c})
        content = self.ring.zero
        for part in sorted(parts.values(), key=len):  # where one is a number, all others need no looking at
            content = content.gcd(part) if not (content and content.is_ground) else content
        found = numerator.exquo(content)
        highest = parts[max(parts)].exquo(content)
        return polynomial_in(variable, self.expression(found.mul_ground(self.field.domain.one / highest.LC)))


def reduced(e: Expr) -> Expr:
    """A rational function with its numbers reduced, and no constant below where the denominator is one of them."""
    polynomials = Polynomials.of([e])
    if polynomials is None:
        return e
    numerator, den = polynomials.fraction(e)
    return polynomials.expression(numerator) / polynomials.expression(den)


def approximated(e: Expr) -> Expr:
    """A polynomial with rational numbers in place of those of a constant's field, each nearer than a pair of doubles.

    A coefficient that vanishes is left out. Without a constant the expression is returned as it is.
    """
    polynomials = Polynomials.of([e])
    if polynomials is None:
        return e
    terms = []
    for powers, c in polynomials.read(e).terms():
        symbols = (s**k for s, k in zip(polynomials.symbols, powers, strict=True))
        terms.append(Mul(_near(polynomials.field, c), *symbols))
    return Add(*terms)


def _near(field: Field, number: Any) -> Rational:
    """A rational number within 1/DIGITS of an element, relative to it; the element itself where that is rational."""
    parts = field.parts(number)
    if len(parts) == 1:
        return Rational(int(parts[0].numerator), int(parts[0].denominator))
    middle = field.near(number, DIGITS**2)  # so near that the rounding below does not depend on the enclosure
    power = abs(middle.numerator).bit_length() - middle.denominator.bit_length()
    if abs(middle) < Fraction(2) ** power:  # now 2**power <= |middle| < 2**(power + 1), whatever the enclosure was
        power -= 1
    scale = Integer(2) ** (121 - power)
    return Rational(round(Rational(middle.numerator, middle.denominator) * scale), scale)


def replaced(values: Mapping[Any, Expr]) -> dict[Any, Expr]:
    """Expressions with `approximated` coefficients."""
    return {key: approximated(e) for key, e in values.items()}
