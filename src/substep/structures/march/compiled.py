"""Steps of small structures with springs of laws, computed many at a time by a kernel that serves all schemes and laws.

It does what `StructureSteps.complete` and `.commit` do. A step that fails in any way it leaves to these, so that what
ends a march, and with which words, is said in one place.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.kernel_modules import address, compiles
from ..model.memory import Memory, RememberingForce
from ..model.model import Model
from ..model.springs import Springs
from ..solvers.matrices import Matrix, is_operator
from . import newton
from .newton import NonlinearSystem
from .scheme_plan import Force, Steps, System, step_of
from .steps import Run, StructureSteps
from .time_loop import Stretch

KEPT = 8  # sets of slopes of which a kernel keeps the factors, of each system and lane
PARTS = "indptr", "indices", "data"  # of a sparse matrix
SMALL = 100  # free degrees of freedom, and springs, up to which a kernel computes the steps
RULES = (
    newton.TOLERANCE, newton.EXACT, newton.ROUNDING, newton.TOO_FAR, newton.SMALL, newton.BALANCED, newton.ITERATIONS,
    newton.SEARCH, newton.LINE,
)  # fmt: skip


class Lanes(NamedTuple):
    """Where structures side by side are: their state (S, m), what they remember (k,), which of them count (lanes,) ...

    ... and of each system the largest displacements and shortened corrections (I, lanes); a kernel goes on from there.
    """

    state: Array
    memory: Array
    alive: NDArray[np.bool_]
    largest: Array
    shortened: NDArray[np.int64]


class Rows(NamedTuple):
    """After m steps, or the last of them: u, v, a (m, R, n, lanes), what is remembered (m, k), of springs (m, 3, s,
    lanes), iterations; done: how many steps.

    All but the last two are written anew by the next steps that are made.
    """

    motion: Array
    memories: Array
    springs: Array
    counts: NDArray[np.int64]
    done: int


@dataclass(frozen=True, eq=False)
class CompiledSteps:
    """Of runs side by side the arrays that the kernel reads: see there. balances: the systems that are such.

    march: of a run that is alone, what goes on with a step that fails. kept: memory for `Rows`. peaks: displacements
    that are looked at, in compressed rows, and the largest moduli so far of these, of their rates, and of springs.
    """

    runs: Sequence[Run]
    march: StructureSteps | None
    springs: Springs
    kernels: ModuleType
    steps: Steps
    arrays: tuple[Any, ...]
    balances: list[int]
    kept: tuple[Array, Array, Array]
    peaks: tuple[tuple[Array, Array, Array], Array, Array]

    @classmethod
    def of(cls, march: StructureSteps, rows: int) -> "CompiledSteps | None":
        """None for what the kernel does not take."""
        return cls.together([march.run], rows, march) if takes(march.run) else None

    @classmethod
    def together(
        cls, runs: Sequence[Run], rows: int, march: StructureSteps | None = None, shown: Matrix | None = None
    ) -> "CompiledSteps":
        """Of one run, with its march, or of as many as there are lanes that `takes` takes, of one kind.

        rows: of `Rows`, at most; shown: rows (r, n) of the displacements of which lanes keep peaks.
        """
        from ...derived.modules import spring_march_module  # noqa: PLC0415 (the one door to SymPy)

        of, steps, lanes = [run.structure for run in runs], step_of(runs[0].scheme, runs[0].h), len(runs)
        springs, held = zip(*map(_springs_of, of), strict=True)
        n, of_rate = of[0].size, springs[0].of_rate
        given = [(s.M, s.damping, s.K, K) for s, K in zip(of, held, strict=True)]
        matrices = np.array([[_dense(matrix, n) for matrix in each] for each in given])  # (lanes, 4, n, n)
        plan, shares = _plan(steps, of_rate, held[0] is not None)
        linear = np.zeros((lanes, len(shares), n, n))
        for s, share in enumerate(shares):
            for m, factor in enumerate(share):  # of any number of lanes to the bit the same
                linear[:, s] += factor * matrices[:, m]
        stiff = np.abs(np.diagonal(matrices[:, 2], axis1=1, axis2=2)).max(axis=1)
        blocks = _blocks(np.concatenate([matrices, linear], axis=1))
        structure = blocks, stiff, _side_by_side([run.shapes.T for run in runs])
        room = _room(steps, springs[0], n, lanes)
        arrays = RULES, plan, steps.out, steps.report, structure, (*_springs(springs), of_rate), room
        balances = [k for k, system in enumerate(steps.systems) if system.balance]
        (X, _, memories), total = room[0], room[3][6]
        kept = np.empty((rows, len(steps.report), X.shape[1])), np.empty((rows, memories.shape[1]))
        kept = *kept, np.empty((rows, 3, total.size))
        none, many = shown is None, 0 if shown is None else shown.shape[0] * lanes
        peaks = np.zeros((0 if none else len(steps.report), many)), np.zeros((0 if none else 2, total.size))
        chosen = _compressed(springs[0].compressed if shown is None else shown)
        return cls(runs, march, springs[0], spring_march_module(lanes), steps, arrays, balances, kept, (chosen, *peaks))

    def at(self, states: Sequence[Array], memories: Sequence[Memory]) -> Lanes:
        """Where structures are that have these states (S, n) and remember that."""
        kept = [np.stack(of, axis=1).ravel() for of in zip(*(memory.springs for memory in memories), strict=True)]
        alive, zero = np.ones(len(self.runs), np.bool_), np.zeros((len(self.steps.systems), len(self.runs)))
        return Lanes(_side_by_side(states), _padded(np.concatenate(kept)[None])[0], alive, zero, zero.astype(np.int64))

    def made(self, lanes: Lanes, loads: Sequence[Array]) -> Rows:
        """Steps under loads (I, m, J) of each system, of each lane; they are fewer than m where one fails.

        Of more steps than there is room for the last rows are not in order.

        lanes: where they begin, and then where they have come to; one that has failed is no longer alive.
        """
        factors = np.stack(loads, axis=-1)  # (I, m, J, lanes)
        systems, m, J, L = factors.shape
        counts = np.empty((min(m, len(self.kept[0])), systems, L), np.int64)
        given = lanes.state, lanes.memory, factors.reshape(systems, m, J * L), lanes.alive, *self.arrays
        done = self.kernels.march(*given, (*self.kept, counts, lanes.largest, lanes.shortened, *self.peaks))
        motion, memories, answers = (x[:done] for x in self.kept)
        motion = self._lanes_apart(motion, self.runs[0].structure.size)
        return Rows(motion, memories, self._by_spring(answers), counts[:done, self.balances], done)

    @property
    def largest(self) -> tuple[Array, Array]:
        """The largest moduli so far: (R, r, lanes) of what is shown, and (2, s, lanes) of springs."""
        (first, _, _), motion, strained = self.peaks
        return self._lanes_apart(motion, len(first) - 1), self._by_spring(strained)

    def _lanes_apart(self, rows: Array, size: int) -> Array:
        L = len(self.runs)
        return rows[..., : size * L].reshape(*rows.shape[:-1], size, L)

    def _by_spring(self, rows: Array) -> Array:
        """Of rows of springs, group by group, those in the springs' order."""
        found = self._lanes_apart(rows, self.springs.size)
        if len(self.springs.groups) == 1:
            return found
        return found[..., np.argsort(np.concatenate([x for _, x in self.springs.groups])), :]

    def taken(self, X: Array, loads: Sequence[Array], ends: Array) -> Stretch:
        """Of one march the steps from X (V, n), which has begun, to the times `ends` (m,) under loads (m, J) of each
        system.

        They are fewer than m where one fails.
        """
        march, n = self.march, X.shape[1]
        assert march is not None
        assert march.memory is not None
        lanes = self.at([X[: self.steps.given]], [march.memory])
        lanes.largest[:, 0] = [getattr(solver, "largest", 0.0) for solver in march.systems]
        *made, done = self.made(lanes, [np.array(loads)])
        motion, memories, springs, counts = (x[..., 0] if x.ndim > 2 else x for x in made)
        for solver, size, more in zip(march.systems, lanes.largest[:, 0], lanes.shortened[:, 0], strict=True):
            if isinstance(solver, NonlinearSystem):
                solver.largest, solver.shortened = float(size), solver.shortened + int(more)
        kept, last = (self.memories(x).at((..., 0, slice(None))) for x in (memories, lanes.memory[None]))
        state = lanes.state[:, :n].copy()
        return Stretch(march, ends[:done], motion, kept, springs, counts, state, last.at(0))

    def memories(self, rows: Array) -> Memory:
        """Of rows (m, ..) as the kernel has them, (m, s, lanes, ..)."""
        found, first = list[Array](), 0
        for law, where in self.springs.groups:
            shape = len(where), len(self.runs), len(law.memory)
            last = first + math.prod(shape)
            found.append(rows[:, first:last].reshape(len(rows), *shape))
            first = last
        return Memory(tuple(found))


