"""Continuous piecewise linear functions, written by `larger` and `smaller`, of which roots have closed form."""

from collections.abc import Sequence
from itertools import combinations
from typing import Any, NamedTuple

from sympy import Expr, Ge, Gt, Le, Lt, Piecewise, S, Symbol, cancel, true

from .branches import larger, smaller
from .parameter import Parameter, positive


class _Part(NamedTuple):
    """A value, and what is positive where it holds: side*x + const, of which x is the symbol and side 1 or -1."""

    value: Expr
    gap: Expr
    side: int


def joined(e: Expr, x: Symbol, parameters: Sequence[Parameter]) -> Expr:
    """The expression with each Piecewise that is linear in x, and seen to be continuous there, by larger and smaller.

    Of those with at most one part on each side of a middle one.
    """
    if not e.has(Piecewise):
        return e
    args = [joined(arg, x, parameters) if isinstance(arg, Expr) else arg for arg in e.args]
    found = _joined(e, x, parameters) if isinstance(e, Piecewise) else None
    return (e.func(*args) if not isinstance(e, Piecewise) else e) if found is None else found


def _joined(e: Piecewise, x: Symbol, parameters: Sequence[Parameter]) -> Expr | None:
    *given, (middle, always) = e.args
    parts = [_part(value, condition, x, parameters) for value, condition in given]
    found = [p for p in parts if p is not None]
    if always != true or len(found) < len(parts) or not 0 < len(parts) < 3:
        return None
    if len(found) == 2 and found[0].side == found[1].side and _never(found[0].gap - found[1].gap, parameters):
        one, (value, gap, side) = found  # from one end to the other: the last is beyond the second
        middle, found = value, [one, _Part(middle, -gap, -side)]
    if any(a.side == b.side or not _never(a.gap + b.gap, parameters) for a, b in combinations(found, 2)):
        return None
    whole, bends = middle, list[Expr]()
    for part in found:
        bend = cancel((part.value - middle) / part.gap)  # continuous where the values part with the gap
        over, under = (positive(sign * bend, parameters, or_zero=True) for sign in (1, -1))
        if middle.has(Piecewise) or bend.has(x) or not (over or under):
            return None
        bends.append(bend)
        whole = (larger if over else smaller)(part.value, whole)
    # the outer of two is right where the inner holds if both bend to one side, or alike, as the edges of a strip
    alike = len(bends) < 2 or cancel(bends[0] + bends[1]) == 0 or positive(bends[0] * bends[1], parameters)
    return whole if alike else None


def _part(value: Any, condition: Any, x: Symbol, parameters: Sequence[Parameter]) -> _Part | None:
    if not isinstance(condition, Gt | Ge | Lt | Le) or value.diff(x, 2) != 0 or value.has(Piecewise):
        return None
    gap = condition.gts - condition.lts
    by = gap.diff(x)
    rises, falls = positive(by, parameters), positive(-by, parameters)
    if by.has(x) or not (rises or falls):
        return None
    return _Part(value, (gap / (by if rises else -by)).expand(), 1 if rises else -1)


def _never(e: Expr, parameters: Sequence[Parameter]) -> bool:
    """Whether it is seen not to be positive."""
    e = e.expand()
    return e == S.Zero or positive(-e, parameters, or_zero=True)
