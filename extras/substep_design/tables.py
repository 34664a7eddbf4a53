"""Stability function -> a table of sub-steps with it, whose order holds on nonlinear problems too.

Up to order 2 every sub-step but the last is trapezoidal. From order 3 on the first is, and the others satisfy the
condition of stage order 2, sum_j a_ij c_j = c_i^2/2, which leaves the conditions sum b c^k = 1/(k + 1) and, at order 4,
sum b a c^2 = 1/12. What is then free are times of sub-steps' ends: the fractions with denominators up to 5 inside the
step at which every coefficient is finite for all gamma asked for, and the principal error is least: the root of the sum
over the trees of order p + 1 of the squares of their coefficients in the error of one step (Hairer, Norsett & Wanner I,
II.3); where rho_inf is free, its geometric mean over both ends.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import permutations
from math import comb, prod
from typing import Any

from substep_derive.algebra.rational import RationalFunctions
from substep_derive.algebra.rooted_trees import residuals
from substep_derive.declare.symbols import gamma
from sympy import Expr, Integer, Matrix, Rational, Symbol, cancel, expand, factor, factor_list, fraction, together

from .answer import Budget
from .candidate import Candidate
from .stability_function import StabilityFunction, approximate, numbers_with, sign_at

HALF = Rational(1, 2)
TIMES = sorted({Rational(p, q) for q in range(2, 6) for p in range(1, q)})
HIGHEST_ORDER = 4


@dataclass(frozen=True)
class Table:
    """rows: coefficients of each sub-step, 2, 3, ... of them; times: of the sub-steps' ends, the last is 1."""

    rows: tuple[tuple[Expr, ...], ...]
    times: tuple[Expr, ...]

    @cached_property
    def square(self) -> tuple[list[list[Any]], list[Any], RationalFunctions]:
        """A and b, with the row of zeros of t_n, over the rational functions of their symbols."""
        symbols = sorted({s for row in self.rows for e in row for s in e.free_symbols}, key=str)
        field, size = RationalFunctions(symbols), len(self.rows) + 1
        full = [[field.number(Integer(0))] * size]
        full += [[*map(field.number, row), *[field.number(Integer(0))] * (size - len(row))] for row in self.rows]
        return full, full[-1], field

    def residuals(self, order: int) -> list[Expr]:
        """The coefficients of the trees of that order in the error of one step; all zero for the order."""
        A, b, field = self.square
        return [field.expression(field.domain.convert(e)) for e in residuals(A, b, order, field.number(Integer(1)))]

    @cached_property
    def poles(self) -> tuple[Expr, ...]:
        """Polynomials at whose zeros a coefficient is infinite, each once."""
        bottoms = [fraction(together(e))[1] for row in self.rows for e in row]
        return tuple(dict.fromkeys(base for e in bottoms for base, _ in factor_list(e)[1]))


def principal_error(table: Table, order: int) -> Expr:
    """The square of the principal error, a rational function of the table's symbols."""
    return factor(sum((e**2 for e in table.residuals(order + 1)), Integer(0)))


def is_of_order(table: Table, order: int, candidate: Candidate) -> bool:
    """Whether all conditions up to this order hold, identically or at the candidate's gamma, exactly."""
    rest = [e for k in range(1, order + 1) for e in table.residuals(k) if e != 0]
    return all(not candidate.is_branch and sign_at(candidate.ends[0], e) == 0 for e in rest)


def table_of(candidate: Candidate, budget: Budget) -> tuple[Table, tuple[str, ...]] | None:
    """A table with the candidate's stability function and the order, and how it was chosen; None where none is known.

    Raises OutOfTimeError.
    """
    function = candidate.function
    n, p = function.n, function.order
    if p <= 2:
        return _trapezoids(function), ()
    if n + 1 < p or p < n or p > HIGHEST_ORDER:
        return None
    free = [] if p > n else [Symbol(f"c_{k}") for k in range(3, n + 1)]
    general = _of_stage_order_2(function, free)
    if not free:
        return general, ()
    budget.begin_step(f"the principal error over the times {', '.join(map(str, free))}")
    error = principal_error(general, p)
    kept: list[tuple[Expr, dict[Symbol, Rational]]] = []
    finite: dict[Expr, bool] = {}
    for chosen in permutations(TIMES, len(free)):
        values = dict(zip(free, chosen, strict=True))
        budget.begin_step(f"poles of the table at {values}")
        for pole in (expand(e.subs(values)) for e in general.poles):
            if pole not in finite:
                finite[pole] = _is_nowhere_zero(pole, candidate)
            if not finite[pole]:
                break
        else:
            kept.append((cancel(error.subs(values)), values))
    kept.sort(key=lambda one: prod(_decimals(one[0], candidate)))
    if not kept:
        return None
    best, values = kept[0]
    everywhere = all(_not_below(other, best, candidate) for other, _ in kept[1:])
    table = Table(_at(general.rows, values), _at([general.times], values)[0])
    where = "in the geometric mean of rho_inf = 0 and 1" if candidate.is_branch else "at this gamma"
    where += ", and at every rho_inf between" if candidate.is_branch and everywhere else ""
    names = ", ".join(f"{k} = {v}" for k, v in values.items())
    why = (
        f"{names}: of {len(kept)} choices with denominators up to 5 that keep every coefficient finite, the one with",
        f"the least principal error {where};",
        f"its square is {' to '.join(f'{x:.4g}' for x in _decimals(best, candidate))}.",
    )
    return table, why


