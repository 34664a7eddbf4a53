"""Scheme -> the series of its step, its start and its report, in trees.

All relations and balances of a step are equations in series. In the level of weight w the new symbols appear with
constant coefficients, since N adds 2 to the weight, C 1 and K0 2: one matrix, the same for all levels, gives the levels
one after another, implicit or not.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from sympy import QQ, Expr, Symbol

from ..algebra.rational import SingularMatrix, matrix_inverse
from ..declare.errors import DeclarationError
from ..declare.scheme import Scheme
from ..declare.symbols import K0, C, N, f, knot, knot_of, steps_back
from ..oscillator.evaluation import Evaluation
from ..step.step import Step
from .forms import Applied, Form, Term, form
from .trees import Level, Series, Trees, U, V, add

KNOWN = knot(0)


@dataclass
class StepSeries:
    """A scheme's equations at numbers of a field for its parameters."""

    evaluation: Evaluation

    def __post_init__(self) -> None:
        scheme, number = self.evaluation.scheme, self.number
        self.scheme, self.state, self.unknowns = scheme, scheme.state, scheme.unknowns
        self.one = self.evaluation.field.domain.one
        step = Step.of(scheme)
        self.equations = [form(scheme.name, e, number) for e in step.equations]
        self.reports = [form(scheme.name, e, number) for e in step.reported]
        self.after = step.after

    def number(self, value: Expr) -> Any:
        """A function of the parameters as a number of the field."""
        return self.evaluation.number(value)

    @property
    def reads_tangent(self) -> bool:
        """Whether K0 occurs in the step."""
        step = Step.of(self.scheme)
        return any(e.has(K0) for e in (*step.equations, *step.reported))

    @cached_property
    def starter(self) -> "StepSeries | None":
        """The scheme that marches the first steps."""
        start = self.scheme.start_scheme
        if start is None:
            return None
        field = self.evaluation.field
        return StepSeries(Evaluation(start, field, {}))

    @cached_property
    def starts(self) -> list[Form]:
        """How the state follows from u_0, v_0, a_0, where expressions give it."""
        start = Step.of(self.scheme).start
        assert start is not None
        return [form(self.scheme.name, e, self.number) for e in start]

    @cached_property
    def consistent(self) -> Form:
        """The acceleration that u_0 and v_0 have by the equation of motion."""
        return form(self.scheme.name, f(0) - C * KNOWN.v - N(KNOWN.u), self.number)

    @cached_property
    def solution(self) -> list[list[tuple[int, Any]]]:
        """For each equation, the unknowns (number, minus the entry of the inverse) that what it holds contributes to.

        Raises DeclarationError if the equations do not determine the unknowns as h -> 0.
        """
        n, zero = len(self.unknowns), self.one - self.one
        plain = [equation.plain() for equation in self.equations]
        rows = [[coefficients.get(s, zero) for s in self.unknowns] for coefficients in plain]
        try:
            inverse = matrix_inverse(rows, self.evaluation.field.domain)
        except SingularMatrix as error:
            raise DeclarationError(
                f"{self.scheme.name}: as h -> 0 the relations and balances do not determine "
                f"{', '.join(map(str, self.unknowns))}"
            ) from error
        return [[(j, -inverse[j][i]) for j in range(n) if inverse[j][i]] for i in range(n)]

    def step(self, of: Trees, state: Sequence[Series], direction: int = 1) -> tuple[list[Series], list[Series]]:
        """(new state, u and h v and h^2 a as reported) of a step from a state, as long as the state's series.

        direction = -1: a step of length -h, from t_n + h to t_n, with velocities still times h, not -h.
        """
        run = Run(of, self.one, direction, dict(zip(self.state, _signed(self.state, state, direction), strict=True)))
        weight = len(state[0]) - 1
        for s in self.unknowns:
            run.series[s] = []
        for w in range(weight + 1):
            rest = [run.level(equation, w, set(self.unknowns)) for equation in self.equations]
            levels: list[Level] = [{} for _ in self.unknowns]
            for held, contributions in zip(rest, self.solution, strict=True):
                for j, c in contributions:
                    add(levels[j], held, c)
            for s, level in zip(self.unknowns, levels, strict=True):
                run.series[s].append(level)
            for equation in self.equations:
                run.complete(equation, w)
        after = _signed(self.state, [run.series[s] for s in self.after], direction)
        report = [run.whole(e, weight) for e in self.reports]
        return after, _signed(KNOWN, report, direction)

    def start(self, of: Trees, u: Series, v: Series, direction: int = 1) -> list[Series]:
        """The state of a scheme that starts itself, from series of u_0 and h v_0 and the acceleration they have."""
        run = Run(of, self.one, direction, dict(zip(KNOWN, _signed(KNOWN, [u, v], direction), strict=False)))
        weight = len(u) - 1
        run.series[KNOWN.a] = run.whole(self.consistent, weight)
        return _signed(self.state, [run.whole(e, weight) for e in self.starts], direction)


