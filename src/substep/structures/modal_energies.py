"""The account of energy of modes that are marched as oscillators, from blocks of their coordinates."""

from collections.abc import Sequence
from functools import reduce

import numpy as np

from ..core.arrays import Array
from ..core.loads import values_at
from .modes import Modes


class ModalEnergies:
    """Energies as `substep.structures.histories.Energies` adds them up, of many steps at once.

    The matrices of modes are diagonal. Work is that of the loads on these modes. rows (n+1, 4): kinetic and strain
    energy, work and damped energy after each step.
    """

    def __init__(self, modes: Modes, h: float, n: int) -> None:
        self.modes, self.h, self.rows = modes, h, np.empty((n + 1, 4))
        self.q, self.sums = modes.start[:1], np.zeros(2)  # work and damped energy up to the coordinates q

    def add(self, first: int, blocks: Sequence[Array], factors: Sequence[Array]) -> None:
        """Add the steps from the number `first` on, 0 being the start.

        Their coordinates are the sum of blocks (r, 3, m), each times its factors (m,).
        """
        modes = self.modes
        q, v = (
            reduce(np.add, (block[:, kind] * factor for block, factor in zip(blocks, factors, strict=True)))
            for kind in range(2)
        )
        change = np.diff(q, axis=0, prepend=self.q)
        t = np.maximum(np.arange(first - 1, first + len(q)), 0) * self.h
        work = np.zeros(len(q))
        for (_, load), factor in zip(modes.structure.loads, modes.load_factors.T, strict=True):
            force = values_at(load, t)
            work += 0.5 * (force[:-1] + force[1:]) * _weighted(change, factor)
        damped = _weighted(change**2, np.diag(modes.damping)) / self.h
        rows = self.rows[first : first + len(q)]
        rows[:, 0] = 0.5 * np.einsum("ri,ri->r", v, v)
        rows[:, 1] = 0.5 * _weighted(q**2, modes.omega**2)
        rows[:, 2:] = self.sums + np.cumsum([work, damped], axis=1).T
        self.q, self.sums = q[-1:].copy(), rows[-1, 2:]


def _weighted(x: Array, weights: Array) -> Array:
    """x (r, m) times weights (m,), without BLAS; see `substep.structures.combine`."""
    return np.einsum("ri,i->r", x, weights)
