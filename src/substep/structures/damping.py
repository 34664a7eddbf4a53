"""Damping of a structure that is not given as a matrix."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..core.arrays import Array
from ..core.errors import called_as, non_negative, real_number
from .low_rank import LowRank
from .matrices import Matrix, combination

if TYPE_CHECKING:
    from .modes import Modes
    from .structure import Structure

OTHER = 1e-6  # phi^T M phi differs by more from the unit matrix where shapes are those of another structure


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
    """
    ratios = [real_number(name, x) for name, x in (("xi_1", xi_1), ("xi_2", xi_2))]
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


@dataclass(frozen=True, eq=False)
class ModalDamping:
    """Damping ratios xi (m,) of the m lowest modes, or of these modes; made by `modal_damping`."""

    xi: Array
    modes: "Modes | None" = None

    def matrix(self, structure: "Structure") -> LowRank:
        """C = sum of 2 xi omega (M phi) (M phi)^T in the free degrees of freedom, of low rank.

        Raises ValueError for modes of another structure, and as `Structure.modes`.
        """
        modes = structure.modes(len(self.xi)) if self.modes is None else self.modes
        shapes = modes.free_shapes
        unit = np.eye(len(modes))
        if len(shapes) != structure.size or np.abs(shapes.T @ (structure.M @ shapes) - unit).max() > OTHER:
            raise ValueError(
                f"expected modes of this structure with {structure.size} free degrees of freedom, got others of "
                f"{len(shapes)}; take those of a structure with the same M, K, fixed and constraints"
            )
        weights = 2.0 * self.xi * modes.omega
        damped = weights > 0.0
        return LowRank(np.asfortranarray(structure.M @ shapes[:, damped]), weights[damped])


def modal_damping(xi: ArrayLike, modes: "Modes | int | None" = None) -> ModalDamping:
    """Damping ratios of modes, as C of `substep.structure`: sum of 2 xi omega (M phi) (M phi)^T, all others undamped.

    xi: ratios (m,) of the m lowest modes, or one for all. modes: how many, if xi is one number; or a structure's
    `Modes`, which are then not computed again. The matrix is full and is never formed: products take 4 n m operations,
    and effective matrices are those without it, corrected (Woodbury). Of an internal force the modes are those of its
    tangent at u0. Wilson & Penzien, Int. J. Num. Meth. Eng. 4 (1972) 5-10.

    Raises ValueError for negative ratios, for one number without `modes`, and for as many as there are no modes.
    """
    ratios = non_negative("xi", xi)
    if modes is None or isinstance(modes, int | np.integer):
        known, count = None, len(ratios) if modes is None and ratios.ndim == 1 else modes
    else:
        known, count = modes, len(modes)
    if count is None or isinstance(modes, bool) or count < 1 or ratios.shape not in ((), (count,)):
        raise ValueError(
            "expected xi (m,), a ratio for each of m modes, or one number and modes=m or Modes, got xi of "
            f"shape {ratios.shape} and modes = {modes!r}; give as many ratios as modes"
        )
    return ModalDamping(np.broadcast_to(ratios, (count,)).astype(np.float64), known)
