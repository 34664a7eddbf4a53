"""What a march of a structure in steps that end at events keeps: rows of u, v, a, energies, reactions, iterations."""

from functools import partial

import numpy as np

from ...core.arrays import Array
from ...core.outcome import Status
from ...core.state import State
from ...marching.events import Stand
from ..model.given import Dof
from .histories import Kept
from .response import StructureResponse
from .spring_histories import SpringRows
from .structure_events import EventSteps, Passed


class EventHistories(Kept):
    """What such a march has so far; a row for each of its steps."""

    def __init__(self, clock: EventSteps, dofs: list[Dof], account: bool, started: State | None) -> None:
        super().__init__(clock.run, dofs, account, started)
        self.clock = clock
        self.springs = None if self.run.memory is None else SpringRows(self.run, 1, started)
        self.rows, self.times, self.touched = list[Array](), list[float](), list[Array]()
        self.middle = clock.march.reacting.middle
        self._put(clock.first)

    def add(self, step: Passed) -> None:
        """Steps."""
        forces, at = self.clock.march.reacting.forces, step.middle
        if self.energies is not None and at != self.middle:  # behind a jump
            self.energies = self.energies._replace(loads=forces.factors(self.times[-1], at))
        self.middle = at
        for x in step.stands:
            if self.energies is not None:
                h = x.t - self.times[-1]
                loads, half = (forces.factors(t, at) for t in (x.t, x.t - 0.5 * h))
                both, (memory, touched) = np.array([x.u, x.v]), x.memory
                self.energies = self.energies.after(self.run.structure, both, x.t, h, loads, half, memory, touched[0])
                self.accounts.append(np.array([self.energies.row]))
            if self.springs is not None and x.memory.memory is not None:
                self.springs.add(x.t, x.u, x.v, x.memory.memory, kept=True)
            self._put(x)

    def _put(self, x: Stand) -> None:
        self.rows.append(self.select(np.array([x.u, x.v] if x.a is None else [x.u, x.v, x.a])))
        self.times.append(x.t)
        self.touched.append(x.memory.touched)

    def response(self, status: Status) -> StructureResponse:
        """The rows so far, and how the march ended."""
        run, march, rows = self.run, self.clock.march, np.array(self.rows)
        counts, cost = march.statistics
        n, springs, failed = len(rows), self.springs, march.at.t + march.wanted
        return StructureResponse(
            rows[:, 0], rows[:, 1], counts[: n - 1], status, None if status == "completed" else failed,
            run.structure, run.scheme, np.nan, rows[:, 2] if self.kinds == 3 else None, np.array(self.times), cost,
            started=self.started, last=partial(getattr, self.clock, "stands"), happenings=tuple(march.happenings),
            dofs=tuple(self.dofs), account=self.account(n, status, f"steps of up to {cost.longest:.3g}"),
            springs=None if springs is None else springs.histories(n),
            remembered=None if springs is None else springs.remembered(n), touched=np.array(self.touched),
        )  # fmt: skip
