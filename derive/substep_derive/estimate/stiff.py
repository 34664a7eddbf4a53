"""What a step holds as rational functions of Omega, at one damping ratio: how an estimate grows on stiff components.

A value grows like Omega^k if that is how it compares, as Omega -> oo, with the state of the step, displacements counted
as u, velocities as v/omega and accelerations as a/omega^2.
"""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from sympy import QQ, Expr, Matrix, Symbol, eye, oo

from ..algebra import rational
from ..declare.scheme import Scheme
from ..declare.symbols import knot, knot_of, successor
from ..oscillator.evaluation import Evaluation
from .held import END, HALVED, START, Step, earlier

Row = list[dict[int, Any]]  # for each symbol of the state, power of Omega -> number


def kind_of(symbol: Symbol) -> int:
    """0, 1, 2 for a displacement, velocity, acceleration."""
    return "uva".index((knot_of(symbol) or ("u", ""))[0])


@cache
def held_rows(scheme: Scheme) -> tuple[dict[Symbol, Matrix], Expr]:
    """Symbol -> numerators of its row over the state, times its power of h; and their common denominator."""
    step = Step.of(scheme)
    n, m = len(step.unknowns), len(step.state)
    solution, den = rational.solve(step.matrix[:, :n], -step.matrix[:, n : n + m])
    rows = {s: solution[i, :] for i, s in enumerate(step.unknowns)}
    return {s: den * eye(m)[j, :] for j, s in enumerate(step.state)} | rows, den


class Growth:
    """Rows of a step's values at numbers for the parameters and the damping ratio."""

    def __init__(self, evaluation: Evaluation, damping: Any) -> None:
        self.state = evaluation.scheme.state
        self.one = evaluation.field.domain.one
        rows, den = held_rows(evaluation.scheme)

        def powers(e: Expr) -> dict[int, Any]:
            return {power: c for (power, _), c in evaluation.coefficients(e, damping).items()}

        self.den = powers(den)
        self.rows: dict[Symbol, Row] = {s: [powers(e) for e in row] for s, row in rows.items()}
        self.step = [self.rows[successor(s)] for s in self.state]
        u, v, _ = knot(0)
        self.starts_from = (
            u in self.state
            and v in self.state
            and self.rows[END.u] == self.rows.get(successor(u))
            and (self.rows[END.v] == self.rows.get(successor(v)))
        )
        if self.starts_from:
            at_u, at_v = self.state.index(u), self.state.index(v)
            two = damping * 2
            row: Row = [{} for _ in self.state]
            row[at_u] = {power + 2: -c for power, c in self.den.items()}
            row[at_v] = {power + 1: -c * two for power, c in self.den.items() if two}
            self.rows[START.a] = row

    def _through(self, row: Row, step: Sequence[Row]) -> Row:
        found: Row = [{} for _ in self.state]
        for j, factor in enumerate(row):
            for k, entry in enumerate(step[j]):
                for p, x in factor.items():
                    for q, y in entry.items():
                        found[k][p + q] = found[k].get(p + q, 0 * self.one) + x * y
        return found

    def _times(self, row: Row, den: Mapping[int, Any]) -> Row:
        found: Row = []
        for entry in row:
            product: dict[int, Any] = {}
            for p, x in entry.items():
                for q, y in den.items():
                    product[p + q] = product.get(p + q, 0 * self.one) + x * y
            found.append(product)
        return found

    def columns(self, symbols: Sequence[Symbol]) -> tuple[list[Row], int]:
        """A row for each symbol, over the same denominator, and the denominator's degree.

        Over the state at t_n, or, if one of the symbols belongs to the step before, over that at t_n - h.
        """
        degree = max(self.den)
        if HALVED.u in symbols or HALVED.v in symbols:
            return self._with_halved(symbols)
        if all(s in self.rows for s in symbols):
            return [self.rows[s] for s in symbols], degree
        before = {earlier(s): row for s, row in self.rows.items() if s != START.a}
        rows = [
            self._through(self.rows[s], self.step) if s in self.rows else self._times(before[s], self.den)
            for s in symbols
        ]
        return rows, 2 * degree

    def _with_halved(self, symbols: Sequence[Symbol]) -> tuple[list[Row], int]:
        half = self.one * QQ(1, 2)

        def at_half(row: Row, kind: int) -> Row:
            scale = [half ** kind_of(s) * 2**kind for s in self.state]
            return [{p: c * half**p * x for p, c in entry.items()} for entry, x in zip(row, scale, strict=True)]

        den = {p: c * half**p for p, c in self.den.items()}
        step = [at_half(row, kind_of(s)) for s, row in zip(self.state, self.step, strict=True)]
        twice = {
            halved: self._times(self._through(at_half(self.rows[end], k), step), self.den)
            for k, (halved, end) in enumerate(((HALVED.u, END.u), (HALVED.v, END.v)))
        }
        square = self._times([den], den)[0]
        rows = [twice[s] if s in twice else self._times(self.rows[s], square) for s in symbols]
        return rows, 3 * max(self.den)

    def of(self, symbols: Sequence[Symbol], factors: Sequence[Any]) -> int:
        """The power of Omega with which a combination grows; a negative one is possible."""
        rows, degree = self.columns(symbols)
        found = []
        for k, s in enumerate(self.state):
            total: dict[int, Any] = {}
            for factor, row in zip(factors, rows, strict=True):
                for power, c in row[k].items():
                    total[power] = total.get(power, 0 * self.one) + factor * c
            found += [power + kind_of(s) - degree for power, c in total.items() if c]
        return max(found, default=-oo)

    def excess(self, rows: Sequence[Row], degree: int, limit: int) -> list[list[Any]]:
        """Linear conditions on the factors of the rows under which their sum grows no faster than Omega^limit."""
        conditions = []
        for k, s in enumerate(self.state):
            highest = max((p for row in rows for p in row[k]), default=0)
            for power in range(degree + limit - kind_of(s) + 1, highest + 1):
                conditions.append([row[k].get(power, 0 * self.one) for row in rows])
        return conditions
