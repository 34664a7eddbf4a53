"""Series of symbols in trees -> those of linear forms of them, level by level, and of forces at displacements."""

from dataclasses import dataclass, field
from typing import Any

from sympy import QQ, Expr, Symbol

from ..declare.errors import DeclarationError
from ..declare.symbols import N_of_rates
from .forms import Applied, Form, Term
from .trees import Level, Series, Trees, U, V, add, tree_of


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
                kind = ForceOfRates if isinstance(term.of, N_of_rates) else Force
                self._forces[term.of] = kind(self, term.arguments)
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
        if applied.argument is None:
            return self._operated(applied.kind, x, w)
        if applied.kind == "mass":
            return self._mass_level(x, [self.level(applied.argument, k) for k in range(w - 1)], w)
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

    def _mass_level(self, x: Series, u: Series, w: int) -> Level:
        """The level of weight w of M(u_n)^-1 (M(u) - M(u_n)) x."""
        found: Level = {}
        for tree in self.of.levels[w]:
            kind, branches = self.of.keys[tree]
            if kind != "M":
                continue
            of_x, *along = branches
            c = x[self.of.weights[of_x]].get(of_x, self.one - self.one)
            for k, branch in enumerate(along):
                c = (
                    c
                    * u[self.of.weights[branch]].get(branch, self.one - self.one)
                    * QQ(1, along[: k + 1].count(branch))
                )
            if c:
                found[tree] = c
        return found


class Force:
    """The series of h^2 N(u) at a displacement, or of its mean along the line from one displacement to another.

    The mean is what a discrete gradient is on one coordinate. On several it is one of them; any that is symmetric in
    its two displacements differs from it by a term with the square of their distance.
    """

    def __init__(self, run: Run, arguments: tuple[Form, ...]) -> None:
        self.run, self.arguments = run, arguments
        self.series: list[Series] = [[] for _ in arguments]
        self.products: dict[int, list[Any]] = {}  # tree -> polynomial in s of its branches' product, from s^0 up

    def _grow(self, weight: int) -> None:
        for argument, series in zip(self.arguments, self.series, strict=True):
            while len(series) <= weight:
                series.append(self.run.level(argument, len(series)))
            if series[0] != {U: self.run.one}:
                raise DeclarationError(
                    "expected the internal force at displacements that tend to u_n as h -> 0: an argument of N whose "
                    f"coefficients of displacements add up to 1, got {series[0].get(U, 0)}"
                )

    def _branch(self, branch: int) -> list[Any]:
        """The coefficient of a tree in the displacement u + s*(w - u), as a polynomial in s."""
        w = self.run.of.weights[branch]
        zero = self.run.one - self.run.one
        first, *last = (series[w].get(branch, zero) for series in self.series)
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


class ForceOfRates(Force):
    """The series of h^2 N(u, v)."""

    def _grow(self, weight: int) -> None:
        for argument, series, first, more in zip(self.arguments, self.series, (U, V), (0, 1), strict=True):
            while len(series) <= weight + more:
                series.append(self.run.level(argument, len(series)))
            if series[more] != {first: self.run.one * self.run.direction**more}:
                raise DeclarationError(
                    "expected forces at displacements and velocities that tend to u_n and v_n as "
                    f"h -> 0, got {series[more].get(first, 0)} times {'uv'[more]}_n, at which forces that depend on "
                    "rates would be others; take another scheme"
                )

    def _branch(self, branch: int) -> list[Any]:
        tree = tree_of(branch)
        c = self.series[branch < 0][self.run.of.weights[tree]].get(tree, self.run.one - self.run.one)
        return [c if branch >= 0 else c * self.run.direction]


def _multiplied(p: list[Any], q: list[Any]) -> list[Any]:
    """The product of two polynomials; [] for 0."""
    product = [p[0] * 0] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        if a:
            for j, b in enumerate(q):
                product[i + j] = product[i + j] + a * b
    return product if any(product) else []
