"""Scheme -> Estimator: the combination of what a step holds that equals the leading term of its local error.

The local error is numerical minus exact u and v after one step from the scheme's smooth motion, its own acceleration
included (see `motion`). A combination that equals it to leading order for every frequency, damping and smooth load is
an estimate; all of them are an affine family. On nonlinear equations the same holds for schemes of orders one and two:
the linear terms and those of the load are then all elementary differentials that the leading error can consist of.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from sympy import QQ, Expr, Function, Integer, Rational, Symbol, factor, fraction

from ..algebra.algebraic import generator
from ..declare.catalogue import find
from ..declare.parameter_set import ParameterSet
from ..declare.related import related
from ..declare.scheme import Scheme
from ..declare.symbols import h, knot, omega, t, xi
from ..oscillator.evaluation import Evaluation
from .analysis import LEVELS, WITHOUT_BEFORE, Analysis, NoEstimator, analysis_of, pool
from .expansion import Expansion
from .family import Family
from .held import EMBEDDED, END

kappa = Symbol("kappa")  # the length of the step before, divided by h
exact_motion, rest_of_force = Function("u"), Function("g")  # of t; g: what of a force is not linear in u
GENERIC_RATIO = QQ(97, 113)


@dataclass(frozen=True)
class Estimate:
    """One estimated local error.

    error: combination of held symbols, in the unit of u or of v. order: p, where the local error is O(h^(p+1)).
    growth: the power of Omega with which the estimate grows at most as Omega -> oo, compared with the state: 0 or less
    where it is bounded, negative where it vanishes. extra: symbol -> what it stands for, of values that the step does
    not hold by itself. of: "u_1" or "v_1", or that it is the error of a second value of lower order. leading: the local
    error's leading term, with derivatives of the exact motion u(t) and, where the scheme takes load and force at
    different instants, of what of the force is not linear in u, g(t). family: all combinations that equal it, of what
    the step holds and, if need be, of extra values; None where parameters were put in afterwards.
    """

    error: Expr
    order: int
    growth: int
    extra: Mapping[Symbol, str]
    of: str
    leading: Expr
    family: Family | None

    def __repr__(self) -> str:
        return f"<estimate of the error of {self.of}, order {self.order}: .error = {self.error}>"


@dataclass(frozen=True)
class Estimator:
    """Estimated local errors, numerical minus exact, of u and v after one step of length h.

    displacement, velocity: the two estimates. evaluation: what numbers or symbols the parameters are.
    """

    evaluation: Evaluation
    displacement: Estimate
    velocity: Estimate

    def __repr__(self) -> str:
        return f"<estimator of {self.scheme.name}: .u of order {self.order[0]}, .v of order {self.order[1]}>"

    @property
    def scheme(self) -> Scheme:
        """The scheme, its parameters fixed where they were given."""
        return self.evaluation.scheme

    @property
    def u(self) -> Expr:
        """The estimated local error of u, linear in knots' symbols."""
        return self.displacement.error

    @property
    def v(self) -> Expr:
        """The estimated local error of v, linear in knots' symbols."""
        return self.velocity.error

    @property
    def order(self) -> tuple[int, int]:
        """p of u and of v: the estimated errors are of order h^(p+1)."""
        return self.displacement.order, self.velocity.order

    @property
    def extra(self) -> Mapping[Symbol, str] | None:
        """Symbol -> what has to be kept or evaluated besides the step; None where the step holds everything."""
        both = {**self.displacement.extra, **self.velocity.extra}
        return both or None

    def at(self, **parameters: Any) -> "Estimator":
        """The same formulas at exact values of parameters left free. Raises NoEstimator where one is blind there."""
        exact = self.scheme.exact(parameters)
        found = []
        for name, one in (("u", self.displacement), ("v", self.velocity)):
            leading = one.leading.subs(exact, simultaneous=True)
            values = ", ".join(f"{s} = {value}" for s, value in exact.items())
            below = fraction(factor(one.error))[1].subs(exact, simultaneous=True)
            if below == 0 or factor(leading) == 0:
                raise NoEstimator(
                    f"{self.scheme.name}: the estimate {one.error} of the error of {name} is blind at {values}, where "
                    f"that error is not of order {one.order}; derive one for these values: "
                    f"estimator('{self.scheme.name}', {values})"
                )
            error = one.error.subs(exact, simultaneous=True)
            found.append(replace(one, error=error, leading=leading, family=None))
        return Estimator(_symbolic(self.scheme.fix(parameters)), *found)