def _signed(symbols: Sequence[Symbol], series: Sequence[Series], direction: int) -> list[Series]:
    """The series, those of velocities with the sign of the direction."""
    return [
        [{tree: -c for tree, c in level.items()} for level in one]
        if direction < 0 and (knot_of(s) or ("", ""))[0] == "v"
        else one
        for s, one in zip(symbols, series, strict=False)
    ]


@dataclass
class Run:
    """Series of symbols, from which those of forms are computed level by level.

    direction: 1, or -1 for a step backwards, which takes the load at t_n + h - tau*h.
    """

    of: Trees
    one: Any
    direction: int
    series: dict[Symbol, Series]
    _held: dict[Any, Series] = field(default_factory=dict)
    _forces: dict[Expr, "Force"] = field(default_factory=dict)

    def whole(self, e: Form, weight: int) -> Series:
        """The form's levels of weights up to `weight`."""
        return [self.level(e, w) for w in range(weight + 1)]

    def level(self, e: Form, w: int, unknown: set[Symbol] | None = None) -> Level:
        """The form's level of weight w; without the parts plain*symbol of unknown symbols, whose level is not known."""
        total: Level = {}
        for term in e.terms:
            own = term.of in (unknown or ())
            if term.over:
                add(total, self._divided(term, w, own), self.one)
            elif not own:
                add(total, self.value(term, w), term.plain)
        for applied in e.applied:
            add(total, self._applied(applied, w), self.one)
        return total

    def value(self, term: Term, w: int) -> Level:
        """The level of a symbol, a force or a load."""
        if term.instant is not None:
            if w < 2 or not self.of.load:
                return {}
            after = term.instant if self.direction > 0 else self.one - term.instant
            c = self.one
            for k in range(1, w - 1):
                c = c * after * QQ(1, k)
            return {self.of.number("f", w - 2): c} if c else {}
        if term.arguments:
            if term.of not in self._forces:
                self._forces[term.of] = Force(self, term.arguments)
            return self._forces[term.of].level(w)
        return self.series[term.of][w]

    def _divided(self, term: Term, w: int, own: bool) -> Level:
        """The level of y = den^-1 num x, without plain*x if x is not known there yet: y = num x - (den - 1) y."""
        x, y = self._held.setdefault((id(term), "x"), []), self._held.setdefault((id(term), "y"), [])
        if len(y) > w:
            return y[w]
        if not own:
            x.append(self.value(term, w))
        level: Level = {}
        for kind, c in term.under:
            add(level, self._operated(kind, x, w), c)
        for kind, c in term.over:
            add(level, self._operated(kind, y, w), -c)
        if not own:
            add(level, x[w], term.plain)
        y.append(level)
        return level

    def complete(self, e: Form, w: int) -> None:
        """Take up the level of weight w of symbols that were unknown when `level` was asked for."""
        for term in e.terms:
            if term.over and len(x := self._held[id(term), "x"]) == w:
                x.append(self.value(term, w))
                add(self._held[id(term), "y"][w], x[w], term.plain)

    def _applied(self, applied: Applied, w: int) -> Level:
        """The level of an operator times a form, which takes lower levels of the form only."""
        x = self._held.setdefault((id(applied), "x"), [])
        while len(x) < w:
            x.append(self.level(applied.to, len(x)))
        if applied.kind != "tangent":
            return self._operated(applied.kind, x, w)
        assert applied.argument is not None
        return Force(self, (applied.argument,)).tangent_level(x, w)

    def _operated(self, kind: str, x: Series, w: int) -> Level:
        """The level of weight w of C x or K0 x."""
        if kind == "C" and not self.of.damping:
            return {}
        lower = w - (1 if kind == "C" else 2)
        level = x[lower] if lower >= 0 else {}
        if U in level:
            raise DeclarationError(
                "expected C and K0 to multiply velocities, accelerations or differences of displacements, got a "
                "displacement; write N(u) + K0*(u_1 - u) for a force linearized at u"
            )
        sign = self.direction if kind == "C" else 1
        return {self.of.number(kind, tree): c * sign for tree, c in level.items()}


