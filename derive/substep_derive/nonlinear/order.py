"""Scheme -> order of u, v and a on nonlinear equations, the start included.

Let z be the exact motion at t_n, and Z_n(z) the numerical state there, as a series in the trees at z. Then
Z_(n+1)(z) = S(Z_n)(E^-1 z), with S a step and E the exact motion over h. Whatever the start, Z_n tends to a constant
series plus, in the level of the first weight at which a step is wrong, terms that grow with n or n^2 (v errs alike in
every step, u twice as often). The rest dies out with powers of the parasitic eigenvalues of a step as h -> 0, and is
filtered out exactly by a polynomial in the shift from n to n + 1 that vanishes at these. What is left, h^w n^j times a
tree with n = t/h, is an error of order w - j in u, w - 1 - j in v, w - 2 - j in a.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from sympy import QQ

from ..declare.errors import InconsistentScheme
from ..declare.symbols import knot_of, lattice
from ..oscillator.evaluation import Evaluation
from ..oscillator.order import AtLeast, Triple
from .step import StepSeries, exact, lag
from .trees import Level, Series, Trees, flow, trees

HIGHEST_WEIGHT = 10  # of trees: enough to see that a scheme is of order 8, and not of order 9


@dataclass(frozen=True)
class Error:
    """A tree in the error of u, v or a that makes its order what it is: coefficient*h^weight*n^growth, n = t/h."""

    quantity: str
    tree: str
    growth: int
    coefficient: Any


@dataclass(frozen=True)
class NonlinearOrder:
    """Orders of (u, v, a) at a fixed time, from consistent u_0, v_0, a_0, on smooth equations of any size per unit mass.

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


def nonlinear_order(evaluation: Evaluation, highest_weight: int = HIGHEST_WEIGHT) -> NonlinearOrder:
    """The orders at the numbers that an evaluation has for the parameters.

    Raises InconsistentScheme for a step whose matrix as h -> 0 does not have the eigenvalue 1 exactly twice.
    """
    step = StepSeries(evaluation)
    kinds = ((False, False), (True, False), (False, True), (True, True))
    found = [_order(step, trees(*kind, step.reads_tangent), highest_weight) for kind in kinds]
    return NonlinearOrder(*(order for order, _ in found), found[-1][1])


def _order(step: StepSeries, of: Trees, highest: int) -> tuple[Triple, tuple[Error, ...]]:
    errors: list[list[tuple[int, Error]]] = [[], [], []]
    for weight in range(3, highest + 1):
        errors = _errors(step, of, weight)
        lasting = min((order for own in errors for order, e in own if e.growth), default=weight)
        if lasting <= weight - 2:
            break
    orders, trees_wrong = [], []
    lasting = [pair for own in errors for pair in own if pair[1].growth]
    for k, own in enumerate(errors):
        worst = min((*own, *lasting), key=lambda pair: pair[0], default=None)
        orders.append(worst[0] if worst else AtLeast(highest - k))
        trees_wrong += [worst[1]] if worst else []
    return tuple(orders), tuple(trees_wrong)  # type: ignore[return-value]


def _errors(step: StepSeries, of: Trees, weight: int) -> list[list[tuple[int, Error]]]:
    """For u, v, a: (order, error) of each tree up to this weight that is wrong."""
    of.grow(weight)
    filtered = _filtered(step, of, weight)
    truth = exact(of, step.one, weight)
    found: list[list[tuple[int, Error]]] = [[], [], []]
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
    return found


def _filtered(step: StepSeries, of: Trees, weight: int) -> list[list[Series]]:
    """Three successive values of the reported u, h v, h^2 a, without what dies out."""
    march = _march(step, of, weight)
    first, states = [], []
    for _ in range(2):
        state, report = next(march)
        states.append(state)
        first.append(report)
    active = _first_parasitic(step, *states)
    polynomial = annihilator(step, active, weight) if active is not None else [step.one]
    reports = first[1:]  # the report of the start is not the step's
    while len(reports) < len(polynomial) + 2:
        reports.append(next(march)[1])
    return [[_mixed(polynomial, [r[k] for r in reports[i:]]) for k in range(3)] for i in range(3)]


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
        at = [knot_of(s) or ("u", "0") for s in step.state]
        state = [rows[steps + int(lattice(label) or 0)]["uva".index(kind)] for kind, label in at]
        report = rows[-1]
    while True:
        yield state, report
        state, report = ([flow(of, s, -1, step.one) for s in both] for both in step.step(of, state))


