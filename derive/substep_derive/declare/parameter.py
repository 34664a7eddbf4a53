"""Parameters of schemes and scenes: the interval each may lie in, its default, and families of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

from sympy import (
    QQ,
    CoercionFailed,
    Expr,
    Interval,
    Mul,
    Poly,
    PolynomialError,
    Rational,
    S,
    Set,
    Symbol,
    Union,
    fraction,
    oo,
    together,
    true,
)
from sympy import factor as factored

from ..algebra.algebraic import Algebraic, RealRoot, irreducible, real_roots
from .errors import DeclarationError
from .expressions import expression

POSITIVE, NOT_NEGATIVE, REAL = Interval.open(0, oo), Interval(0, oo), Interval(-oo, oo)
NEGATIVE, NOT_POSITIVE = Interval.open(-oo, 0), Interval(-oo, 0)
# what SymPy may be told of a symbol, and the numbers of which it is true
ASSUMED: Mapping[str, Set] = {
    "positive": POSITIVE, "negative": NEGATIVE, "nonnegative": NOT_NEGATIVE, "nonpositive": NOT_POSITIVE,
    "nonzero": Union(NEGATIVE, POSITIVE), "zero": S.EmptySet, "integer": S.Integers, "rational": S.Rationals,
    "irrational": S.EmptySet, "imaginary": S.EmptySet,
}  # fmt: skip


def written_interval(name: str, interval: Interval) -> str:
    """An interval of real numbers as a paper writes it: beta > 0, 0 < gamma_t <= 1."""
    low, high = ("" if end.is_infinite else str(end) for end in (interval.start, interval.end))
    after_low, before_high = ("<" if open_ else "<=" for open_ in (interval.left_open, interval.right_open))
    if low and high:
        return f"{low} {after_low} {name} {before_high} {high}"
    if low:
        return f"{name} {after_low.replace('<', '>')} {low}"
    return f"{name} {before_high} {high}" if high else f"{name} real"


@dataclass(frozen=True)
class Root:
    """A default given implicitly: the one root in the parameter's interval of a polynomial equation."""

    equation: Expr

    def subs(self, values: Mapping[Symbol, Expr]) -> "Root":
        """The equation with parameters replaced."""
        return Root(self.equation.subs(values, simultaneous=True))


