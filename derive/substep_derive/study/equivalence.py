"""Which schemes are the same on a linear oscillator, and at which parameters: found by solving, not typed.

Two schemes share their spectrum if their characteristic polynomials, without roots 0, are proportional at
every Omega. Crosswise multiplied, the coefficients of powers of Omega are polynomial equations in the
parameters. They are solved undamped, by factors and substitution over Q; damping and the matrices themselves are
compared at what was found.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Any

from sympy import (
    QQ,
    Dummy,
    Expr,
    Integer,
    Poly,
    Rational,
    Symbol,
    cancel,
    expand,
    factor_list,
    fraction,
    groebner,
    resultant,
    together,
)

from ..declare.parameter import Root
from ..declare.scheme import Scheme
from ..declare.schemes import declared
from ..declare.symbols import Omega, lam, xi
from ..oscillator.amplification import Amplification
from ..stability.hurwitz import characteristic
from .derivation import derive

Values = dict[Symbol, Expr]
MATRIX, SPECTRUM, UNDAMPED = "matrix", "spectrum", "spectrum at xi = 0"


@dataclass(frozen=True)
class Subject:
    """One side of a comparison: `steps` steps of h/steps of a scheme, in all its parameters or a family's argument."""

    scheme: Scheme
    symbols: tuple[Symbol, ...]
    substituted: Mapping[Symbol, Expr]
    domains: Mapping[Symbol, Any]
    typical: Mapping[Symbol, Expr]
    steps: int = 1

    @classmethod
    def of(cls, scheme: Scheme) -> "Subject":
        """The scheme with all its parameters free, but those that others decide."""
        domains = {p.symbol: p.domain for p in scheme.parameters}
        free = tuple(s for s in scheme.values if s not in scheme.decided)
        return cls(scheme, free, {}, domains, scheme.typical)

    @property
    def families(self) -> "list[Subject]":
        """One subject for each family, with the family's argument as its only parameter."""
        found, scheme = [], self.scheme
        for family in scheme.families:
            argument = family.argument
            rest = {p.symbol: p.default for p in scheme.parameters if p.symbol not in family.values}
            if any(isinstance(default, Root) or not default.is_rational_function() for default in rest.values()):
                continue
            values = dict(family.values)
            for symbol, default in rest.items():
                values[symbol] = default.subs(values)
            x = argument.symbol
            found.append(
                replace(
                    self, symbols=(x,), substituted=values, domains={x: argument.domain}, typical={x: argument.default}
                )
            )
        return found

    @cached_property
    def terms(self) -> int:
        """The number of terms of the polynomial, a measure of what a comparison costs."""
        return sum(len(Poly(c, Omega, *self.symbols).terms()) for c in self.polynomial)

    @property
    def amplification(self) -> Amplification:
        """The amplification of one step, in the scheme's own parameters."""
        return derive(self.scheme).amplification

    @cached_property
    def polynomial(self) -> list[Expr]:
        """The undamped characteristic polynomial without roots 0 and factors free of lambda, from the lowest power."""
        p = Poly(self.coefficients({}, damped=False)[::-1], lam).as_expr()
        kept = [base**k for base, k in factor_list(p)[1] if base.has(lam)]
        return Poly(expand(_product(kept)), lam).all_coeffs()[::-1]

    def coefficients(self, values: Mapping[Symbol, Expr], *, damped: bool) -> list[Expr]:
        """The characteristic polynomial of all the steps at given values, without roots 0, from the lowest power."""
        p = characteristic(self.scheme).as_expr()
        p = _at(_at(p, self.substituted), {**values, Omega: Omega / self.steps, **({} if damped else {xi: Integer(0)})})
        if self.steps > 1:
            power = Dummy("mu")
            p = resultant(p, power - lam**self.steps, lam).subs(power, lam)
        c = Poly(p, lam).all_coeffs()[::-1]
        while c[0] == 0:
            c = c[1:]
        return c

    def matrix(self, values: Mapping[Symbol, Expr]) -> tuple[list[Expr], Expr]:
        """Numerators and denominator of A at given parameters, for every Omega and xi."""
        step = self.amplification.step
        values = {k: e.subs(dict(values)) for k, e in self.substituted.items()} or values
        return [e.subs(dict(values), simultaneous=True) for e in step.N], step.den.subs(dict(values), simultaneous=True)

    def inside(self, values: Mapping[Symbol, Expr], typical: Mapping[Symbol, Expr]) -> bool:
        """Whether values, at typical ones of what they depend on, are in the parameters' intervals."""
        for symbol, value in values.items():
            number = value.subs(typical)
            if number.free_symbols or not number.is_finite or number not in self.domains[symbol]:
                return False
        return True


