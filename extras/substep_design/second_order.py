"""Where newmark_bdf2 is of second order and stable for every Omega > 0, and has a given rho_inf."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from substep_derive.algebra.algebraic import Algebraic, generator
from substep_derive.algebra.exact_number import exact_number
from substep_derive.declare.symbols import beta, gamma_t, lam
from substep_derive.stability.certificate import certify
from substep_derive.stability.conditions import Conditions, conditions
from substep_derive.study.derivation import derive
from substep_derive.study.equivalence import solutions
from sympy import Expr, Integer, Poly, Rational, cancel, factor, fraction, real_roots, together
from sympy.core.relational import Relational

from .parameters import limit


@dataclass(frozen=True)
class Region:
    """newmark_bdf2 at gamma = 1/2: beta as a function of gamma_t for which rho_inf has a given value.

    intervals: of gamma_t, as (low, high, low_closed, high_closed), where it is stable for every Omega > 0.
    """

    rho_inf: Rational
    beta: Expr
    intervals: tuple[tuple[Expr, Expr, bool, bool], ...]


def region(rho_inf: Any) -> tuple[Region, ...]:
    """Where newmark_bdf2 is of order 2, stable for every Omega > 0, and has a given rho_inf: curves in (gamma_t, beta).

    Raises TypeError for a float.
    """
    wished = exact_number(rho_inf)
    scheme = derive("newmark_bdf2", gamma=Rational(1, 2)).scheme
    p = limit(scheme)
    while p.eval(0) == 0:
        p = p.quo(Poly(lam, lam))
    stable = conditions(scheme)
    found = []
    for root in dict.fromkeys((wished, -wished)):
        for values in solutions([p.eval(root)], [beta]):
            curve = factor(values[beta])
            intervals = _stable_intervals(stable, curve)
            if intervals:
                found.append(Region(wished, curve, intervals))
    return tuple(found)


def _stable_intervals(stable: Conditions, curve: Expr) -> tuple[tuple[Expr, Expr, bool, bool], ...]:
    """The stable intervals of gamma_t on the curve, each decided at one rational between zeros of the inequalities."""
    sides = [e.lhs - e.rhs for condition in stable.inequalities for e in condition.atoms(Relational)]
    polynomials = [part for e in (*sides, beta) for part in fraction(together(e.subs(beta, curve)))]
    cuts: set[Any] = {Integer(0), Integer(1)}
    for e in polynomials:
        if e.has(gamma_t):
            cuts.update(r for r in real_roots(Poly(e, gamma_t)) if 0 < r < 1)
    ends = sorted(cuts)

    def holds(value: Expr) -> bool:
        if value in (0, 1) or fraction(together(curve))[1].subs(gamma_t, value) == 0:
            return False
        split = value if value.is_Rational else Algebraic.of(value)
        at = value if value.is_Rational else generator
        b = cancel(curve.subs(gamma_t, at))
        if curve.subs(gamma_t, value) < 0:
            return False
        weight = b if b.is_Rational else Algebraic(split.coefficients, split.interval, b)
        return certify(stable.scheme, gamma_t=split, beta=weight).stable

    found: list[tuple[Expr, Expr, bool, bool]] = []
    for low, high in pairwise(ends):
        if not holds(Rational(str(((low + high) / 2).n(12)))):
            continue
        if found and found[-1][1] == low and holds(low):
            found[-1] = (found[-1][0], high, found[-1][2], holds(high))
        else:
            found.append((low, high, holds(low), holds(high)))
    return tuple(found)
