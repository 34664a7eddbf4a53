"""Any declaration stepped number by number on an oscillator whose spring remembers; nothing of the derivation is used.

All relations and the inertia of each balance are one linear system, so that every new symbol is affine in the inertias
s. The balances are met in the order declared: each is one equation in its own s, whose root is found by bracketing.
When memory is committed is found from numbers too: the same linear system is stepped through the motions u = t, t^2,
t^3, ..., which say where the knots are in time and whether they follow the motion as the end of the step does.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from declared_steps import Marcher, System, later
from scipy.optimize import brentq
from substep_derive import Scheme
from substep_derive.declare.symbols import N, f, knot, knot_of, lattice
from sympy import Symbol

Array = Any
u0, v0, a0 = knot(0)
u1, v1, a1 = knot(1)


def lag(symbol: Symbol) -> float:
    """When the symbol of a state is, in steps after t_n: -1 for u_-1."""
    return float(lattice((knot_of(symbol) or ("", "0"))[1]) or 0)


@dataclass(frozen=True)
class Spring:
    """A law: its stiffness before it is strained, what it remembers then, and how it follows a path without a turn.

    follow: of e, what was committed last and the time since then, s: force and memory at e.
    """

    k: float
    unstrained: Any
    follow: Callable[[float, Any, float], tuple[float, Any]]


# displacement -> what was committed at it, and when, in steps after t_n; the last committed is the last
Known = dict[float, tuple[Any, float]]
Terms = list[tuple[Any, float, Any]]  # of a linear form: symbol or atom, coefficient, the form of a force's argument


class Remembering:
    """Steps of the scheme on u'' + damping u' + spring(u) = load(t)."""

    def __init__(self, scheme: Scheme, values: Mapping[Symbol, Any], spring: Spring, damping: float,
                 load: Callable[[float], float], h: float, tangent: float | None = None) -> None:  # fmt: skip
        """tangent: that which a start takes at u_0; by default the spring's before it yields."""
        k, first = np.array([[spring.k]]), np.array([[spring.k if tangent is None else tangent]])
        linear = System(lambda u: k @ u, lambda u: k, lambda a, b: a, np.array([[damping]]), np.atleast_1d)
        self.marcher = Marcher(scheme, values, linear, h, np.zeros(1))
        self.marcher.matrices[3] = first
        self.scheme, self.spring, self.damping, self.load, self.h = scheme, spring, damping, load, h
        self.unknowns, self.state = scheme.unknowns, scheme.state
        self.balances = [tuple(map(self.form, (b.inertia, b.damping, b.force, b.load))) for b in scheme.balances]
        rows = [self.form(symbol - e) for symbol, e in scheme.relations.items()]
        rows += [inertia for inertia, *_ in self.balances]
        read = [self.row(terms) for terms in rows]
        given = np.zeros((len(rows), len(self.balances)))
        given[-len(self.balances) :] = np.eye(len(self.balances))
        inverse = np.linalg.inv(np.array([new for new, _ in read]))
        self.by_state, self.by_s = -inverse @ np.array([old for _, old in read]), inverse @ given

    def form(self, e: Any) -> Terms:
        """The terms of an expression linear in symbols, N and f."""

        def plain(terms: Any) -> Terms:
            return [(atom, float(c[0, 0]), plain(inner[0]) if inner else None) for atom, c, inner in terms]

        return plain(self.marcher.form(e))

    def row(self, terms: Terms) -> tuple[Array, Array]:
        """The coefficients of the new symbols and of the state."""
        new, old = np.zeros(len(self.unknowns)), np.zeros(len(self.state))
        for symbol, c, _ in terms:
            where, names = (new, self.unknowns) if symbol in self.unknowns else (old, self.state)
            where[names.index(symbol)] += c
        return new, old

    def symbols(self, state: Array, s: Array) -> dict[Symbol, float]:
        """Every symbol of a step."""
        new = self.by_state @ state + self.by_s @ s
        return dict(zip((*self.state, *self.unknowns), (*state, *new), strict=True))

    def through(self, power: int) -> dict[Symbol, float]:
        """Every symbol of a step through the motion u = (t/h)^power of a free mass, by the load that it needs."""
        position = np.poly1d([1.0, *[0.0] * power])
        motion = [position.deriv(kind) / self.h**kind for kind in range(3)]
        old = [motion["uva".index(s.name[0])](lag(s)) for s in self.state]
        loads = [load for *_, load in self.balances]
        inertia = [sum(c * motion[2](self.marcher.instant(atom)) for atom, c, _ in load) for load in loads]
        return self.symbols(np.array(old), np.array(inertia))

    @cached_property
    def instants(self) -> dict[Symbol, float]:
        """When each symbol's knot is, in steps after t_n; meant of displacements."""
        return self.through(1)

    def end_of(self, power: int) -> float:
        """The displacement that is reported of this motion."""
        return self.value(self.form(self.scheme.report.get(u1, u1)), self.through(power), 0.0, {})

    @cached_property
    def instants_of_force(self) -> list[float]:
        """When the balances take the spring's force, in steps after t_n."""
        return [self.instant(inner) for b in self.balances for atom, _, inner in b[2] if isinstance(atom, N)]

    def instant(self, displacement: Terms) -> float:
        """That of a mixture of displacements."""
        return sum(c * self.instants[s] for s, c, _ in displacement)

    @cached_property
    def commits(self) -> list[tuple[int, Symbol]]:
        """The balances after which memory is committed within a step, and the displacement at which it is.

        A displacement does where the force is taken at it, or at a mixture with it, and where t^2 passes through it,
        and t^3, t^4, ... as far as they pass through the end of the step, between the displacement before it and this
        end. None where they do not go forward in time.
        """
        at, powers = self.instants, [2]
        while self.end_of(powers[-1] + 1) == pytest.approx(1, abs=1e-12):
            powers.append(powers[-1] + 1)
        through = {power: self.through(power) for power in powers}
        ways, met = list[tuple[int, Symbol]](), set(self.state)
        for k, (_, _, force, _) in enumerate(self.balances):
            read = {s for atom, _, inner in force if isinstance(atom, N) for s, _, _ in inner}
            ways += [(k, s) for s in sorted(read - met, key=str)]
            met |= read
        if any(at[s] < at[before] - 1e-12 for (_, before), (_, s) in pairwise(ways)):
            return []
        found, last = list[tuple[int, Symbol]](), 0.0
        for k, s in ways:
            followed = all(abs(x[s] - at[s] ** power) < 1e-12 for power, x in through.items())
            if last + 1e-12 < at[s] < 1 - 1e-12 and followed:
                found.append((k, s))
                last = at[s]
        return found

    def force(self, e: float, at: float, known: Known) -> float:
        """At e, at this instant: of what was committed at e, if it was, else of what was committed last."""
        if e in known:
            memory, instant = known[e]
            return self.spring.follow(e, memory, (at - instant) * self.h)[0]
        return self.spring.follow(e, *self.last(at, known))[0]

    def commit(self, e: float, at: float, known: Known) -> None:
        """Commit at e, at this instant, what follows from the last committed."""
        memory = self.spring.follow(e, *self.last(at, known))[1]
        known.pop(e, None)
        known[e] = memory, at

    def last(self, at: float, known: Known) -> tuple[Any, float]:
        """What was committed last, and the time from then to this instant, s."""
        memory, instant = [*known.values()][-1]
        return memory, (at - instant) * self.h

    def value(self, terms: Terms, x: Mapping[Symbol, float], t: float, known: Known) -> float:
        total = 0.0
        for atom, c, inner in terms:
            if isinstance(atom, f):
                total += c * self.load(t + self.h * self.marcher.instant(atom))
            elif isinstance(atom, N):
                total += c * self.force(self.value(inner, x, t, known), self.instant(inner), known)
            else:
                total += c * x[atom]
        return total

    def residual(self, k: int, state: Array, s: Array, t: float, known: Known, inertia: float) -> float:
        """Of the k-th balance at an inertia of its own, those of the balances before it given."""
        _, damping, force, load = self.balances[k]
        x = self.symbols(state, np.array([*s[:k], inertia, *s[k + 1 :]]))
        damped, forced, loaded = (self.value(terms, x, t, known) for terms in (damping, force, load))
        return inertia + self.damping * damped + forced - loaded

    def step(self, state: Array, u: float, memory: Any, t: float) -> tuple[dict[Symbol, float], Any, Array]:
        """Every symbol, the memory, and u, v, a (NaN without one of its own) at the end of a step from u at t."""
        s, known = np.zeros(len(self.balances)), {u: (memory, 0.0)}
        for k in range(len(self.balances)):
            s[k] = root(partial(self.residual, k, state, s, t, known))
            for where in [where for balance, where in self.commits if balance == k]:
                self.commit(self.symbols(state, s)[where], self.instants[where], known)
        x = self.symbols(state, s)
        rows = []
        for symbol in (u1, v1, a1):
            e = self.scheme.report.get(symbol, symbol)
            own = e != symbol or symbol in x
            rows.append(self.value(self.form(e), x, t, known) if own else np.nan)
        memory = self.spring.follow(rows[0], *self.last(1.0, known))[1]
        return x, memory, np.array(rows)


