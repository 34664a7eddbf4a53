"""Contacts in a step of a structure: the reactions with which a balance is solved, at the knot where u is new.

A balance is solved for its unknown z without reactions, and then for them: z moves by A^-1 B^T c p, A its effective
matrix, c the factor of z in its inertia, so that p accelerates by M^-1 B^T p, whatever weight the balance gives to
forces. Of each gap at the displacement that z moves and its reaction p one is 0; with restitution e, where the motion
from t_n on would close the gap, of the velocity that opens it and p: see docs/constraints_and_contact.md. A friction is
at its limit against the velocity there, or that is 0; what limits it is its strength in this balance. That takes d
solutions with A once for each factorization, and a problem in d unknowns a balance.

Where reactions are not remembered, their acceleration, a vector behind the unknowns, is taken off what a step keeps.
Where they are, a balance takes reactions as it takes forces, with the same weights: c is then that of its own, and
those that were solved for before, also at t_n by the last balance of the step before, are beside its loads.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ...core.arrays import Array
from ..model.contacts import Contacts
from ..model.model import Model
from .scheme_plan import Touch

Solve = Callable[[Array], Array]


@dataclass(eq=False)
class Pressing:
    """The contacts of a structure in one balance.

    place: of the unknown among the vectors; at: of the acceleration that the reactions give it, None where they are
    remembered. weight: c. touch: where the reactions act. p (d,): those of the last solution. known: pairs of a weight
    and the contacts whose reactions the balance takes too.
    """

    structure: Model
    contacts: Contacts
    place: int
    at: int | None
    weight: float
    touch: Touch
    p: Array
    known: "list[tuple[float, Pressing]]" = field(default_factory=list)
    factors: Solve | None = None
    moved: Array = field(default_factory=lambda: np.empty(0))  # A^-1 B^T c (n, d)
    compliance: Array = field(default_factory=lambda: np.empty(0))  # B A^-1 B^T c (d, d)

    def begin(self) -> None:
        """Begin a solution without reactions."""
        self.p = np.zeros(self.contacts.size)

    @property
    def stands(self) -> tuple[Array, ...]:
        """What a later march takes to go on to the bit from the last solution."""
        return (self.p,)

    def resume(self, p: Array, u: Array) -> None:
        """Take the reactions of a step before, at its displacement."""
        self.p = p

    def go_on(self, *stands: Array) -> None:
        """Stand where another march did."""
        (self.p,) = stands

    def press(self, X: Array, factors: Solve, scale: float = 1.0) -> None:
        """Solve for the reactions, where the unknown is in its place of X without them; factors: of A over scale."""
        self.begin()
        X[self.place] = self.settled(X, X[self.place], factors, scale)
        self.finish(X)

    def settled(self, X: Array, z: Array, factors: Solve, scale: float = 1.0) -> Array:
        """The unknown under the reactions that are solved for, from the one without them. Raises NotFound."""
        more = self.more(X, z, factors, scale)
        return z if more is None else z + more[0]

    def more(self, X: Array, z: Array, factors: Solve, scale: float = 1.0) -> tuple[Array, Array] | None:
        """By how much the unknown (n,), and the residual's known part, change where z is that of the reactions so far.

        None for nothing; the reactions are changed. Raises NotFound where there are none.
        """
        q = self._free(X, z)
        if not self.p.any() and (q >= 0.0).all() and not self.contacts.sliding.any():
            return None
        if self.factors is not factors:
            self.factors = factors
            self.moved = factors(self.weight / scale * self.contacts.forces(self.structure.size))
            self.compliance = self.contacts.rows @ self.moved[self.contacts.columns]
        found = self.contacts.reactions(q - self.compliance @ self.p, self.compliance, self.p, self.touch.strength)
        more, self.p = found - self.p, found
        return self.moved @ more, -self.weight * self._spread(more)

    def kept(self, X: Array, z: Array) -> bool:
        """Whether the unknown is where the last reactions hold it, but for rounding."""
        return True

    @property
    def pushing(self) -> Array | None:
        """The force (n,) of the reactions of the last solution; None for none."""
        return self._spread(self.p) if self.p.any() else None

    def loaded(self, load: Array | None, scale: float) -> Array | None:
        """The load (n,) over scale, with the reactions that are known."""
        for weight, other in self.known:
            if (pushing := other.pushing) is not None:
                found = weight / scale * pushing
                load = found if load is None else load + found
        return load

    def _spread(self, p: Array) -> Array:
        """The forces (n,) of reactions."""
        found = np.zeros(self.structure.size)
        found[self.contacts.columns] = p @ self.contacts.rows
        return found

    def finish(self, X: Array) -> None:
        """Put the acceleration that the reactions give in its place of X."""
        if self.at is not None:
            X[self.at] = self.structure.pushed @ self.p if self.p.any() else 0.0

    def _free(self, X: Array, z: Array) -> Array:
        """Gaps, or velocities that open them, over what z moves them by (d,); infinite where nothing is to be held."""
        contacts, j = self.contacts, self.place
        u, v, ahead, before = (row[:j] @ X[:j, contacts.columns] for row in self.touch.rows)
        c_u, c_v = (float(row[j]) for row in self.touch.rows[:2])
        found = np.empty(contacts.size)
        held, bouncing = ~contacts.bouncing, contacts.bouncing
        if held.any():
            gaps = contacts.gaps0 + contacts.rows @ (u + c_u * z[contacts.columns])
            found[held] = gaps[held] / c_u
        if bouncing.any():
            opens = contacts.rows @ (v + c_v * z[contacts.columns])
            free = z - self.moved @ self.p if self.p.any() else z
            closes = contacts.closing(ahead, c_u * free[contacts.columns]) | contacts.sliding
            opens += contacts.restitution * (contacts.rows @ before)
            found[bouncing] = np.where(closes, opens / c_v, np.inf)[bouncing]
        return found
