"""Modes of a structure: frequencies, shapes, damping, participation; the coordinates in which it is superposed."""

# pyright: reportUnnecessaryIsInstance=false
# what users give is checked when it comes, whatever its annotation says

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import Array
from ...core.errors import damping_ratio
from ...core.exports import Exported
from ..model.model import Model
from ..model.rayleigh import Rayleigh
from ..model.supports import require_still_supports
from ..solvers.low_rank import LowRank
from .eigen import static_response

COUPLED = 1e-10  # off the diagonal of the modal damping matrix, relative to its largest entry


@dataclass(frozen=True)
class Participation(Exported):
    """Of modes in a motion of the base: factors Gamma (m,), effective modal masses Gamma^2 (m,), their limit `total`.

    factors: phi^T M iota of mass-normalised shapes, in the unit of sqrt(mass). total: iota^T M iota, what all effective
    masses sum up to, but for mass at degrees of freedom that are fixed. Chopra, Dynamics of Structures, (13.2.3).
    """

    axes: ClassVar = dict.fromkeys(("factors", "effective_mass", "share"), ("mode",))

    factors: Array
    total: float

    @property
    def effective_mass(self) -> Array:
        """Effective modal masses (m,)."""
        return self.factors**2

    @property
    def share(self) -> Array:
        """Effective modal masses relative to the total (m,)."""
        return self.effective_mass / self.total if self.total > 0.0 else np.zeros_like(self.factors)


