"""Wish -> values of gamma: exact elimination, real-root isolation, and signs at algebraic numbers.

What is found or excluded is the stability function; `tables` makes a scheme of it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from substep_derive.algebra.algebraic import Algebraic
from substep_derive.declare.symbols import gamma, rho_inf
from sympy import Expr, Poly, Rational, cancel, expand, factor, fraction, gcd, together

from .answer import Budget
from .candidate import Candidate, caret, numerator_of, shown
from .least import between, fixed_numerator, least_for_every_radius, ordered
from .stability_function import (
    StabilityFunction,
    approximate,
    coefficient,
    is_stable,
    numbers_with,
    sign_at,
    stable_intervals,
)
from .wish import FREE, Wish

UNSTABLE = "E < 0 somewhere: unstable"


@dataclass(frozen=True)
class Result:
    """verdict: 'found', 'none' or 'undecided', why, and the candidates, the best first."""

    verdict: str
    candidates: tuple[Candidate, ...]
    why: tuple[str, ...]


def search(wish: Wish, budget: Budget) -> Result:
    """What the wish leaves, but for least damping at an order below n. Raises OutOfTimeError."""
    n, p = wish.sub_steps, wish.order
    if p > n + 1:
        return _too_high(wish, budget)
    if p == n + 1:
        return _highest(wish, budget)
    if p == n:
        if wish.rho_inf == FREE:
            return _free(wish, fixed_numerator(n, p), budget)
        return _one_parameter(wish, budget) if wish.rho_inf is None else _given_radius(wish, budget)
    if p == n - 1 and isinstance(wish.rho_inf, Rational):
        return _one_parameter(wish, budget)
    return Result(
        "undecided",
        (),
        (
            f"Order {p} leaves gamma and {n - p} coefficients of the numerator free, and least {wish.least} is decided",
            "here for a single free number: ask for least damping and a rho_inf, or for a higher order.",
        ),
    )


def _too_high(wish: Wish, budget: Budget) -> Result:
    n = wish.sub_steps
    if not wish.one_stiffness:
        why = (
            f"Order {n + 2} needs F(x) = prod_i (1 - gamma_i d/dx) x^{n + 2} to vanish with its derivative at x = 1:",
            f"up to factorials these are the coefficients of z^{n + 2} and z^{n + 1} in e^z prod_i (1 - gamma_i z).",
            "For real gamma_i each factor 1 - gamma_i d/dx keeps all zeros real (Hermite, Poulain), lowers by one the",
            "multiplicity of a zero that was there, and gives simple new ones: F has no double zero but x = 0.",
        )
        return Result("none", (), why)
    budget.begin_step("a common root of the two conditions of order n + 2")
    one, two = (coefficient(n + k, n) for k in (1, 2))
    shared = gcd(Poly(one, gamma), Poly(two, gamma))
    why = (
        f"R = P/(1 - gamma z)^{n} with P of degree {n}: order {n + 2} needs the coefficients of z^{n + 1} and",
        f"z^{n + 2} in e^z (1 - gamma z)^{n} to vanish: {caret(factor(one))} = 0 and {caret(factor(two))} = 0.",
        f"Their greatest common divisor is {caret(shared.as_expr())}, so that they have no common root.",
    )
    return Result("none" if shared.degree() == 0 else "undecided", (), why)


def _highest(wish: Wish, budget: Budget) -> Result:
    """Order n + 1: finitely many gamma."""
    n = wish.sub_steps
    function = fixed_numerator(n, n + 1)
    equation = Poly(coefficient(n + 1, n), gamma).clear_denoms(convert=True)[1].as_expr()
    why = [
        f"R = P/(1 - gamma z)^{n} with P of degree {n}: order {n + 1} fixes P, and needs the coefficient of z^{n + 1}",
        f"in e^z (1 - gamma z)^{n} to vanish: {caret(equation)} = 0 (n = 3: Crouzeix), so that gamma is not free.",
    ]
    kept = []
    for number in numbers_with(equation):
        budget.begin_step(f"A-stability at gamma = {shown(number)}")
        stable = is_stable(function.excess, number)
        radius = abs(float(function.at_infinity.subs(gamma, approximate(number))))
        verdict = "A-stable" if stable else UNSTABLE
        why.append(f"  gamma = {shown(number)}: {verdict}, |R(oo)| = {radius:.6g}...")
        if stable:
            kept.append(Candidate(function, equation, (number, number)))
    if wish.rho_inf == FREE:
        why.append("rho_inf takes no other values than these: it is not free.")
        return Result("none" if wish.one_stiffness else "undecided", (), (*why, *_differing(wish)))
    if isinstance(wish.rho_inf, Rational):
        radius = fraction(together(function.at_infinity))
        wished = expand(radius[0] ** 2 - wish.rho_inf**2 * radius[1] ** 2)
        kept = [one for one in kept if sign_at(one.ends[0], wished) == 0]
        why.append(f"rho_inf = {wish.rho_inf} at {len(kept)} of them: the sign of R(oo)^2 - rho_inf^2 there is exact.")
    if kept:
        return Result("found", tuple(kept), tuple(why))
    return Result("none" if wish.one_stiffness else "undecided", (), (*why, *_differing(wish)))


def _differing(wish: Wish) -> tuple[str, ...]:
    if wish.one_stiffness:
        return ()
    return (
        "Whether gamma_i that differ have it was not decided: they are decided here where one gamma meets the wish, or",
        "where the order is above n + 1.",
    )


def _given_radius(wish: Wish, budget: Budget) -> Result:
    """Order n and a number rho_inf: finitely many gamma."""
    n = wish.sub_steps
    function = fixed_numerator(n, n)
    why, kept = [*_order_n(function)], []
    for sign in (1, -1) if wish.rho_inf else (1,):
        equation = numerator_of(function.at_infinity - sign * wish.rho_inf)
        for number in numbers_with(equation):
            budget.begin_step(f"A-stability at gamma = {shown(number)}")
            stable = is_stable(function.excess, number)
            why.append(f"  gamma = {shown(number)}: {'A-stable' if stable else UNSTABLE}")
            if stable:
                kept.append(Candidate(function, equation, (number, number)))
    if not kept:
        return Result("none" if wish.one_stiffness else "undecided", (), (*why, *_differing(wish)))
    return Result("found", ordered(kept, wish.least), (*why, *_best(wish, kept)))


def _order_n(function: StabilityFunction) -> tuple[str, ...]:
    return (
        f"R = P/(1 - gamma z)^{function.n} with P of degree {function.n}: order {function.order} fixes P, and",
        f"R(oo) = {caret(function.at_infinity)}.",
    )


def _best(wish: Wish, kept: Sequence[Candidate]) -> tuple[str, ...]:
    best, *others = ordered(kept, wish.least)
    if not others:
        return ()
    return (f"Of {len(kept)} the least {wish.least.replace('_', ' ')} is at gamma = {shown(best.ends[0])}.",)


def _others(wish: Wish, best: Candidate, budget: Budget) -> tuple[str, ...]:
    """Where, of all stable functions of the order, others than those of the best branch are better."""
    low, high = sorted(best.ends, key=approximate)
    better = [
        f"  rho_inf from {one.low} to {one.high}: {one.piece.text}"
        for one in least_for_every_radius(wish.sub_steps, wish.least, budget)
        if not _contains((low, high), one.piece.low, one.piece.high)
    ]
    words = (
        f"Of all that are A-stable and of order {wish.order} the {wish.least.replace('_', ' ')} is least on this branch"
    )
    return (f"{words}, but for", *better) if better else (f"{words}.",)


# --- one free number -----------------------------------------------------------------------------------


def _one_parameter(wish: Wish, budget: Budget) -> Result:
    """gamma is free: where it is stable, and where the criterion is least in size there."""
    n, p = wish.sub_steps, wish.order
    kept: list[Candidate] = []
    why: list[str] = []
    for sign in (1, -1) if wish.rho_inf else (1,):
        last = () if p == n else (sign * wish.rho_inf * (-gamma) ** n,)
        function = fixed_numerator(n, p, last)
        criterion = function.least(wish.least)
        budget.begin_step("the intervals of gamma in which E >= 0")
        for low, high in stable_intervals(function.excess):
            ends = f"[{shown(low)}, {'oo' if high is None else shown(high)}]"
            why.append(f"P = {caret(_polynomial(function))} is A-stable for gamma in {ends}.")
            budget.begin_step(f"the least |{wish.least}| in {ends}")
            inside = [low, *([] if high is None else [high])]
            for equation in (criterion, criterion.diff(gamma)):
                inside += [x for x in numbers_with(equation) if between(x, low, high)] if equation.has(gamma) else []
            kept += [Candidate(function, x.polynomial.as_expr(gamma), (x, x)) for x in inside]
    if not kept:
        why.append("No gamma > 0 is A-stable.")
        return Result("none" if wish.one_stiffness else "undecided", (), (*why, *_differing(wish)))
    best = ordered(kept, wish.least)[0]
    why.append(
        f"Of its zeros, its stationary points and the ends, the {wish.least.replace('_', ' ')} is least in size at "
        f"gamma = {shown(best.ends[0])}."
    )
    return Result("found", (best,), tuple(why))


def _polynomial(function: StabilityFunction) -> str:
    return " + ".join(f"({factor(c)}) z^{k}" if k else str(c) for k, c in enumerate(function.numerator))


# --- every rho_inf in [0, 1] ---------------------------------------------------------------------------


def _free(wish: Wish, function: StabilityFunction, budget: Budget, *, proved_stable: bool = False) -> Result:
    """Branches gamma(rho_inf), each from rho_inf = 1 to rho_inf = 0 without a turn, on which E >= 0."""
    why, kept = [*_order_n(function)], []
    for branch, excluded in branches(function.at_infinity, function.excess, budget, proved_stable=proved_stable):
        low, high = sorted(branch.ends, key=approximate)
        where = f"gamma from {shown(branch.ends[0])} at rho_inf = 1 to {shown(branch.ends[1])} at rho_inf = 0"
        if excluded:
            why.append(f"  {where}: {excluded}")
        else:
            why.append(f"  {where}: R(oo) has no stationary point and E >= 0 in all of [{_short(low)}, {_short(high)}]")
            kept.append(Candidate(function, branch.equation, branch.ends))
    if kept:
        best = ordered(kept, wish.least)
        return Result("found", best, (*why, *_best(wish, kept), *_others(wish, best[0], budget)))
    for radius in (Rational(1), Rational(0), Rational(1, 2)):
        one = search(Wish(wish.sub_steps, wish.order, radius, wish.one_stiffness, wish.least), budget)
        if one.verdict == "none":
            why.append(f"There is none with rho_inf = {radius}, so that it is not free:")
            return Result("none", (), (*why, *one.why))
    return Result("undecided", (), (*why, "No branch joins rho_inf = 1 and 0; whether pieces of several do is open."))


def _short(number: Algebraic) -> str:
    return f"{float(approximate(number)):.6g}"


@dataclass(frozen=True)
class Branch:
    """An interval of gamma on which R(oo) goes from +-1 to 0 without a turn, and the equation of gamma at rho_inf."""

    equation: Expr
    ends: tuple[Algebraic, Algebraic]


def branches(
    at_infinity: Expr, excess: Sequence[Expr], budget: Budget, *, proved_stable: bool = False
) -> Iterator[tuple[Branch, str]]:
    """Every such interval, with what excludes it, or ''."""
    zeros = numbers_with(numerator_of(at_infinity))
    turns = numbers_with(numerator_of(cancel(at_infinity.diff(gamma))))
    poles = numbers_with(fraction(together(at_infinity))[1])
    cells = [] if proved_stable else stable_intervals(excess)
    for sign in (1, -1):
        equation = numerator_of(at_infinity - sign * rho_inf)
        ones = numbers_with(numerator_of(at_infinity - sign))
        marks = sorted([*((x, 0) for x in zeros), *((x, 1) for x in ones)], key=lambda mark: approximate(mark[0]))
        for (left, a), (right, b) in pairwise(marks):
            if a == b or any(between(x, left, right) for x in (*turns, *poles)):
                continue
            budget.begin_step(f"A-stability for gamma between {shown(left)} and {shown(right)}")
            ends = (left, right) if a == 1 else (right, left)
            covered = proved_stable or any(_contains(cell, left, right) for cell in cells)
            yield Branch(equation, ends), "" if covered else UNSTABLE


def _contains(cell: tuple[Algebraic, Algebraic | None], left: Algebraic, right: Algebraic | None) -> bool:
    low, high = cell
    if right is None:
        return high is None
    starts = low.shares_generator(left) or approximate(low) < approximate(left)
    ends = high is None or high.shares_generator(right) or approximate(right) < approximate(high)
    return starts and ends
