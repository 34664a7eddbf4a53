"""The loop over time of a structure: a clock proposes steps, each is computed, and the clock judges what came of it.

Steps that a kernel computes many at a time come as a `Stretch`, complete; the clock judges them at once.

There are two clocks: `FixedSteps` accepts each step as it comes, `ChosenSteps` estimates its error and may reject it.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple, Protocol

from ...core.arrays import Array
from ...core.outcome import Status
from ..model.memory import Memory
from ..solvers.complementarity import NotFound
from .steps import StructureSteps


class Trial(NamedTuple):
    """A step of length h to the time t, s: X (V, n), begun by march, and of each system the loads (J,) and an instant.

    advanced: whether it was begun by `StructureSteps.advance`.
    """

    march: StructureSteps
    X: Array
    loads: Sequence[Array]
    times: Sequence[float]
    t: float
    h: float
    advanced: bool = False


class Stretch(NamedTuple):
    """Complete steps of march to the times t (m,), s, none of which has failed.

    motion (m, 2 or 3, n): what the scheme reports after each; memories: what was committed then, of m rows; springs
    (m, 3, s): their elongations, forces and stored energies; counts (m, balances): iterations; state (S, n), memory:
    after the last. The first three are written anew in the next stretch.
    """

    march: StructureSteps
    t: Array
    motion: Array
    memories: Memory
    springs: Array
    counts: Array
    state: Array
    memory: Memory


class Clock(Protocol):
    """What gives a march its steps; done: how many of the total units of progress are; status: how the march ended."""

    unit: str
    total: int
    done: int
    status: Status

    def trials(self) -> Iterator[Trial | Stretch]:
        """The steps to compute, one after another, until the end or until the status says why there is none."""
        ...

    def accepted(self, step: Any) -> bool:
        """Whether the step counts, now that it is complete; then the next one goes on from it."""
        ...

    def failed(self, step: Trial) -> None:
        """Take note that Newton's iteration has not converged in the step, or that reactions were not found."""
        ...


def steps_taken(clock: Clock) -> Iterator[Trial | Stretch]:
    """The steps of a march that count, complete; X is written anew in the step after the next."""
    for step in clock.trials():
        try:
            if isinstance(step, Trial):
                step.march.complete(step.X, step.loads, step.times, advanced=step.advanced)
                step.march.commit(step.X, step.t)
            counts = clock.accepted(step)
        except NotFound:
            assert isinstance(step, Trial)
            clock.failed(step)
        else:
            if counts:
                yield step
