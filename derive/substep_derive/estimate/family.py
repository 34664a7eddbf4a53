"""All combinations of a step's values that equal the leading local error: an affine family, and its default member."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from sympy import Expr, Integer, Symbol, factor

from ..algebra.algebraic import Field, generator
from ..algebra.rational import affine_solutions
from ..declare.errors import DeclarationError
from ..declare.symbols import h, kind_of
from ..oscillator.evaluation import Evaluation
from .expansion import Expansion, weight
from .sparse import reduction, sparsest
from .stiff import Growth

FASTEST = 4  # power of Omega up to which an estimate's growth matters; beyond, the fewest terms decide


@dataclass(frozen=True, eq=False)
class Family:
    """The combinations sum(factor * h^k * symbol), with k = 0, 1, 2 for u, v, a, that equal an error to leading order.

    values: symbol -> its expansion, times its power of h. error: that of u, or of h*v. own: 0 for u, 1 for v, in the
    unit of which expressions are written. top: the power of h up to which both agree, the error's first or a later one.
    """

    evaluation: Evaluation
    values: Mapping[Symbol, Expansion]
    error: Expansion
    own: int
    top: int

    @property
    def symbols(self) -> tuple[Symbol, ...]:
        """What the combinations consist of."""
        return tuple(self.values)

    def system(self, symbols: Iterable[Symbol]) -> tuple[list[list[Any]], list[Any]]:
        """Rows and right sides of the conditions on the factors of these symbols, one for each term up to `top`."""
        zero, parts = self.evaluation.field.domain.zero, [self.values[s] for s in symbols]
        keys = {key for value in (*parts, self.error) for key in value.terms if weight(key) <= self.top}
        ordered = sorted(keys, key=lambda key: (weight(key), key))
        rows = [[value.terms.get(key, zero) for value in parts] for key in ordered]
        return rows, [self.error.terms.get(key, zero) for key in ordered]

    def combination(self, symbols: Sequence[Symbol]) -> Expr | None:
        """A combination of these symbols alone; None where they do not suffice."""
        found = affine_solutions(*self.system(symbols), len(symbols), self.evaluation.field.domain)
        return None if found is None else self.written(symbols, found[0])

    @cached_property
    def _solutions(self) -> tuple[list[Any], list[list[Any]]] | None:
        return affine_solutions(*self.system(self.symbols), len(self.symbols), self.evaluation.field.domain)

    @property
    def empty(self) -> bool:
        """Whether no combination equals the error."""
        return self._solutions is None

    @cached_property
    def particular(self) -> Expr:
        """One member. Raises DeclarationError for an empty family."""
        if self._solutions is None:
            raise DeclarationError(
                f"{self.evaluation.scheme.name}: expected a family with members, got an empty one; ask for more values"
            )
        return self.written(self.symbols, self._solutions[0])

    @cached_property
    def nullspace(self) -> tuple[Expr, ...]:
        """A basis of what can be added: combinations that vanish to the order of the error, relations among them."""
        return () if self._solutions is None else tuple(self.written(self.symbols, v) for v in self._solutions[1])

    def contains(self, expression: Expr) -> bool:
        """Whether an expression, linear in the symbols, is a member."""
        factors = {
            s: expression.diff(s) * h ** (self.own - kind_of(s)) for s in expression.free_symbols & {*self.values}
        }
        remaining = expression - sum(expression.diff(s) * s for s in factors)
        if factor(remaining) != 0 or any(factor(e).has(h) for e in factors.values()):
            return False
        difference = self.error.plus(Expansion(), self.evaluation.field.domain.one)
        for s, e in factors.items():
            difference = difference.plus(self.values[s], -self.evaluation.number(factor(e)))
        return (difference.valuation or 0) > self.top or difference.valuation is None

    def written(self, symbols: Sequence[Symbol], factors: Sequence[Any]) -> Expr:
        """A combination as an expression."""
        total: Expr = Integer(0)
        for s, c in zip(symbols, factors, strict=True):
            total += self.evaluation.field.expression(c) * h ** (kind_of(s) - self.own) * s
        return total if total.has(generator) else factor(total)

    def sparsest(self, growths: Sequence[Growth]) -> tuple[tuple[Symbol, ...], int]:
        """(symbols, growth) of the default: bounded as Omega -> oo, or else growing least, then of fewest terms.

        Among equals more accelerations and velocities, which lose fewer digits than differences of displacements. Only
        for numbers as parameters, and not for an empty family.
        """
        field, symbols = self.evaluation.field, self.symbols
        assert isinstance(field, Field)
        rows, right = self.system(symbols)
        columns = [growth.of_symbols(symbols) for growth in growths]
        system, value = rows, right
        for slower in range(FASTEST):
            bounds = [
                condition
                for growth, entries in zip(growths, columns, strict=True)
                for condition in growth.excess(entries, slower + self.own)
            ]
            bounded = [*rows, *bounds], [*right, *([field.domain.zero] * len(bounds))]
            if affine_solutions(*bounded, len(symbols), field.domain) is not None:
                system, value = bounded
                break
        p, remainder = reduction(field)
        images = list(zip(*([remainder(c) for c in row] for row in system), strict=True))
        found = sparsest(images, [remainder(c) for c in value], p)
        if not found:
            some = affine_solutions(system, value, len(symbols), field.domain)
            assert some is not None
            found = [tuple(k for k, c in enumerate(some[0]) if c)]
        best = min(found, key=lambda support: (-sum(kind_of(symbols[k]) for k in support), support))
        chosen = tuple(symbols[k] for k in best)
        factors = affine_solutions(*self.system(chosen), len(chosen), field.domain)
        assert factors is not None
        return chosen, max(growth.of(chosen, factors[0]) for growth in growths) - self.own
