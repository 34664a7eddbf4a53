"""Nonlinear constraints in a step of a structure: the multipliers with which a balance is solved, and g(u) = 0."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...core.arrays import Array
from ..solvers.complementarity import NotFound
from .pressing import Pressing, Solve

ITERATIONS = 50
EXACT = 4e-16  # of the displacements: a correction within it is rounding
KEPT = 1e-14  # of the parts of a gradient times the displacements: a value of g within it is rounding
ROUNDING = 1e-12  # of the displacements: corrections within it that no longer shrink are rounding too


@dataclass(eq=False)
class Holding(Pressing):
    """The constraints of a structure in one balance, as `Pressing` has contacts; reaction (n,): that of p.

    With the gradients G where the unknown is, multipliers are those with which g vanishes to first order; a few
    solutions more bring g to rounding, since G turns little in a step. acts: of an explicit balance the row of the
    displacement at which it takes forces, where the gradients are along which its reaction acts; empty otherwise.
    """

    contacts: Any
    acts: Array = field(default_factory=lambda: np.empty(0))
    reaction: Array = field(default_factory=lambda: np.empty(0))

    def begin(self) -> None:
        """Begin a solution without reactions."""
        self.p, self.reaction = np.zeros(self.contacts.size), np.zeros(self.structure.size)

    def resume(self, p: Array, u: Array) -> None:
        """Take the multipliers of a step before, at its displacement."""
        self.p, self.reaction = p, self.contacts.forces(u, p)

    @property
    def stands(self) -> tuple[Array, ...]:
        """What a later march takes to go on to the bit: with the force, whose gradients are of the last iteration."""
        return self.p, self.reaction

    def go_on(self, *stands: Array) -> None:
        """Stand where another march did."""
        self.p, self.reaction = stands

    @property
    def pushing(self) -> Array | None:
        """The force (n,) of the reactions of the last solution."""
        return self.reaction if self.p.any() else None

    def settled(self, X: Array, z: Array, factors: Solve, scale: float = 1.0) -> Array:
        """The unknown where g = 0, from the one without reactions. Raises NotFound."""
        c_u, previous = self._displacement(X, z)[1], np.inf
        for _ in range(ITERATIONS):
            dz, _ = self.more(X, z, factors, scale)
            z = z + dz
            size, u = abs(c_u) * float(np.abs(dz).max()), self._displacement(X, z)[0]
            largest = max(self.contacts.length, float(np.abs(u).max()))
            if size <= EXACT * largest or (size >= 0.5 * previous and size <= ROUNDING * largest):
                return z
            if not np.isfinite(size):
                break
            previous = size
        raise NotFound

    def kept(self, X: Array, z: Array) -> bool:
        """Whether g vanishes, but for rounding."""
        u, _ = self._displacement(X, z)
        values, G = self.contacts.at(u)
        return bool((np.abs(values) <= KEPT * (np.abs(G) @ np.maximum(np.abs(u), self.contacts.length))).all())

    def more(self, X: Array, z: Array, factors: Solve, scale: float = 1.0) -> tuple[Array, Array]:
        """By how much the unknown (n,), and the residual's known part, change where z is that of the reactions so far.

        Raises NotFound where constraints have become dependent.
        """
        u, c_u = self._displacement(X, z)
        values, G = self.contacts.at(u)
        along = self.contacts.at(self.acts[: self.place] @ X[: self.place])[1] if self.acts.any() else G
        moved = factors(self.weight / scale * np.column_stack([-along.T, self.reaction]))
        compliance, taken = c_u * (G @ moved[:, :-1]), c_u * (G @ moved[:, -1])
        try:
            self.p = np.linalg.solve(compliance, taken - values)
        except np.linalg.LinAlgError as error:
            raise NotFound from error
        reaction = -self.p @ along
        change, self.reaction = reaction - self.reaction, reaction
        return moved[:, :-1] @ self.p - moved[:, -1], -self.weight * change

    def _displacement(self, X: Array, z: Array) -> tuple[Array, float]:
        """The displacement (n,) that the unknown moves, and by how much."""
        row, j = self.touch.rows[0], self.place
        return row[:j] @ X[:j] + row[j] * z, float(row[j])
