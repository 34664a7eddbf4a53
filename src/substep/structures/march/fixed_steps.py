"""Steps of a structure that are all of one length: each counts as it comes."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...core.arrays import Array
from ...core.outcome import Status
from ...run.schemes import carried, require_acceleration
from ..model.memory import Memory
from ..solvers.combine import combined
from .compiled import CompiledSteps
from .newton import NonlinearSystem, Tangent
from .scheme_plan import step_of
from .steps import Run
from .time_loop import Stretch, Trial

BLOCK = 256  # steps for which the loads are sampled at once
STRETCH = 2048  # steps that a kernel computes at once, as far as it computes them


class FixedSteps:
    """The clock of n steps of run.h, of which `done` were made before; march.steps.report @ X of a step are u, v, a.

    state (S, n): after those, by default where the run begins; tangents: that systems kept there; memory: what is
    remembered there; stands: `Pressing.stands` there. to_end: go on where a step overflows, as one of several cases
    may. singly: one by one, also where a kernel would compute them. Where another scheme marches the first steps, those
    are its own.
    """

    unit = "steps"

    def __init__(
        self,
        run: Run,
        n: int,
        done: int = 0,
        state: Array | None = None,
        tangents: Sequence[Tangent | None] = (),
        memory: Memory | None = None,
        stands: Sequence[Array] = (),
        *,
        to_end: bool = False,
        singly: bool = False,
    ) -> None:
        self.run, self.total, self.done, self.tangents, self.to_end = run, n, done, tangents, to_end
        self.memory, self.stands, self.singly = memory, stands, singly
        self.state = run.begin.rows if state is None else state
        self.status: Status = "completed"

    def trials(self) -> Iterator[Trial | Stretch]:
        """The steps. Raises ValueError for a singular effective matrix."""
        run, scheme, done, state = self.run, self.run.scheme, self.done, self.state
        memory = self.memory
        if state is None and scheme.starter is not None:
            history = [run.given]
            require_acceleration(scheme, *(len(step_of(one, run.h).report) for one in (scheme, scheme.starter)))
            starter = replace(run, scheme=scheme.starter)
            starting = FixedSteps(starter, min(scheme.starting_steps, self.total), singly=True)
            for step in starting.trials():
                yield step
                assert isinstance(step, Trial)
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
        march.begin(X, run.started() if state is None else state, memory, stands=self.stands)
        compiled = None if self.singly else CompiledSteps.of(march, min(STRETCH, self.total))
        first, begun = done, True
        while first < self.total:
            count = min(BLOCK if compiled is None else STRETCH, self.total - first)
            loads, ends = march.loads(first, count), run.time(np.arange(first, first + count) + 1)
            if compiled is not None:
                stretch = compiled.taken(X, loads, ends)
                if made := len(stretch.t):
                    yield stretch
                    march.begin(X, stretch.state, stretch.memory)
                    first, begun = first + made, True
                if made == count:
                    continue
                compiled = compiled if made or not self.to_end else None  # where a step overflows all others do
                count, loads, ends = 1, [x[made : made + 1] for x in loads], ends[made : made + 1]  # the one that fails
            for *rows, at, end in zip(*loads, march.times(first, count), ends.tolist(), strict=True):
                yield Trial(march, X, rows, at, end, run.h, not begun)
                if self.status != "completed":
                    return
                march.advance(X, after)
                X, after, first, begun = after, X, first + 1, False

    def accepted(self, step: Trial | Stretch) -> bool:
        """Whether it has not overflown, where that ends the march."""
        if isinstance(step, Stretch):
            self.done += len(step.t)
            return True
        step.march.look(step.X, step.times)
        last = step.march.steps.systems[-1].place
        if not (self.to_end or math.isfinite(float(step.X[last].sum()))):
            self.status = "non_finite"
            return False
        self.done += 1
        return True

    def failed(self, step: Trial) -> None:
        """End the march."""
        self.status = "newton_failed"
