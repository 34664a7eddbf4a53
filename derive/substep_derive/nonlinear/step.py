"""Scheme -> the series of its step, its start and its report, in trees.

All relations and balances of a step are equations in series. In the level of weight w the new symbols appear with
constant coefficients, since N adds 2 to the weight, C 1 and K0 2: one matrix, the same for all levels, gives the levels
one after another, implicit or not.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from sympy import Expr, Symbol

from ..algebra.rational import SingularMatrix, matrix_inverse
from ..declare.errors import DeclarationError
from ..declare.scheme import Scheme
from ..declare.symbols import K0, C, K_t, M, N, N_discrete, N_of_rates, f, kind_of, knot, knot_of, steps_back
from ..oscillator.evaluation import Evaluation
from ..step.places import places
from ..step.step import Step
from .form_series import Run
from .forms import Applied, Form, form
from .trees import Level, Series, Trees, U, V, add, trees

KNOWN = knot(0)


@dataclass
class StepSeries:
    """A scheme's equations at numbers of a field for its parameters.

    rates: whether forces depend on rates in any way. A balance takes them where it does so in kernels: at the velocity
    that C multiplies or, where it takes the force at several displacements, at that of each of their knots. mixed:
    whether a balance then mixes forces of inertia M(u) a, and not accelerations. Raises DeclarationError for a scheme
    of which no such velocity is known, or that mixes more than accelerations.
    """

    evaluation: Evaluation
    rates: bool = False
    mixed: bool = False

    def __post_init__(self) -> None:
        scheme = self.evaluation.scheme
        self.scheme, self.state, self.unknowns = scheme, scheme.state, scheme.unknowns
        self.one = self.evaluation.field.domain.one
        step = Step.of(scheme)
        self.equations = [self._at_masses(e) if self.mixed else self.form(e) for e in step.equations]
        self.reports = [self.form(e) for e in step.reported]
        self.after = step.after

    def number(self, value: Expr) -> Any:
        """A function of the parameters as a number of the field."""
        return self.evaluation.number(value)

    def form(self, e: Expr) -> Form:
        """An expression of the declaration as a linear form."""
        return self._plain(self._with_rates(e) if self.rates else e)

    def _plain(self, e: Expr) -> Form:
        return form(self.scheme.name, e, self.number)

    def _with_rates(self, e: Expr) -> Expr:
        """With N(u, v) in place of C v + N(u)."""
        if not e.has(C, K0, K_t, N, N_discrete):
            return e
        e = e.subs(M, 1)
        damping = e.diff(C)
        found, same = places(e, damping)
        if e.has(K0, K_t, N_discrete):
            raise DeclarationError(
                f"{self.scheme.name}: expected forces at displacements, got a discrete gradient or coefficients from a "
                "stiffness, from which no step follows where forces depend on rates; take another scheme"
            )
        if damping.has(C) or not same or not all(place.v for place in found):
            raise DeclarationError(
                f"{self.scheme.name}: expected C at the velocities of the knots of the force, with the same weights, "
                f"got {damping} beside {', '.join(str(place.force) for place in found)}, from which no step follows "
                "where forces depend on rates; take another scheme"
            )
        return e.subs(C, 0).subs({place.force: N_of_rates(place.u, place.v) for place in found})

    def _at_masses(self, e: Expr) -> Form:
        """A relation as it is, a balance with each acceleration and force times the mass at its own displacement."""
        found, moved = self.form(e), self._with_rates(e)
        forces = moved.atoms(N_of_rates)
        if not forces:
            return found
        rest = moved.subs(dict.fromkeys(forces, 0))
        inertia = sorted((s for s in rest.free_symbols if knot_of(s)), key=str)
        if others := [s for s in inertia if kind_of(s) != 2]:
            raise DeclarationError(
                f"{self.scheme.name}: expected a mixture of accelerations at knots, got {others[0]} in {e}, which "
                "stands at no displacement at which a mass could be taken"
            )
        parts = [(knot((knot_of(a) or ("", ""))[1]).u, a) for a in inertia]
        parts += [(force.args[0], force) for force in sorted(forces, key=str)]
        more = tuple(Applied("mass", self._plain(moved.coeff(x) * x), self._plain(u)) for u, x in parts)
        return replace(found, applied=found.applied + more)

    def trees(self, damping: bool, load: bool) -> Trees:
        """The trees of an equation with or without damping, which is a force like any other where these have rates."""
        return trees(damping and not self.rates, load, self.reads_tangent, self.rates, self.mixed)

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
        return StepSeries(Evaluation(start, field, {}), self.rates, self.mixed)

    @cached_property
    def starts(self) -> list[Form]:
        """How the state follows from u_0, v_0, a_0, where expressions give it."""
        start = Step.of(self.scheme).start
        assert start is not None
        return [self.form(e) for e in start]

    @cached_property
    def consistent(self) -> Form:
        """The acceleration that u_0 and v_0 have by the equation of motion."""
        return self.form(f(0) - C * KNOWN.v - N(KNOWN.u))

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
