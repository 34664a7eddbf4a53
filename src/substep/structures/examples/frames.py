"""Plane beams and frames of two-node elements with shear deformation.

The element has the exact static stiffness of a Timoshenko beam and the mass that is consistent with its shape
functions (Przemieniecki, Theory of Matrix Structural Analysis, 1968, sections 5.6 and 11.4).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import Array
from ...core.loads import Load
from ..solvers.factorization import Solver
from ..solvers.matrices import Matrix
from ..structure import Structure, structure
from .checks import counts, positive
from .naming import placed

DISPLACEMENTS = ("ux", "uy", "rz")  # of each node, in a plane: along x and y, and the rotation from x to y


@dataclass(frozen=True)
class Section:
    """Stiffnesses and masses of a straight member, in consistent units.

    EA, EI: axial and bending stiffness. GA: shear stiffness kappa G A, infinite for a Bernoulli beam. mass, rotary:
    rho A and rho I, per length.
    """

    EA: float
    EI: float
    mass: float
    GA: float = math.inf
    rotary: float = 0.0

    @classmethod
    def rectangle(
        cls, width: float, depth: float, *, E: float, rho: float, nu: float | None = None, kappa: float = 5 / 6
    ) -> "Section":
        """A rectangle bent in the plane of its depth; with Poisson's ratio nu it deforms in shear, else it does not."""
        positive(width=width, depth=depth, E=E, rho=rho)
        area, inertia = width * depth, width * depth**3 / 12
        GA = math.inf if nu is None else kappa * area * E / (2 * (1 + nu))
        return cls(E * area, E * inertia, rho * area, GA, 0.0 if nu is None else rho * inertia)

    def element(self, length: float) -> tuple[Array, Array]:
        """Mass and stiffness (6, 6) of a member along x, for ux, uy, rz of its first and then of its second end."""
        gauss, weights = np.polynomial.legendre.leggauss(4)  # exact for the products of cubics
        s, w = 0.5 * (1.0 + gauss), 0.5 * length * weights
        shear = 12.0 * self.EI / (self.GA * length**2)
        axial = np.array([1.0 - s, s])
        bent = np.array([
            1 - 3 * s**2 + 2 * s**3 + shear * (1 - s),
            length * (s - 2 * s**2 + s**3 + shear / 2 * (s - s**2)),
            3 * s**2 - 2 * s**3 + shear * s,
            length * (s**3 - s**2 + shear / 2 * (s**2 - s)),
        ]) / (1 + shear)  # fmt: skip
        turned = np.array([
            6 / length * (s**2 - s), 1 - 4 * s + 3 * s**2 + shear * (1 - s),
            6 / length * (s - s**2), 3 * s**2 - 2 * s + shear * s,
        ]) / (1 + shear)  # fmt: skip
        curved = np.array([
            6 / length * (2 * s - 1), 6 * s - 4 - shear, 6 / length * (1 - 2 * s), 6 * s - 2 + shear,
        ]) / (length * (1 + shear))  # fmt: skip
        sheared = np.array([-1.0, -length / 2, 1.0, -length / 2]) * shear / (length * (1 + shear))
        M, K = np.zeros((2, 6, 6))
        along, across = np.ix_([0, 3], [0, 3]), np.ix_([1, 2, 4, 5], [1, 2, 4, 5])
        M[along] = self.mass * (axial * w) @ axial.T
        M[across] = self.mass * (bent * w) @ bent.T + self.rotary * (turned * w) @ turned.T
        K[along] = self.EA / length * np.array([[1.0, -1.0], [-1.0, 1.0]])
        K[across] = self.EI * (curved * w) @ curved.T
        if shear:
            K[across] += self.GA * length * np.outer(sheared, sheared)
        return M, K


def assembled(nodes: ArrayLike, members: Sequence[tuple[int, int, Section]]) -> tuple[Matrix, Matrix]:
    """M and K (3n, 3n) of members (first node, second node, section) between nodes (n, 2) of a plane.

    Degrees of freedom are ux, uy, rz of the first node, then of the second, and so on. Raises ValueError for a member
    without length.
    """
    from scipy import sparse  # noqa: PLC0415 (slow to import)

    places = np.asarray(nodes, dtype=np.float64)
    rows, columns, masses, stiffnesses = [], [], [], []
    known: dict[tuple[Section, float, float], tuple[Array, Array]] = {}
    for first, second, section in members:
        x, y = np.round(places[second] - places[first], 12)
        length = math.hypot(x, y)
        if length == 0.0:
            raise ValueError(f"expected a member between two places, got nodes {first} and {second} at the same one")
        if (section, x, y) not in known:
            turn = np.array([[x, y, 0.0], [-y, x, 0.0], [0.0, 0.0, length]]) / length
            both = np.kron(np.eye(2), turn)
            known[section, x, y] = tuple(both.T @ matrix @ both for matrix in section.element(length))
        M, K = known[section, x, y]
        dofs = np.r_[3 * first : 3 * first + 3, 3 * second : 3 * second + 3]
        rows.append(np.repeat(dofs, 6))
        columns.append(np.tile(dofs, 6))
        masses.append(M.ravel())
        stiffnesses.append(K.ravel())
    at, size = (np.concatenate(rows), np.concatenate(columns)), 3 * len(places)
    M, K = (sparse.csr_array((np.concatenate(x), at), shape=(size, size)) for x in (masses, stiffnesses))
    return M, K


