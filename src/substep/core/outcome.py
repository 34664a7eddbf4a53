"""How a march has ended, what its steps have cost, and what has happened in it."""

from dataclasses import dataclass
from typing import Literal, NamedTuple, get_args

Ended = Literal["completed", "newton_failed", "non_finite", "energy_bound", "step_too_small"]
STATUSES: tuple[Ended, ...] = get_args(Ended)  # in the order of the kernels' numbers
Status = Ended | Literal["interrupted"]  # the latter from the keyboard: a march of a structure that is not done


@dataclass(frozen=True)
class Statistics:
    """What steps of chosen length have cost.

    accepted, rejected: steps; newton_failures: those of the rejected whose iteration did not converge.
    newton_iterations, newton_most: of each balance in the accepted steps, their sum and the most in one. shortest,
    longest: accepted steps, s; NaN if there is none.
    """

    accepted: int
    rejected: int
    newton_failures: int
    newton_iterations: tuple[int, ...]
    newton_most: tuple[int, ...]
    shortest: float
    longest: float


class Happening(NamedTuple):
    """At t (s) the contact or friction of that name closes, opens, is hit, slides, sticks or turns, as `what` says.

    what: "closes", "opens" or "hits", of a contact that is open again at once; "slides", "sticks" or "turns".
    """

    t: float
    name: str
    what: str