@dataclass(frozen=True, eq=False, repr=False)
class ModalBasis:
    """The m lowest modes of a structure, as coordinates in which it moves; made by `Structure.modes`.

    omega (m,): circular frequencies, rad/s, ascending, 0 for rigid modes. free_shapes (n, m): mass-normalised shapes in
    the structure's free degrees of freedom. damping (m, m): phi^T C phi, 1/s. known_statics: `statics`, where the
    factors by which the modes were found gave them.
    """

    structure: Model
    omega: Array
    free_shapes: Array
    damping: Array
    known_statics: Array | None = None

    def __len__(self) -> int:
        return len(self.omega)

    @cached_property
    def shapes(self) -> Array:
        """Mass-normalised shapes (N, m) in all degrees of freedom."""
        return self.structure.T @ self.free_shapes

    @cached_property
    def inertia(self) -> Array:
        """M times the shapes (n, m), whose transpose takes a state to modal coordinates."""
        return self.structure.M @ self.free_shapes

    @cached_property
    def statics(self) -> Array:
        """Displacements (n, J) of the free degrees of freedom under each load vector, constant in time.

        Of a free body its deformation; raises ValueError where not all of its rigid modes are among these.
        """
        if self.known_statics is not None:
            return self.known_statics
        return static_response(self.structure, self.structure.load_vectors, self.free_shapes[:, : self.rigid])

    @cached_property
    def load_factors(self) -> Array:
        """phi^T of each load vector (m, J)."""
        return self.free_shapes.T @ self.structure.load_vectors

    @cached_property
    def start(self) -> Array:
        """q, q', q'' (3, m) at t = 0: phi^T M of the structure's start; q'' by the equations of motion if not given."""
        whole = self.structure
        given = [whole.u0, whole.v0] if whole.a0_given is None else [whole.u0, whole.v0, whole.a0_given]
        start = np.zeros((3, len(self)))
        start[: len(given)] = [x @ self.inertia if x.any() else 0.0 * self.omega for x in given]
        if whole.a0_given is None:
            loads = whole.load_values(np.zeros(1))[0]
            start[2] = self.load_factors @ loads - self.damping @ start[1] - self.omega**2 * start[0]
        return start

    @property
    def periods(self) -> Array:
        """Natural periods (m,), s; inf for rigid modes."""
        with np.errstate(divide="ignore"):
            return 2.0 * np.pi / self.omega

    @property
    def rigid(self) -> int:
        """How many of the modes are rigid."""
        return int(np.count_nonzero(self.omega == 0.0))

    @cached_property
    def coupling(self) -> float:
        """The largest entry of phi^T C phi off its diagonal, relative to the largest of all."""
        largest = float(np.abs(self.damping).max())
        rest = self.damping - np.diag(np.diag(self.damping))
        return float(np.abs(rest).max()) / largest if largest > 0.0 else 0.0

    @property
    def classical(self) -> bool:
        """Whether damping does not couple the modes: phi^T C phi is diagonal to 1e-10."""
        return self.coupling <= COUPLED

    @cached_property
    def xi(self) -> Array:
        """Damping ratios (m,), phi^T C phi / (2 omega) of each mode alone; inf for a rigid mode that is damped."""
        c = np.diag(self.damping).copy()
        c[np.abs(c) <= COUPLED * np.abs(self.damping).max(initial=0.0)] = 0.0  # rounding, of either sign
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(c == 0.0, 0.0, 0.5 * c / self.omega)

    @property
    def lanes(self) -> bool:
        """Whether each mode is an oscillator of its own: classical damping, xi >= 0, no damped rigid mode."""
        return self.classical and bool((self.xi >= 0.0).all() and np.isfinite(self.xi).all())

    @property
    def together(self) -> str:
        """Why they are not oscillators of their own, in words; empty where they are."""
        if self.lanes:
            return ""
        if not self.classical:
            return f"damping couples the modes ({self.coupling:.1e} of its largest entry is off the diagonal)"
        if (self.xi < 0.0).any():
            return f"damping is negative and drives modes (xi = {self.xi.min():.3g} at the least)"
        return "damping acts on a rigid mode, which has no damping ratio"

    def first(self, n: int) -> Self:
        """The n lowest of them. Raises ValueError for n that is not from 1 to m."""
        if isinstance(n, bool) or not isinstance(n, int | np.integer) or not 1 <= n <= len(self):
            raise ValueError(f"expected from 1 to {len(self)} modes, got {n!r}; compute more with Structure.modes")
        return replace(self, omega=self.omega[:n], free_shapes=self.free_shapes[:, :n], damping=self.damping[:n, :n])

    def damped(self, xi: ArrayLike, *, overdamped: bool = False) -> Self:
        """The same modes with these damping ratios in place of the structure's damping: one for all, or (m,).

        Their structure is damped likewise, by `modal_damping`, so that modes which are not among these are undamped.
        Raises ValueError for negative ratios, for those above 1, likely percent, unless overdamped, and other shapes.
        """
        ratios = damping_ratio("xi", xi, overdamped=overdamped)
        if ratios.shape not in ((), (len(self),)):
            raise ValueError(f"expected xi as one number or {len(self)}, one for each mode, got shape {ratios.shape}")
        xi = np.broadcast_to(ratios, (len(self),))
        require_still_supports(self.structure)
        C = damping_of_modes(self.structure, self.omega, self.free_shapes, xi) if ratios.any() else None
        damping = np.diag(np.broadcast_to(2.0 * ratios * self.omega, self.omega.shape))
        return replace(self, structure=replace(self.structure, C=C, full_damping=None), damping=damping)

    def damping_matrix(self) -> Array:
        """C (N, N) = M phi (phi^T C phi) phi^T M, for `substep.structure`: only these modes are damped.

        Full, whatever the matrices are: meant for structures of some hundred degrees of freedom. Wilson & Penzien,
        Evaluation of orthogonal damping matrices, Int. J. Num. Meth. Eng. 4, 5-10, 1972.
        """
        spread = self.structure.full_mass @ self.shapes
        return spread @ self.damping @ spread.T

    def participation(self, direction: ArrayLike) -> Participation:
        """Participation factors and effective masses for a motion of the base; see `Structure.ground_motion`."""
        iota = self.structure.influence_of(direction)
        moved = self.structure.full_mass @ iota
        return Participation(self.shapes.T @ moved, float(iota @ moved))

    def __repr__(self) -> str:
        ends = f"omega from {self.omega[0]:.4g} to {self.omega[-1]:.4g} rad/s"
        kind = "classical damping" if self.classical else "modes coupled by damping"
        return f"Modes({len(self)} of {self.structure.size}, {ends}, {kind})"


def damping_of_modes(structure: Model, omega: Array, shapes: Array, xi: Array) -> LowRank:
    """C = sum of 2 xi omega (M phi) (M phi)^T in the free degrees of freedom, of low rank; shapes (n, m), xi (m,)."""
    weights = 2.0 * xi * omega
    damped = weights > 0.0
    return LowRank(np.asfortranarray(structure.M @ shapes[:, damped]), weights[damped])


def modal_damping_matrix(structure: Model, omega: Array, shapes: Array) -> Array:
    """phi^T C phi (m, m) of the structure's damping."""
    C = structure.at_start.C
    if C is None:
        return np.zeros((len(omega), len(omega)))
    if isinstance(C, Rayleigh):
        return np.diag(C.alpha + C.beta * omega**2)
    return shapes.T @ (C @ shapes)
