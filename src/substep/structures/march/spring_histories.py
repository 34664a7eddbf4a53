"""What springs did in a march: elongations, forces, energies, and what an internal force has remembered."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.memory import require_memory
from ...core.state import State
from ..model.memory import WORK, Memory, Recalled, RememberingForce
from .steps import Run


@dataclass(frozen=True, eq=False)
class SpringHistories:
    """Of s springs, (n+1, s) each: elongations, forces, stored and dissipated energy.

    dissipated: by the law's own account, exactly along the path, where it keeps one; else the work of the force by the
    trapezoidal rule over each step, less what is stored. lengths (s,): as the structure has them, None without.
    shortened: corrections of Newton's iteration that had gone too far, as they do where the branch of a spring changes.
    work (s,): what went into them until the last step, to go on from; None where each law keeps its own account.
    """

    elongations: Array
    forces: Array
    stored: Array
    dissipated: Array
    lengths: Array | None = None
    shortened: int = 0
    work: Array | None = None

    @property
    def ratios(self) -> Array:
        """Elongations over lengths (n+1, s), as drift ratios of stories. Raises ValueError without lengths."""
        if self.lengths is None:
            raise ValueError("expected lengths of the springs for ratios, got none; give heights= of the stories")
        return self.elongations / self.lengths

    def between(self, before: NDArray[np.intp], after: NDArray[np.intp], share: Array) -> "SpringHistories":
        """Rows that lie between two of these each, a share (m,) of the way, on straight lines."""
        rows = (self.elongations, self.forces, self.stored, self.dissipated)
        found = (x[before] + share[:, None] * (x[after] - x[before]) for x in rows)
        return SpringHistories(*found, self.lengths, self.shortened, self.work)

    def loop(self, spring: int) -> tuple[Array, Array]:
        """Elongation and force (n+1,) of one spring, to draw one over the other."""
        return self.elongations[:, spring], self.forces[:, spring]


class Table:
    """Rows (m, ..), with room for more; what is added is copied."""

    def __init__(self, row: Any, room: int) -> None:
        self.every, self.count = np.empty((room, *np.shape(row)), np.asarray(row).dtype), 0

    def add(self, rows: Array) -> None:
        """Rows (k, ..)."""
        first, self.count = self.count, self.count + len(rows)
        if self.count > len(self.every):
            before, self.every = self.every, np.empty((2 * self.count, *self.every.shape[1:]), self.every.dtype)
            self.every[:first] = before[:first]
        self.every[first : self.count] = rows


class SpringRows:
    """Collects what springs do, and what is remembered, row by row.

    accounts: of each group of springs whose law keeps account of what it dissipates its number, and where it remembers
    that. The work of forces is added up only where some law does not: from where the march goes on, if it is known
    there, else from what is stored at its start.
    """

    def __init__(self, run: Run, rows: int, started: State | None) -> None:
        force = run.structure.internal
        assert isinstance(force, RememberingForce)
        assert run.memory is not None
        self.force, self.shortened, size = force, 0, 0
        self.accounts = list[tuple[int, int]]()
        if force.springs is not None:
            size = force.springs.size
            laws = [law.memory for law, _ in force.springs.groups]
            self.accounts = [(k, names.index("dissipated")) for k, names in enumerate(laws) if "dissipated" in names]
            require_memory((rows, 4 + max(map(len, laws)), size), "keep a longer stride")
        self.adds_work = force.springs is not None and len(self.accounts) < len(force.springs.groups)
        self.rows, self.work = Table(np.zeros((3, size)), rows), Table(np.zeros(size), rows if self.adds_work else 0)
        self.kept = [Table(x, rows) for x in run.memory.springs]  # and of states of a material, by name
        self.states = {name: Table(x, rows) for name, x in run.memory.states.items()}
        self.latest = np.zeros((3, size))  # elongations, forces and work after the last step
        self.before = None if started is None else started.memory.get(WORK)
        if self.adds_work and self.before is not None and np.shape(self.before) != (size,):
            raise ValueError(
                f"expected {WORK} in the memory of start of shape ({size},), got {np.shape(self.before)}; give what "
                "r.state.memory has"
            )
        u, v, _ = run.given
        self.add(run.time(0), u, v, run.memory, kept=True)

    def add(self, t: float, u: Array, v: Array, memory: Memory, *, kept: bool) -> None:
        """A step that ends at t with u, v (n,), where the memory was committed; kept: whether it is a row."""
        row = np.zeros((1, 3, 0))
        if self.force.springs is not None:
            found = self.force.answer(t, u, v, Recalled(memory)).of_springs
            assert found is not None
            row = np.array([[found.e, found.force, found.stored]])
        self.add_all(row, memory.at(None), slice(None) if kept else slice(0))

    def add_all(self, rows: Array, memories: Memory, kept: Any) -> None:
        """Steps (m, 3, s), as `Stretch.springs`, and what was remembered after each; kept: which of them are rows here.

        The first row that is added is the start.
        """
        (e, q, work), (e_1, q_1) = self.latest, rows[-1, :2]
        if self.adds_work:
            if not self.rows.count:
                work = rows[0, 2] if self.before is None else np.asarray(self.before)
            every = np.concatenate([np.array([[e, q]]), rows[:, :2]]) if self.rows.count else rows[[0, 0], :2]
            steps = 0.5 * (every[:-1, 1] + every[1:, 1]) * np.diff(every[:, 0], axis=0)
            steps[0] += work
            done = np.cumsum(steps, axis=0)
            self.work.add(done[kept])
            work = done[-1]
        self.latest = np.array([e_1, q_1, work])
        self.rows.add(rows[kept])
        for table, x in zip(self.kept, memories.springs, strict=True):
            table.add(x[kept])
        for name, x in memories.states.items():
            self.states[name].add(x[kept])

    def remembered(self, rows: int) -> Memory:
        """What was remembered in the first rows."""
        states = {name: table.every[:rows] for name, table in self.states.items()}
        return Memory(tuple(table.every[:rows] for table in self.kept), states)

    def arrays(self, rows: int, latest: Array, memory: Memory) -> dict[str, Array]:
        """What a store keeps to go on from: the first rows, and `latest` and the memory after the last step."""
        every = Memory.joined([self.remembered(rows), memory.at(None)])
        found = {f"memory {k}": x for k, x in enumerate(every.springs) if x.size}
        found |= {f"state {name}": x for name, x in every.states.items()} | {"latest": latest}
        found |= {"springs": self.rows.every[:rows], "spring_work": self.work.every[:rows]}
        return {name: x for name, x in found.items() if x.size}

    def resume(self, arrays: Mapping[str, Any], rows: int, shortened: int) -> Memory:
        """Go on from what `arrays` has given; returns the memory after the last step."""
        memory = [arrays.get(f"memory {k}", np.zeros((rows + 1, *x.every.shape[1:]))) for k, x in enumerate(self.kept)]
        states = {name: arrays[f"state {name}"] for name in self.states}
        tables = [*self.kept, *self.states.values(), self.rows, self.work]
        given = [*memory, *states.values(), arrays.get("springs"), arrays.get("spring_work")]
        for table, x in zip(tables, given, strict=True):
            table.count = 0
            if x is not None:
                table.add(x[:rows])
        self.shortened, self.latest = shortened, arrays.get("latest", self.latest)
        return Memory(tuple(memory), states).at(-1)

    def histories(self, rows: int) -> SpringHistories | None:
        """The first rows."""
        springs = self.force.springs
        if springs is None:
            return None
        e, q, stored = np.moveaxis(self.rows.every[:rows], 1, 0)
        dissipated = np.empty(e.shape)
        if self.adds_work:
            with np.errstate(all="ignore"):  # of a march that overflows
                dissipated[:] = self.work.every[:rows] - stored
        for k, place in self.accounts:
            dissipated[:, springs.groups[k].where] = self.kept[k].every[:rows, :, place]
        work = self.latest[2] if self.adds_work else None
        return SpringHistories(e, q, stored, dissipated, springs.lengths, self.shortened, work)
