"""A scheme with an exact value for each of its parameters, and for the damping ratio, all in one field."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from sympy import Expr, Rational, Symbol, cancel

from ..algebra.algebraic import Algebraic, Field, generator
from ..algebra.exact_number import exact_number
from .catalogue import find
from .errors import DeclarationError
from .parameter import Parameter, Root
from .scheme import TOLERANCE, Scheme, both_given, divided_by_zero


@dataclass(frozen=True)
class ParameterSet:
    """A scheme with a value for every parameter and for xi (None: xi stays a symbol), all in one field K."""

    scheme: Scheme
    values: Mapping[Symbol, Expr]
    damping: Expr | None
    field: Field

    @classmethod
    def of(cls, scheme: str | Scheme, damping: Any, given: Mapping[str, Any]) -> "ParameterSet":
        """Given values, defaults for the rest. Raises DeclarationError, ValueError, TypeError as `certify` does."""
        declared = find(scheme)
        numbers = _Numbers()
        number = None if damping is None else numbers.expression(damping)
        check_damping(declared, number)
        constant = declared.constant
        own = {} if constant is None else {constant: numbers.expression(constant.number)}
        values = _given(declared, given, numbers)
        decided = {s: (by, cancel(e.subs(by, values[by]))) for s, (by, e) in declared.decided.items() if by in values}
        stated = {s: values[s] for s in decided if s in values}
        values |= {s: value for s, (_, value) in decided.items()}
        for parameter in declared.parameters:
            if parameter.symbol not in values:
                values[parameter.symbol] = _default(declared, parameter, values, numbers)
        field = Field(numbers.found)
        for symbol, value in stated.items():
            difference = field.number(values[symbol]) - field.number(value)
            if any(field.sign(sign * difference - field.number(TOLERANCE)) > 0 for sign in (1, -1)):
                raise both_given(declared.name, symbol, decided[symbol][0], value, values[symbol])
        for parameter in declared.parameters:
            _check_inside(declared, parameter, values[parameter.symbol], field)
        for e in declared.denominators:
            at = e.xreplace(values)
            if at.is_finite is False or not field.number(at):
                raise divided_by_zero(declared.name, e, values)
        if number is not None and field.sign(field.number(number)) < 0:
            raise ValueError(f"expected a damping ratio xi >= 0, got {damping}")
        return cls(declared, own | {s: values[s] for s in declared.values}, number, field)

    def damped(self, damping: Any) -> "ParameterSet":
        """The same parameters at another xi. Raises ValueError for a second algebraic number."""
        numbers = _Numbers(self.field.r)
        number = numbers.expression(damping)
        check_damping(self.scheme, number)
        field = self.field if numbers.found is self.field.r else Field(numbers.found)
        return replace(self, damping=number, field=field)

    def public(self, value: Expr) -> Rational | Algebraic:
        """A number of the field as users meet it."""
        if isinstance(value, Rational):
            return value
        assert self.field.r is not None
        return Algebraic(self.field.r.coefficients, self.field.r.interval, value)

    @property
    def parameters(self) -> dict[str, Rational | Algebraic]:
        """Name -> value, as users meet it."""
        return {s.name: self.public(self.values[s]) for s in self.scheme.values}

    @property
    def title(self) -> str:
        """One line: the scheme, the values, and the definition of r if a value depends on it."""
        values = {s.name: v for s, v in self.values.items()} | ({} if self.damping is None else {"xi": self.damping})
        line = ", ".join([self.scheme.name, *(f"{name} = {value}" for name, value in values.items())])
        return line if self.field.r is None else f"{line}, where {self.field.r.definition}"


def check_damping(scheme: Scheme, damping: Expr | None) -> None:
    """Raises DeclarationError for a damping ratio that is not 0 and a scheme that takes none."""
    if damping is not None and damping != 0 and not scheme.takes_damping:
        raise DeclarationError(
            f"{scheme.name} is a scheme for u'' = g(t, u), without damping: expected xi = 0, got {damping}; "
            "take xi = 0 or another scheme"
        )


class _Numbers:
    """Exact numbers as expressions; remembers the one algebraic number they may be functions of."""

    def __init__(self, found: Algebraic | None = None) -> None:
        self.found = found

    def expression(self, value: Any) -> Expr:
        if not isinstance(value, Algebraic):
            return exact_number(value)
        if self.found is None:
            self.found = value
        elif not self.found.shares_generator(value):
            raise ValueError(
                f"two algebraic numbers in one certificate, {self.found} and {value}; "
                f"express all values by a single one, or give one of them as a rational"
            )
        return value.value


def _given(scheme: Scheme, given: Mapping[str, Any], numbers: _Numbers) -> dict[Symbol, Expr]:
    """Values of the scheme's own parameters that follow from those given, which may be arguments of families."""
    own = {p.name: p.symbol for p in scheme.parameters}
    families = {family.argument.name: family for family in scheme.families}
    algebraic = {k: v for k, v in given.items() if isinstance(v, Algebraic) and (k in own or k in families)}
    values: dict[Symbol, Expr] = dict(scheme.exact({k: v for k, v in given.items() if k not in algebraic}))
    for key, value in algebraic.items():
        number = numbers.expression(value)
        if key in own:
            following = {own[key]: number}
        else:
            family = families[key]
            _check_inside(scheme, family.argument, number, Field(numbers.found))
            following = {s: e.subs(family.argument.symbol, number) for s, e in family.values.items()}
        if twice := [s for s in following if s in values]:
            raise DeclarationError(f"{scheme.name}: {twice[0]} is given twice, by itself and by a family")
        values |= following
    return values


def _check_inside(scheme: Scheme, parameter: Parameter, value: Expr, field: Field) -> None:
    if not field.inside(value, parameter.domain):
        what = value if field.r is None else f"{value} ({field.r.definition})"
        raise DeclarationError(
            f"{scheme.name}: {parameter.name} = {what} lies outside {parameter.written}; choose a value inside"
        )


def _default(scheme: Scheme, parameter: Parameter, values: Mapping[Symbol, Expr], numbers: _Numbers) -> Expr:
    default = parameter.default.subs(values)
    if isinstance(default, Root):
        if default.equation.free_symbols != {parameter.symbol}:
            raise ValueError(f"{scheme.name}: give {parameter.name}; its default is a root of {default.equation}")
        found = parameter.root(values)
        return found if isinstance(found, Rational) else numbers.expression(found)
    if default.is_finite is False:
        raise DeclarationError(
            f"{scheme.name}: the default of {parameter.name} is {default} here; give {parameter.name}"
        )
    if default.is_rational_function(generator) and (default.free_symbols or default.is_Rational):
        return default
    if default.free_symbols:
        raise ValueError(f"{scheme.name}: give {parameter.name}; its default {default} is no rational function of r")
    return numbers.expression(Algebraic.of(default))
