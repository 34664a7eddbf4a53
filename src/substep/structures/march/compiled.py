"""Steps of small structures with springs of laws, computed many at a time by a kernel that serves all schemes and laws.

It does what `StructureSteps.complete` and `.commit` do. A step that fails in any way it leaves to these, so that what
ends a march, and with which words, is said in one place.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.kernel_modules import compiles
from ...core.laws import by_name
from ..model.memory import Memory, RememberingForce
from ..model.model import Model
from ..model.springs import Springs
from ..solvers.matrices import Matrix, is_operator
from . import newton
from .compiled_arrays import (
    blocks_of,
    compressed_rows,
    dense,
    padded,
    plan_of,
    room_of,
    side_by_side,
    springs_of_lanes,
)
from .newton import NonlinearSystem
from .scheme_plan import Steps, step_of
from .steps import Run, StructureSteps
from .time_loop import Stretch

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
        matrices = np.array([[dense(matrix, n) for matrix in each] for each in given])  # (lanes, 4, n, n)
        some = tuple(matrices.any(axis=(0, 2, 3)).tolist())
        plan, shares = plan_of(steps, of_rate, some)
        linear = np.zeros((lanes, len(shares), n, n))
        for s, share in enumerate(shares):
            for m, factor in enumerate(share):  # of any number of lanes to the bit the same
                linear[:, s] += factor * matrices[:, m]
        stiff = np.abs(np.diagonal(matrices[:, 2], axis1=1, axis2=2)).max(axis=1)
        blocks = blocks_of(np.concatenate([matrices, linear], axis=1))
        structure = blocks, stiff, side_by_side([run.shapes.T for run in runs])
        room = room_of(steps, springs[0], linear)
        arrays = RULES, plan, steps.out, steps.report, structure, (*springs_of_lanes(springs), of_rate), room
        balances = [k for k, system in enumerate(steps.systems) if system.balance]
        (X, _, memories), size = room[0], room[1][1].shape[1]
        kept = np.empty((rows, len(steps.report), X.shape[1])), np.empty((rows, memories.shape[1]))
        kept = *kept, np.empty((rows, 3, size))
        none, many = shown is None, 0 if shown is None else shown.shape[0] * lanes
        peaks = np.zeros((0 if none else len(steps.report), many)), np.zeros((0 if none else 2, size))
        chosen = compressed_rows(springs[0].compressed if shown is None else shown)
        return cls(runs, march, springs[0], spring_march_module(lanes), steps, arrays, balances, kept, (chosen, *peaks))

    def at(self, states: Sequence[Array], memories: Sequence[Memory]) -> Lanes:
        """Where structures are that have these states (S, n) and remember that."""
        every = zip(*(memory.springs for memory in memories), strict=True)
        kept = [by_name(np.stack(of, axis=1)).ravel() for of in every]
        alive, zero = np.ones(len(self.runs), np.bool_), np.zeros((len(self.steps.systems), len(self.runs)))
        return Lanes(side_by_side(states), padded(np.concatenate(kept)[None])[0], alive, zero, zero.astype(np.int64))

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
            shape = len(law.memory), len(where), len(self.runs)
            last = first + math.prod(shape)
            found.append(np.moveaxis(rows[:, first:last].reshape(len(rows), *shape), 1, -1))
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