STEEL = Section.rectangle(0.1, 0.2, E=2.1e11, rho=7850.0)
COLUMN = Section.rectangle(0.4, 0.4, E=3e10, rho=2500.0)
BEAM = Section.rectangle(0.3, 0.5, E=3e10, rho=12000.0)


def _straight(elements: int, length: float, section: Section) -> tuple[Matrix, Matrix, Array]:
    """M, K, and the places of nodes (n, 2) along x."""
    counts(elements=elements)
    positive(length=length)
    places = np.column_stack([np.linspace(0.0, length, elements + 1), np.zeros(elements + 1)])
    M, K = assembled(places, [(i, i + 1, section) for i in range(elements)])
    return M, K, places


def cantilever(
    elements: int = 20,
    *,
    length: float = 3.0,
    section: Section = STEEL,
    load: Load | None = None,
    C: Any = None,
    solver: Solver = "auto",
) -> Structure:
    """A beam along x, clamped at x = 0; names "uy at 3". load: transverse force on its tip over time.

    By default of steel, 0.1 x 0.2 x 3 m, in N, m, kg. Raises ValueError for dimensions that are not positive.
    """
    M, K, places = _straight(elements, length, section)
    tip = 3 * elements + 1
    return structure(
        M, K, C=C, load=[] if load is None else [({tip: 1.0}, load)], fixed=[0, 1, 2],
        names=placed(DISPLACEMENTS, places[:, :1]), solver=solver,
    )  # fmt: skip


def simple_beam(
    elements: int = 20,
    *,
    length: float = 10.0,
    section: Section | None = None,
    load: Load | None = None,
    C: Any = None,
    solver: Solver = "auto",
) -> Structure:
    """A beam along x, simply supported at both ends; names "uy at 5". load: force per length over time.

    By default that of NAFEMS, Selected Benchmarks for Forced Vibration (1989), test 5T: 2 x 2 x 10 m, E = 200e9,
    nu = 0.3, rho = 8000, in N, m, kg. Raises ValueError for dimensions that are not positive.
    """
    section = section or Section.rectangle(2.0, 2.0, E=200e9, rho=8000.0, nu=0.3)
    M, K, places = _straight(elements, length, section)
    P = np.zeros(3 * (elements + 1))
    dx = length / elements
    for i in range(elements):
        P[[3 * i + 1, 3 * i + 2, 3 * i + 4, 3 * i + 5]] += dx * np.array([1 / 2, dx / 12, 1 / 2, -dx / 12])
    supports = [0, 1, 3 * elements + 1]
    P[supports] = 0.0
    return structure(
        M, K, C=C, load=[] if load is None else [(P, load)], fixed=supports,
        names=placed(DISPLACEMENTS, places[:, :1]), solver=solver,
    )  # fmt: skip


def frame(
    stories: int = 5,
    bays: int = 3,
    *,
    height: float = 3.0,
    width: float = 6.0,
    per_member: int = 4,
    column: Section = COLUMN,
    beam: Section = BEAM,
    load: Load | None = None,
    C: Any = None,
    solver: Solver = "auto",
) -> Structure:
    """A plane frame with clamped columns, each member cut into elements; names "ux at 0 15".

    load: horizontal force on the upper left corner over time. By default of concrete, the floors' mass in the beams'
    density, in N, m, kg. Raises ValueError for dimensions that are not positive.
    """
    counts(stories=stories, bays=bays, per_member=per_member)
    positive(height=height, width=width)
    places: list[tuple[float, float]] = []
    at: dict[tuple[float, float], int] = {}

    def node(x: float, y: float) -> int:
        key = round(x, 9), round(y, 9)
        if key not in at:
            at[key] = len(places)
            places.append((x, y))
        return at[key]

    members = []
    for story in range(1, stories + 1):
        below, above = (story - 1) * height, story * height
        lines = [((bay * width, below), (bay * width, above), column) for bay in range(bays + 1)]
        lines += [((bay * width, above), ((bay + 1) * width, above), beam) for bay in range(bays)]
        for (x, y), (x_end, y_end), section in lines:
            cuts = np.linspace(0.0, 1.0, per_member + 1)
            between = [node(x + cut * (x_end - x), y + cut * (y_end - y)) for cut in cuts]
            members += [(i, j, section) for i, j in pairwise(between)]
    M, K = assembled(places, members)
    clamped = [3 * i + kind for i, (_, y) in enumerate(places) if y == 0.0 for kind in range(3)]
    corner = 3 * node(0.0, stories * height)
    return structure(
        M, K, C=C, load=[] if load is None else [({corner: 1.0}, load)], fixed=clamped,
        names=placed(DISPLACEMENTS, places), solver=solver,
    )  # fmt: skip
