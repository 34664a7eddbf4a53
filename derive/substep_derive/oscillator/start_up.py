"""The state from which a scheme's own steps begin, from u, v, a at t = 0, in any arithmetic."""

from collections.abc import Callable, Sequence
from typing import TypeVar

from sympy import Expr

from ..declare.symbols import kind_of, steps_back
from .amplification import Affine, Amplification

T = TypeVar("T")
Apply = Callable[[Affine, Sequence[T], Sequence[Expr]], Sequence[T]]


def start_up(amplification: Amplification, given: Sequence[T], apply: Apply) -> tuple[list[T], int]:
    """(the scheme's state, how many steps another scheme has marched) from given u_0, h*v_0, h^2*a_0.

    apply: gives what an Affine makes of a vector and, if there are any, of loads at instants in steps after t = 0.
    """
    scheme = amplification.scheme
    if scheme.start_scheme is None:
        if amplification.start is None:
            return [given[kind_of(s)] for s in scheme.state], 0
        return list(apply(amplification.start, given, amplification.start_stencil)), 0
    starter = Amplification.of(scheme.start_scheme)
    steps = int(max(map(steps_back, scheme.state)))
    history, state = [list(given)], start_up(starter, given, apply)[0]
    for k in range(steps):
        state, reported = stepped(starter, state, apply, k)
        history.append(reported)
    return [history[steps - int(steps_back(s))][kind_of(s)] for s in scheme.state], steps


def stepped(amplification: Amplification, state: Sequence[T], apply: Apply, k: int = 0) -> tuple[list[T], list[T]]:
    """The new state, and u, h*v, h^2*a reported at the end, of a step that begins at t = k h."""
    at = [k + tau for tau in amplification.stencil]
    after = list(apply(amplification.step, state, at))
    others = iter(apply(amplification.outputs, state, at) if amplification.outputs.N.rows else ())
    return after, [after[place] if place >= 0 else next(others) for place in amplification.in_state]
