"""`design`: a wish goes through the search for stability functions, their tables, and their declarations."""

from typing import Any, overload

from substep_derive.algebra.algebraic import Algebraic, generator
from substep_derive.algebra.points import simplest_between
from substep_derive.declare.errors import DeclarationError
from substep_derive.declare.parameter import Parameter, Root
from substep_derive.declare.scheme import Scheme
from substep_derive.declare.symbols import gamma, rho_inf
from substep_derive.declare.tableau import tableau
from sympy import Expr, Integer, Interval, Poly, Rational, Symbol, cancel, expand, factor

from .answer import Answer, Budget, Found, OutOfTimeError
from .candidate import Candidate, caret, shown
from .dissipation import least_damping
from .parameters import Design, parameters
from .search import Result, search
from .stability_function import QQ, approximate, numbers_with, sign_at, value_at
from .tables import Table, is_of_order, table_of
from .wish import Wish

Y = Symbol("y")


@overload
def design(scheme: str | Scheme, rho_inf: Any = None, order: int = 2) -> tuple[Design, ...]: ...
@overload
def design(
    *,
    sub_steps: int,
    order: int,
    rho_inf: Any = None,
    one_stiffness: bool = True,
    l_stable: bool = False,
    least: str = "error_constant",
    cpu_seconds: float = 60.0,
) -> Answer: ...
def design(
    scheme: str | Scheme | None = None,
    rho_inf: Any = None,
    order: int = 2,
    *,
    sub_steps: int | None = None,
    one_stiffness: bool = True,
    l_stable: bool = False,
    least: str = "error_constant",
    cpu_seconds: float = 60.0,
) -> "tuple[Design, ...] | Answer":
    """Exact parameters from requirements: of a declared scheme, or a composite scheme of so many sub-steps.

    Of a scheme (a name or a declaration): parameters that give this order and this spectral radius as Omega -> oo, a
    number or left open as rho; see `parameters.parameters`.

    With sub_steps: the schemes that take u and v by one rule, stable for every Omega > 0 and every damping ratio, of
    this order on linear and nonlinear problems, with rho_inf a number, "free" (every value in [0, 1], as a parameter)
    or None (any); l_stable: rho_inf = 0; one_stiffness: one effective stiffness for all sub-steps is required; least:
    "error_constant", "period_error" or "damping". The answer's verdict is "found", "none" with a proof, or "undecided"
    with what was tried, at the latest after cpu_seconds, which are looked at between exact steps.

    Raises DeclarationError for a wish that contradicts itself, TypeError for a float.
    """
    if (scheme is None) == (sub_steps is None):
        raise DeclarationError(
            "expected either a scheme, whose parameters are sought, or sub_steps, of which one is composed; got "
            f"{'neither' if scheme is None else 'both'}: design('generalized_alpha') or design(sub_steps=3, order=3)"
        )
    if scheme is not None:
        return parameters(scheme, rho_inf, order)
    wish = Wish.of(sub_steps, order, rho_inf, one_stiffness=one_stiffness, l_stable=l_stable, least=least)
    if not cpu_seconds >= 0:
        raise DeclarationError(f"expected CPU seconds of at least 0, got {cpu_seconds}; 60 is the default")
    budget = Budget(cpu_seconds)
    try:
        return _answer(wish, budget)
    except OutOfTimeError as error:
        tried = tuple(f"  done: {step}" for step in budget.done)
        why = f"{cpu_seconds:g} s of CPU time were allowed; {error}; allow more by cpu_seconds."
        return Answer(wish, "undecided", None, (why, *tried))


def _answer(wish: Wish, budget: Budget) -> Answer:
    below = wish.order < wish.sub_steps and wish.least == "damping" and wish.rho_inf is not None
    result: Result = least_damping(wish, budget) if below else search(wish, budget)
    why = list(result.why)
    if not result.candidates:
        return Answer(wish, result.verdict, None, tuple(why))
    best = result.candidates[0]
    budget.begin_step(f"a table for gamma = {shown(best.ends[0])}")
    made = table_of(best, budget)
    if made is None:
        why.append(
            f"These are of order {wish.order} on linear problems. Tables whose order holds on nonlinear ones are known "
            "here for order 2, for order n, and for order n + 1, up to order 4."
        )
        return Answer(wish, "undecided", None, tuple(why))
    if not wish.one_stiffness:
        why.append("One effective stiffness suffices; whether several would lessen the error was not decided.")
    budget.begin_step("the conditions of the order")
    return Answer(wish, "found", _found(best, *made, wish), tuple(why))


