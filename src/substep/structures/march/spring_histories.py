"""What springs did in a march: elongations, forces, energies, and what an internal force has remembered."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.memory import require_memory
from ..model.memory import Memory, Recalled, RememberingForce
from .steps import Run


@dataclass(frozen=True, eq=False)
class SpringHistories:
    """Of s springs, (n+1, s) each: elongations, forces, stored and dissipated energy.

    dissipated: by the law's own account, exactly along the path, where it keeps one; else the work of the force by the
    trapezoidal rule over each step, less what is stored. lengths (s,): as the structure has them, None without.
    shortened: corrections of Newton's iteration that had gone too far, as they do where the branch of a spring changes.
    """

    elongations: Array
    forces: Array
    stored: Array
    dissipated: Array
    lengths: Array | None = None
    shortened: int = 0

    @property
    def ratios(self) -> Array:
        """Elongations over lengths (n+1, s), as drift ratios of stories. Raises ValueError without lengths."""
        if self.lengths is None:
            raise ValueError("expected lengths of the springs for ratios, got none; give heights= of the stories")
        return self.elongations / self.lengths

    def loop(self, spring: int) -> tuple[Array, Array]:
        """Elongation and force (n+1,) of one spring, to draw one over the other."""
        return self.elongations[:, spring], self.forces[:, spring]


class SpringRows:
    """Collects what springs do, and what is remembered, row by row."""

    def __init__(self, run: Run, rows: int) -> None:
        force = run.structure.internal
        assert isinstance(force, RememberingForce)
        assert run.memory is not None
        self.force, self.kept, self.shortened = force, list[Memory](), 0
        self.rows = list[Array]()  # (m, 4, s): elongations, forces, stored, work
        if force.springs is not None:
            kept = 4 + max((x.shape[1] for x in run.memory.springs), default=0)
            require_memory((rows, kept, force.springs.size), "keep a longer stride")
        self.latest = np.zeros((3, 0))  # elongations, forces and work after the last step
        u, v, _ = run.given
        self.add(run.time(0), u, v, run.memory, kept=True)

    def add(self, t: float, u: Array, v: Array, memory: Memory, *, kept: bool) -> None:
        """A step that ends at t with u, v (n,), where the memory was committed; kept: whether it is a row."""
        if self.force.springs is not None:
            found = self.force.answer(t, u, v, Recalled(memory)).of_springs
            assert found is not None
            work = np.zeros(len(found.e))
            if self.rows:
                e, q, before = self.latest
                work = before + 0.5 * (q + found.force) * (found.e - e)
            self.latest = np.array([found.e, found.force, work])
            if kept:
                self.rows.append(np.array([[found.e, found.force, found.stored, work]]))
        if kept:
            self.kept.append(memory.at(None))

    def add_all(self, rows: Array, memories: Memory, kept: Any) -> None:
        """Steps with their `Stretch.springs`, and what was remembered after each; kept: which of them are rows here."""
        (e, q), (_, _, _, work) = self.latest[:2], np.moveaxis(rows, 1, 0)
        work[0] = self.latest[2] + 0.5 * (q + rows[0, 1]) * (rows[0, 0] - e)
        work[1:] = 0.5 * (rows[:-1, 1] + rows[1:, 1]) * np.diff(rows[:, 0], axis=0)
        np.cumsum(work, axis=0, out=work)
        self.latest = rows[-1, [0, 1, 3]]
        self.rows.append(rows[kept])
        self.kept.append(memories.at(kept))

    def remembered(self, rows: int) -> Memory:
        """What was remembered in the first rows."""
        return Memory.joined(self.kept).at(slice(rows))

    def arrays(self, rows: int, latest: Array, memory: Memory) -> dict[str, Array]:
        """What a store keeps to go on from: the first rows, and `latest` and the memory after the last step."""
        every = Memory.joined([self.remembered(rows), memory.at(None)])
        found = {f"memory {k}": x for k, x in enumerate(every.springs) if x.size}
        found |= {f"state {name}": x for name, x in every.states.items()} | {"latest": latest}
        if self.rows:
            found["springs"] = np.concatenate(self.rows)[:rows]
        return {name: x for name, x in found.items() if x.size}

    def resume(self, arrays: Mapping[str, Any], rows: int, shortened: int) -> Memory:
        """Go on from what `arrays` has given; returns the memory after the last step."""
        shape, first = rows + 1, self.kept[0]
        springs = (arrays.get(f"memory {k}", np.zeros((shape, *x.shape[1:]))) for k, x in enumerate(first.springs))
        every = Memory(tuple(springs), {name: arrays[f"state {name}"] for name in first.states})
        self.kept, self.shortened = [every.at(slice(rows))], shortened
        if self.rows:
            self.rows, self.latest = [arrays["springs"]], arrays["latest"]
        return every.at(-1)

    def histories(self, rows: int) -> SpringHistories | None:
        """The first rows."""
        springs = self.force.springs
        if springs is None:
            return None
        e, q, stored, work = np.moveaxis(np.concatenate(self.rows)[:rows], 1, 0)
        with np.errstate(all="ignore"):  # of a march that overflows
            dissipated = work - (stored - stored[0])
        for k, group in enumerate(springs.groups):
            if "dissipated" in group.law.memory:
                place = group.law.memory.index("dissipated")
                dissipated[:, group.where] = self.remembered(rows).springs[k][..., place]
        return SpringHistories(e, q, stored, dissipated, springs.lengths, self.shortened)
