"""A step of a scheme applied to expansions: its equations, solved weight by weight by the inverse at h = 0."""

from collections.abc import Sequence
from math import factorial
from typing import Any, TypeVar

from sympy import QQ, Symbol

from ..algebra.rational import SingularMatrix, affine_solutions, matrix_inverse
from ..declare.errors import InconsistentScheme
from ..declare.symbols import h, successor
from ..oscillator.evaluation import Evaluation
from .expansion import Expansion, Key, load, of_g
from .held import END, HeldStep

Matrix = list[list[Any]]
T = TypeVar("T")


class ExpandedStep:
    """The step in numbers of the evaluation's field.

    rows: its equations, each as (column, power of h*c, power of h^2*k, number), in columns for the unknowns, the state,
    the loads and the forces. A step of length 0 is a linear map: inverse solves its equations for the unknowns; free:
    these from the state; new: the new state from it. rest, moving: the states that it leaves at rest (u = 1), and that
    it moves uniformly (u = 1 and h*v = 1 at its end). top: the weight up to which loads are expanded; damped: whether c
    is not 0.
    """

    def __init__(self, evaluation: Evaluation, top: int, damped: bool) -> None:
        self.evaluation, self.top, self.damped = evaluation, top, damped
        self.held = HeldStep.of(evaluation.scheme)
        self.one, self.zero = evaluation.field.domain.one, evaluation.field.domain.zero
        self.rows = [self._row(i) for i in range(self.held.matrix.rows)]
        self._without_length()
        self._instants()

    def _row(self, i: int) -> list[tuple[int, int, int, Any]]:
        row: list[tuple[int, int, int, Any]] = []
        for column, entry in enumerate(self.held.matrix.row(i)):
            # Omega^a xi^b = (h*c/2)^b (h^2*k)^((a-b)/2)
            found = self.evaluation.coefficients(entry).items() if entry != 0 else ()
            kept = (((a, b), value) for (a, b), value in found if self.damped or not b)
            row += [(column, b, (a - b) // 2, value * QQ(1, 2**b)) for (a, b), value in kept]
        return row

    def at_rest(self, row: list[tuple[int, int, int, Any]], column: int) -> Any:
        """The number of a column in a row where the step has no length, so that neither c nor k acts."""
        return next((value for at, i, j, value in row if at == column and i == j == 0), self.zero)

    def _without_length(self) -> None:
        """The step of length 0, in which neither c nor k acts."""
        step, one, zero = self.held, self.one, self.zero
        n, m = len(step.unknowns), len(step.state)
        leading = [[self.at_rest(row, c) for c in range(n + m)] for row in self.rows]
        self.inverse = self.inverted(
            [row[:n] for row in leading], f"{step.scheme.name}: a step of length 0 is not determined"
        )
        self.free = [
            [-sum((x * leading[k][n + j] for k, x in enumerate(row)), zero) for j in range(m)] for row in self.inverse
        ]
        identity = [[one if i == j else zero for j in range(m)] for i in range(m)]
        self.new = [self.after(s, self.free, identity) for s in step.state]
        u, v = (self.free[step.unknowns.index(s)] for s in END[:2])
        less = [[x - y for x, y in zip(*rows, strict=True)] for rows in zip(self.new, identity, strict=True)]
        self.rest = self._mode([*less, u, v], [zero] * m + [one, zero])
        self.moving = self._mode([*less, u, v], [*self.rest, one, one])

    def after(self, s: Symbol, unknowns: Sequence[T], state: Sequence[T]) -> T:
        """What stands for a symbol of the state after a step: among values of the unknowns, or of the state before."""
        new = successor(s)
        step = self.held
        return unknowns[step.unknowns.index(new)] if new in step.unknowns else state[step.state.index(new)]

    def inverted(self, matrix: Matrix, reason: str) -> Matrix:
        """The inverse. Raises InconsistentScheme with the reason where there is none."""
        try:
            return matrix_inverse(matrix, self.evaluation.field.domain)
        except SingularMatrix as error:
            raise InconsistentScheme(reason) from error

    def _mode(self, rows: Matrix, right: list[Any]) -> list[Any]:
        found = affine_solutions(rows, right, len(rows[0]), self.evaluation.field.domain)
        if found is None or found[1]:
            raise InconsistentScheme(f"{self.held.scheme.name}: it does not keep rest and uniform motion as they are")
        return found[0]

    def _instants(self) -> None:
        """The times at which loads and forces are taken, the latter by the displacement in uniform motion."""
        step, number = self.held, self.evaluation.number
        m = len(step.state)
        motion = {s: self.moving[j] for j, s in enumerate(step.state)}
        for i, s in enumerate(step.unknowns):
            motion[s] = sum((self.free[i][j] * self.moving[j] for j in range(m)), self.zero)
        self.times = [number(tau) for tau in step.stencil]
        self.force_times = [
            [  # motion has h*v and h^2*a, so that h is 1 in what multiplies them
                sum((number(e.diff(s).subs(h, 1)) * motion[s] for s in e.free_symbols if s in motion), self.zero)
                for e in arguments
            ]
            for arguments in step.forces
        ]

    def _load(self, k: int, later: int) -> Expansion:
        """h^2 f at the k-th instant."""
        found, power = Expansion(), self.one
        for m in range(self.top - 1):
            found.add(load(m, self.one, self.damped), power, 0, 0, self.top)
            power = power * (self.times[k] + later) * QQ(1, m + 1)
        return found

    def _force(self, k: int, later: int) -> Expansion:
        """h^2 g at the k-th argument of N; the mean over the time between two, for a discrete gradient."""
        found, times = Expansion(), [time + later for time in self.force_times[k]]
        powers = [self.one for _ in times]
        for m in range(self.top - 1):
            if len(times) == 1:
                value = powers[0]
            else:  # the divided difference of t^(m+1)/(m+1)!
                value, (a, b) = self.zero, times
                power = self.one
                for _ in range(m + 1):  # a^m + a^(m-1) b + ... + b^m
                    value, power = value * a + power, power * b
                value = value * reciprocal_factorial(m + 1)
            if value:
                found.terms[0, 0, of_g(m)] = value
            powers = [power * time * QQ(1, m + 1) for power, time in zip(powers, times, strict=True)]
        return found

    def advanced(self, state: list[Expansion], top: int, later: int = 0) -> list[Expansion]:
        """The unknowns after a step from a state, which is that at t_n + later*h."""
        n = len(self.held.unknowns)
        loads = [self._load(k, later) for k in range(len(self.held.stencil))]
        given = [*state, *loads, *(self._force(k, later) for k in range(len(self.held.forces)))]
        rest = [Expansion() for _ in self.rows]
        for row, right in zip(self.rows, rest, strict=True):
            for column, i, j, value in row:
                if column >= n:
                    right.add(given[column - n], -value, i, j, top)
        found = [Expansion() for _ in range(n)]
        for w in range(top + 1):
            layer = applied(self.inverse, [right.at_weight(w) for right in rest])
            for x, part in zip(found, layer, strict=True):
                x.terms |= part.terms
            for row, right in zip(self.rows, rest, strict=True):
                for column, i, j, value in row:
                    if column < n and (i or j):
                        right.add(layer[column], -value, i, j, top)
        return found


def applied(matrix: Matrix, right: list[dict[Key, Any]]) -> list[Expansion]:
    """A matrix times a vector of terms."""
    found = [Expansion() for _ in matrix]
    for key in {key for part in right for key in part}:
        column = [(k, part[key]) for k, part in enumerate(right) if key in part]
        for x, row in zip(found, matrix, strict=True):
            # a sum of nothing is no number of a field
            products = [row[k] * c for k, c in column if row[k]]
            if products and (value := sum(products[1:], products[0])):
                x.terms[key] = value
    return found


def reciprocal_factorial(n: int) -> Any:
    """1/n!."""
    return QQ(1, factorial(n))
