"""Polynomials and rational functions of a scheme's parameters -> numbers of one field.

At a parameter set the field is Q, or Q(r) where a parameter is irrational; with parameters left free it is the field of
rational functions in them. Nothing is rounded, so that a number that vanishes is exactly 0.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from sympy import Expr, Symbol, nan, sympify, zoo

from ..algebra.algebraic import Field
from ..algebra.expanded import terms
from ..algebra.rational import RationalFunctions
from ..declare.errors import DeclarationError
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
        """A rational function of the parameters as a number of the field.

        Raises DeclarationError where it divides by 0, as where relations do not determine what they define.
        """
        if value not in self._found:
            found = sympify(value).xreplace(self.values)
            if found.has(zoo, nan):
                given = ", ".join(f"{s} = {number}" for s, number in self.values.items())
                raise DeclarationError(
                    f"{self.scheme.name}: expected parameters at which {value} is finite, got {given}; choose others"
                )
            self._found[value] = self.field.number(found)
        return self._found[value]

    @cached_property
    def _found(self) -> dict[Expr, Any]:
        return {}

    @cached_property
    def _numbers(self) -> dict[Symbol, Any]:
        return {symbol: self.field.number(value) for symbol, value in self.values.items()}

    def coefficients(self, polynomial: Expr, damping: Any | None = None) -> dict[tuple[int, int], Any]:
        """(power of Omega, power of xi) -> number, of a polynomial in both and in the parameters, zeros left out.

        If damping, an element of the field, is given, it replaces xi, whose power is then always 0.
        """
        if polynomial not in self._known:
            self._known[polynomial] = self._read(polynomial)
        found = self._known[polynomial]
        if damping is None:
            return dict(found)
        at_damping: dict[tuple[int, int], Any] = {}
        powers = [self.field.domain.one]
        for (at_Omega, at_xi), value in found.items():
            while len(powers) <= at_xi:
                powers.append(powers[-1] * damping)
            share = value * powers[at_xi] if at_xi else value
            at_damping[at_Omega, 0] = at_damping[at_Omega, 0] + share if (at_Omega, 0) in at_damping else share
        return {key: value for key, value in at_damping.items() if value}

    @cached_property
    def _known(self) -> dict[Expr, dict[tuple[int, int], Any]]:
        return {}

    def _read(self, polynomial: Expr) -> dict[tuple[int, int], Any]:
        symbols, domain = [*self._numbers, Omega, xi], self.field.domain
        powers: list[list[Any]] = [[domain.one] for _ in self._numbers]
        factors = list(zip(powers, self._numbers.values(), strict=True))
        found: dict[tuple[int, int], Any] = {}
        for monomial, c in terms(polynomial, symbols).items():
            *own, at_Omega, at_xi = monomial
            value = domain.convert(c)
            for (table, number), power in zip(factors, own, strict=True):
                while len(table) <= power:
                    table.append(table[-1] * number)
                if power:
                    value = value * table[power]
            key = at_Omega, at_xi
            found[key] = found[key] + value if key in found else value
        return {key: value for key, value in found.items() if value}
