"""The declaration of a composite scheme from its coefficients.

Knot 1 of the table is t_n itself, so that it costs nothing; every further knot is the end of a sub-step, the last one
t_n + h. Such a table is an explicit first stage with singly or multiply diagonally implicit ones, stiffly accurate
(ESDIRK; Kennedy & Carpenter, NASA/TM-2016-219173, section 2).
"""

from collections.abc import Sequence
from typing import Any

from sympy import Expr, Integer, sympify

from .errors import DeclarationError
from .parameter import Parameter
from .published import Published
from .scheme import Balance, Scheme
from .symbols import h, knot

LABELS = "gklmpqrs"  # of the ends of all sub-steps but the last


def composite(
    name: str,
    table: Sequence[Sequence[Any]],
    times: Sequence[Any],
    parameters: Sequence[Parameter] = (),
    reference: str = "",
    published: Published | None = None,
) -> Scheme:
    """The scheme that takes u and v by one rule: y_i = y_0 + h sum_j table[i][j] y'_j, an equation of motion at each.

    table: one row for each sub-step, of 2, 3, ... coefficients; the first weighs the rates at t_n and the last those at
    the sub-step's own end. times: of those ends in steps after t_n, the last of which is 1. Both are exact, rational in
    the parameters.

    Raises DeclarationError for rows of other lengths, for more than nine of them, or for a last time that is not 1.
    """
    if [len(row) for row in table] != list(range(2, len(times) + 2)) or not 1 <= len(times) <= len(LABELS) + 1:
        raise DeclarationError(
            f"{name}: expected 1 to {len(LABELS) + 1} rows of 2, 3, ... coefficients and as many times, got rows of "
            f"{[len(row) for row in table]} and {len(times)} times; write one row for each sub-step"
        )
    if sympify(times[-1]) != 1:
        raise DeclarationError(f"{name}: expected the last sub-step to end at 1, got {times[-1]}; scale the times")
    knots = [knot(0), *(knot(label) for label in LABELS[: len(times) - 1]), knot(1)]
    relations: dict[Any, Expr] = {}
    for end, row in zip(knots[1:], table, strict=True):
        for kind in (0, 1):  # u from velocities, v from accelerations
            sums = (sympify(weight) * at[kind + 1] for weight, at in zip(row, knots, strict=False))
            relations[end[kind]] = knots[0][kind] + h * sum(sums, Integer(0))
    balances = tuple(Balance.at(end, tau) for end, tau in zip(knots[1:], times, strict=True))
    return Scheme(name, relations, balances, tuple(parameters), reference=reference, published=published)