def estimator(
    scheme: str | Scheme, *, held_only: bool = False, damped: bool = True, changing: bool = False, **parameters: Any
) -> Estimator:
    """The default estimator of a scheme: parameters given are fixed exactly, all others stay symbols.

    Formulas hold at almost all values of the symbols; `Estimator.at` refuses those where they do not. held_only: only
    what the step itself holds. damped: whether they have to hold with damping; without it they may be shorter.
    changing: whether they have to hold where the step changes, so that values of the step before are taken with kappa
    only, else two half steps. A value may be an expression in other parameters, or the argument of a family as a
    symbol. Raises NoEstimator, or DeclarationError for an unknown name or parameter.
    """
    declared = find(scheme)
    damped = damped and declared.takes_damping
    return _estimator(related(declared, parameters) if parameters else declared, held_only, damped, changing)


@cache
def _estimator(scheme: Scheme, held_only: bool, damped: bool, changing: bool) -> Estimator:
    analysis = analysis_of(_generic(scheme), damped)
    if scheme.constant is not None and not scheme.values:  # no symbol besides kappa, which steps may do without
        return _found(analysis, analysis, held_only, changing)
    return _found(analysis, analysis_of(_symbolic(scheme), damped, _highest(analysis)), held_only, changing)


@cache
def acceleration_lag(scheme: Scheme) -> int | None:
    """The power of h with which the acceleration in a scheme's state differs from the motion's own.

    At almost all parameters; None where the two are the same, or the state holds none. Where it is a number, a state
    belongs to the length of the step that led to it.
    """
    return analysis_of(_generic(scheme), scheme.takes_damping).lag


def _generic(scheme: Scheme) -> Evaluation:
    """The scheme at numbers for its parameters that have nothing to do with each other."""
    free = [p for p in scheme.parameters if p.symbol not in scheme.decided]
    values = {p.name: p.inside(Rational(31 + 7 * i, 97 + 12 * i)) for i, p in enumerate(free)}
    return Evaluation.at(ParameterSet.of(scheme, None, values))


def _symbolic(scheme: Scheme) -> Evaluation:
    return Evaluation.symbolic(scheme, (*scheme.values, kappa))


def estimator_at(parameters: ParameterSet, *, damped: bool = True, changing: bool = False) -> Estimator:
    """The default estimator at a parameter set, whose values may be irrational; there is no kappa in its formulas.

    damped, changing: as in `estimator`. Raises NoEstimator.
    """
    analysis = analysis_of(Evaluation.at(parameters), damped and parameters.scheme.takes_damping)
    return _found(analysis, analysis, False, changing)


def _highest(analysis: Analysis) -> int:
    return max(e.undamped_valuation or 0 for e in analysis.errors)


def _found(analysis: Analysis, exact: Analysis, held_only: bool, changing: bool) -> Estimator:
    """Chosen with numbers for the parameters, then solved for with those that are wanted."""
    one = analysis.motion.one
    uneven = analysis.uneven and exact is not analysis
    ratio = exact.evaluation.number(kappa) if uneven else exact.motion.one
    levels = LEVELS[:1] if held_only else WITHOUT_BEFORE if changing and not uneven else LEVELS
    chosen: list[Estimate | tuple[int, Family] | None] = [
        _second_value(analysis, exact, own) or _cheapest(analysis, one, own, levels) for own in (0, 1)
    ]
    last = LEVELS[-1]
    if any(isinstance(choice, tuple) and choice[0] == last for choice in chosen):  # half steps serve both
        for own, choice in enumerate(chosen):
            if isinstance(choice, tuple) and choice[0] > 0:
                chosen[own] = _cheapest(analysis, one, own, LEVELS[-1:]) or choice
    found = []
    for own, choice in enumerate(chosen):
        if choice is None:
            raise NoEstimator(_reason(exact, own, held_only))
        found.append(choice if isinstance(choice, Estimate) else _solved(analysis, exact, ratio, *choice))
    return Estimator(exact.evaluation, *found)


