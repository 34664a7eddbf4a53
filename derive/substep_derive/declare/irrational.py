"""Irrational numbers in a table -> one parameter whose default is a root, and all entries rational in it."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

from sympy import (
    Add,
    Expr,
    Integer,
    Interval,
    IsomorphismFailed,
    Mul,
    NotAlgebraic,
    Poly,
    Pow,
    Rational,
    Symbol,
    SympifyError,
    minimal_polynomial,
    primitive_element,
    sympify,
    to_number_field,
)

from ..algebra.algebraic import Algebraic, RealRoot
from .errors import DeclarationError
from .parameter import Parameter, Root

theta = Symbol("theta")
NARROW = Rational(1, 2**40)  # length of theta's interval: the table is what it is at the root alone

Table = Sequence[Sequence[Any]]


def generated(
    name: str, parameters: tuple[Parameter, ...], tables: Iterable[Table]
) -> tuple[tuple[Parameter, ...], list[Table]]:
    """(parameters, tables) with theta in place of irrational numbers; both as given where there are none.

    theta is the number that occurs most often, if all others follow from it, or else a sum of multiples of them
    (a primitive element).

    Raises DeclarationError for a number that is not real or not algebraic, and where a parameter's default is an
    irrational number already.
    """
    given = [[[_read(x) for x in row] for row in table] for table in tables]
    found = Counter(e for table in given for row in table for x in row for e in _irrational(x))
    if not found:
        return parameters, [*given]
    listed = ", ".join(map(str, found))
    if any(isinstance(p.default, Root) or p.symbol == theta for p in parameters):
        raise DeclarationError(
            f"{name}: expected irrational numbers written as rational functions of the parameter whose default is a "
            f"root, got {listed} besides; write them so, or leave that parameter out"
        )
    try:
        number, values = _generator([e for e, _ in found.most_common()])
        root = Algebraic.of(number)
    except (NotAlgebraic, NotImplementedError, ValueError, TypeError) as error:
        raise DeclarationError(
            f"{name}: expected exact entries, irrational ones real and algebraic such as sqrt(2), cbrt(2) or "
            f"cos(pi/18), got {listed}; let any other number be a Parameter"
        ) from error
    exact: list[Table] = [[[_replaced(x, values) for x in row] for row in table] for table in given]
    if number.is_Rational:  # all of them are only written with radicals
        return parameters, exact
    declared = Parameter(theta, _around(root), Root(root.polynomial.as_expr(theta)))
    return (*parameters, declared), exact


def _read(value: Any) -> Any:
    try:
        return sympify(value, strict=True)
    except SympifyError:
        return value  # which is refused where the table is read


def _irrational(e: Any) -> list[Expr]:
    """The irrational numbers in an entry: itself, or those that its symbols are combined with."""
    if not isinstance(e, Expr) or e.is_Rational or e.is_Symbol or any(part.is_Float for part in e.atoms()):
        return []
    if e.is_number:
        return [e]
    return [number for part in e.args for number in _irrational(part)] if isinstance(e, Add | Mul | Pow) else []


def _replaced(e: Any, values: dict[Expr, Expr]) -> Any:
    if not isinstance(e, Expr) or not e.args:
        return e
    return values[e] if e in values else e.func(*(_replaced(part, values) for part in e.args))


def _generator(numbers: list[Expr]) -> tuple[Expr, dict[Expr, Expr]]:
    """(the number that theta stands for, each number as a polynomial in theta)."""
    rational = {e: -p.TC() / p.LC() for e in numbers if (p := _minimal(e)).degree() == 1}
    others = [e for e in numbers if e not in rational]
    if not others:
        return Integer(0), rational
    for e in others:
        try:
            return e, rational | {x: _in(x, e) for x in others}
        except IsomorphismFailed:
            continue
    weights = primitive_element(others, theta)[1]
    combined = Add(*(w * e for w, e in zip(weights, others, strict=True)))
    return combined, rational | {x: _in(x, combined) for x in others}


def _minimal(number: Expr) -> Poly:
    return Poly(minimal_polynomial(number, theta), theta)


def _in(number: Expr, generator: Expr) -> Expr:
    """The number as a polynomial in theta, which stands for the generator. Raises IsomorphismFailed."""
    coefficients = to_number_field(number, generator).coeffs()
    return Add(*(c * theta**k for k, c in enumerate(reversed(coefficients))))


def _around(number: Algebraic) -> Interval:
    """A short interval with the number in it."""
    root = RealRoot(number.polynomial, *number.interval)
    while (root.high - root.low) * NARROW.q > NARROW.p:
        root.narrow()
    return Interval(*(Rational(int(end.numerator), int(end.denominator)) for end in (root.low, root.high)))