def leading_matrix(step: StepSeries) -> list[list[Any]]:
    """The matrix of a step from state to state as h -> 0, in u, h v, h^2 a."""
    zero = step.one - step.one
    place = {s: j for j, s in enumerate(step.state)}
    rows: dict[Any, list[Any]] = {
        s: [step.one if i == j else zero for j in range(len(place))] for i, s in enumerate(step.state)
    }
    rows |= {s: [zero] * len(place) for s in step.unknowns}
    for equation, contributions in zip(step.equations, step.solution, strict=True):
        for s, c in equation.plain().items():
            if s in place:
                for j, factor in contributions:
                    rows[step.unknowns[j]][place[s]] += factor * c
    return [rows[s] for s in step.after]


def _first_parasitic(step: StepSeries, before: Sequence[Series], after: Sequence[Series]) -> int | None:
    """The lowest weight at which a step changes the state, in trees at the instant reached, in a parasitic part."""
    A = leading_matrix(step)
    for w in range(len(before[0])):
        numbers = sorted({tree for s in (*before, *after) for tree in s[w]})
        for tree in numbers:
            zero = step.one - step.one
            change = [y[w].get(tree, zero) - x[w].get(tree, zero) for x, y in zip(before, after, strict=True)]
            for _ in range(2):
                change = [
                    sum((a * x for a, x in zip(row, change, strict=True)), zero) - own
                    for row, own in zip(A, change, strict=True)
                ]
            if any(change):
                return w
    return None


def characteristic(matrix: Sequence[Sequence[Any]], one: Any) -> list[Any]:
    """The characteristic polynomial, from the constant term up (Faddeev and Le Verrier)."""
    n, zero = len(matrix), one - one
    identity = [[one if i == j else zero for j in range(n)] for i in range(n)]
    coefficients, power = [one], identity
    for k in range(1, n + 1):
        product = [
            [sum((matrix[i][m] * power[m][j] for m in range(n)), zero) for j in range(n)] for i in range(n)
        ]
        c = sum((product[i][i] for i in range(n)), zero) * QQ(-1, k)
        coefficients.append(c)
        power = [[product[i][j] + (c if i == j else zero) for j in range(n)] for i in range(n)]
    return coefficients[::-1]


def annihilator(step: StepSeries, active: int, weight: int) -> list[Any]:
    """A polynomial in the shift, 1 at 1, that vanishes at all that dies out up to this weight; from the constant term up.

    Parasitic parts that begin with the weight `active` enter a level linearly, m at a time from weight m*active + 2 on
    through derivatives of N; each weight more raises the power of n that stands beside a product of their eigenvalues.
    """
    one = step.one
    parasitic = characteristic(leading_matrix(step), one)
    for _ in range(2):
        parasitic = _without_root_1(parasitic)
        if parasitic is None:
            break
    if parasitic is None or not sum(parasitic, one - one):
        raise InconsistentScheme(
            f"{step.scheme.name}: as h -> 0 its step does not have the eigenvalue 1 exactly twice, so that start and "
            "errors do not die out"
        )
    found, m, products = [one], 1, parasitic
    while m == 1 or m * active + 2 <= weight:
        rest: list[Any] | None = products
        while rest is not None and not sum(rest, one - one):
            rest = _without_root_1(rest)
        size = sum(rest or [], one - one)
        for _ in range(weight - m * active - (2 if m > 1 else 0) + 1):
            found = _product(found, [c / size for c in rest or [one]])
        m, products = m + 1, _kronecker(products, parasitic, one)
    return found


def _without_root_1(p: Sequence[Any]) -> list[Any] | None:
    """p(x)/(x - 1), None where that leaves a rest."""
    quotient: list[Any] = []
    carry = p[-1] - p[-1]
    for c in reversed(p):
        carry = carry + c
        quotient.append(carry)
    return quotient[-2::-1] if not quotient[-1] else None


def _product(p: Sequence[Any], q: Sequence[Any]) -> list[Any]:
    zero = p[0] - p[0]
    product = [zero] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            product[i + j] = product[i + j] + a * b
    return product


def _power_sums(p: Sequence[Any], count: int) -> list[Any]:
    """Sums of the first powers of the roots of a polynomial whose leading coefficient is 1 (Newton's identities)."""
    c = list(reversed(p))
    sums: list[Any] = []
    for k in range(1, count + 1):
        total = c[k] * -k if k < len(c) else c[0] - c[0]
        for i in range(1, k):
            if i < len(c):
                total = total - c[i] * sums[k - i - 1]
        sums.append(total)
    return sums


def _kronecker(p: Sequence[Any], q: Sequence[Any], one: Any) -> list[Any]:
    """The polynomial whose roots are all products of a root of p and a root of q."""
    n = (len(p) - 1) * (len(q) - 1)
    sums = [a * b for a, b in zip(_power_sums(p, n), _power_sums(q, n), strict=True)]
    c = [one]
    for k in range(1, n + 1):
        total = sums[k - 1]
        for i in range(1, k):
            total = total + c[i] * sums[k - i - 1]
        c.append(total * QQ(-1, k))
    return c[::-1]