def takes(run: Run) -> bool:
    """Whether the kernel takes it: not another internal force, a large structure, nor a solver of the user's.

    Nor does it solve balances together.
    """
    s, force = run.structure, run.structure.internal
    if not isinstance(force, RememberingForce) or force.springs is None or force.material is not None:
        return False
    if run.scheme.info.together or s.contacts:
        return False
    if max(s.size, force.springs.size) > SMALL or s.solver not in ("auto", "dense") or not compiles():
        return False
    return not any(is_operator(matrix) for matrix in (s.M, s.damping, s.K, force.K))


def kind_of(run: Run) -> tuple[Any, ...]:
    """Equal of runs that the kernel takes if they differ in numbers alone, not in those of springs' rows and steps."""
    s, (springs, K) = run.structure, _springs_of(run.structure)
    groups = [(law.module, where.tobytes()) for law, where in springs.groups]
    parts = [getattr(matrix, x).tobytes() for matrix in (s.T, springs.compressed) for x in PARTS]
    return step_of(run.scheme, run.h), s.T.shape, len(run.loads), K is None, groups, parts


def begun_together(runs: Sequence[Run]) -> tuple[list[Run], Array]:
    """Such runs of one kind with u, v, a and what they remember where they begin, and there elongations and forces of
    springs (2, s, lanes): what springs do is asked of all at once.
    """
    of = [run.structure for run in runs]
    springs, held = zip(*map(_springs_of, of), strict=True)
    every, u, v = Springs.together(springs), np.array([s.u0 for s in of]), np.array([s.v0 for s in of])
    before = tuple(map(np.stack, zip(*(one.unstrained for one in springs), strict=True)))
    memory = every.answers(u, v, before, 0.0).memory
    there = every.answers(u, v, memory, 0.0)
    found = list[Run]()
    for k, (run, s) in enumerate(zip(runs, of, strict=True)):
        remembered, K, a = Memory(tuple(x[k] for x in memory)), held[k], s.a0_given
        if a is None:
            force = springs[k].spread(there.force[k])
            a = s.acceleration(0.0, s.u0, s.v0, held=force if K is None else force + K @ s.u0)
        found.append(Run(s, run.scheme, run.h, start=np.array([s.u0, s.v0, a]), remembered=remembered))
    return found, np.moveaxis([there.e, there.force], 1, -1)


