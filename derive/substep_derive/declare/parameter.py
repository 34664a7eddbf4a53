"""Parameters of schemes and scenes: the interval each may lie in, its default, and families of them."""

from collections.abc import Mapping
from dataclasses import dataclass

from sympy import Expr, Interval, Rational, Symbol


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

    The default may be an expression in parameters declared before this one.
    """

    symbol: Symbol
    domain: Interval
    default: Expr | Root

    @property
    def name(self) -> str:
        """The symbol's name."""
        return self.symbol.name


@dataclass(frozen=True)
class Family:
    """A way to name a scheme's parameters by one other: argument -> parameters."""

    argument: Parameter
    values: Mapping[Symbol, Expr]


def root_near(equation: Expr, parameter: Parameter) -> Rational:
    """A rational within 1e-40 of the root in the parameter's interval: where only its size matters."""
    low, high = Rational(parameter.domain.start), Rational(parameter.domain.end)
    sign = equation.subs(parameter.symbol, low) > 0
    while high - low > Rational(1, 10**40):
        middle = (low + high) / 2
        inside = (equation.subs(parameter.symbol, middle) > 0) == sign
        low, high = (middle, high) if inside else (low, middle)
    return low
