"""Estimator -> EndCheck: the acceleration at the end of a step against the one that the step took for granted there.

A floor that a step reaches only at its end acts on nothing but the acceleration there. Where that has no part in an
estimate - it is not evaluated, or has the same weight in v_1 and in the second value, or only the load is taken at the
end and the force before it - such a step looks exact. It is
then compared with the acceleration at the end that follows from the others by the polynomial through them.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sympy import QQ, Expr, Integer, Rational, Symbol, expand, factor

from ..algebra.algebraic import generator
from ..algebra.rational import SingularMatrix, matrix_inverse
from ..declare.scheme import Scheme
from ..declare.symbols import C, N, f, h, kind_of, knot_of
from ..step.step import Step
from .estimator import Estimate, Estimator
from .expansion import Expansion
from .held import END, HALVED, START
from .motion import SmoothMotion

# shares of h times the difference that count as an error of v: where it is of the estimate's order in h, and where it
# is of a lower one, and would else reject short steps of a smooth motion
SHARE, SHARE_OF_LOWER_ORDER = Rational(1, 16), Rational(1, 256)


@dataclass(frozen=True)
class EndCheck:
    """error: an error of v, 0 to leading order in a smooth motion, that the acceleration at the end has a part in.

    always: whether a step needs it; else only one without a step before it, where an estimate needs that step.
    """

    error: Expr
    always: bool


def end_check(found: Estimator, damped: bool) -> EndCheck | None:
    """What has to be asked besides the estimated errors; None where these see the end of every step."""
    damped, order = damped and found.scheme.takes_damping, min(found.order)
    motion = SmoothMotion(found.evaluation, 1, damped)
    step = motion.step
    first = len(step.unknowns) + len(step.state)
    loads = [k for k, tau in enumerate(step.stencil) if tau.subs(step.scheme.typical) >= 1]
    late = _late(motion, [first + k for k in loads])
    forces = _late(motion, [first + len(step.stencil) + k for k in _forces_at_the_end(motion)])
    seen = []
    for own, one in enumerate((found.displacement, found.velocity)):
        (by_load, before), (by_force, _) = (_sees(one, own, motion, kind) for kind in (late, forces))
        seen.append((by_load and by_force, before))
    if any(sees and not before for sees, before in seen):
        return None
    motion = SmoothMotion(found.evaluation, order + 2, damped)
    return EndCheck(_error(motion, late, order), not any(sees for sees, _ in seen))


def _forces_at_the_end(motion: SmoothMotion) -> list[int]:
    """Which forces are taken at t_n + h or later; those at mixtures of displacements act at their mixed instant."""
    field = motion.evaluation.field
    root = getattr(field, "root", None)
    typical = {**motion.step.scheme.typical, **({} if root is None else {generator: root.approximation()})}

    def late(times: list[Any]) -> bool:
        return any(float(field.expression(x).subs(typical)) > 1 - 1e-9 for x in times)

    return [k for k, times in enumerate(motion.equations.force_times) if late(times)]


def _late(motion: SmoothMotion, places: list[int]) -> Mapping[Symbol, list[Any]]:
    """Of each new symbol, times its power of h: its factors of the columns at some places, in a step of length 0."""
    step = motion.step
    columns = [[motion.equations.at_rest(row, place) for row in motion.equations.rows] for place in places]
    return {
        s: [-sum((x * c for x, c in zip(row, column, strict=True)), motion.zero) for column in columns]
        for s, row in zip(step.unknowns, motion.equations.inverse, strict=True)
    }


def _sees(one: Estimate, own: int, motion: SmoothMotion, late: Mapping[Symbol, list[Any]]) -> tuple[bool, bool]:
    """Whether the loads at the end have a part in an estimate, and whether that needs the step before."""
    ends, total = dict(zip(HALVED[:2], END[:2], strict=True)), [motion.zero] * len(late[END.a])
    symbols = {s for s in one.error.free_symbols if knot_of(s)}
    for s in sorted(symbols & {*late, *ends}, key=str):
        kind = kind_of(s)
        weight = motion.evaluation.number(_tidy(one.error.diff(s) * h ** (own - kind)))
        share = weight * QQ(2**kind, 4) if s in ends else weight  # the second of two steps of half the length
        total = [x + share * y for x, y in zip(total, late[ends.get(s, s)], strict=True)]
    return any(total), not symbols <= {*late, *ends, *motion.step.state, START.a}


def _error(motion: SmoothMotion, late: Mapping[Symbol, list[Any]], order: int) -> Expr:
    """The difference of the acceleration at the end from its extrapolation, h times it, times its share."""
    scheme, values = motion.step.scheme, motion.held()
    known: dict[Symbol, Expansion] = {}
    for s in (*scheme.unknowns, *scheme.state, START.a):
        if kind_of(s) == 2 and not any(late.get(s, ())) and all(values[s].terms != x.terms for x in known.values()):
            known[s] = values[s]
    end = values[END.a]
    factors = _extrapolation(motion, [*known.values()], end, order)
    number = motion.evaluation.field.expression
    defect, error = end, _end_symbol(scheme, motion.damped)
    for s, c in zip(known, factors, strict=True):
        defect = defect.plus(known[s], -c)
        error -= number(c) * s
    lower = defect.valuation is not None and defect.valuation < order + 2
    return _tidy((SHARE_OF_LOWER_ORDER if lower else SHARE) * h * error)


def _extrapolation(motion: SmoothMotion, known: list[Expansion], end: Expansion, order: int) -> list[Any]:
    """Factors of least squares with which accelerations give that at the end, for polynomials in time.

    They are exact up to the degree order - 1, or one that there are enough accelerations for.
    """
    for size in range(order, 0, -1):
        rows = [[x.terms.get((0, 0, 2 + m), motion.zero) for x in known] for m in range(size)]
        right = [end.terms.get((0, 0, 2 + m), motion.zero) for m in range(size)]
        products = [[sum((x * y for x, y in zip(a, b, strict=True)), motion.zero) for b in rows] for a in rows]
        try:
            inverse = matrix_inverse(products, motion.evaluation.field.domain)
        except SingularMatrix:
            continue
        y = [sum((x * c for x, c in zip(row, right, strict=True)), motion.zero) for row in inverse]
        return [sum((row[k] * c for row, c in zip(rows, y, strict=True)), motion.zero) for k in range(len(known))]
    raise AssertionError("the acceleration at the start is always known")


def _end_symbol(scheme: Scheme, damped: bool) -> Symbol:
    """a_*end, or the step's own symbol for the same."""
    u, v, _ = Step.of(scheme).reported
    for balance in scheme.balances:
        different = C * (balance.damping - v) if damped else Integer(0)
        if balance.inertia.is_Symbol and expand(different + balance.force - N(u) - balance.load + f(Integer(1))) == 0:
            return balance.inertia
    return END.a


def _tidy(e: Expr) -> Expr:
    return e if e.has(generator) else factor(e)
