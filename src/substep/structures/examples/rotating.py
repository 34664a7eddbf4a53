"""A bar that turns about one end: large rotations, elastic in Green-Lagrange strain (St. Venant-Kirchhoff)."""

from typing import Any

import numpy as np

from ...core.arrays import Array
from ..solvers.factorization import Solver
from ..solvers.matrices import Matrix
from ..structure import Structure, structure
from .checks import counts, positive
from .naming import placed


class _Bar:
    """Forces of elements of reference length l in a row of nodes: energy EA l E^2/2, E = (|r|^2 - l^2)/(2 l^2)."""

    def __init__(self, places: Array, EA: float) -> None:
        self.places, self.EA = places, EA
        self.l = np.linalg.norm(np.diff(places, axis=0), axis=1)

    def _state(self, u: Array) -> tuple[Array, Array]:
        """r (n, 2) from end to end of each element, and its strain (n,)."""
        r = np.diff(self.places + u.reshape(-1, 2), axis=0)
        return r, (np.einsum("ij,ij->i", r, r) - self.l**2) / (2.0 * self.l**2)

    def potential(self, u: Array) -> float:
        """Strain energy."""
        _, strain = self._state(u)
        return 0.5 * self.EA * float(self.l @ strain**2)

    def force(self, u: Array) -> Array:
        """Its slope (2n + 2,)."""
        r, strain = self._state(u)
        pull = (self.EA * strain / self.l)[:, None] * r
        total = np.zeros_like(self.places)
        total[1:] += pull
        total[:-1] -= pull
        return total.ravel()

    def tangent(self, u: Array) -> Matrix:
        """The slope of that (2n + 2, 2n + 2)."""
        from scipy import sparse  # noqa: PLC0415 (slow to import)

        r, strain = self._state(u)
        own = strain[:, None, None] * np.eye(2) + r[:, :, None] * r[:, None, :] / self.l[:, None, None] ** 2
        blocks = np.kron([[1.0, -1.0], [-1.0, 1.0]], own * (self.EA / self.l)[:, None, None])
        at = 2 * np.arange(len(r))[:, None] + np.arange(4)
        rows, columns = np.broadcast_arrays(at[:, :, None], at[:, None, :])
        size = self.places.size
        return sparse.csr_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size))


def rotating_bar(
    elements: int = 4,
    *,
    EA: float = 1e4,
    length: float = 3.0443,
    tip: float = 10.0,
    mass: float = 0.01,
    speed: float = 7.72,
    C: Any = None,
    solver: Solver = "auto",
) -> Structure:
    """A bar along x, pinned at x = 0, with a mass at its tip that starts at `speed` along y; names "ux at 3.0443".

    EA: N for strain in the sense of Green and Lagrange; mass: of the bar, lumped at its nodes, 0 for one element alone,
    which is then the scene elastic_pendulum, whose numbers the defaults are. Raises ValueError for dimensions that are
    not positive, and for a massless bar of several elements, whose inner nodes nothing would hold across it.
    """
    counts(elements=elements)
    positive(EA=EA, length=length, tip=tip)
    if elements > 1 or mass != 0.0:
        positive(mass=mass)
    x = np.linspace(0.0, length, elements + 1)
    places = np.column_stack([x, np.zeros_like(x)])
    masses = mass / elements * np.r_[0.5, np.ones(elements - 1), 0.5]
    masses[-1] += tip
    bar = _Bar(places, EA)
    from scipy import sparse  # noqa: PLC0415

    start = np.column_stack([np.zeros_like(x), speed * x / length]).ravel()
    return structure(
        sparse.diags_array(np.repeat(masses, 2)), internal_force=bar.force, tangent=bar.tangent,
        potential=bar.potential, C=C, v0=start, fixed=[0, 1], names=placed(["ux", "uy"], places[:, :1]), solver=solver,
    )  # fmt: skip
