"""Polynomials and rational functions of a scheme's parameters -> numbers of one field.

At a parameter set the field is Q, or Q(r) where a parameter is irrational; with parameters left free it is the field of
rational functions in them. Nothing is rounded, so that a number that vanishes is exactly 0.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from sympy import Expr, Symbol

from ..algebra.algebraic import Field
from ..algebra.expanded import terms
from ..algebra.rational import RationalFunctions
from ..declare.parameter_set import ParameterSet
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, xi
from .amplification import Amplification


@dataclass(frozen=True)
class Evaluation:
    """A scheme with numbers of a field for its parameters; values: each one's number as an expression."""

    scheme: Scheme
    field: Field | RationalFunctions
    values: Mapping[Symbol, Expr]

    @classmethod
    def at(cls, parameters: ParameterSet) -> "Evaluation":
        """The scheme with the values of a parameter set."""
        return cls(parameters.scheme, parameters.field, parameters.values)

    @classmethod
    def at_defaults(cls, scheme: str | Scheme) -> "Evaluation":
        """The scheme with every parameter at its default. Raises DeclarationError, ValueError as `ParameterSet.of`."""
        return cls.at(ParameterSet.of(scheme, None, {}))

    @classmethod
    def free(cls, scheme: Scheme) -> "Evaluation":
        """The scheme with every parameter left free: results hold at almost all values."""
        if scheme.constant is not None and not scheme.values:
            return cls.at_defaults(scheme)
        return cls.symbolic(scheme, scheme.values)

    @classmethod
    def symbolic(cls, scheme: Scheme, symbols: Iterable[Symbol]) -> "Evaluation":
        """The scheme with these symbols as numbers of a field: parameters, and others besides."""
        given = [*symbols]
        own = [] if scheme.constant is None else [scheme.constant]
        return cls(scheme, RationalFunctions(given, scheme.constant), {s: s for s in (*own, *given)})

    @cached_property
    def amplification(self) -> Amplification:
        """The amplification of the scheme, in the symbols of its parameters."""
        return Amplification.of(self.scheme)

    def number(self, value: Expr) -> Any:
        """A rational function of the parameters as a number of the field."""
        return self.field.number(value.subs(self.values, simultaneous=True))

    @cached_property
    def _numbers(self) -> dict[Symbol, Any]:
        return {symbol: self.field.number(value) for symbol, value in self.values.items()}

    def coefficients(self, polynomial: Expr, damping: Any | None = None) -> dict[tuple[int, int], Any]:
        """(power of Omega, power of xi) -> number, of a polynomial in both and in the parameters, zeros left out.

        If damping, an element of the field, is given, it replaces xi, whose power is then always 0.
        """
        symbols, domain = [*self._numbers, Omega, xi], self.field.domain
        numbers = [*self._numbers.values()]
        powers: list[list[Any]] = [[domain.one] for _ in (*numbers, damping)]
        found: dict[tuple[int, int], Any] = {}
        for monomial, c in terms(polynomial, symbols).items():
            *own, at_Omega, at_xi = monomial
            value = domain.convert(c)
            factors = list(zip(powers, numbers, own, strict=False))
            if damping is not None:
                factors.append((powers[-1], damping, at_xi))
            for table, number, power in factors:
                while len(table) <= power:
                    table.append(table[-1] * number)
                value = value * table[power]
            key = at_Omega, at_xi if damping is None else 0
            found[key] = found[key] + value if key in found else value
        return {key: value for key, value in found.items() if value}