def _decimals(e: Expr, candidate: Candidate) -> list[float]:
    """The values at gamma, or at both ends of the branch."""
    return [float(e.subs(gamma, approximate(x))) for x in dict.fromkeys(candidate.ends)]


def _at(rows: Sequence[Sequence[Expr]], values: Mapping[Symbol, Expr]) -> tuple[tuple[Expr, ...], ...]:
    return tuple(tuple(factor(cancel(e.subs(values))) for e in row) for row in rows)


def _is_nowhere_zero(pole: Expr, candidate: Candidate) -> bool:
    """Whether a polynomial does not vanish at the candidate's gamma, or anywhere on its branch, ends included."""
    if not pole.has(gamma):
        return pole != 0
    if any(sign_at(end, pole) == 0 for end in candidate.ends):
        return False
    low, high = sorted(map(approximate, candidate.ends))
    return not (candidate.is_branch and numbers_with(pole, low, high))


def _not_below(other: Expr, best: Expr, candidate: Candidate) -> bool:
    """Whether one error is at least another one on the whole branch: their difference has no zero in it."""
    difference = cancel(other - best)
    if any(sign_at(end, difference) < 0 for end in candidate.ends):
        return False
    low, high = sorted(map(approximate, candidate.ends))
    return not (candidate.is_branch and difference.has(gamma) and numbers_with(difference, low, high))


# --- tables --------------------------------------------------------------------------------------------


def _moments(function: StabilityFunction) -> list[Expr]:
    """m_k = b^T A^(k-1) 1 (m_0 = 1), which are what P holds: p_k = sum_i binomial(n, i) (-gamma)^i m_(k-i)."""
    n = function.n
    found: list[Expr] = []
    for k, p in enumerate(function.numerator):
        found.append(cancel(p - sum((comb(n, i) * (-gamma) ** i * found[k - i] for i in range(1, k + 1)), Integer(0))))
    return found


def _trapezoids(function: StabilityFunction) -> Table:
    """Trapezoidal sub-steps of 2 gamma h, then weights of all rates, from the moments: linear equations."""
    n, m = function.n, _moments(function)
    rows: list[tuple[Expr, ...]] = [(gamma, *[2 * gamma] * (i - 1), gamma) for i in range(1, n)]
    inner = [(Integer(0),) * n, *((*row, *[Integer(0)] * (n - len(row))) for row in rows)]
    powers = [Matrix([Integer(1)] * n)]
    for _ in range(n - 1):
        powers.append(Matrix(inner) * powers[-1])
    # m_k = sum_j b_j v_k[j] + gamma m_(k-1), since the last rate's own row is b
    right = Matrix([m[k] - gamma * m[k - 1] for k in range(1, n + 1)])
    weights = Matrix([list(v) for v in powers]).LUsolve(right)
    last = (*(factor(cancel(e)) for e in weights), gamma)
    return Table((*rows, last), (*(2 * gamma * i for i in range(1, n)), Integer(1)))


def _of_stage_order_2(function: StabilityFunction, free: Sequence[Symbol]) -> Table:
    """Two to four sub-steps of order 3 or 4; free: the times c_3 (and c_4), or nothing where the order decides them."""
    n, m = function.n, _moments(function)
    c2 = 2 * gamma
    sums = [HALF - gamma, 2 * m[3] - gamma if n > 2 else None, Rational(1, 4) - gamma]
    c = [c2, *free]
    if n == 3 and not free:  # order 4: the rule with the ends c_2, c_3 and 1 is exact for c^3
        c.append(factor(cancel((sums[2] - c2 * sums[1]) / (sums[1] - c2 * sums[0]))))
    powers = Matrix([[x**k for x in c] for k in range(1, n)])
    b = [factor(cancel(e)) for e in powers.LUsolve(Matrix(sums[: n - 1]))]
    inner = [[] for _ in range(n - 2)]
    if n > 2:
        inner[0] = [factor(cancel((c[1] ** 2 / 2 - gamma * c[1]) / c2))]
    if n > 3:
        left = 2 * m[4] - gamma * 2 * m[3] - b[0] * gamma * c2**2 - b[1] * (inner[0][0] * c2**2 + gamma * c[1] ** 2)
        left -= b[2] * (c2 * (c[2] ** 2 / 2 - gamma * c[2]) + gamma * c[2] ** 2)
        a43 = factor(cancel(left / (b[2] * c[1] * (c[1] - c2))))
        inner[1] = [factor(cancel((c[2] ** 2 / 2 - gamma * c[2] - a43 * c[1]) / c2)), a43]
    rows = [(gamma, gamma)]
    for time, row in zip(c[1:], inner, strict=True):
        rows.append((factor(cancel(time - sum(row) - gamma)), *row, gamma))
    rows.append((factor(cancel(1 - sum(b) - gamma)), *b, gamma))
    return Table(tuple(rows), (*c, Integer(1)))