def _product(factors: Iterable[Expr]) -> Expr:
    total: Expr = Integer(1)
    for one in factors:
        total *= one
    return total


@dataclass(frozen=True)
class Equivalence:
    """left at left_values is right at right_values; values may depend on parameters left free, and hold where
    they lie in the parameters' intervals. Parameters that a family's argument does not determine have their default.

    kind: the same matrix A and state, the same spectrum at every damping ratio, or only undamped. steps: the
    left one's step is that many of the right one's, each h/steps long.
    """

    left: str
    right: str
    left_values: Mapping[str, Expr]
    right_values: Mapping[str, Expr]
    kind: str
    steps: int = 1

    @property
    def text(self) -> str:
        """The equivalence in one line."""
        left, right = (
            name + (f"({', '.join(f'{k} = {v}' for k, v in values.items())})" if values else "")
            for name, values in ((self.left, self.left_values), (self.right, self.right_values))
        )
        return f"{left} = {right}{f' in {self.steps} steps of h/{self.steps}' if self.steps > 1 else ''}: {self.kind}"


# --- polynomial equations --------------------------------------------------------------------------------


def solutions(equations: Sequence[Expr], unknowns: Sequence[Symbol], depth: int = 0) -> Iterator[Values]:
    """Rational solutions; an unknown that a solution leaves out is free, and other symbols are generic.

    Equations are split into factors and used where they are linear in an unknown, with a Groebner basis where
    none is. Irrational solutions are not returned.
    """
    expanded = [expand(e) for e in equations]
    split = sorted((_factors(e, unknowns) for e in expanded if e != 0), key=_difficulty)
    if not split:
        yield {}
        return
    if not split[0]:
        return  # a nonzero constant
    for one in split[0]:
        x = next((x for x in unknowns if Poly(one, x).degree() == 1), None)
        rest = [_product(factors) for factors in split[1:]]
        if x is None:
            if depth == 0 and len(one.free_symbols & set(unknowns)) > 1:
                basis = groebner([one, *rest], *unknowns, order="grevlex")
                yield from solutions(list(basis.exprs), unknowns, 1)
            continue
        a, b = Poly(one, x).all_coeffs()
        value = cancel(-b / a)
        for found in solutions([_with_ratio(e, x, -b, a) for e in rest], [u for u in unknowns if u != x], depth):
            if a.subs(found) != 0 and expand(a) != 0:
                yield found | {x: cancel(value.subs(found))}
        if a.free_symbols & set(unknowns):
            yield from solutions([a, b, *rest], unknowns, depth)


def _factors(equation: Expr, unknowns: Sequence[Symbol]) -> list[Expr]:
    """The irreducible factors that hold an unknown."""
    factors = factor_list(equation)[1] if equation.free_symbols else []
    return [base for base, _ in factors if base.free_symbols & set(unknowns)]


def _difficulty(factors: Sequence[Expr]) -> tuple[int, int, int]:
    """Sort key: first equations without a solution, then those linear in an unknown, then the shortest."""
    linear = all(any(Poly(e, x).degree() == 1 for x in e.free_symbols) for e in factors)
    return (len(factors) > 0, not linear, sum(len(Poly(e).terms()) for e in factors))


