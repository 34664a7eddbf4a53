"""What a step holds as rational functions of Omega and xi: how an estimate grows on stiff components.

A value grows like Omega^k if that is how it compares, as Omega -> oo, with the state of the step, displacements counted
as u, velocities as v/omega and accelerations as a/omega^2.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from sympy import QQ, Expr, Matrix, Symbol, eye, oo

from ..algebra import rational
from ..declare.scheme import Scheme
from ..declare.symbols import kind_of, knot, successor
from ..oscillator.evaluation import Evaluation
from .held import END, HALVED, START, HeldStep, earlier

Polynomial = dict[tuple[int, int], Any]  # (power of Omega, power of xi) -> number
Row = list[Polynomial]  # one for each symbol of the state


@cache
def held_rows(scheme: Scheme) -> tuple[dict[Symbol, Matrix], Expr]:
    """Symbol -> numerators of its row over the state, times its power of h; and their common denominator."""
    step = HeldStep.of(scheme)
    n, m = len(step.unknowns), len(step.state)
    solution, den = rational.solve(step.matrix[:, :n], -step.matrix[:, n : n + m])
    rows = {s: solution[i, :] for i, s in enumerate(step.unknowns)}
    return {s: den * eye(m)[j, :] for j, s in enumerate(step.state)} | rows, den


@dataclass(frozen=True)
class Rows:
    """A row for each of some symbols, over one denominator; before: over the state one step earlier."""

    rows: list[Row]
    den: Polynomial
    before: bool

    def combined(self, factors: Sequence[Any]) -> Row:
        """The sum of factor * row."""
        found: Row = [{} for _ in self.rows[0]]
        for factor, row in zip(factors, self.rows, strict=True):
            for total, entry in zip(found, row, strict=True):
                for key, c in entry.items():
                    _add(total, key, factor * c)
        return found


class Growth:
    """Rows of a step's values at numbers for the parameters and the damping ratio; None leaves xi a variable."""

    def __init__(self, evaluation: Evaluation, damping: Any | None) -> None:
        self.state = evaluation.scheme.state
        one = self.one = evaluation.field.domain.one
        rows, den = held_rows(evaluation.scheme)
        self.den = evaluation.coefficients(den, damping)
        self.rows: dict[Symbol, Row] = {
            s: [evaluation.coefficients(e, damping) for e in row] for s, row in rows.items()
        }
        self.step = [self.rows[successor(s)] for s in self.state]
        u, v, _ = knot(0)
        # what is reported is the state itself, so that the acceleration at t_n follows from it
        if all(s in self.state and self.rows[end] == self.rows[successor(s)] for s, end in ((u, END.u), (v, END.v))):
            row: Row = [{} for _ in self.state]
            row[self.state.index(u)] = _product({(2, 0): -one}, self.den)
            two: Polynomial = {(1, 1): -2 * one} if damping is None else {(1, 0): -2 * damping}
            row[self.state.index(v)] = _product(two, self.den)
            self.rows[START.a] = row

    def of_symbols(self, symbols: Sequence[Symbol]) -> Rows:
        """A row for each symbol, over the state at t_n, or over that before if one belongs to the step before."""
        if not all(s in self.rows or s in HALVED for s in symbols):
            before = {earlier(s): row for s, row in self.rows.items() if s != START.a}
            rows = [
                self._through(self.rows[s], self.step) if s in self.rows else _times(before[s], self.den)
                for s in symbols
            ]
            return Rows(rows, _product(self.den, self.den), True)
        if any(s in HALVED for s in symbols):
            return self._with_halved(symbols)
        return Rows([self.rows[s] for s in symbols], self.den, False)

    def _through(self, row: Row, step: Sequence[Row]) -> Row:
        """The row over the state before a step, each entry a product of two numerators."""
        found: Row = [{} for _ in self.state]
        for j, factor in enumerate(row):
            for k, entry in enumerate(step[j]):
                for key, c in _product(factor, entry).items():
                    _add(found[k], key, c)
        return found

    def _with_halved(self, symbols: Sequence[Symbol]) -> Rows:
        """Two steps of h/2: Omega/2 in their rows, and h/2 in the scales of the state."""
        half = self.one * QQ(1, 2)

        def at_half(row: Row, kind: int) -> Row:
            scales = [half ** kind_of(s) * 2**kind for s in self.state]
            return [{(p, q): c * half**p * x for (p, q), c in e.items()} for e, x in zip(row, scales, strict=True)]

        den = {(p, q): c * half**p for (p, q), c in self.den.items()}
        step = [at_half(row, kind_of(s)) for s, row in zip(self.state, self.step, strict=True)]
        twice = {
            halved: _times(self._through(at_half(self.rows[end], k), step), self.den)
            for k, (halved, end) in enumerate(zip(HALVED[:2], END[:2], strict=True))
        }
        square = _product(den, den)
        rows = [twice[s] if s in twice else _times(self.rows[s], square) for s in symbols]
        return Rows(rows, _product(square, self.den), False)

    def of(self, symbols: Sequence[Symbol], factors: Sequence[Any]) -> int:
        """The power of Omega with which a combination grows; a negative one is possible."""
        found = self.of_symbols(symbols)
        degree = max(p for p, _ in found.den)
        return max(
            (p + kind_of(s) - degree for s, e in zip(self.state, found.combined(factors), strict=True) for p, _ in e),
            default=-oo,
        )

    def excess(self, found: Rows, limit: int) -> list[list[Any]]:
        """Linear conditions on the factors of the rows under which their sum grows no faster than Omega^limit."""
        conditions, degree, zero = [], max(p for p, _ in found.den), 0 * self.one
        for k, s in enumerate(self.state):
            highest = max((p for row in found.rows for p, _ in row[k]), default=0)
            for power in range(degree + limit - kind_of(s) + 1, highest + 1):
                conditions.append([row[k].get((power, 0), zero) for row in found.rows])
        return conditions


def _add(total: Polynomial, key: tuple[int, int], value: Any) -> None:
    value = total[key] + value if key in total else value
    if value:
        total[key] = value
    else:
        total.pop(key, None)


def _product(one: Mapping[tuple[int, int], Any], other: Mapping[tuple[int, int], Any]) -> Polynomial:
    found: Polynomial = {}
    for (p, q), x in one.items():
        for (r, s), y in other.items():
            _add(found, (p + r, q + s), x * y)
    return found


def _times(row: Row, factor: Polynomial) -> Row:
    return [_product(entry, factor) for entry in row]
