"""Damping ratios of modes in place of a damping matrix."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import Array
from ...core.errors import called_as, damping_ratio
from ..model.model import Model
from ..solvers.low_rank import LowRank
from .eigen import eigenmodes
from .modes import ModalBasis, damping_of_modes

OTHER = 1e-6  # phi^T M phi differs by more from the unit matrix where shapes are those of another structure


@dataclass(frozen=True, eq=False)
class ModalDamping:
    """Damping ratios xi (m,) of the m lowest modes, or of these modes; made by `modal_damping`."""

    xi: Array
    modes: ModalBasis | None = None

    def matrix(self, structure: Model) -> LowRank:
        """C = sum of 2 xi omega (M phi) (M phi)^T in the free degrees of freedom, of low rank.

        Raises ValueError for modes of another structure, and as `eigenmodes`.
        """
        if self.modes is None:
            omega, shapes, _ = eigenmodes(structure, len(self.xi))
        else:
            omega, shapes = self.modes.omega, self.modes.free_shapes
        unit = np.eye(len(omega))
        if len(shapes) != structure.size or np.abs(shapes.T @ (structure.M @ shapes) - unit).max() > OTHER:
            raise ValueError(
                f"expected modes of this structure with {structure.size} free degrees of freedom, got others of "
                f"{len(shapes)}; take those of a structure with the same M, K, fixed and constraints"
            )
        return damping_of_modes(structure, omega, shapes, self.xi)


@called_as("modal_damping(0.05, modes=10)")
def modal_damping(xi: ArrayLike, modes: ModalBasis | int | None = None, *, overdamped: bool = False) -> ModalDamping:
    """Damping ratios of modes, as C of `substep.structure`: sum of 2 xi omega (M phi) (M phi)^T, all others undamped.

    xi: ratios (m,) of the m lowest modes, or one for all. modes: how many, if xi is one number; or a structure's
    `Modes`, which are then not computed again. overdamped: ratios above 1 are meant. The matrix is full and is never
    formed: products take 4 n m operations, and effective matrices are those without it, corrected (Woodbury). Of an
    internal force the modes are those of its tangent at u0. Wilson & Penzien, Int. J. Num. Meth. Eng. 4 (1972) 5-10.

    Raises ValueError for negative ratios, for those above 1, likely percent, unless overdamped, for one number without
    `modes`, and for as many as there are no modes.

    >>> frame = ss.structure(np.eye(2), [[5.0, -2.0], [-2.0, 2.0]], C=ss.modal_damping(0.05, modes=2))
    >>> frame.modes(2).xi.round(12)
    array([0.05, 0.05])
    """
    ratios = damping_ratio("xi", xi, overdamped=overdamped)
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