@dataclass(frozen=True)
class Parameter:
    """A free parameter, the interval it may lie in, and the value taken when none is given.

    The default may be an expression in parameters declared before this one. It is None for a scene's parameter that
    has to be given.

    Raises DeclarationError for an interval or a default that is not exact.
    """

    symbol: Symbol
    domain: Interval
    default: Any  # an Expr or a Root; None for a scene's parameter that has to be given

    @property
    def written(self) -> str:
        """The interval as a paper writes it: beta > 0, 0 < gamma_t <= 1."""
        return written_interval(self.name, self.domain)

    def __post_init__(self) -> None:
        symbol, domain = cast(tuple[Any, Any], (self.symbol, self.domain))  # which a user may have given wrong
        if not isinstance(symbol, Symbol):
            raise DeclarationError(f"expected a SymPy Symbol as a parameter, got {self.symbol!r}; write Symbol('...')")
        ends = (self.domain.start, self.domain.end) if isinstance(domain, Interval) else ()
        if not ends or not all(isinstance(end, Rational) or end.is_infinite for end in ends):
            raise DeclarationError(
                f"{self.name}: expected an interval with rational or infinite ends and more than one number in it, "
                f"got {self.domain}; write Interval(0, Rational(1, 2)), Interval.open(0, oo), ..."
            )
        require_assumptions(self.name, f"numbers in {domain}", symbol, domain)
        if self.default is None or isinstance(self.default, Root):
            return
        default = expression(self.name, "a default", self.default)
        object.__setattr__(self, "default", default)
        if default.has(self.symbol) or any(part.is_Float for part in default.atoms()):
            raise DeclarationError(
                f"{self.name}: expected an exact default, perhaps in parameters declared before, got {default}; write "
                "a fraction as Rational(1, 4)"
            )

    def check_default(self) -> None:
        """Raises DeclarationError for a default outside the interval, if it depends on no other parameter."""
        if isinstance(self.default, Root):
            if not self.default.equation.free_symbols - {self.symbol}:
                self.root({})
        elif self.default is not None and self.default.is_number and self.domain.contains(self.default) is not true:
            raise DeclarationError(
                f"{self.name}: the default {self.default} does not lie in {self.domain}; choose one inside"
            )

    @property
    def name(self) -> str:
        """The symbol's name."""
        return self.symbol.name

    @property
    def default_symbols(self) -> set[Symbol]:
        """Symbols that the default reads, of an implicit one its equation's others."""
        if self.default is None:
            return set()
        default = self.default.equation if isinstance(self.default, Root) else self.default
        return default.free_symbols - {self.symbol}

    def inside(self, share: Rational) -> Expr:
        """The number at this share of the way through the interval.

        In a half-infinite interval it lies this far from the finite end; in an infinite one it is 2*share - 1.
        """
        low, high = self.domain.start, self.domain.end
        if low.is_finite:
            return low + share * (high - low if high.is_finite else 1)
        return high - share if high.is_finite else 2 * share - 1

    def polynomial(self, values: Mapping[Symbol, Expr]) -> Poly:
        """The polynomial, with coprime integer coefficients, whose root in the interval an implicit default is."""
        assert isinstance(self.default, Root)
        numerator = fraction(together(self.default.subs(values).equation))[0]
        try:
            found = Poly(numerator, self.symbol, domain=QQ)
        except (PolynomialError, CoercionFailed) as error:
            raise DeclarationError(
                f"{self.name}: expected a polynomial equation in {self.name} with rational coefficients for its "
                f"default, got {numerator}; give {self.name}"
            ) from error
        return found.clear_denoms(convert=True)[1].primitive()[1] if not found.is_zero else found

    def root(self, values: Mapping[Symbol, Expr]) -> "Rational | Algebraic":
        """The implicit default at exact values of the other parameters.

        Raises DeclarationError unless exactly one root lies in the interval.
        """
        polynomial = self.polynomial(values)
        found = [] if polynomial.is_zero else _roots_inside(polynomial, self.domain)
        if len(found) != 1:
            count = "any number" if polynomial.is_zero else str(len(found))
            raise DeclarationError(
                f"{self.name} has no default here: expected one root of {polynomial.as_expr()} in {self.domain}, "
                f"got {count}; give {self.name}, or declare an interval with one root in it"
            )
        (root,) = found
        if root.rational is not None:
            return Rational(int(root.rational.numerator), int(root.rational.denominator))
        low, high = (Rational(int(end.numerator), int(end.denominator)) for end in (root.low, root.high))
        return Algebraic(tuple(int(c) for c in root.polynomial.all_coeffs()), (low, high))


def _roots_inside(polynomial: Poly, domain: Interval) -> list[RealRoot]:
    """The distinct real roots that lie in an interval."""
    found: list[RealRoot] = []
    for factor in irreducible(polynomial):
        for root in real_roots(factor) if factor.degree() else []:
            if all(_beside(root, end, side, is_open) for end, side, is_open in _ends(domain)):
                found.append(root)
    return found


def _ends(domain: Interval) -> Sequence[tuple[Expr, int, bool]]:
    """The finite ends as (number, 1 for the lower or -1 for the upper end, whether the interval excludes it)."""
    both = ((domain.start, 1, domain.left_open), (domain.end, -1, domain.right_open))
    return [(end, side, bool(is_open)) for end, side, is_open in both if end.is_finite]


