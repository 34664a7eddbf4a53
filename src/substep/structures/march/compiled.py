"""Steps of small structures with springs of laws, computed many at a time by a kernel that serves all schemes and laws.

It does what `StructureSteps.complete` and `.commit` do. A step that fails in any way it leaves to these, so that what
ends a march, and with which words, is said in one place.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.kernel_modules import address, compiles
from ..model.memory import Memory, RememberingForce
from ..model.springs import Springs
from ..solvers.matrices import Matrix, is_operator
from . import newton
from .newton import NonlinearSystem
from .scheme_plan import Force, Steps, System, step_of
from .steps import StructureSteps
from .time_loop import Stretch

SMALL = 100  # free degrees of freedom, and springs, up to which a kernel computes the steps
RULES = (
    newton.TOLERANCE, newton.EXACT, newton.ROUNDING, newton.TOO_FAR, newton.SMALL, newton.BALANCED, newton.ITERATIONS,
    newton.SEARCH, newton.LINE,
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class CompiledSteps:
    """Of a march the arrays that the kernel reads: see there. balances: the numbers of its systems that are such."""

    march: StructureSteps
    springs: Springs
    kernels: ModuleType
    steps: Steps
    arrays: tuple[Any, ...]
    balances: list[int]

    @classmethod
    def of(cls, march: StructureSteps) -> "CompiledSteps | None":
        """None for what the kernel does not take: another internal force, a large structure, a solver of the user's."""
        s, force = march.run.structure, march.run.structure.internal
        if not isinstance(force, RememberingForce) or force.springs is None or force.material is not None:
            return None
        if max(s.size, force.springs.size) > SMALL or s.solver not in ("auto", "dense") or not compiles():
            return None
        if any(is_operator(matrix) for matrix in (s.M, s.damping, s.K, force.K)):
            return None
        from ...derived.modules import spring_march_module  # noqa: PLC0415 (the one door to SymPy)

        springs, steps = force.springs, step_of(march.run.scheme, march.run.h)
        matrices = np.array([_by_columns(matrix, s.size) for matrix in (s.M, s.damping, s.K, force.K)])  # (4, n, m)
        stiff = float(np.abs(s.K.diagonal()).max())
        plan = _plan(steps, springs.of_rate, force.K is not None, matrices)
        structure = matrices, np.array([_spans(matrix) for matrix in matrices]), stiff
        arrays = RULES, plan, steps.out, steps.report, structure, (*_springs(springs), springs.of_rate)
        balances = [k for k, system in enumerate(steps.systems) if system.balance]
        return cls(march, springs, spring_march_module(), steps, arrays, balances)

    def taken(self, X: Array, loads: Sequence[Array], ends: Array) -> Stretch:
        """The steps from X (V, n), which has begun, to the times `ends` (m,) under loads (m, J) of each system.

        They are fewer than m where one fails.
        """
        march, steps, m, n = self.march, self.steps, len(ends), X.shape[1]
        assert march.memory is not None
        state, width = _padded(X[: steps.given]), -(-n // 4) * 4
        memory = np.concatenate([rows.ravel() for rows in march.memory.springs])
        forces = np.array([values @ _padded(march.run.shapes.T) for values in loads]).reshape(-1, m, width)
        motion, remembered = np.empty((m, len(steps.report), width)), np.empty((m, len(memory)))
        counts, answers = np.empty((m, len(steps.systems)), np.int64), np.empty((m, 4, self.springs.size))
        largest = np.array([getattr(solver, "largest", 0.0) for solver in march.systems])
        shortened = np.zeros(len(march.systems), np.int64)
        results = motion, remembered, answers, counts, largest, shortened
        done = self.kernels.march(state, memory, forces, *self.arrays, results)
        for solver, size, more in zip(march.systems, largest.tolist(), shortened.tolist(), strict=True):
            if isinstance(solver, NonlinearSystem):
                solver.largest, solver.shortened = size, solver.shortened + more
        memories, places = self._memories(remembered[:done]), np.concatenate([x for _, x in self.springs.groups])
        if len(self.springs.groups) > 1:
            answers = answers[:, :, np.argsort(places)]
        made = counts[:done, self.balances]
        return Stretch(march, ends[:done], motion[:done, :, :n], memories, answers[:done], made, state[:, :n].copy())

    def _memories(self, rows: Array) -> Memory:
        """Of rows (m, ..) as the kernel has them."""
        found, first = list[Array](), 0
        for law, where in self.springs.groups:
            shape = len(where), len(law.memory)
            last = first + shape[0] * shape[1]
            found.append(rows[:, first:last].reshape(len(rows), *shape))
            first = last
        return Memory(tuple(found))


def _padded(rows: Array) -> Array:
    """With zeros up to a multiple of 4 columns."""
    found = np.zeros((len(rows), -(-rows.shape[1] // 4) * 4))
    found[:, : rows.shape[1]] = rows
    return found


def _by_columns(matrix: Matrix | None, n: int) -> Array:
    """Transposed, so that columns are contiguous, and padded; 0 for None."""
    if matrix is None:
        return _padded(np.zeros((n, n)))
    return _padded(np.array(matrix.toarray() if hasattr(matrix, "toarray") else matrix, dtype=np.float64).T)


def _spans(columns: Array) -> NDArray[np.int64]:
    """Of each four rows the first column in which they have an entry, and that after the last one (m/4, 2)."""
    used = (columns != 0.0).reshape(len(columns), -1, 4).any(axis=2).T
    ends = np.stack([used.argmax(axis=1), used.shape[1] - used[:, ::-1].argmax(axis=1)], axis=1)
    return np.where(used.any(axis=1)[:, None], ends, 0)


def _plan(steps: Steps, of_rate: bool, held: bool, matrices: Array) -> tuple[Any, ...]:
    """What the kernel takes as `plan`. held: whether the internal force has a linear part."""
    V, systems = steps.vectors, steps.systems
    by_system = [list(system.forces) for system in systems]
    every = [(force, system) for system, forces in zip(systems, by_system, strict=True) for force in forces]
    rows = [
        [s.inertia, s.damping, s.stiffness, sum((f.w * f.u for f in s.forces), np.zeros(V)) * held] for s in systems
    ]
    rows = np.reshape(rows, (-1, 4, V))
    linear = np.array([np.einsum("m,mij->ij", row[:, s.place], matrices) for row, s in zip(rows, systems, strict=True)])
    iterated = [s.moves_force(of_rate) for s in systems]
    shown = [max(s.displacements, key=lambda row, s=s: abs(row[s.place]), default=np.zeros(V)) for s in systems]
    velocity = [s.velocity if s.forces else np.zeros(V) for s in systems]
    forces = (
        np.array([f.w for f, _ in every]), np.reshape([f.u for f, _ in every], (-1, V)),
        np.array([f.place for f, _ in every], np.int64), np.array([f.since for f, _ in every]),
        np.array([f.u[s.place] == 0.0 and not (of_rate and s.velocity[s.place]) for f, s in every], bool),
    )  # fmt: skip
    slopes = np.reshape([_share(f, s) for f, s in every], (-1, 2)).T.copy()
    commits = [(c.u, c.v, c.since) for s in systems for c in s.commits]
    commits.append((steps.report[0], steps.report[1], steps.since))
    u, v, since = (np.array(x) for x in zip(*commits, strict=True))
    used = np.array([row[:, : s.place].any(axis=1) for row, s in zip(rows, systems, strict=True)])
    return (
        rows, used, linear, np.array([_spans(A) for A in linear]), np.array(iterated), np.array(shown),
        np.array(velocity), _firsts(by_system), forces, slopes, _firsts([s.commits for s in systems]),
        np.array([u, v]), since,
        np.array([_answered(steps, of_rate, k, *commit) for k, commit in enumerate(commits)], np.int64),
    )  # fmt: skip


def _answered(steps: Steps, of_rate: bool, level: int, u: Array, v: Array, since: float) -> int:
    """The number of the last force that is taken where, and from what, a commit is; -1 where none is."""
    every, found = [(force, system.velocity) for system in steps.systems for force in system.forces], -1
    for number, (force, velocity) in enumerate(every):
        same = np.array_equal(force.u, u) and (not of_rate or np.array_equal(velocity, v))
        if same and force.place == level and force.since == since:
            found = number
    return found


def _share(force: Force, system: System) -> tuple[float, float]:
    """How the slopes by elongations and by rates, taken where this force is, count in the residual's derivative."""
    j = system.place
    moving = [f for f in system.forces if f.u[j] != 0.0] or list(system.forces[:1])
    return (float(force.w * force.u[j]), float(system.damping[j])) if any(f is force for f in moving) else (0.0, 0.0)


def _firsts(parts: Sequence[Sequence[Any]]) -> NDArray[np.int64]:
    """Where each part begins once all are in a row, and where the last one ends."""
    return np.array([0, *accumulate(map(len, parts))], np.int64)


def _springs(springs: Springs) -> tuple[Any, ...]:
    """B in compressed rows, and the laws, as the kernel takes them: springs group by group."""
    B = springs.compressed[np.concatenate([where for _, where in springs.groups])]
    tables = [law.table((len(where),)) for law, where in springs.groups]
    kept = [range(len(where) * len(law.memory)) for law, where in springs.groups]
    laws = (
        np.array([address(law.module.evaluate) for law, _ in springs.groups]),
        _firsts([where for _, where in springs.groups]), _firsts([table.ravel() for table in tables]),
        _firsts(kept), np.concatenate([table.ravel() for table in tables]),
    )  # fmt: skip
    return (B.indptr.astype(np.uint64), B.indices.astype(np.uint64), B.data), laws  # unsigned: none is below 0
