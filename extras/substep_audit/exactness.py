"""Whether a stepper is exact: for undriven motion, and for a load that is linear or constant over a step."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from substep.core.arrays import Array

from .fit import largest
from .linear_step import Oscillators
from .noise import QUIET, Noise
from .probes import Measured

Load = Literal["linear over a step", "constant over a step", "otherwise"]


@dataclass(frozen=True)
class ExactStep:
    """The exact motion of P oscillators over a step, by the matrix exponential of u, v, f and its slope."""

    at: Oscillators

    @cached_property
    def matrices(self) -> Array:
        """(P, 2, 4): u, v at the end of a step from u, v, f at its beginning, and the change of f within it."""
        from scipy.linalg import expm  # noqa: PLC0415 (slow to import)

        h, found = self.at.h, []
        for omega, xi in zip(self.at.omega, self.at.xi, strict=True):
            rates = np.array([[0, 1, 0, 0], [-(omega**2), -2 * xi * omega, 1, 0], [0, 0, 0, 1 / h], [0, 0, 0, 0]])
            found.append(expm(rates * h)[:2])
        return np.array(found)

    def histories(self, start: Array, n: int, loads: Array, kind: Load) -> Array:
        """u, v, a (P, n+1, 3) from u, v (2,), with the load's values (n+1,) linear or constant over each step."""
        rows = np.zeros((len(self.at.Omega), n + 1, 3))
        rows[:, 0, :2] = start
        for k in range(n):
            change = loads[k + 1] - loads[k] if kind == "linear over a step" else 0.0
            rows[:, k + 1, :2] = np.einsum("pij,pj->pi", self.matrices[:, :, :2], rows[:, k, :2])
            rows[:, k + 1, :2] += self.matrices[:, :, 2] * loads[k] + self.matrices[:, :, 3] * change
        u, v = rows[..., 0], rows[..., 1]
        omega, xi = self.at.omega[:, None], self.at.xi[:, None]
        rows[..., 2] = loads - 2 * xi * omega * v - omega**2 * u
        return rows


def exactness(own: Sequence[Measured], driven: Mapping[str, Measured], noise: Noise = QUIET) -> Load | None:
    """The load for which a stepper is exact; "otherwise" if only undriven motion is; None if it is not exact."""
    if noise.hides or not all(_agrees(run, "otherwise", noise) for run in own):
        return None
    kinds: tuple[Load, ...] = ("linear over a step", "constant over a step")
    agreeing = (kind for kind in kinds if driven and all(_agrees(run, kind, noise) for run in driven.values()))
    return next(agreeing, "otherwise")


def _agrees(run: Measured, kind: Load, noise: Noise) -> bool:
    """Whether u and v are exact; the acceleration at the end of a step is either side's where the load jumps."""
    n, powers = run.rows.shape[1] - 1, run.at.powers
    loads = np.array([run.load.at(t) for t in np.arange(n + 1) * run.at.h])
    rows = ExactStep(run.at).histories(np.array(run.start[:2]) / powers[:2], n, loads, kind) * powers
    return largest(run.deviation(rows)[:, 1:, :2]) <= noise.rounding
