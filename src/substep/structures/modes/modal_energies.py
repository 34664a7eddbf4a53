"""The account of energy of modes that are marched as oscillators, from blocks of their coordinates."""

from collections.abc import Sequence
from functools import reduce

import numpy as np

from ...core.arrays import Array
from ...core.kernel_modules import loaded
from ...run.clock import ConstantSteps
from ..march.quadrature import of_work
from .modes import ModalBasis


class ModalEnergies:
    """Energies as `substep.structures.march.energies.Energies` adds them up, of many steps at once.

    The matrices of modes are diagonal. Work is that of the loads on these modes.
    """

    def __init__(self, modes: ModalBasis, steps: ConstantSteps) -> None:
        self.modes, self.steps, n = modes, steps, steps.n
        self.before = np.empty((2, len(modes)))  # q and v in the last row so far
        self.found = np.empty((n + 1, 5 + 2 * len(modes.structure.loads)))  # sums over modes, a row for each step

    def add(self, first: int, blocks: Sequence[Array], factors: Sequence[Array]) -> None:
        """Add the steps from the number `first` on, 0 being the start.

        Their coordinates are the sum of blocks (r, 3, m), each times its factors (m,).
        """
        modes, X, factor = self.modes, np.ascontiguousarray(blocks[0]), factors[0]
        if len(blocks) > 1:  # of one block the factors go into the weights
            X = reduce(np.add, (block * factor for block, factor in zip(blocks, factors, strict=True)))
            factor = np.ones(len(modes))
        if first == 0:
            self.before = X[0, :2].copy()  # no step leads to the start
        weights = factor**2 * np.array([np.ones(len(modes)), modes.omega**2, np.diag(modes.damping)])
        forces = np.ascontiguousarray(modes.load_factors.T * factor)
        kernel = loaded("shared.combinations").sums_over_modes
        kernel(X, self.before, weights, forces, self.steps.dt, self.found[first : first + len(X)])
        self.before = X[-1, :2].copy()

    def rows(self, done: int) -> Array:
        """Kinetic and strain energy, work, damped energy and quadrature (done + 1, 5) at the start and after each step.

        Steps up to the number `done` were added.
        """
        h, J, loaded_by = self.steps.dt, len(self.modes.structure.loads), self.modes.structure.load_values
        kinetic, strain, along, odd, even = self.found[: done + 1, :5].T
        moved, rates = self.found[1 : done + 1, 5 : 5 + J], self.found[: done + 1, 5 + J :]
        steps = np.arange(done + 1)
        f, half = (loaded_by(self.steps.begin.time(h, at)) for at in (steps, steps[1:] - 0.5))
        work = 0.5 * ((f[:-1] + f[1:]) * moved).sum(axis=1)
        finer = of_work((f[:-1], half, f[1:]), moved, (rates[:-1], rates[1:]), h, np.multiply).sum(axis=1)
        finer -= odd[1:] * (h / 12) + even[1:] / (20 * h)
        found = np.zeros((done + 1, 5))
        found[:, 0], found[:, 1] = 0.5 * kinetic, 0.5 * strain
        found[1:, 2:] = np.cumsum([work, along[1:] / h, finer], axis=1).T
        return found
