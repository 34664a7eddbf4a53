"""Parasitic eigenvalues of a step as h -> 0, and the polynomial that filters out what dies out with their powers."""

from collections.abc import Sequence
from typing import Any

from sympy import QQ, Poly

from ..declare.errors import InconsistentScheme
from ..declare.symbols import lam
from ..oscillator.spectrum import on_circle
from .step import StepSeries
from .trees import Series


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


def first_parasitic(step: StepSeries, before: Sequence[Series], after: Sequence[Series]) -> int | None:
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
        product = [[sum((matrix[i][m] * power[m][j] for m in range(n)), zero) for j in range(n)] for i in range(n)]
        c = sum((product[i][i] for i in range(n)), zero) * QQ(-1, k)
        coefficients.append(c)
        power = [[product[i][j] + (c if i == j else zero) for j in range(n)] for i in range(n)]
    return coefficients[::-1]


def annihilator(step: StepSeries, active: int, weight: int, *, lasting: bool = False) -> list[Any]:
    """A polynomial in the shift, 1 at 1, that vanishes at all parasitic parts up to this weight, constant term first.

    lasting: it does not at those that do not die out, whose eigenvalues tend to the unit circle.

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
        if lasting and rest:
            whole = Poly.from_list(rest[::-1], lam, domain=step.evaluation.field.domain)
            rest = whole.quo(on_circle(whole)).rep.to_list()[::-1]
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
