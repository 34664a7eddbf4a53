"""Steps of a structure that are all of one length: each counts as it comes."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...core.arrays import Array
from ...core.response import Status
from ...run.schemes import carried, require_acceleration
from ..solvers.combine import combined
from .newton import NonlinearSystem, Tangent
from .scheme_plan import step_of
from .steps import Run
from .time_loop import Trial

BLOCK = 256  # steps for which the loads are sampled at once


class FixedSteps:
    """The clock of n steps of run.h, of which `done` were made before; march.steps.report @ X of a step are u, v, a.

    state (S, n): after those, by default where the run begins; tangents: that systems kept there. to_end: go on where a
    step overflows, as one of several cases may. Where another scheme marches the first steps, those are its own.
    """

    unit = "steps"

    def __init__(
        self,
        run: Run,
        n: int,
        done: int = 0,
        state: Array | None = None,
        tangents: Sequence[Tangent | None] = (),
        *,
        to_end: bool = False,
    ) -> None:
        self.run, self.total, self.done, self.tangents, self.to_end = run, n, done, tangents, to_end
        self.state = run.begin.rows if state is None else state
        self.status: Status = "completed"

    def trials(self) -> Iterator[Trial]:
        """The steps. Raises ValueError for a singular effective matrix."""
        run, scheme, done, state = self.run, self.run.scheme, self.done, self.state
        memory = None
        if state is None and scheme.starter is not None:
            history = [run.given]
            require_acceleration(scheme, *(len(step_of(one, run.h).report) for one in (scheme, scheme.starter)))
            starting = FixedSteps(replace(run, scheme=scheme.starter), min(scheme.starting_steps, self.total))
            for step in starting.trials():
                yield step
                if self.status != "completed":
                    return
                memory = step.march.memory
                history.append(run.with_acceleration(combined(step.march.steps.report, step.X), step.t, memory))
            if (done := starting.total) == self.total:
                return
            state = carried(scheme.history, done, lambda k, kind: history[k][kind])
        march = run.prepared(step_of(scheme, run.h))
        for solver, tangent in zip(march.systems, self.tangents, strict=False):
            if tangent is not None and isinstance(solver, NonlinearSystem):
                solver.keep(tangent)
        X, after = run.room(march.steps), run.room(march.steps)
        march.begin(X, run.started() if state is None else state, memory)
        for first in range(done, self.total, BLOCK):
            count = min(BLOCK, self.total - first)
            loads, times = march.loads(first, count), march.times(first, count)
            ends = run.time(np.arange(first, first + count) + 1).tolist()
            for n, (*rows, at, end) in enumerate(zip(*loads, times, ends, strict=True), first):
                yield Trial(march, X, rows, at, end, run.h, n > done)
                if self.status != "completed":
                    return
                march.advance(X, after)
                X, after = after, X

    def accepted(self, step: Trial) -> bool:
        """Whether it has not overflown, where that ends the march."""
        step.march.look(step.X, step.times)
        if not (self.to_end or math.isfinite(float(step.X[-1].sum()))):
            self.status = "non_finite"
            return False
        self.done += 1
        return True

    def failed(self, step: Trial) -> None:
        """End the march."""
        self.status = "newton_failed"
