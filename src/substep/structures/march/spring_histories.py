"""What springs did in a march: elongations, forces, energies, and what an internal force has remembered."""

from collections.abc import Sequence
from dataclasses import dataclass

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
        self.force, self.remembered, self.shortened = force, list[Memory](), 0
        self.rows = list[Array]()  # (4, s): elongations, forces, stored, work
        if force.springs is not None:
            kept = 4 + max((x.shape[1] for x in run.memory.springs), default=0)
            require_memory((rows, kept, force.springs.size), "keep a longer stride")
        self.last = np.zeros((2, 0))  # elongations and forces
        self.work = np.zeros(0)
        u, v, _ = run.given
        self.add(run.time(0), u, v, run.memory, kept=True)

    def add(self, t: float, u: Array, v: Array, memory: Memory, *, kept: bool) -> None:
        """A step that ends at t with u, v (n,), where the memory was committed; kept: whether it is a row."""
        if self.force.springs is not None:
            found = self.force.answer(t, u, v, Recalled(memory)).of_springs
            assert found is not None
            now = np.array([found.e, found.force])
            if self.rows:
                self.work = self.work + 0.5 * (self.last[1] + now[1]) * (now[0] - self.last[0])
            else:
                self.work = np.zeros(len(found.e))
            self.last = now
            if kept:
                self.rows.append(np.array([*now, found.stored, self.work]))
        if kept:
            self.remembered.append(memory)

    def histories(self, rows: int) -> SpringHistories | None:
        """The first rows."""
        springs = self.force.springs
        if springs is None:
            return None
        e, q, stored, work = np.moveaxis(np.array(self.rows[:rows]), 1, 0)
        dissipated = work - (stored - stored[0])
        for k, group in enumerate(springs.groups):
            if "dissipated" in group.law.memory:
                place = group.law.memory.index("dissipated")
                dissipated[:, group.where] = [memory.springs[k][:, place] for memory in self.remembered[:rows]]
        return SpringHistories(e, q, stored, dissipated, springs.lengths, self.shortened)


def named_rows(force: RememberingForce, remembered: Sequence[Memory]) -> dict[str, Array]:
    """What is remembered by name, (n+1, s) of springs and (n+1, ...) of states."""
    rows = [force.named(memory) for memory in remembered]
    return {name: np.array([row[name] for row in rows]) for name in (rows[0] if rows else ())}
