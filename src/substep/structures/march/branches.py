"""Factors of an effective matrix with springs, for the branches in which these are."""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ...core.arrays import Array
from ..model.springs import Springs

Solve = Callable[[Array], Array]
KEPT = 16  # sets of slopes of which the factors are kept
FEW = 100  # springs whose slopes may differ from those before anything is strained, beside a sparse matrix


@dataclass(eq=False)
class Branches:
    """Solutions with A + B^T diag(d) B for the last few d (s,), the slopes of springs by the unknown of a system.

    Of a sparse matrix there is one factorization, with the slopes `first` before anything is strained. Where those of
    few springs differ, the solution with it is corrected (Woodbury), which takes one more solution for each spring that
    ever differs: 100 x 100 masses with 30 springs, a third of them yielding, take half the time. It depends on d
    alone which way is gone, so that a march that goes on from another has its digits.
    """

    springs: Springs
    sparse: bool
    factorized: Callable[[Array], Solve]
    first: Array
    kept: OrderedDict[bytes, Solve] = field(default_factory=OrderedDict)
    base: Solve | None = None
    last: Array | None = None  # the slopes that were asked for last
    columns: dict[int, Array] = field(default_factory=dict)  # of the inverse with the first slopes, times a row of B

    def of(self, d: Array) -> Solve:
        """The function b -> x. Raises ValueError for a singular matrix."""
        key, self.last = d.tobytes(), d
        if key not in self.kept:
            places = np.flatnonzero(d != self.first)
            found = self._corrected(places, d) if self.sparse and len(places) <= FEW else self.factorized(d)
            while len(self.kept) >= KEPT:
                self.kept.popitem(last=False)
            self.kept[key] = found
        self.kept.move_to_end(key)
        return self.kept[key]

    def _corrected(self, places: Array, d: Array) -> Solve:
        if self.base is None:
            self.base = self.factorized(self.first)
        if not len(places):
            return self.base
        base, B = self.base, self.springs.B[places]
        for place in places.tolist():
            if place not in self.columns:
                row = self.springs.B[[place]]
                self.columns[place] = base(np.asarray(row if isinstance(row, np.ndarray) else row.toarray()).ravel())
        Z = np.array([self.columns[place] for place in places.tolist()])
        change = (d - self.first)[places]
        middle = np.eye(len(places)) + change[:, None] * np.asarray(B @ Z.T)
        try:
            back = np.linalg.solve(middle, np.diag(change)).T @ Z
        except np.linalg.LinAlgError:
            return self.factorized(d)  # which says where it is singular

        def solved(b: Array) -> Array:
            x = base(b)
            return x - np.asarray(B @ x) @ back

        return solved
