"""Schemes of n sub-steps of low order whose dissipation is all at high frequencies.

|1 - i gamma y|^(2n) - |P(iy)|^2 = (1 - rho_inf^2) (gamma y)^(2n) is the least low-frequency dissipation that n
sub-steps can have at a given rho_inf (Zhang et al. 2020 for n = 3): the coefficients of lower powers of y vanish, and
what is left is nowhere negative, which is the proof of stability.
"""

from collections.abc import Sequence
from typing import Any

from substep_derive.algebra.algebraic import Algebraic
from substep_derive.declare.symbols import gamma, rho_inf
from sympy import Expr, Poly, Symbol, cancel, factor, fraction, solve, together

from .answer import Budget
from .candidate import Candidate, caret, shown
from .least import ordered
from .search import Result, branches
from .stability_function import StabilityFunction, coefficient, is_stable, numbers_with, sign_at
from .wish import FREE, Wish


def least_damping(wish: Wish, budget: Budget) -> Result:
    """The candidates. Raises OutOfTimeError."""
    n, p = wish.sub_steps, wish.order
    free = wish.rho_inf == FREE
    radius: Any = rho_inf if free else wish.rho_inf
    why = [
        f"R = P/(1 - gamma z)^{n} with P of degree {n}: order {p} fixes P up to z^{p}, |R(oo)| = rho_inf its last",
        f"coefficient. Least damping: E = (1 - rho_inf^2) (gamma y)^{2 * n}, which is nowhere negative.",
    ]
    kept: list[Candidate] = []
    undecided = False
    for sign in (1, -1) if radius != 0 else (1,):
        unknown = [Symbol(f"p_{k}") for k in range(p + 1, n)]
        given = [coefficient(k, n) for k in range(p + 1)]
        function = StabilityFunction((*given, *unknown, sign * radius * (-gamma) ** n), p)
        equations = [factor(e) for e in function.excess[:-1] if e != 0]
        budget.begin_step(
            f"elimination of {len(unknown)} coefficients from {len(equations)} equations, R(oo) = {sign} rho_inf"
        )
        eliminated = _eliminate(equations, unknown, budget)
        if eliminated is None:
            undecided = True
            why.append(f"  R(oo) = {'-' if sign < 0 else ''}rho_inf: more than these were not eliminated.")
            continue
        values, left = eliminated
        function = StabilityFunction(tuple(cancel(e.subs(values)) for e in function.numerator), p)
        shared = _shared(left)
        why.append(f"  R(oo) = {'-' if sign < 0 else ''}rho_inf: what is left is {caret(factor(shared))} = 0")
        kept += _on_branches(function, shared, budget) if free else _at_numbers(function, shared, budget)
    if kept:
        why.append("Of these the error constant is least in size at the first one, which follows.")
        return Result("found", ordered(kept, "error_constant"), tuple(why))
    if free or undecided or not wish.one_stiffness:
        return Result("undecided", (), (*why, "No other way was tried."))
    return Result("none", (), (*why, "No gamma > 0 satisfies this, so that none has this least damping."))


def _eliminate(
    equations: Sequence[Expr], unknown: Sequence[Symbol], budget: Budget
) -> tuple[dict[Symbol, Expr], list[Expr]] | None:
    """Values of the unknowns as rational functions of gamma, from equations linear in one; and what is left."""
    values: dict[Symbol, Expr] = {}
    rest, open_ = list(equations), list(unknown)
    while open_:
        budget.begin_step(f"substitution for one of {', '.join(map(str, open_))}")
        linear = [(e, x) for e in rest for x in open_ if Poly(e, x).degree() == 1 and not Poly(e, x).LC().has(*open_)]
        if not linear:
            return None
        e, x = linear[0]
        value = cancel(solve(e, x)[0])
        values = {k: cancel(v.subs(x, value)) for k, v in values.items()} | {x: value}
        rest = [fraction(together(cancel(other.subs(x, value))))[0] for other in rest if other is not e]
        open_.remove(x)
    return values, [e for e in rest if cancel(e) != 0]


def _shared(left: Sequence[Expr]) -> Expr:
    """The polynomial whose roots are those that all have."""
    found = Poly(left[0], gamma) if left else Poly(0, gamma)
    for e in left[1:]:
        found = found.gcd(Poly(e, gamma))
    while found.degree() > 0 and found.eval(0) == 0:
        found = found.quo(Poly(gamma, gamma))
    return found.as_expr()


def _usable(function: StabilityFunction, number: Algebraic) -> bool:
    """Whether the numerator has a value there, and what is left of E is as it should be, exactly."""
    bottoms = [fraction(together(e))[1] for e in function.numerator]
    return all(sign_at(number, e) != 0 for e in bottoms) and is_stable(function.excess, number)


def _at_numbers(function: StabilityFunction, equation: Expr, budget: Budget) -> list[Candidate]:
    kept = []
    for number in numbers_with(equation) if equation.has(gamma) else []:
        budget.begin_step(f"E at gamma = {shown(number)}")
        if _usable(function, number):
            kept.append(Candidate(function, equation, (number, number)))
    return kept


def _on_branches(function: StabilityFunction, equation: Expr, budget: Budget) -> list[Candidate]:
    """Where the equation is linear in rho_inf, the intervals of gamma on which that goes from 1 to 0 without a turn."""
    p = Poly(equation, rho_inf)
    if p.degree() != 1:
        return []
    radius = cancel(-p.eval(0) / p.LC())
    kept = []
    for branch, _ in branches(radius, (), budget, proved_stable=True):
        if sign_at(branch.ends[0], radius - 1) == 0 and cancel(branch.equation.subs(rho_inf, radius)) == 0:
            kept.append(Candidate(function, branch.equation, branch.ends))
    return kept