def _cheapest(analysis: Analysis, ratio: Any, own: int, levels: Iterable[int]) -> tuple[int, Family] | None:
    """The first level at which there are estimates, and these.

    An error whose leading term is due to damping alone is matched up to the first that is not, if possible.
    """
    error = analysis.errors[own]
    for top in sorted({error.valuation or 0, error.undamped_valuation or 0}, reverse=True):
        for level in levels:
            family = Family(analysis.evaluation, pool(analysis, level, ratio)[0], error, own, top)
            if not family.empty:
                return level, family
    return None


def _solved(analysis: Analysis, exact: Analysis, ratio: Any, level: int, family: Family) -> Estimate:
    """The default of a family, with the numbers that are wanted for the parameters."""
    own = family.own
    symbols, growth = family.sparsest(analysis.growths)
    values, extra = pool(exact, level, ratio)
    wanted = Family(exact.evaluation, values, exact.errors[own], own, family.top)
    combination = wanted.combination(symbols)
    if combination is None:  # they suffice for equal steps only
        generic = replace(family, values=pool(analysis, level, analysis.motion.one * GENERIC_RATIO)[0])
        symbols, growth = generic.sparsest(analysis.growths)
        combination = wanted.combination(symbols)
    if combination is None:
        raise NoEstimator(
            f"{exact.evaluation.scheme.name}: {symbols} suffice at some parameters only; give all of them"
        )
    return Estimate(
        error=combination,
        order=(family.error.valuation or 0) - 1 - own,
        growth=growth,
        extra={s: extra[s] for s in symbols if s in extra},
        of=f"{'uv'[own]}_1",
        leading=_leading(exact.evaluation, exact.errors[own], own),
        family=wanted,
    )


def _second_value(analysis: Analysis, exact: Analysis, own: int) -> Estimate | None:
    """From the declaration's second value: of higher order than the first, or else the error is that of the second."""
    scheme, name, one = analysis.evaluation.scheme, "uv"[own], analysis.motion.one
    second, first, end = EMBEDDED[own], END[own], knot(1)[own]
    if second not in analysis.values:
        return None
    difference, error = analysis.values[second] - analysis.values[first], analysis.errors[own]
    top = difference.valuation
    if top is None:
        raise NoEstimator(f"{scheme.name}: expected a second value of {name}_1 of another order, got {name}_1 itself")
    higher = difference.plus(error, one).valuation
    is_higher = higher is None or higher > top
    if not is_higher and top >= (error.valuation or 0):
        return None  # of the same order: the difference is no error of either
    growth = max(g.of((second, first), (one, -one)) for g in analysis.growths) - own
    shown = scheme.embedded[end] - scheme.report.get(end, end)
    wanted = exact.values[second] - exact.values[first]
    target = exact.errors[own] if is_higher else wanted
    return Estimate(
        error=(-shown if is_higher else shown).subs(exact.evaluation.values, simultaneous=True),
        order=top - 1 - own,
        growth=growth,
        extra={},
        of=f"{name}_1" if is_higher else f"the second value of {name}_1",
        leading=_leading(exact.evaluation, target, own),
        family=Family(exact.evaluation, exact.held, target, own, top),
    )


def _leading(evaluation: Evaluation, error: Expansion, own: int) -> Expr:
    """The leading term of an error in u or v, with c = 2*xi*omega and k = omega^2."""
    total: Expr = Integer(0)
    top = error.valuation or 0
    for (i, j, place), value in sorted(error.at_weight(top).items()):
        what = exact_motion(t).diff((t, place)) if place >= 0 else rest_of_force(t).diff((t, -1 - place))
        total += evaluation.field.expression(value) * (2 * xi * omega) ** i * omega ** (2 * j) * what
    return h ** (top - own) * (total if total.has(generator) else factor(total))


def _reason(exact: Analysis, own: int, held_only: bool) -> str:
    name, scheme = "uv"[own], exact.evaluation.scheme.name
    cure = (
        "leave held_only out to learn which value besides these measures it"
        if held_only
        else "nor does one with the end's acceleration, with the step before or with two half steps"
    )
    return (
        f"{scheme}: blind in {name}: no combination of {', '.join(map(str, exact.held))} equals its local error "
        f"{_leading(exact.evaluation, exact.errors[own], own)}; {cure}"
    )
