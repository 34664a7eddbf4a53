"""What a march of a structure keeps: rows of u, v, a, energies and iterations, in memory or on disk."""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.memory import require_memory
from ...core.outcome import Statistics, Status
from ...core.state import State
from ...run.clock import ConstantSteps
from ..model.contacts import Contacts
from ..model.given import Dof
from ..model.memory import Memory, RememberingForce
from ..model.model import Model
from ..solvers.combine import combined
from ..solvers.matrices import is_identity
from .energies import Energies, accounted, held_at_start
from .fixed_steps import BLOCK
from .fork import stands as stands_at
from .going_on import stands, stood
from .newton import Tangent
from .response import Account, StructureResponse
from .saved import Saved, described
from .scheme_plan import step_of
from .spring_histories import SpringRows
from .step_control import ChosenSteps
from .steps import Run
from .time_loop import Stretch, Trial


class Kept:
    """What marches with dt and with tol keep alike: the account of energy, and how rows of u, v, a are selected.

    run: the march; dofs: the degrees of freedom asked for; started: the state that it begins at, None for the
    structure's start. kinds: 3 where the scheme has an acceleration of its own, else 2: of u, v, a.
    """

    def __init__(self, run: Run, dofs: list[Dof], account: bool, started: State | None) -> None:
        s = run.structure
        self.run, self.dofs, self.started = run, dofs, started
        self.places = [s.place(dof) for dof in dofs]
        self.select = selection(s, self.places)
        self.kinds = len(step_of(run.scheme, run.h).report)
        self.energies = Energies.at_start(s, run.given[:2], run.time(0), run.memory) if account else None
        self.accounts = [] if self.energies is None else [np.array([self.energies.row])]  # rows (m, 5)

    def account(self, rows: int, status: Status, step: str) -> Account | None:
        """The account of the first rows; warns where the scheme has dissipated, or gained, much in steps like that."""
        found = np.concatenate(self.accounts)[:rows] if self.accounts else []
        impacts = isinstance(self.run.structure.contacts, Contacts)
        return accounted(self.run.scheme, found, status, step, held_at_start(self.run), impacts=impacts)