class Force:
    """The series of h^2 N(u) at a displacement, or of its mean along the line from one displacement to another.

    The mean is what a discrete gradient is on one coordinate. On several it is one of them; any that is symmetric in
    its two displacements differs from it by a term with the square of their distance.
    """

    def __init__(self, run: Run, arguments: tuple[Form, ...]) -> None:
        self.run, self.arguments = run, arguments
        self.displacements: list[Series] = [[] for _ in arguments]
        self.products: dict[int, list[Any]] = {}  # tree -> polynomial in s of its branches' product, from s^0 up

    def _grow(self, weight: int) -> None:
        for argument, series in zip(self.arguments, self.displacements, strict=True):
            while len(series) <= weight:
                series.append(self.run.level(argument, len(series)))
            if series[0] != {U: self.run.one}:
                raise DeclarationError(
                    "expected the internal force at displacements that tend to u_n as h -> 0: an argument of N whose "
                    f"coefficients of displacements add up to 1, got {series[0].get(U, 0)}"
                )

    def _branch(self, tree: int) -> list[Any]:
        """The coefficient of a tree in the displacement u + s*(w - u), as a polynomial in s."""
        w = self.run.of.weights[tree]
        zero = self.run.one - self.run.one
        first, *last = (series[w].get(tree, zero) for series in self.displacements)
        return [first, *(c - first for c in last)]

    def _product(self, tree: int, shorter: int, last: int, count: int) -> list[Any]:
        if tree not in self.products:
            factor = [c * QQ(1, count) for c in self._branch(last)]
            self.products[tree] = _multiplied(self.products[shorter], factor) if self.products.get(shorter) else []
        return self.products[tree]

    def level(self, w: int) -> Level:
        """The level of weight w."""
        if w < 2:
            return {}
        self._grow(w - 2)
        if w == 2:
            tree = self.run.of.number("N")
            self.products[tree] = [self.run.one]
            return {tree: self.run.one}
        found: Level = {}
        for grown in self.run.of.forces[w]:
            product = self._product(grown.tree, grown.shorter, grown.last, grown.count)
            if product:
                value = product[0]
                for k, c in enumerate(product[1:], start=2):
                    value = value + c * QQ(1, k)
                if value:
                    found[grown.tree] = value
        return found

    def tangent_level(self, x: Series, w: int) -> Level:
        """The level of weight w of h^2 N'(u) x."""
        for lower in range(2, w + 1):
            self.level(lower)
        found: Level = {}
        for grown in self.run.of.forces[w] if w > 2 else ():
            branches = self.run.of.keys[grown.tree][1]
            for branch in sorted(set(branches)):
                others = list(branches)
                others.remove(branch)
                product = self.products.get(self.run.of.number("N", *others))
                c = x[self.run.of.weights[branch]].get(branch)
                if product and c:
                    add(found, {grown.tree: product[0]}, c)
        return found


def _multiplied(p: list[Any], q: list[Any]) -> list[Any]:
    """The product of two polynomials; [] for 0."""
    product = [p[0] * 0] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        if a:
            for j, b in enumerate(q):
                product[i + j] = product[i + j] + a * b
    return product if any(product) else []


def lag(scheme: Scheme) -> int:
    """How many steps before t_n the oldest entry of the state is."""
    return int(max(map(steps_back, scheme.state)))


def exact(of: Trees, one: Any, weight: int) -> tuple[Series, Series, Series]:
    """u, h v and h^2 a of the exact motion at the instant to which the trees belong."""
    found: tuple[Series, ...] = tuple([{} for _ in range(weight + 1)] for _ in range(3))
    u, v, a = found
    u[0][U], v[1][V] = one, one
    a[2] = {tree: one * c for tree, c in of.rate(V).items()}
    return u, v, a
