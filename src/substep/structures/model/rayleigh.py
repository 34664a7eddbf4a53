"""Rayleigh damping, by two numbers in place of a matrix."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.errors import called_as, damping_ratio, real_number
from ..solvers.matrices import Matrix, combination


@dataclass(frozen=True)
class Rayleigh:
    """C = alpha M + beta K; alpha in 1/s, beta in s.

    Kept as two numbers: a balance then needs one product with M beside its solve.
    """

    alpha: float
    beta: float

    def __post_init__(self) -> None:
        for name in ("alpha", "beta"):
            real_number(f"{name} of Rayleigh damping", getattr(self, name))

    def matrix(self, M: Matrix, K: Matrix) -> Matrix:
        """The damping matrix."""
        return combination([(self.alpha, M), (self.beta, K), (0.0, M)]) if self.alpha or self.beta else 0.0 * M

    def ratio(self, omega: float) -> float:
        """The damping ratio of a mode of circular frequency omega, rad/s: (alpha/omega + beta omega)/2."""
        return 0.5 * (self.alpha / omega + self.beta * omega)


@called_as("rayleigh(0.02, 0.05, at=(omega_1, omega_2))")
def rayleigh(xi_1: float, xi_2: float, *, at: tuple[float, float]) -> Rayleigh:
    """Rayleigh damping with the ratios xi_1 and xi_2 at two circular frequencies, rad/s (Chopra, Dynamics, (11.4.10)).

    Raises ValueError for frequencies that are not positive and different, and for ratios that need a negative alpha or
    beta, which would drive the modes below or above.

    >>> damping = ss.rayleigh(0.05, 0.05, at=(6.0, 30.0))
    >>> round(damping.alpha, 3), round(damping.beta, 5)
    (0.5, 0.00278)
    """
    ratios = [real_number(name, x) for name, x in (("xi_1", xi_1), ("xi_2", xi_2))]
    damping_ratio("xi", [max(x, 0.0) for x in ratios])  # negative ones are answered below
    if np.shape(at) != (2,):
        raise ValueError(f"expected at as two circular frequencies, rad/s, got {at!r}; give a list [omega_1, omega_2]")
    omegas = [real_number("a frequency of Rayleigh damping", omega, positive=True) for omega in at]
    if omegas[0] == omegas[1]:
        raise ValueError(f"expected two different frequencies, got {omegas[0]} twice; give two of the structure's")
    alpha, beta = np.linalg.solve([[0.5 / omega, 0.5 * omega] for omega in omegas], ratios)
    if alpha < 0.0 or beta < 0.0:
        raise ValueError(
            f"expected ratios for which neither part is negative, got alpha = {alpha:.3g}, beta = {beta:.3g}: "
            "modes outside the two frequencies would be driven; bring the ratios nearer to each other"
        )
    return Rayleigh(float(alpha), float(beta))
