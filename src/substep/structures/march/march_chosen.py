"""March a structure with tol: what is kept of steps that it chooses, and what ends a run."""

from dataclasses import replace
from functools import partial

import numpy as np

from ...core.arrays import Array
from ...core.progress import shown
from ...core.response import Statistics, Status
from ...core.state import State
from ...run.clock import Control
from ..model.given import Dof
from .histories import Energies, accounted, held_at_start, selection
from .response import StructureResponse
from .step_control import ChosenSteps, Taken
from .steps import Run

PARTS = 1000  # of the span, for the bar


class ChosenHistories:
    """What a march with tol has so far: rows of u, v, a at the degrees of freedom asked for, energies, iterations."""

    def __init__(self, run: Run, places: list[int], account: bool, started: State | None) -> None:
        s = run.structure
        self.started = started
        self.run, self.select = run, selection(s, places)
        self.rows: list[Array] = [self.select(run.given)]
        self.times, self.lengths, self.counts = [run.time(0)], [0.0], [[0] * run.scheme.balances]
        self.energies = Energies.at_start(s, run.given[:2], run.time(0)) if account else None
        self.accounts = [] if self.energies is None else [self.energies.row]

    def add(self, taken: Taken) -> None:
        """A step."""
        if self.energies is not None:
            energies = self.energies.after(
                self.run.structure, taken.rows[:2], taken.t, taken.h, taken.load, taken.half_load
            )
            self.energies = energies._replace(loads=taken.next_load)
            self.accounts.append(energies.row)
        self.rows.append(self.select(taken.rows))
        self.times.append(taken.t)
        self.lengths.append(taken.h)
        self.counts.append(taken.counts)

    def response(self, march: ChosenSteps, status: Status, kept: list[Dof]) -> StructureResponse:
        """The rows so far, and how the march ended."""
        kinds, counts = min(len(row) for row in self.rows), np.array(self.counts[1:], np.int64)
        counts = counts.reshape(-1, self.run.scheme.balances)
        rows = np.array([row[:kinds] for row in self.rows])
        lengths, made = self.lengths[1:] or [np.nan], len(self.counts) > 1
        sums, most = (x.tolist() for x in (counts.sum(axis=0), counts.max(axis=0, initial=0)))
        statistics = Statistics(
            len(counts), march.rejected, march.failed, tuple(sums), tuple(most), min(lengths), max(lengths)
        )
        step = f"steps of up to {max(lengths):.3g}"
        return StructureResponse(
            rows[:, 0], rows[:, 1], counts, status, None if status == "completed" else march.t + march.proposed,
            self.run.structure, self.run.scheme, np.nan, rows[:, 2] if made and kinds == 3 else None,
            np.array(self.times), statistics,
            dofs=tuple(kept), account=accounted(
                self.run.scheme, self.accounts, status, step, held_at_start(self.run)
            ),
            started=self.started, last=partial(replace, march.stands),
        )  # fmt: skip


def march_chosen(
    run: Run, asked: Control, own_atol: bool, kept: list[Dof], account: bool, progress: bool, started: State | None
) -> StructureResponse:
    """The march with tol; own_atol: whether atol was given, else its part of u is one of the largest u so far.

    started: the state that the run begins at, None for the structure's start.
    """
    s, span = run.structure, asked.t_end - asked.t_begin
    share_u, atol_u = (0.0, asked.atol_u) if own_atol else (asked.atol_u, 0.0)
    march = ChosenSteps(run, replace(asked, atol_u=atol_u), (share_u, asked.share_v))
    found = ChosenHistories(run, [s.place(dof) for dof in kept], account, started)
    status: Status = "interrupted"  # unless it ends
    try:
        with np.errstate(all="ignore"), shown(PARTS, 0, progress, "march", "parts") as advance:
            done = 0
            for taken in march.steps():
                found.add(taken)
                now = int(PARTS * (taken.t - asked.t_begin) / span)
                advance(now - done)
                done = now
        status = march.status
    except KeyboardInterrupt:
        pass
    except Exception as error:  # as in a march with dt
        error.response = found.response(march, status, kept)  # type: ignore[attr-defined]
        error.add_note("what the march had done before is in the attribute `response` of this exception")
        raise
    return found.response(march, status, kept)
