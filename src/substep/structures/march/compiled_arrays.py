"""Arrays of a small structure with springs, or of several side by side, as the kernel of their march takes them."""

from collections.abc import Sequence
from functools import lru_cache
from itertools import accumulate
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.kernel_modules import address
from ...core.laws import by_name
from ..model.springs import Springs
from ..solvers.matrices import Matrix
from .scheme_plan import Force, Steps, System

KEPT = 8  # sets of slopes of which a kernel keeps the factors, of each system and lane


def padded(rows: Array) -> Array:
    """With zeros up to a multiple of 4 columns."""
    found = np.zeros((len(rows), -(-rows.shape[1] // 4) * 4))
    found[:, : rows.shape[1]] = rows
    return found


def side_by_side(rows: Sequence[Array]) -> Array:
    """Of each lane rows (m, n), as rows (m, n lanes), padded."""
    return padded(np.stack(rows, axis=-1).reshape(len(rows[0]), rows[0].shape[1] * len(rows)))


def dense(matrix: Matrix | None, n: int) -> Array:
    """0 for None."""
    if matrix is None:
        return np.zeros((n, n))
    return np.asarray(matrix.toarray() if hasattr(matrix, "toarray") else matrix, dtype=np.float64)


def blocks_of(matrices: Array) -> tuple[Any, ...]:
    """Of matrices (lanes, Q, r, n) where the blocks begin of each so many numbers of a vector, places, and entries.

    A block is what multiplies one number of another vector, in each of the lanes; of one lane four numbers have one.
    """
    L, Q, m, n = matrices.shape
    width = max(L, 4)
    rows = np.zeros((Q, -(-m * L // width) * width, n))
    rows[:, : m * L] = np.moveaxis(matrices, 0, 2).reshape(Q, m * L, n)
    blocks = rows.reshape(Q, -1, width, n)
    q, r, column = np.nonzero(blocks.any(axis=2))
    count = np.zeros((Q, blocks.shape[1]), np.int64)
    np.add.at(count, (q, r), 1)
    ends = np.cumsum(count).reshape(count.shape)
    first = np.concatenate([np.append(0, ends[:-1, -1])[:, None], ends], axis=1)
    return first, column * L, blocks[q, r, :, column].ravel()


@lru_cache(64)  # many structures take the same steps
def plan_of(steps: Steps, of_rate: bool, some: tuple[bool, ...]) -> tuple[tuple[Any, ...], list[Array]]:
    """What the kernel takes as `plan`, and of each system how the four matrices count for its unknown.

    some: which of the matrices have entries.
    """
    V, systems = steps.vectors, steps.systems
    by_system = [list(system.forces) for system in systems]
    every = [(force, system) for system, forces in zip(systems, by_system, strict=True) for force in forces]
    rows = [
        [s.inertia, s.damping, s.stiffness, sum((f.w * f.u for f in s.forces), np.zeros(V)) * some[3]] for s in systems
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
    slopes = np.reshape([_share(f, s, of_rate) for f, s in every], (-1, 2)).T.copy()
    commits = [(c.u, c.v, c.since) for s in systems for c in s.commits]
    commits.append((steps.report[0], steps.report[1], steps.since))
    u, v, since = (np.array(x) for x in zip(*commits, strict=True))
    used = np.array([row[:, : s.place].any(axis=1) & some for row, s in zip(rows, systems, strict=True)])
    guess = [
        (s.begin - row) / row[s.place] if row[s.place] else np.zeros(V) for row, s in zip(shown, systems, strict=True)
    ]
    return (
        rows, used, np.array(iterated), np.array(shown), np.array(guess), np.array(velocity),
        _firsts(by_system), forces, slopes, _firsts([[*s.commits, *[None] * (s is systems[-1])] for s in systems]),
        np.array([u, v]), since,
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


def _share(force: Force, system: System, of_rate: bool) -> tuple[float, float]:
    """How the slopes by elongations and by rates, taken where this force is, count in the residual's derivative.

    Those by rates count 0 where no law reads rates, which a kernel then need not add.
    """
    j = system.place
    moving = [f for f in system.forces if f.u[j] != 0.0] or list(system.forces[:1])
    counts = any(f is force for f in moving)
    return float(force.w * force.u[j]) * counts, float(system.damping[j]) * (counts and of_rate)


def _firsts(parts: Sequence[Sequence[Any]]) -> NDArray[np.int64]:
    """Where each part begins once all are in a row, and where the last one ends."""
    return np.array([0, *accumulate(map(len, parts))], np.int64)


def room_of(steps: Steps, springs: Springs, linear: Array) -> tuple[Any, ...]:
    """What the kernel writes in: X, the next state and memories; vectors of degrees of freedom, of springs and of
    lanes, and marks of these; the springs' answers to the forces; factors, and whether lanes are factorized together;
    and what is counted in a step.

    linear (lanes, I, n, n): the systems' matrices without springs.
    """
    V, S, (lanes, count, n, _) = steps.vectors, len(steps.out), linear.shape
    F = max(sum(len(s.forces) for s in steps.systems), 1)
    k = sum(len(where) * lanes * len(law.memory) for law, where in springs.groups)
    width, size, k = (-(-x // 4) * 4 for x in (n * lanes, springs.size * lanes, k))

    def zeros(many: int, *shape: int, kind: Any = np.float64) -> tuple[Array, ...]:
        return tuple(np.zeros(shape, kind) for _ in range(many))

    levels = 2 + sum(len(s.commits) for s in steps.systems)
    factors = np.zeros((count, lanes, KEPT, springs.size)), np.zeros((count, lanes, KEPT, n, n))
    orders = np.zeros((count, lanes, KEPT, n), np.int64), np.zeros((count, lanes, KEPT, n, 2), np.int64)
    symmetric = (linear == linear.swapaxes(2, 3)).all(axis=(0, 2, 3)) & (lanes > 1)
    spans = np.tile(np.array([n, 0]), (count, n, 1))  # of no column yet
    if symmetric.any():
        spans[symmetric] = _envelopes(linear[:, symmetric].any(axis=0), springs.B)
    in_use = (
        np.zeros((count, n, n * lanes)),
        np.zeros((count, n, lanes), np.int64),
        spans,
        np.full((count, size), np.nan),
    )
    return (
        (*zeros(1, V, width), *zeros(1, S, width), *zeros(1, levels, k)),
        (*zeros(1, 9, width), *zeros(1, 5, size), *zeros(1, 15, lanes),
         (*zeros(1, lanes, kind=np.int64), *zeros(4, lanes, kind=np.bool_))),
        (*zeros(1, F, 4, size), *zeros(1, F, size), *zeros(1, F, k)),
        (*factors, *orders, *zeros(1, count, lanes, 2, kind=np.int64), *in_use, *zeros(1, count, kind=np.bool_),
         symmetric),
        (*zeros(1, count, lanes, kind=np.int64), *zeros(1, count, lanes), *zeros(1, 1)),
    )  # fmt: skip


def _envelopes(entries: NDArray[np.bool_], B: Matrix) -> NDArray[np.int64]:
    """Where columns of the factors of symmetric matrices with such entries (I, n, n) and B^T B begin and end."""
    n, touched = entries.shape[-1], dense(B, B.shape[1]) != 0.0
    found = entries | (touched.T @ touched) | np.eye(n, dtype=bool)
    low = found.argmax(axis=1)
    high = n - (low[:, None, ::-1] <= np.arange(n)[:, None]).argmax(axis=2)  # after the last row that begins there
    return np.stack([low, high], axis=-1)


def _first_like(row: Array, rows: Array) -> int:
    """The number of the first of the rows that is this one, -1 where none is."""
    return next((k for k, other in enumerate(rows) if np.array_equal(other, row)), -1)


def springs_of_lanes(every: Sequence[Springs]) -> tuple[Any, ...]:
    """B, and the laws, as the kernel takes them: springs group by group, and of each its lanes."""
    springs, L = every[0], len(every)
    B = springs.compressed
    if len(springs.groups) > 1:
        B = B[np.concatenate([where for _, where in springs.groups])]
    laws = zip(*([law for law, _ in one.groups] for one in every), strict=True)
    counts = [len(where) for _, where in springs.groups]
    tables = [
        by_name(np.stack([law.table((count,)) for law in of], axis=1)).ravel()
        for of, count in zip(laws, counts, strict=True)
    ]
    kept = [range(L * len(where) * len(law.memory)) for law, where in springs.groups]
    laws = (
        np.array([address(law.module.evaluate) for law, _ in springs.groups]), _firsts([range(L * n) for n in counts]),
        _firsts(tables), _firsts(kept), np.concatenate(tables),
    )  # fmt: skip
    rows = np.tile(B.toarray(), (L, 1, 1, 1))
    return (blocks_of(rows), blocks_of(rows.swapaxes(2, 3)), compressed_rows(B)), laws


def compressed_rows(B: Matrix) -> tuple[Array, Array, Array]:
    """A sparse matrix as the kernel takes it."""
    return B.indptr.astype(np.int64), B.indices.astype(np.int64), B.data
