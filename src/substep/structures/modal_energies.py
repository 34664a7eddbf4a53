"""The account of energy of modes that are marched as oscillators, from blocks of their coordinates."""

from collections.abc import Sequence
from functools import reduce

import numpy as np

from ..core.arrays import Array
from ..core.loads import values_at
from .modes import Modes
from .quadrature import of_damped, of_work


class ModalEnergies:
    """Energies as `substep.structures.histories.Energies` adds them up, of many steps at once.

    The matrices of modes are diagonal. Work is that of the loads on these modes. rows (n+1, 5): kinetic and strain
    energy, work, damped energy and quadrature after each step.
    """

    def __init__(self, modes: Modes, h: float, n: int) -> None:
        self.modes, self.h, self.rows = modes, h, np.empty((n + 1, 5))
        self.last, self.sums = modes.start[:2], np.zeros(3)  # q and v, and the sums up to there

    def add(self, first: int, blocks: Sequence[Array], factors: Sequence[Array]) -> None:
        """Add the steps from the number `first` on, 0 being the start.

        Their coordinates are the sum of blocks (r, 3, m), each times its factors (m,).
        """
        modes = self.modes
        q, v = (
            reduce(np.add, (block[:, kind] * factor for block, factor in zip(blocks, factors, strict=True)))
            for kind in range(2)
        )
        change, ends = np.diff(q, axis=0, prepend=self.last[:1]), (np.concatenate([self.last[1:], v[:-1]]), v)
        t = np.maximum(np.arange(first - 1, first + len(q)), 0) * self.h
        between = 0.5 * (t[:-1] + t[1:])
        work, finer = np.zeros(len(q)), np.zeros(len(q))
        for (_, load), factor in zip(modes.structure.loads, modes.load_factors.T, strict=True):
            force = values_at(load, t)
            moved, rates = _weighted(change, factor), [_weighted(x, factor) for x in ends]
            forces = force[:-1], values_at(load, between), force[1:]
            work += 0.5 * (force[:-1] + force[1:]) * moved
            finer += of_work(forces, moved, rates, self.h, np.multiply)
        C = np.diag(modes.damping)
        damped = _weighted(change**2, C) / self.h
        by_C = (change, change * C), ends, [x * C for x in ends]
        finer -= of_damped(*by_C, self.h, lambda x, y: np.einsum("ri,ri->r", x, y))
        if first == 0:
            finer[0] = 0.0  # no step leads to the start
        rows = self.rows[first : first + len(q)]
        rows[:, 0] = 0.5 * np.einsum("ri,ri->r", v, v)
        rows[:, 1] = 0.5 * _weighted(q**2, modes.omega**2)
        rows[:, 2:] = self.sums + np.cumsum([work, damped, finer], axis=1).T
        self.last, self.sums = np.array([q[-1], v[-1]]), rows[-1, 2:]


def _weighted(x: Array, weights: Array) -> Array:
    """x (r, m) times weights (m,), without BLAS; see `substep.structures.combine`."""
    return np.einsum("ri,i->r", x, weights)