def loads_side_by_side(runs: Sequence[Run], count: int) -> list[Array]:
    """Of each run the loads (I, count, J) of each system in the first steps; of functions that runs share once."""
    steps, found, known = step_of(runs[0].scheme, runs[0].h), list[Array](), dict[tuple[int, ...], Array]()
    for run in runs:
        key = tuple(id(g) for _, g in run.loads)
        if key not in known:
            known[key] = np.array(StructureSteps(run, steps, (), None, None, []).loads(0, count))
        found.append(known[key])
    return found


def _springs_of(s: Model) -> tuple[Springs, Matrix | None]:
    """The springs of a structure that the kernel takes, and the linear part of its internal force."""
    assert isinstance(s.internal, RememberingForce)
    assert s.internal.springs is not None
    return s.internal.springs, s.internal.K


def _padded(rows: Array) -> Array:
    """With zeros up to a multiple of 4 columns."""
    found = np.zeros((len(rows), -(-rows.shape[1] // 4) * 4))
    found[:, : rows.shape[1]] = rows
    return found


def _side_by_side(rows: Sequence[Array]) -> Array:
    """Of each lane rows (m, n), as rows (m, n lanes), padded."""
    return _padded(np.stack(rows, axis=-1).reshape(len(rows[0]), rows[0].shape[1] * len(rows)))


def _dense(matrix: Matrix | None, n: int) -> Array:
    """0 for None."""
    if matrix is None:
        return np.zeros((n, n))
    return np.asarray(matrix.toarray() if hasattr(matrix, "toarray") else matrix, dtype=np.float64)


def _blocks(matrices: Array) -> tuple[Any, ...]:
    """Of matrices (lanes, Q, n, n) where the blocks begin of each so many numbers of a vector, places, and entries.

    A block is what multiplies one number of another vector, in each of the lanes; of one lane four numbers have one.
    """
    L, Q, n, _ = matrices.shape
    width = max(L, 4)
    rows = np.zeros((Q, -(-n * L // width) * width, n))
    rows[:, : n * L] = np.moveaxis(matrices, 0, 2).reshape(Q, n * L, n)
    blocks = rows.reshape(Q, -1, width, n)
    q, r, column = np.nonzero(blocks.any(axis=2))
    count = np.zeros((Q, blocks.shape[1]), np.int64)
    np.add.at(count, (q, r), 1)
    ends = np.cumsum(count).reshape(count.shape)
    first = np.concatenate([np.append(0, ends[:-1, -1])[:, None], ends], axis=1)
    return first, column * L, blocks[q, r, :, column].ravel()


@lru_cache(64)  # many structures take the same steps
def _plan(steps: Steps, of_rate: bool, held: bool) -> tuple[tuple[Any, ...], list[Array]]:
    """What the kernel takes as `plan`, and of each system how the four matrices count for its unknown.

    held: whether the internal force has a linear part.
    """
    V, systems = steps.vectors, steps.systems
    by_system = [list(system.forces) for system in systems]
    every = [(force, system) for system, forces in zip(systems, by_system, strict=True) for force in forces]
    rows = [
        [s.inertia, s.damping, s.stiffness, sum((f.w * f.u for f in s.forces), np.zeros(V)) * held] for s in systems
    ]
    rows = np.reshape(rows, (-1, 4, V))
    shares = [row[:, s.place] for row, s in zip(rows, systems, strict=True)]
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
        rows, used, np.array(iterated), np.array(shown), np.array(velocity), _firsts(by_system), forces, slopes,
        _firsts([[*s.commits, *[None] * (s is systems[-1])] for s in systems]), np.array([u, v]), since,
        np.array([_answered(steps, of_rate, k, *commit) for k, commit in enumerate(commits)], np.int64),
        np.array([_first_like(row, steps.report) for row in steps.out], np.int64),
    ), shares  # fmt: skip


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


def _room(steps: Steps, springs: Springs, n: int, lanes: int) -> tuple[Any, ...]:
    """What the kernel writes in: X, the next state and memories; vectors; those of Newton's iteration, and numbers and
    marks of lanes; the springs' answers to the forces, and their numbers; factors; and what is counted in a step."""
    V, count, S = steps.vectors, len(steps.systems), len(steps.out)
    F = max(sum(len(s.forces) for s in steps.systems), 1)
    k = sum(len(where) * lanes * len(law.memory) for law, where in springs.groups)
    width, size, k = (-(-x // 4) * 4 for x in (n * lanes, springs.size * lanes, k))

    def zeros(many: int, *shape: int, kind: Any = np.float64) -> tuple[Array, ...]:
        return tuple(np.zeros(shape, kind) for _ in range(many))

    levels = 2 + sum(len(s.commits) for s in steps.systems)
    factors = np.zeros((count, lanes, KEPT, springs.size)), np.zeros((count, lanes, KEPT, n, n))
    orders = np.zeros((count, lanes, KEPT, n), np.int64), np.zeros((count, lanes, KEPT, n, 2), np.int64)
    spans = np.tile(np.array([n, 0]), (count, n, 1))  # of no column yet
    in_use = (
        np.zeros((count, n, n * lanes)),
        np.zeros((count, n, lanes), np.int64),
        spans,
        np.full((count, size), np.nan),
    )
    return (
        (*zeros(1, V, width), *zeros(1, S, width), *zeros(1, levels, k)), zeros(3, width),
        (zeros(7, width), zeros(15, lanes), (*zeros(1, lanes, kind=np.int64), *zeros(4, lanes, kind=np.bool_))),
        (*zeros(1, F, 4, size), *zeros(1, F, size), *zeros(5, size), *zeros(1, F, k)),
        (*factors, *orders, *zeros(1, count, lanes, 2, kind=np.int64), *in_use, *zeros(1, count, kind=np.bool_)),
        (*zeros(1, count, lanes, kind=np.int64), *zeros(1, count, lanes), *zeros(1, 1)),
    )  # fmt: skip


def _first_like(row: Array, rows: Array) -> int:
    """The number of the first of the rows that is this one, -1 where none is."""
    return next((k for k, other in enumerate(rows) if np.array_equal(other, row)), -1)


def _springs(every: Sequence[Springs]) -> tuple[Any, ...]:
    """B in compressed rows, and the laws, as the kernel takes them: springs group by group, and of each its lanes."""
    springs, L = every[0], len(every)
    B = springs.compressed
    if len(springs.groups) > 1:
        B = B[np.concatenate([where for _, where in springs.groups])]
    laws = zip(*([law for law, _ in one.groups] for one in every), strict=True)
    counts = [len(where) for _, where in springs.groups]
    tables = [
        np.stack([law.table((count,)) for law in of], axis=1).ravel() for of, count in zip(laws, counts, strict=True)
    ]
    kept = [range(L * len(where) * len(law.memory)) for law, where in springs.groups]
    laws = (
        np.array([address(law.module.evaluate) for law, _ in springs.groups]), _firsts([range(L * n) for n in counts]),
        _firsts(tables), _firsts(kept), np.concatenate(tables),
    )  # fmt: skip
    return _compressed(B), laws


def _compressed(B: Matrix) -> tuple[Array, Array, Array]:
    """A sparse matrix as the kernel takes it."""
    return B.indptr.astype(np.int64), B.indices.astype(np.int64), B.data