def _beside(root: RealRoot, end: Any, side: int, is_open: bool) -> bool:
    """Whether a root lies on the interval's side of one of its ends."""
    number = QQ(int(end.p), int(end.q))
    if root.rational is not None:
        return (root.rational - number) * side > 0 or (root.rational == number and not is_open)
    while root.low <= number <= root.high:
        root.narrow()
    return (root.low - number) * side > 0


@dataclass(frozen=True)
class Family:
    """A family of members: one argument, such as rho_inf, from which some parameters of a scheme follow."""

    argument: Parameter
    values: Mapping[Symbol, Expr]


def positive(e: Expr, parameters: Sequence[Parameter], *, or_zero: bool = False) -> bool:
    """Whether a product of numbers and of factors linear in one parameter is positive in the whole of their intervals.

    or_zero: it may be 0 at their ends. False where it is not seen.
    """
    negative = False
    for factor in Mul.make_args(factored(e)):
        base, exponent = factor.as_base_exp()
        sign = _sign(base, parameters, or_zero=or_zero and exponent.is_positive is True)
        if not sign or not exponent.is_integer:
            return False
        negative ^= sign < 0 and bool(exponent.is_odd)
    return not negative


def _sign(e: Expr, parameters: Sequence[Parameter], *, or_zero: bool) -> int:
    """1 or -1 where an expression linear in one parameter has that sign in the whole of its interval, else 0."""
    if e.is_number:
        return 1 if e > 0 else -1 if e < 0 else 0
    domain = next((p.domain for p in parameters if e.free_symbols == {p.symbol}), None)
    (symbol, *more) = e.free_symbols
    if domain is None or more or e.diff(symbol, 2) != 0:
        return 0
    ends = [
        (e.subs(symbol, end) if end.is_finite else e.diff(symbol) * end, or_zero or open_)
        for end, open_ in ((domain.start, domain.left_open), (domain.end, domain.right_open))
    ]
    for sign in (1, -1):
        if all(sign * x > 0 or (x == 0 and allowed) for x, allowed in ends) and any(sign * x > 0 for x, _ in ends):
            return sign
    return 0


def signed(e: Expr, parameters: Sequence[Parameter]) -> Expr:
    """The expression with parameters that cannot be negative as symbols of which SymPy knows it."""
    known = [p.symbol for p in parameters if p.domain.is_subset(NOT_NEGATIVE)]
    return e.subs({s: Symbol(s.name, nonnegative=True) for s in known}, simultaneous=True)


def require_assumptions(owner: str, taken: str, symbol: Symbol, domain: Interval) -> None:
    """Raises DeclarationError for a symbol of which SymPy assumes what is not true of all numbers that it stands for.

    SymPy writes |k| and sqrt(k**2) as k where it is told that k is positive, before a declaration is made of that.
    """
    for name, where in ASSUMED.items():
        if getattr(symbol, f"is_{name}") and not domain.is_subset(where):
            raise DeclarationError(
                f"{owner}: expected '{symbol}' as a symbol that stands for {taken}, got one that SymPy assumes to be "
                f"{name}; write Symbol('{symbol}')"
            )


def require_parameters(owner: str, given: Any) -> None:
    """Raises DeclarationError for what are no parameters, each with a default in those before it if it has one."""
    listed = isinstance(given, tuple | list)
    parameters = cast(Sequence[Any], given) if listed else ()
    if not listed or not all(isinstance(p, Parameter) for p in parameters):
        raise DeclarationError(
            f"{owner}: expected parameters as a tuple of required(...) and optional(...), got {given!r}; write "
            "parameters=(optional(k, 1),)"
        )
    known = set[Symbol]()
    for p in cast(Sequence[Parameter], parameters):
        if unknown := sorted(p.default_symbols - known, key=str):
            raise DeclarationError(
                f"{owner}: expected the default of {p.name} in parameters declared before it, got '{unknown[0]}'; "
                "declare that first"
            )
        known.add(p.symbol)