class Histories(Kept):
    """What a march in constant steps has so far: rows of u, v, a in memory or on disk, energies, and iterations.

    done, state, last, motion, tangents, memory, of_springs, stands and energies belong together and are set at once,
    last in a step: what a step that was interrupted has put elsewhere lies beyond `done` and does not count. last: the
    step.
    """

    def __init__(
        self,
        run: Run,
        asked: ConstantSteps,
        dofs: list[Dof],
        account: bool,
        save: str | Path | None,
        started: State | None,
    ) -> None:
        super().__init__(run, dofs, account, started)
        self.asked, self.stride, self.done = asked, asked.stride, 0
        self.sampled = 0, np.empty((0, 2, 0))
        shape = (asked.n // self.stride + 1, self.kinds, len(dofs))
        if save is None:
            require_memory(shape, "keep fewer dofs, a longer stride, or save= to a folder")
        self.springs = None if run.memory is None else SpringRows(run, shape[0], started)
        self.memory = run.memory
        self.of_springs = np.empty((3, 0))  # what `SpringRows.latest` was after the last step
        self.touched = list[Array]()  # of contacts, reactions and gaps (2, d) in each row
        self.reactions = run.reactions
        self.stands: Sequence[Array] = ()  # see `Pressing.stands`
        if run.reactions is not None:
            self.touched.append(run.touched)
        self.iterations = np.zeros((asked.n, run.scheme.balances), np.int64)
        self.state: Array | None = None
        self.last: Trial | None = None
        self.motion: Array | None = None  # u, v and, where the scheme has its own, a after a march that is resumed
        self.tangents: list[Tangent | None] = []
        self.saved = None
        if save is None:
            self.rows = np.empty(shape)
        else:
            choices = {"dofs": self.places, "stride": self.stride, "account": account}
            self.saved = Saved(save, shape, asked.n, run.h, lambda end: described(run, end, **choices))
            if self.saved.last is not None:
                self._resume(self.saved.last)
        if not self.done:
            self._put(0, self.select(run.given[: self.kinds]))

    def add(self, step: Trial | Stretch) -> None:
        """A step, or all of a stretch, with all that is kept of it."""
        if isinstance(step, Stretch):
            self._add_all(step)
            return
        march, X, done, energies = step.march, step.X, self.done + 1, self.energies
        counts, own = march.counts, march.run is self.run  # else another scheme marches the first steps
        self.iterations[done - 1] = counts if own else [sum(counts), *[0] * (self.run.scheme.balances - 1)]
        kept, memory = done % self.stride == 0, march.memory
        if self.springs is not None and memory is not None:
            self.springs.add(step.t, *combined(march.steps.report[:2], X), memory, kept=kept)
            self.springs.shortened = march.shortened
        reactions = None
        if self.touched:
            reactions, gaps = march.touched(X)
            self.touched += [np.array([reactions, gaps])] if kept else []
        if energies is not None:
            both = combined(march.steps.report[:2], X)
            energies = energies.after(self.run.structure, both, step.t, step.h, *self._loads(done), memory, reactions)
            if kept:
                self.accounts.append(np.array([energies.row]))
        if kept:
            self._put(done // self.stride, self.select(march.steps.report[: self.kinds], X))
        state = combined(march.steps.out, X) if self.saved is not None and own else None
        self._stand(done, state, energies, march.tangents, memory, step, self.motion, reactions)

    def _stand(
        self, done: int, state: Array | None, energies: Energies | None, tangents: list[Tangent | None],
        memory: Memory | None, last: Trial | None, motion: Array | None, reactions: Array | None = None,
    ) -> None:  # fmt: skip
        """Where the march is after a step, last, or after a stretch that ends with this motion (2 or 3, n)."""
        of_springs = self.of_springs if self.springs is None else self.springs.latest
        pressing = None if last is None else last.march.last_pressing
        self.stands = () if pressing is None else pressing.stands
        self.done, self.state, self.energies, self.tangents = done, state, energies, tangents
        self.memory, self.of_springs, self.last, self.motion = memory, of_springs, last, motion
        self.reactions = reactions
        if self.saved is not None and self.saved.full:
            self._checkpoint()

    def _add_all(self, steps: Stretch) -> None:
        s, march, motion, done = self.run.structure, steps.march, steps.motion, self.done
        force, energies, memories = s.internal, self.energies, steps.memories
        assert isinstance(force, RememberingForce)
        assert self.springs is not None
        numbers = np.arange(done + 1, done + len(motion) + 1)
        kept = slice(None) if self.stride == 1 else np.flatnonzero(numbers % self.stride == 0)
        self.iterations[done : numbers[-1]] = steps.counts
        self.springs.add_all(steps.springs, memories, kept)
        self.springs.shortened = march.shortened
        if energies is not None:
            loads, half = (s.load_values(self.run.time(n)) for n in (numbers, numbers - 0.5))
            held, stored = force.held(motion[:, 0], steps.springs[:, 1]), steps.springs[:, 2].sum(axis=1)
            if force.K is not None:
                stored += 0.5 * np.einsum("mn,mn->m", motion[:, 0], (force.K @ motion[:, 0].T).T)
            end, h = float(steps.t[-1]), self.run.h
            rows, energies = energies.along(s, motion[:, :2], end, h, loads, half, memories, held, stored)
            self.accounts.append(rows[kept])
        if len(rows := motion[kept, : self.kinds]):
            selected = self.select(rows.reshape(-1, s.size)).reshape(*rows.shape[:2], -1)
            first = done // self.stride + 1
            if self.saved is None:
                self.rows[first : first + len(selected)] = selected
            else:
                for place, row in enumerate(selected.copy(), first):
                    self.saved.put(place, row)
        self._stand(done + len(motion), steps.state, energies, march.tangents, steps.memory, None, motion[-1].copy())

    @property
    def kept(self) -> int:
        """How many rows there are."""
        return self.done // self.stride + 1

    def response(self, status: Status) -> StructureResponse:
        """The rows so far, and how the march ended."""
        run, asked = self.run, self.asked
        self._checkpoint()
        u, v, *a = self._read()
        last, springs = None, self.springs
        if self.last is not None:
            last = stands(self.last, run, self.done, asked, self.tangents, self.memory, self.reactions)
        elif self.motion is not None:  # there was no step left
            last = stood(self.motion, self.state, run, self.done, asked, self.tangents, self.memory, self.reactions)
        return StructureResponse(
            u, v, self.iterations[: self.done], status, None if status == "completed" else asked.time(self.done + 1),
            run.structure, run.scheme, self.stride * run.h, a[0] if a else None, asked.times(self.kept),
            started=self.started, last=last, dofs=tuple(self.dofs),
            account=self.account(self.kept, status, f"dt = {run.h:g}"),
            springs=None if springs is None else springs.histories(self.kept),
            remembered=None if springs is None else springs.remembered(self.kept),
            touched=np.array(self.touched[: self.kept]) if self.touched else None,
        )  # fmt: skip

    def _checkpoint(self) -> None:
        """Write what is in memory to the store, if there is one; rows only while another scheme marches the first."""
        if self.saved is None:
            return
        self.saved.write()
        if self.state is None:
            return
        if self.last is not None:
            self.motion = combined(self.last.march.steps.report, self.last.X)
        arrays: dict[str, Any] = {"state": self.state, "iterations": self.iterations[: self.done]}
        if self.motion is not None:
            arrays["motion"] = self.motion
        parts = [None if x is None else [x.t, x.largest] for x in self.tangents]
        numbers: dict[str, Any] = {"done": self.done, "tangents": parts, "sums": []}
        if self.energies is not None:
            arrays |= {"accounts": np.concatenate(self.accounts)[: self.kept], "energies": self.energies.both}
            numbers["sums"] = self.energies.sums
        if self.springs is not None and self.memory is not None:
            arrays |= self.springs.arrays(self.kept, self.of_springs, self.memory)
            numbers["shortened"] = self.springs.shortened
        arrays |= {f"tangent_{k}": x.at for k, x in enumerate(self.tangents) if x is not None}
        if self.reactions is not None:
            arrays |= {"touched": np.array(self.touched[: self.kept]), "reactions": self.reactions}
            arrays |= {f"stands_{k}": x for k, x in enumerate(self.stands)}
        self.saved.checkpoint(arrays, **numbers)

    def _read(self) -> list[Any]:
        """u, v and, where the scheme has its own, a."""
        if self.saved is None:
            return [self.rows[: self.kept, kind] for kind in range(self.kinds)]
        return self.saved.read(self.kept)

    def _loads(self, done: int) -> tuple[Array, Array]:
        """The values (J,) of the loads' functions at the end of step number `done`, and at its middle."""
        first, values = self.sampled
        if not first < done <= first + len(values):
            first = done - 1
            steps = np.arange(done, min(first + BLOCK, self.asked.n) + 1)
            ends_and_halves = (self.run.time(n) for n in (steps, steps - 0.5))
            values = np.stack([self.run.structure.load_values(t) for t in ends_and_halves], axis=1)
            self.sampled = first, values
        end, half = values[done - first - 1]
        return end, half

    def _put(self, place: int, row: Array) -> None:
        if self.saved is None:
            self.rows[place] = row
        else:
            self.saved.put(place, row)

    def _resume(self, last: dict[str, Any]) -> None:
        self.done, self.state, self.motion = last["done"], last["state"], last.get("motion")
        self.iterations[: self.done] = last["iterations"]
        self.tangents = [
            None if x is None else Tangent(x[0], last[f"tangent_{k}"], x[1]) for k, x in enumerate(last["tangents"])
        ]
        if self.springs is not None:
            self.memory = self.springs.resume(last, self.kept, last["shortened"])
            self.of_springs = self.springs.latest
        if self.touched:
            self.touched, self.reactions = [*last["touched"]], last["reactions"]
            self.stands = [last[f"stands_{k}"] for k in range(len(last)) if f"stands_{k}" in last]
        if self.energies is not None:
            self.accounts = [last["accounts"]]
            t, s = self.run.time(self.done), self.run.structure
            loads = s.load_values(np.array([t]))[0]
            found = Energies.of(s, last["energies"], t, loads, self.memory)
            self.energies = found._replace(reactions=self.reactions, **last["sums"])


class ChosenHistories(Kept):
    """What a march in steps of chosen length has so far: rows of u, v, a, energies, iterations and lengths."""

    def __init__(self, clock: ChosenSteps, dofs: list[Dof], account: bool, started: State | None) -> None:
        super().__init__(clock.run, dofs, account, started)
        self.clock = clock
        self.springs = None if self.run.memory is None else SpringRows(self.run, 1, started)
        self.rows: list[Array] = [self.select(clock.run.given[: self.kinds])]
        self.times, self.lengths = [self.run.time(0)], []
        self.again = 0  # steps that a march from a fork makes until the start
        self.before = self._place if clock.t < self.times[0] else None
        self.counts: list[list[int]] = []

    def add(self, step: Trial) -> None:
        """A step."""
        rows = self.clock.here[: self.kinds]
        self.lengths.append(step.h)
        self.counts.append(step.march.counts)
        if not self.clock.asked.behind(step.t):
            self.again, self.before = self.again + 1, self._place
            return
        if self.energies is not None:
            half, load, next_load = self.clock.energy_loads
            energies = self.energies.after(
                self.run.structure, rows[:2], step.t, self.clock.seen, load, half, self.clock.memory
            )
            self.energies = energies._replace(loads=next_load)
            self.accounts.append(np.array([energies.row]))
        if self.springs is not None and self.clock.memory is not None:
            self.springs.add(step.t, *rows[:2], self.clock.memory, kept=True)
            self.springs.shortened = self.clock.shortened
        self.rows.append(self.select(rows))
        self.times.append(step.t)

    @property
    def _place(self) -> tuple[float, Array]:
        """Where the clock is, s, and u, v, a there."""
        t, memory, (u, v, a) = self.clock.t, self.clock.memory, self.clock.here
        own = a if self.kinds == 3 else self.run.structure.acceleration(t, u, v, memory=memory)
        return t, self.select(np.array([u, v, own]))

    def response(self, status: Status) -> StructureResponse:
        """The rows so far, and how the march ended."""
        run, clock, rows = self.run, self.clock, np.array(self.rows)
        counts = np.array(self.counts, np.int64).reshape(-1, run.scheme.balances)
        lengths = self.lengths or [np.nan]
        sums, most = (x.tolist() for x in (counts.sum(axis=0), counts.max(axis=0, initial=0)))
        statistics = Statistics(
            len(counts), clock.rejected, clock.newton_failed, tuple(sums), tuple(most), min(lengths), max(lengths)
        )
        state, last = clock.stands, partial(replace, clock.stands)
        if status == "completed":
            last = partial(stands_at, state, run, clock.asked, clock.shares, clock.fork)
        elif self.started is not None and not clock.asked.behind(state.t):
            last = partial(replace, self.started)
        failed = None if status == "completed" else clock.t + clock.dt_next
        return StructureResponse(
            rows[:, 0], rows[:, 1], counts[self.again :], status, failed,
            run.structure, run.scheme, np.nan, rows[:, 2] if len(counts) and self.kinds == 3 else None,
            np.array(self.times), statistics,
            started=self.started, last=last, before=self.before, dofs=tuple(self.dofs),
            account=self.account(len(rows), status, f"steps of up to {max(lengths):.3g}"),
            springs=None if self.springs is None else self.springs.histories(len(rows)),
            remembered=None if self.springs is None else self.springs.remembered(len(rows)),
        )  # fmt: skip


def selection(structure: Model, places: list[int]) -> Any:
    """A function of rows (r, n), or of rows and vectors that they combine, to values (r, k) at degrees of freedom.

    Rows (r, n, L) of L load cases become (r, k, L); rows may be given back as they are.
    """
    part, columns = None, np.array(places, np.int64)
    if not structure.all_free:
        columns = np.unique(structure.T[places].indices)
        part = structure.T[places][:, columns]
        part = None if is_identity(part) else part
    every = np.array_equal(columns, np.arange(structure.size))

    def select(rows: Array, X: Array | None = None) -> Array:
        of = rows if X is None else X
        found = of if every else of[:, columns]
        if X is not None:
            found = combined(rows, found)
        if part is None:
            return found
        by_dof = np.moveaxis(found, 1, 0)
        rest = by_dof.shape[1:]
        return np.moveaxis((part @ by_dof.reshape(len(columns), math.prod(rest))).reshape(len(places), *rest), 0, 1)

    return select
