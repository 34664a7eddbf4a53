"""Nonlinear constraints in a step of a structure: the multipliers with which a balance is solved, and g(u) = 0."""

from dataclasses import dataclass, field
from functools import cached_property
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
    """The constraints of a structure in one balance, as `Pressing` has contacts, or in s that are solved together.

    stages: of the latter, rows (V,) of the displacements at which they take forces, and weights of these; place is that
    of the last, and p its multipliers. reaction (s, n): of each. With the gradients G where the unknowns are,
    multipliers are those with which g vanishes to first order; a few solutions more bring g to rounding, since G turns
    little in a step. acts: of an explicit balance the row of the displacement at which it takes forces, where the
    gradients are along which its reaction acts; empty otherwise.
    """

    contacts: Any
    stages: tuple[tuple[Array, float], ...] = ()
    acts: Array = field(default_factory=lambda: np.empty(0))
    reaction: Array = field(default_factory=lambda: np.empty(0))

    @cached_property
    def _every(self) -> tuple[Array, Array, Array]:
        """Of the stages, or the one balance: rows of known vectors, and of the unknowns (s, s), and weights (s, 1)."""
        stages = self.stages or ((self.touch.rows[0], self.weight),)
        rows, first = np.array([row for row, _ in stages]), self.place + 1 - len(stages)
        return rows[:, :first], rows[:, first : self.place + 1], np.array([[w] for _, w in stages])

    def begin(self) -> None:
        """Begin a solution without reactions."""
        self.p, self.reaction = np.zeros(self.contacts.size), np.zeros((len(self.stages) or 1, self.structure.size))

    def resume(self, p: Array, u: Array) -> None:
        """Take the multipliers of a step before, at its displacement."""
        self.begin()
        self.p, self.reaction[-1] = p, self.contacts.forces(u, p)

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
        return self.reaction[-1] if self.p.any() else None

    def settled(self, X: Array, z: Array, factors: Solve, scale: float = 1.0) -> Array:
        """The unknown where g = 0, from the one without reactions. Raises NotFound."""
        reach, previous = float(np.abs(self._every[1]).sum(axis=1).max()), np.inf
        for _ in range(ITERATIONS):
            dz, _ = self.more(X, z, factors, scale)
            z = z + dz
            size, U = reach * float(np.abs(dz).max()), self._displacements(X, z)
            largest = max(self.contacts.length, float(np.abs(U).max()))
            if size <= EXACT * largest or (size >= 0.5 * previous and size <= ROUNDING * largest):
                return z
            if not np.isfinite(size):
                break
            previous = size
        raise NotFound

    def kept(self, X: Array, z: Array) -> bool:
        """Whether g vanishes, but for rounding."""
        for u in self._displacements(X, z):
            values, G = self.contacts.at(u)
            if not (np.abs(values) <= KEPT * (np.abs(G) @ np.maximum(np.abs(u), self.contacts.length))).all():
                return False
        return True

    def more(self, X: Array, z: Array, factors: Solve, scale: float = 1.0) -> tuple[Array, Array]:
        """By how much the unknowns (s n,), and the residual's known part, change; z: those under the reactions so far.

        Raises NotFound where constraints have become dependent.
        """
        U, (_, by, weights), d = self._displacements(X, z), self._every, self.contacts.size
        at = [self.contacts.at(u) for u in U]
        values, G = np.concatenate([x for x, _ in at]), np.array([x for _, x in at])
        along = G if not len(self.acts) else self.contacts.at(self.acts[: self.place] @ X[: self.place])[1][None]
        right = np.zeros((*U.shape, values.size + 1))
        for i, directions in enumerate(along):
            right[i, :, i * d : (i + 1) * d] = -directions.T
        right[..., -1] = self.reaction
        right *= weights[..., None] / scale
        moved = factors(right.reshape(z.size, -1)).reshape(right.shape)
        compliance = (G @ (by @ moved.reshape(len(U), -1)).reshape(right.shape)).reshape(values.size, -1)
        try:
            p = np.linalg.solve(compliance[:, :-1], compliance[:, -1] - values)
        except np.linalg.LinAlgError as error:
            raise NotFound from error
        reaction = -(p.reshape(-1, 1, d) @ along)[:, 0]
        change, self.reaction, self.p = weights * (reaction - self.reaction), reaction, p[-d:]
        return (moved[..., :-1] @ p - moved[..., -1]).ravel(), -change.ravel()

    def _displacements(self, X: Array, z: Array) -> Array:
        """The displacements (s, n) that the unknowns (s n,) move."""
        known, by, _ = self._every
        return known @ X[: known.shape[1]] + by @ z.reshape(len(by), -1)