def _found(candidate: Candidate, table: Table, chosen: tuple[str, ...], wish: Wish) -> Found:
    """The scheme of a candidate, its order checked by the conditions of all trees."""
    function, p = candidate.function, candidate.function.order
    if not is_of_order(table, p, candidate):
        raise ArithmeticError(f"{wish.text}: the table {table.rows} is not of order {p}")
    one, nothing = candidate.ends
    number = None if candidate.is_branch else one
    rows, times = table.rows, table.times
    if number is not None:  # polynomials in gamma, of lower degree than its equation
        rows = tuple(tuple(_reduced(number, e) for e in row) for row in rows)
        times = tuple(_reduced(number, e) for e in times)
    name = f"composite_{function.n}_order_{p}"
    scheme = tableau(
        name, [[0], *rows], rows[-1], [0, *times], parameters=_parameters(candidate, table),
        reference=f"designed: {wish.text}",
    )  # fmt: skip
    error = function.error(p + 1)
    where = f"gamma = {shown(one)}"
    if number is None:
        where = f"gamma in {_interval(candidate)}, the root of {caret(candidate.equation)} = 0:"
        where += f" {shown(one)} at rho_inf = 1, {shown(nothing)} at rho_inf = 0"
    proof = (
        where,
        f"R(oo) = {caret(function.at_infinity)}",
        f"error constant {caret(factor(error))} = {_values(error, candidate)}",
        f"E = {_excess(candidate)} >= 0 for every y: |R| <= 1 on the imaginary axis, the pole 1/gamma is positive",
        *chosen,
        f"all conditions of order {p} hold exactly (rooted trees)",
        *(f"{_caret_row(row)} | ends at {caret(time)}" for row, time in zip(rows, times, strict=True)),
    )
    return Found(
        gamma=number,
        equation=candidate.equation,
        interval=(approximate(one), approximate(nothing)),
        numerator=function.numerator[2:],
        rho_inf=rho_inf if candidate.is_branch else _radius(candidate),
        error_constant=error,
        table=rows,
        times=times,
        scheme=scheme,
        proof=proof,
    )


def _reduced(number: Algebraic, e: Expr) -> Expr:
    """A rational function of gamma at the number gamma, as a polynomial in it."""
    field, value = value_at(number, e)
    return field.expression(value).subs(generator, gamma)


def _radius(candidate: Candidate) -> Expr:
    """|R(oo)| at one gamma."""
    at_infinity, number = candidate.function.at_infinity, candidate.ends[0]
    return at_infinity if sign_at(number, at_infinity) >= 0 else -at_infinity


def _interval(candidate: Candidate) -> str:
    low, high = sorted(approximate(x) for x in candidate.ends)
    return f"[{float(low):.6g}, {float(high):.6g}]"


def _values(e: Expr, candidate: Candidate) -> str:
    ends = dict.fromkeys(candidate.ends)
    if not candidate.is_branch and sign_at(candidate.ends[0], e) == 0:
        return "0"
    radii = (Integer(1), Integer(0))
    return " to ".join(
        f"{float(e.subs({gamma: approximate(x), rho_inf: r})):.6g}" for x, r in zip(ends, radii, strict=False)
    )


def _caret_row(row: tuple[Expr, ...]) -> str:
    return "   ".join(caret(e) for e in row)


def _excess(candidate: Candidate) -> str:
    function = candidate.function
    terms = [
        f"({caret(factor(e))}) y^{2 * k}"
        for k, e in enumerate(function.excess)
        if expand(e) != 0 and (candidate.is_branch or sign_at(candidate.ends[0], e))
    ]
    return " + ".join(terms) or "0"


def _parameters(candidate: Candidate, table: Table) -> tuple[Parameter, ...]:
    """gamma as the only root of its equation in an interval, and rho_inf where it is free; nothing for a rational."""
    one = candidate.ends[0]
    if not candidate.is_branch:
        if len(one.coefficients) == 2:
            return ()
        return (Parameter(gamma, Interval(*one.interval), Root(one.polynomial.as_expr(gamma))),)
    low, high = sorted(map(approximate, candidate.ends))
    return (
        Parameter(rho_inf, Interval(0, 1), Rational(1, 2)),
        Parameter(gamma, Interval(*_around(candidate, table, low, high)), Root(candidate.equation)),
    )


def _around(candidate: Candidate, table: Table, low: Rational, high: Rational) -> tuple[Rational, Rational]:
    """Two simple fractions close around the branch, free of turns of rho_inf and poles of the table."""
    radius = _solved(candidate.equation)
    equations = [cancel(radius.diff(gamma)), *(e for e in table.poles if e.has(gamma))]
    turns = [approximate(x) for e in equations for x in numbers_with(e)]
    room = (high - low) / 10
    below = max([low - room, *(x for x in turns if x < low)])
    above = min([high + room, *(x for x in turns if x > high)])
    ends = []
    for a, b in ((below, low), (high, above)):
        found = simplest_between(*(QQ(int(x.p), int(x.q)) for x in (Rational(a), Rational(b))))
        ends.append(Rational(int(found.numerator), int(found.denominator)))
    return ends[0], ends[1]


def _solved(equation: Expr) -> Expr:
    """rho_inf as a function of gamma, from an equation linear in it."""
    p = Poly(equation, rho_inf)
    return cancel(-p.eval(0) / p.LC())
