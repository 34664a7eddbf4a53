"""Scheme -> order of u, v and a on nonlinear equations, the start included.

Let z be the exact motion at t_n, and Z_n(z) the numerical state there, as a series in the trees at z. Then
Z_(n+1)(z) = S(Z_n)(E^-1 z), with S a step and E the exact motion over h. Whatever the start, Z_n tends to a constant
series plus, in the level of the first weight at which a step is wrong, terms that grow with n or n^2 (v errs alike in
every step, u twice as often). The rest dies out with powers of the parasitic eigenvalues of a step as h -> 0, and is
filtered out exactly by a polynomial in the shift from n to n + 1 that vanishes at these. What is left, h^w n^j times a
tree with n = t/h, is an error of order w - j in u, w - 1 - j in v, w - 2 - j in a. Parasitic parts whose eigenvalues
tend to the unit circle are filtered out as well, but do not die out, and are errors of their own.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from sympy import QQ

from ..declare.symbols import kind_of, steps_back
from ..oscillator.evaluation import Evaluation
from ..oscillator.order import AtLeast, Triple
from .parasitic import annihilator, first_parasitic
from .step import StepSeries, exact, lag
from .trees import Level, Series, Trees, flow

HIGHEST_WEIGHT = 10  # of trees: enough to see that a scheme is of order 8, and not of order 9
HIGHEST_MIXED = 6  # with derivatives of the mass: enough for order 4
HIGHEST_OF_RATES = 7  # where forces have rates, with many more trees: enough for order 5


@dataclass(frozen=True)
class Error:
    """A tree in the error of u, v or a that makes its order what it is: coefficient*h^weight*n^growth, n = t/h."""

    quantity: str
    tree: str
    growth: int
    coefficient: Any


Errors = list[list[tuple[int, Error]]]  # for u, v, a: (order, error)


@dataclass(frozen=True)
class NonlinearOrder:
    """Orders of (u, v, a) at a fixed time, from consistent u_0, v_0, a_0, on smooth equations per unit mass.

    free: u'' = g(u). damped: u'' = g(u) - C u'. forced: u'' = g(u) + f(t). uva: all of these together. An order is
    `AtLeast` a number if no tree was found to be wrong. errors: of uva, for each of u, v, a one tree that is wrong.
    K0 is taken as any constant, so that it need not be the tangent where the motion has got to; what is given for
    N_discrete is taken as the mean of N along the line from one displacement to the other.
    """

    free: Triple
    damped: Triple
    forced: Triple
    uva: Triple
    errors: tuple[Error, ...]


def nonlinear_order(evaluation: Evaluation) -> NonlinearOrder:
    """The orders at the numbers that an evaluation has for the parameters.

    Raises InconsistentScheme for a step whose matrix as h -> 0 does not have the eigenvalue 1 exactly twice.
    """
    step = StepSeries(evaluation)
    seen: dict[int, Errors] = {}  # by weight, in all trees: those without damping or load are the same without it
    uva, errors = _order(step, (True, True), HIGHEST_WEIGHT, seen)
    found = [_order(step, kind, HIGHEST_WEIGHT, seen)[0] for kind in ((False, False), (True, False), (False, True))]
    return NonlinearOrder(*found, uva, errors)


def order_of_rates(evaluation: Evaluation, *, mixed: bool = False) -> tuple[Triple, tuple[Error, ...]]:
    """The orders of u, v, a on M(u) u'' = F(u, u'), and for each a tree that is wrong, as of `NonlinearOrder.errors`.

    Balances are read as mixtures of accelerations M(u)^-1 F(u, v) at knots, under which the equation is u'' = g(u, u'),
    with a load f(t) beside it (Arnold & Bruels, Multibody Syst. Dyn. 18 (2007) 185-202); `march` reads them so. mixed:
    as mixtures of forces of inertia M(u) a, without a load.

    Raises DeclarationError for a scheme of which it is not known at which velocities it takes forces, or that mixes
    more than accelerations, and InconsistentScheme as `nonlinear_order`.
    """
    step = StepSeries(evaluation, rates=True, mixed=mixed)
    return _order(step, (False, not mixed), HIGHEST_MIXED if mixed else HIGHEST_OF_RATES, {})


def _order(
    step: StepSeries, kind: tuple[bool, bool], highest: int, seen: dict[int, Errors]
) -> tuple[Triple, tuple[Error, ...]]:
    """Orders, and a tree that is wrong for each; kind: whether there is damping, and whether there is a load."""
    errors: Errors = [[], [], []]
    for weight in range(3, highest + 1):
        if weight in seen:
            absent = [mark for mark, there in zip("Cf", kind, strict=True) if not there]
            errors = [[pair for pair in own if not any(x in pair[1].tree for x in absent)] for own in seen[weight]]
        else:
            errors = _errors(step, step.trees(*kind), weight)
        if kind == (True, True):
            seen[weight] = errors
        lasting = min((order for own in errors for order, e in own if e.growth), default=weight)
        if lasting <= weight - 2:
            break
    orders, trees_wrong = [], []
    lasting = [pair for own in errors for pair in own if pair[1].growth]
    for own in errors:
        worst = min((*own, *lasting), key=lambda pair: pair[0], default=None)
        orders.append(worst[0] if worst else AtLeast(highest - 1))
        trees_wrong += [worst[1]] if worst else []
    return tuple(orders), tuple(trees_wrong)  # type: ignore[return-value]


def _errors(step: StepSeries, of: Trees, weight: int) -> Errors:
    """For u, v, a: (order, error) of each tree up to this weight that is wrong."""
    of.grow(weight)
    filtered, lasting = _filtered(step, of, weight)
    truth = exact(of, step.one, weight)
    found: Errors = [[], [], []]
    for k, quantity in enumerate("uva"):
        for w in range(weight + 1):
            samples = [sample[k][w] for sample in filtered]
            for tree in sorted({tree for level in samples for tree in level} | set(truth[k][w])):
                zero = step.one - step.one
                first, second, third = (level.get(tree, zero) for level in samples[:3])
                double = third - second - second + first
                slope, error = second - first, first - truth[k][w].get(tree, zero)
                growth = 2 if double else 1 if slope else 0
                coefficient = double * QQ(1, 2) if double else slope or error
                if coefficient:
                    what = Error(quantity, of.text(tree), growth, coefficient)
                    found[k].append((w - k - growth, what))
            for tree, coefficient in sorted(lasting[k][w].items()):
                found[k].append((w - k, Error(quantity, of.text(tree), 0, coefficient)))
    return found


def _filtered(step: StepSeries, of: Trees, weight: int) -> tuple[list[list[Series]], list[Series]]:
    """Three successive values of the reported u, h v, h^2 a without parasitic parts; and of these what does not die.

    That is what those parasitic eigenvalues give that tend to the unit circle, each part times a number.
    """
    march = _march(step, of, weight)
    first, states = [], []
    for _ in range(2):
        state, report = next(march)
        states.append(state)
        first.append(report)
    active = first_parasitic(step, *states)
    polynomial = annihilator(step, active, weight) if active is not None else [step.one]
    dying = annihilator(step, active, weight, lasting=True) if active is not None else polynomial
    lasts = len(dying) < len(polynomial)
    for _ in range(3 if lasts else 0):  # what grows with n^0, n^1 and n^2 is no parasitic part
        dying = [a - b for a, b in zip([step.one * 0, *dying], [*dying, step.one * 0], strict=True)]
    reports = first[1:]  # the report of the start is not the step's
    while len(reports) < max(len(polynomial) + 2, len(dying)):
        reports.append(next(march)[1])
    filtered = [[_mixed(polynomial, [r[k] for r in reports[i:]]) for k in range(3)] for i in range(3)]
    nothing: Series = [{} for _ in range(weight + 1)]
    return filtered, [_mixed(dying, [r[k] for r in reports]) if lasts else nothing for k in range(3)]


def _mixed(polynomial: Sequence[Any], samples: Sequence[Series]) -> Series:
    """The sum of c_j times the j-th sample."""
    if len(polynomial) == 1:
        return samples[0]
    total: Series = []
    for levels in zip(*samples[: len(polynomial)], strict=True):
        level: Level = {}
        for c, sample in zip(polynomial, levels, strict=True):
            for tree, value in sample.items():
                level[tree] = level[tree] + c * value if tree in level else c * value
        total.append({tree: c for tree, c in level.items() if c})
    return total


def _march(step: StepSeries, of: Trees, weight: int) -> Iterator[tuple[list[Series], list[Series]]]:
    """(state, report) after 0, 1, 2, ... of the scheme's own steps, in trees at the instant reached."""
    u, v, a = exact(of, step.one, weight)
    if step.starter is None:
        state = step.start(of, u, v)
        report = [u, v, a]
    else:
        rows, steps = [[u, v, a]], lag(step.scheme)
        state = step.starter.start(of, u, v)
        for _ in range(steps):
            state, report = ([flow(of, s, -1, step.one) for s in both] for both in step.starter.step(of, state))
            rows = [[flow(of, s, -1, step.one) for s in row] for row in rows]
            rows.append(report)
        state = [rows[steps - int(steps_back(s))][kind_of(s)] for s in step.state]
        report = rows[-1]
    while True:
        yield state, report
        state, report = ([flow(of, s, -1, step.one) for s in both] for both in step.step(of, state))