def root(residual: Callable[[float], float]) -> float:
    """Where an increasing function is 0, to rounding."""
    at, width = residual(0.0), 1.0
    if at == 0:
        return 0.0
    while np.sign(residual(-np.sign(at) * width)) == np.sign(at):
        width *= 4
        assert width < 1e30
    return brentq(residual, *sorted((0.0, -np.sign(at) * width)), xtol=1e-14, rtol=1e-15)


def history(
    scheme: Scheme, values: Mapping[Symbol, Any], spring: Spring, damping: float, load: Callable[[float], float],
    h: float, n: int, u: float, v: float, tangent: float | None = None,
) -> tuple[Array, list[Any]]:  # fmt: skip
    """u, v, a (n + 1 rows) and what is remembered, from u and v at t = 0, to which the spring was strained at once."""
    _, memory = spring.follow(u, spring.unstrained, 0.0)
    rows, kept = [np.array([u, v, load(0.0) - damping * v - spring.follow(u, memory, 0.0)[0]])], [memory]
    stepper = Remembering(scheme, values, spring, damping, load, h, tangent)
    starter = scheme.start_scheme
    if starter is not None:
        first = -int(min(map(lag, scheme.state)))
        early, kept = history(starter, {}, spring, damping, load, h, first, u, v)
        rows = list(early)
        state = np.array([rows[first + int(lag(s))]["uva".index(s.name[0])] for s in scheme.state])
    else:
        given, known = dict(zip((u0, v0, a0), rows[0], strict=True)), {u: (memory, 0.0)}
        start: Any = scheme.start
        state = np.array([stepper.value(stepper.form(start.get(s, s)), given, 0.0, known) for s in scheme.state])
    for i in range(len(rows) - 1, n):
        x, memory, row = stepper.step(state, rows[-1][0], kept[-1], i * h)
        rows.append(row)
        kept.append(memory)
        state = np.array([x[later(s)] for s in scheme.state])
    return np.array(rows), kept
