"""Scheme -> its modified equation: the differential equation that its numerical motion solves, to any power of h.

A step takes the reported displacement and velocity u, h v to others; a smooth one from u_n, v_n alone, once what a
start has put beside the smooth motion has died out. That map is the flow over one step of a vector field X which is
a series in trees (backward error analysis: Hairer, Lubich & Wanner, Geometric Numerical Integration, chapter IX):

    d u/dn = X_u = h v + ...,    d (h v)/dn = X_v = -h^2 (C v + N(u)) + ...,    n = t/h.

All of it is exact. With u' = X_u/h in place of v the two become one equation, u'' = -(C u' + N(u)) + h^p f_p + ....
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sympy import QQ, Expr

from ..algebra.algebraic import closed_form, generator
from ..algebra.rational import SingularMatrix, affine_solutions, matrix_inverse
from ..declare.errors import InconsistentScheme
from ..oscillator.evaluation import Evaluation
from .step import StepSeries
from .trees import Level, Series, Trees, U, V, add, like, tree_of

HIGHEST = 8  # power of h that is looked at unasked


@dataclass(frozen=True)
class ModifiedEquation:
    """The modified equation at some parameters, of u'' + C u' + N(u) = 0 per unit mass, or of u'' + N(u, u') = 0.

    of: the trees in which series are written. field: X_u and X_v, of u and the reported velocity. terms: power of h ->
    the trees of f_power in u'' = -(C u' + N(u)) + sum of h^power f_power, u' in place of v; powers whose term vanishes
    are left out. top: the highest power that was looked at.
    """

    evaluation: Evaluation
    of: Trees
    field: tuple[Series, Series]
    terms: dict[int, Level]
    top: int

    @property
    def coefficients(self) -> dict[int, dict[str, Expr]]:
        """Power -> tree as text -> its factor in u''. N[v, v] is N''(u)(u', u'), N[N[]] is N'(u) N(u)."""
        return {
            power: {self.of.text(tree): self.closed(c) for tree, c in sorted(level.items())}
            for power, level in self.terms.items()
        }

    def closed(self, number: Any) -> Expr:
        """A number of the field in the parameters, or in radicals or roots of polynomials at their values."""
        field = self.evaluation.field
        found, root = field.expression(number), getattr(field, "root", None)
        return found if root is None else found.subs(generator, closed_form(root, generator))


def modified_equation(
    evaluation: Evaluation, top: int | None = None, damping: bool = False, rates: bool = False
) -> ModifiedEquation:
    """The terms up to h^top; without a top, two terms, of which the second may vanish, and none beyond `HIGHEST`.

    rates: whether forces depend on rates in any other way than by a constant damping. Raises DeclarationError for a
    scheme that has no reading then, InconsistentScheme where an eigenvalue besides the principal pair tends to 1 with
    the step, or rest and uniform motion are not kept as they are.
    """
    if top is None:
        powers = range(1, HIGHEST)
        first = next((k for k in powers if modified_equation(evaluation, k, damping, rates).terms), HIGHEST - 1)
        return modified_equation(evaluation, first + 1, damping, rates)
    step = StepSeries(evaluation, rates)
    of = step.trees(damping, False)
    of.grow(top + 2)
    field = _field(step, of, top + 2)
    second = _second(Along(of, field, step.one), field, top + 2)
    terms = {w - 2: level for w, level in enumerate(second) if w > 2 and level}
    return ModifiedEquation(evaluation, of, field, terms, top)


@dataclass
class Along:
    """Derivatives of trees along a vector field (X_u, X_v), by how much they add to the weight."""

    of: Trees
    field: tuple[Series, Series]
    one: Any

    def __post_init__(self) -> None:
        self._known: dict[tuple[int, int], Level] = {}

    def forget(self) -> None:
        """Levels of the field have been added to."""
        self._known.clear()

    def derivative(self, tree: int, more: int) -> Level:
        """The part of a tree's derivative that weighs `more` more."""
        key = tree, more
        if key not in self._known:
            self._known[key] = self._derivative(*self.of.keys[tree], more)
        return self._known[key]

    def _derivative(self, kind: str, branches: tuple[int, ...], more: int) -> Level:
        own = {"u": (0, more), "v": (1, 1 + more)}.get(kind)
        if own:
            series, w = self.field[own[0]], own[1]
            return dict(series[w]) if w < len(series) else {}
        found: Level = {}
        if kind == "N" and more < len(self.field[0]):
            for x, c in self.field[0][more].items():
                add(found, {self.of.number("N", *branches, x): self.one}, c)
        if kind == "N" and self.of.rates and more + 1 < len(self.field[1]):
            for x, c in self.field[1][more + 1].items():
                add(found, {self.of.number("N", *branches, ~x): self.one}, c)
        for k, branch in enumerate(branches):
            others = branches[:k], branches[k + 1 :]
            for x, c in self.derivative(tree_of(branch), more).items():
                add(found, {self.of.number(kind, *others[0], like(branch, x), *others[1]): self.one}, c)
        return found

    def of_series(self, series: Series, w: int) -> Level:
        """The level of weight w of a series' derivative."""
        found: Level = {}
        for lower in range(min(w, len(series))):
            for tree, c in series[lower].items():
                add(found, self.derivative(tree, w - lower), c)
        return found

    def flowed(self, series: Series, w: int) -> Level:
        """The level of weight w of a series after one step along the field: of exp(D) applied to it."""
        total: Level = dict(series[w]) if w < len(series) else {}
        moved, scale = series, self.one
        for k in range(1, w + 1):
            moved = [self.of_series(moved, lower) for lower in range(w + 1)]
            if not any(moved):
                break
            scale = scale * QQ(1, k)
            add(total, moved[w], scale)
        return total


def _field(step: StepSeries, of: Trees, top: int) -> tuple[Series, Series]:
    """X_u and X_v, level by level, with the state that belongs to a smooth motion.

    In the level of weight w the state of the smooth motion is what a step leads to from there, seen from u and v one
    step later. What a step makes of it and what the motion moves it to hold the unknown level with constant factors,
    one matrix for all levels.
    """
    one, zero, m = step.one, step.one - step.one, len(step.state)
    matrix, report = _without_length(step, of)
    rest, moving = _modes(step, matrix, report)
    system = [
        [(one if i == j else zero) + rest[i] * report[0][j] + moving[i] * report[1][j] - matrix[i][j] for j in range(m)]
        for i in range(m)
    ]
    try:
        inverse = matrix_inverse(system, step.evaluation.field.domain)
    except SingularMatrix as error:
        raise InconsistentScheme(
            f"{step.scheme.name}: an eigenvalue besides the principal pair tends to 1 with the step"
        ) from error
    state: list[Series] = [[{U: c} if c else {}, {V: d} if d else {}] for c, d in zip(rest, moving, strict=True)]
    lasting: list[Series] = [[{}, {}] for _ in state]  # the state without its two modes
    X_u: Series = [{}, {V: one}]
    X_v: Series = [{}, {}]
    along = Along(of, (X_u, X_v), one)
    for w in range(2, top + 1):
        for series in (*state, *lasting, X_u, X_v):
            series.append({})
        along.forget()
        new, (u, v, _) = step.step(of, state)
        residual: list[Level] = []
        for i in range(m):
            level = dict(new[i][w])
            add(level, u[w], -rest[i])
            add(level, v[w], -moving[i])
            add(level, along.flowed(lasting[i], w), -one)
            residual.append(level)
        for i in range(m):
            for j, level in enumerate(residual):
                add(state[i][w], level, inverse[i][j])
            lasting[i][w] = state[i][w]
        ends: list[Level] = [dict(u[w]), dict(v[w])]
        for end, row in zip(ends, report, strict=True):
            for c, series in zip(row, state, strict=True):
                add(end, series[w], c)
        for X, end, tree in ((X_v, ends[1], V), (X_u, ends[0], U)):
            start: Series = [{} for _ in range(w + 1)]
            start[of.weights[tree]][tree] = one
            along.forget()
            add(end, along.flowed(start, w), -one)
            X[w] = end
    return X_u, X_v


def _without_length(step: StepSeries, of: Trees) -> tuple[list[list[Any]], list[list[Any]]]:
    """The step of length 0: the matrix (m, m) from state to state, and the rows of the reported u and v."""
    zero, m = step.one - step.one, len(step.state)
    columns = []
    for j in range(m):
        unit: list[Series] = [[{U: step.one} if i == j else {}] for i in range(m)]
        after, reported = step.step(of, unit)
        columns.append([series[0].get(U, zero) for series in (*after, *reported[:2])])
    rows = [list(row) for row in zip(*columns, strict=True)]
    return rows[:m], rows[m:]


def _modes(
    step: StepSeries, matrix: Sequence[Sequence[Any]], report: Sequence[Sequence[Any]]
) -> tuple[list[Any], list[Any]]:
    """The states that a step of length 0 leaves at rest, with u = 1, and moves uniformly, with u = h v = 1 at its end.

    u at the end of a step from the latter is 1 since its state has u = 0 at the start.
    """
    one, zero, m = step.one, step.one - step.one, len(step.state)
    less = [[x - (one if i == j else zero) for j, x in enumerate(row)] for i, row in enumerate(matrix)]

    def state(right: list[Any]) -> list[Any]:
        solved = affine_solutions([*less, *report], right, m, step.evaluation.field.domain)
        if solved is None or solved[1]:
            raise InconsistentScheme(f"{step.scheme.name}: it does not keep rest and uniform motion as they are")
        return solved[0]

    rest = state([zero] * m + [one, zero])
    return rest, state([*rest, one, one])


def _second(along: Along, field: tuple[Series, Series], top: int) -> Series:
    """h^2 u'' as a series in u and h u', which stands in place of h v."""
    X_u = field[0]
    found: Series = [{} for _ in range(top + 1)]
    substituted = Substituted(along.of, X_u, along.one)
    for w in range(2, top + 1):
        level = along.of_series(X_u, w)
        for lower in range(2, w):
            for tree, c in found[lower].items():
                add(level, substituted.level(tree, w), -c)
        found[w] = level
    return found


Product = tuple[int, tuple[int, ...], Any]  # a weight, branches, and a factor


@dataclass
class Substituted:
    """Trees with a series in place of v."""

    of: Trees
    v: Series
    one: Any

    def level(self, tree: int, w: int) -> Level:
        """The level of weight w of a tree."""
        kind, branches = self.of.keys[tree]
        if kind in "uv":
            return {tree: self.one} if kind == "u" and w == 0 else self.v[w] if kind == "v" else {}
        products: list[Product] = [({"C": 1}.get(kind, 2), (), self.one)]
        for branch in branches:
            less, first = int(branch < 0), self.of.weights[tree_of(branch)]
            products = [
                (weight + more - less, (*chosen, like(branch, x)), c * factor)
                for weight, chosen, factor in products
                for more in range(first, w - weight + less + 1)
                for x, c in self.level(tree_of(branch), more).items()
            ]
        found: Level = {}
        times = 0
        while products:
            for weight, chosen, factor in products:
                if weight == w:
                    add(found, {self.of.number(kind, *chosen): factor}, self.one)
            times += 1
            products = self._by_rate(products, w, times) if kind == "N" and self.of.rates else []
        return found

    def _by_rate(self, products: list["Product"], w: int, times: int) -> list["Product"]:
        """One more branch of the force's own velocity, as far as that is another than v: a term of Taylor's series."""
        return [
            (weight + more - 1, (*chosen, ~x), c * factor * QQ(1, times))
            for weight, chosen, factor in products
            for more in range(2, w - weight + 2)
            for x, c in (self.v[more] if more < len(self.v) else {}).items()
        ]