def _with_ratio(equation: Expr, x: Symbol, numerator: Expr, denominator: Expr) -> Expr:
    """The equation at x = numerator/denominator, times a power of the denominator."""
    if not equation.has(x):
        return equation
    c = Poly(equation, x).all_coeffs()
    n = len(c) - 1
    return sum((e * numerator ** (n - i) * denominator**i for i, e in enumerate(c)), Integer(0))


def _at(equation: Expr, values: Mapping[Symbol, Expr]) -> Expr:
    """The numerator of an equation's left side at given values."""
    return fraction(together(equation.subs(dict(values), simultaneous=True)))[0]


def multiple(left: Sequence[Expr], right: Sequence[Expr]) -> list[Expr] | None:
    """What has to vanish for left(lambda, Omega) to be s(Omega)*lambda^k*right; linear in left's coefficients.

    right has no factor free of lambda, so that s is a polynomial. None if the degrees exclude it.
    """
    a, b = _aligned([_powers(e) for e in left], [_powers(e) for e in right])
    lead = b[-1]
    first = next(i for i, e in enumerate(lead) if e != 0)
    degree = max(map(len, a)) - max(map(len, b))
    if degree < 0 or len(left) < len(right):
        return None
    scale: list[Expr] = []
    for i in range(degree + 1):
        known = sum((scale[k] * _entry(lead, first + i - k) for k in range(i)), Integer(0))
        scale.append((_entry(a[-1], first + i) - known) / lead[first])
    top = max(map(len, a))
    found = []
    for left_row, right_row in zip(a, b, strict=True):
        for i in range(top):
            shifted = sum((s * _entry(right_row, i - k) for k, s in enumerate(scale)), Integer(0))
            total = _entry(left_row, i) - shifted
            found.append(expand(total) if lead[first].is_number else _at(total, {}))
    return [e for e in found if e != 0]


def _powers(e: Expr) -> list[Expr]:
    """Coefficients of powers of Omega from the lowest."""
    return Poly(e, Omega).all_coeffs()[::-1]


def _entry(row: Sequence[Expr], i: int) -> Expr:
    return row[i] if 0 <= i < len(row) else Integer(0)


def _aligned(left: Sequence[Any], right: Sequence[Any]) -> tuple[list[Any], list[Any]]:
    """Both with as many coefficients as the longer one, filled up with zeros at the lowest powers."""
    n = max(len(left), len(right))
    zero: Any = [Integer(0)] if isinstance(left[0], list) else Integer(0)
    return [zero] * (n - len(left)) + list(left), [zero] * (n - len(right)) + list(right)


def crossed(left: Sequence[Expr], right: Sequence[Expr]) -> list[Expr]:
    """Differences that vanish where two polynomials in lambda agree but for roots 0 and a factor."""
    a, b = _aligned(left, right)
    return [a[-1] * y - b[-1] * x for x, y in zip(a[:-1], b[:-1], strict=True)]


def vanish(expressions: Sequence[Expr]) -> bool:
    """Whether all expressions are identically 0; a value at one point may refute it without expanding them."""
    symbols = sorted({s for e in expressions for s in e.free_symbols}, key=str)
    point = {s: Rational(7 * k + 5, 11 * k + 13) for k, s in enumerate(symbols)}
    if any(e.subs(point) != 0 for e in expressions):
        return False
    field = QQ.frac_field(*symbols) if symbols else QQ
    return all(not field.from_sympy(e) for e in expressions)


# --- the search ------------------------------------------------------------------------------------------


