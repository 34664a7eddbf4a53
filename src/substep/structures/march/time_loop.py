"""The loop over time of a structure: a clock proposes steps, each is computed and judged, and what counts is kept.

There are two clocks: `FixedSteps` accepts each step as it comes, `ChosenSteps` estimates its error and may reject it.
"""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from ...core.arrays import Array
from ...core.progress import shown
from ...core.response import Status
from .newton import NewtonFailed
from .response import StructureResponse
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


class Clock(Protocol):
    """What gives a march its steps; done: how many of the total units of progress are; status: how the march ended."""

    unit: str
    total: int
    done: int
    status: Status

    def trials(self) -> Iterator[Trial]:
        """The steps to compute, one after another, until the end or until the status says why there is none."""
        ...

    def accepted(self, step: Trial) -> bool:
        """Whether the step counts, now that it is complete; then the next one goes on from it."""
        ...

    def failed(self, step: Trial) -> None:
        """Take note that Newton's iteration has not converged in the step."""
        ...


class Keeper(Protocol):
    """What keeps of each step what was asked for."""

    def add(self, step: Trial) -> None:
        """A step that counts."""
        ...

    def response(self, status: Status) -> StructureResponse:
        """What was kept, and how the march ended."""
        ...


def steps_taken(clock: Clock) -> Iterator[Trial]:
    """The steps of a march that count, complete; X is written anew in the step after the next."""
    for step in clock.trials():
        try:
            step.march.complete(step.X, step.loads, step.times, advanced=step.advanced)
            counts = clock.accepted(step)
        except NewtonFailed:
            clock.failed(step)
        else:
            if counts:
                yield step


def marched(clock: Clock, kept: Keeper, progress: bool) -> StructureResponse:
    """March to the end, or to what ends the run before it, and respond with what was kept until then.

    progress: whether to show a bar. An exception of a function of the user's, or of a tangent that is singular, carries
    the response until then.
    """
    status: Status = "interrupted"
    try:
        # a run that overflows ends with a status
        with np.errstate(all="ignore"), shown(clock.total, clock.done, progress, "march", clock.unit) as advance:
            done = clock.done
            for step in steps_taken(clock):
                if not math.isfinite(float(step.X[-1].sum())):
                    return kept.response("non_finite")
                kept.add(step)
                advance(clock.done - done)
                done = clock.done
        status = clock.status
    except KeyboardInterrupt:
        pass
    except Exception as error:
        error.response = kept.response(status)  # type: ignore[attr-defined]
        error.add_note("what the march had done before is in the attribute `response` of this exception")
        raise
    return kept.response(status)