def equivalences(
    schemes: Iterable[Scheme] | None = None, *, steps: Sequence[int] = (1, 2), largest: int = 2500
) -> Iterator[Equivalence]:
    """All pairs found among the schemes, those of the catalogue unless others are given; each when it is found.

    Raises DeclarationError for a scheme whose equations are dependent.
    A family's parameters are solved for as functions of another one's, or, for two of one parameter each, both at
    once. `steps`: also one step against several smaller ones of a scheme without parameters and with two
    eigenvalues. Pairs with more than `largest` products of terms are left out; with 10**9 it takes minutes.
    """
    distinct: list[Subject] = []
    for scheme in declared() if schemes is None else schemes:
        subject = Subject.of(scheme)
        alike = (s for s in distinct if s.symbols == subject.symbols and s.polynomial == subject.polynomial)
        twin = next((s for s in alike if same_matrix(s, subject, {}, {})), None)
        if twin is None:
            distinct.append(subject)
        else:
            own = {s.name: s for s in subject.symbols}
            yield Equivalence(twin.scheme.name, scheme.name, own, own, MATRIX)
    named = [subject for s in distinct for subject in s.families]
    few = [s for s in [*distinct, *named] if len(s.symbols) <= 2]
    pairs = list(combinations(distinct, 2))
    pairs += [(a, b) for a in named for b in few if a.scheme is not b.scheme]
    pairs += [(a, b) for a, b in combinations(named, 2) if a.scheme is not b.scheme]
    for a, b in pairs if 1 in steps else ():
        if a.terms * b.terms > largest and min(len(a.symbols), len(b.symbols)) > 1:
            continue
        yield from compare(a, b)
    for k in steps:
        small = [replace(s, steps=k) for s in distinct if k > 1 and len(s.polynomial) == 3 and not s.symbols]
        yield from (e for b in small for a in distinct if a.scheme is not b.scheme for e in compare(a, b))


def same_matrix(a: Subject, b: Subject, left_values: Values, right_values: Values) -> bool:
    """Whether two subjects have the same state and the same amplification matrix at these parameters."""
    if b.steps > 1 or a.scheme.state != b.scheme.state:
        return False
    (left, d), (right, e) = a.matrix(left_values), b.matrix(right_values)
    return vanish([x * e - y * d for x, y in zip(left, right, strict=True)])


def compare(a: Subject, b: Subject) -> list[Equivalence]:
    """The parameters at which two subjects share their spectrum."""
    if len(a.symbols) < len(b.symbols):
        a, b = (b, a) if b.steps == 1 else (a, b)
    other = {s: Dummy(s.name) for s in b.symbols}
    left, right = a.polynomial, [c.subs(other) for c in b.polynomial]
    found: list[Equivalence] = []
    if len(b.symbols) <= 2 and (equations := multiple(left, right)) is not None:
        found = _pairs(a, b, equations, a.symbols, other)
    if not found and len(a.symbols) == len(b.symbols) == 1:
        equations = [c for e in crossed(left, right) for c in _powers(expand(e)) if c != 0]
        found = _pairs(a, b, equations, (*a.symbols, *other.values()), other)
    return found


def _pairs(
    a: Subject, b: Subject, equations: Sequence[Expr], unknowns: Sequence[Symbol], other: Any
) -> list[Equivalence]:
    """Solutions that lie in the parameters' intervals, as equivalences."""
    found = []
    free_names = {dummy: symbol for symbol, dummy in other.items()}
    for values in solutions(equations, unknowns):
        left_values: Values = dict(zip(a.symbols, a.symbols, strict=True)) | {
            s: e for s, e in values.items() if s in a.symbols
        }
        right_values: Values = dict(other) | {s: values[d] for s, d in other.items() if d in values}
        typical = {**a.typical, **{d: b.typical[s] for s, d in other.items()}}
        if _at(a.polynomial[-1], left_values) == 0:
            continue
        if not (a.inside(left_values, typical) and b.inside(right_values, typical)):
            continue
        shown = [{s.name: e.subs(free_names) for s, e in found_at.items()} for found_at in (left_values, right_values)]
        one = Equivalence(a.scheme.name, b.scheme.name, *shown, _kind(a, b, left_values, right_values), b.steps)
        if one not in found:
            found.append(one)
    return found


def _kind(a: Subject, b: Subject, left_values: Values, right_values: Values) -> str:
    """How far two subjects agree that share their undamped spectrum."""
    if not vanish(crossed(a.coefficients(left_values, damped=True), b.coefficients(right_values, damped=True))):
        return UNDAMPED
    return MATRIX if same_matrix(a, b, left_values, right_values) else SPECTRUM
