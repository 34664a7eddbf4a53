"""Balances of a linear structure that are solved together, taken apart into single ones, real or complex.

In s balances with the unknowns z_k, tables m, c, k (s, s) of numbers multiply M, C and K: the sum over k of
(m_ik M + c_ik C + k_ik K) z_k is b_i. In a Runge-Kutta method they are 1, h A and h^2 A^2, so that c/m and k/m have the
same eigenvectors Q. With z = Q w each balance then has an unknown of its own, (M + c_j C + k_j K) w_j = (Q^-1 b/m)_j,
and of a pair of complex ones only one is solved, since the other is its conjugate (Butcher, BIT 16 (1976) 237-240).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...core.arrays import Array
from ..model.model import Model
from ..solvers.combine import add_product, combined
from ..solvers.matrices import Matrix
from .linear import Factors, rows_by_matrix
from .pressing import Pressing
from .scheme_plan import System

APART, WORST = 1e-13, 1e5  # of eigenvectors: what is left beside the diagonals over their condition, and the latter


@dataclass(frozen=True)
class Together:
    """Balances that are solved together.

    rows (P, first): of the known vectors that matrices multiply; shares (s, P): of the products in the right sides b.
    before, after (s, s): from b to what is solved for w, and from w to z; of a complex w two rows, its parts.
    solutions: of each w, and whether it is complex.
    """

    unknowns: slice
    rows: Array
    matrices: tuple[Matrix, ...]
    shares: Array
    before: Array
    after: Array
    solutions: tuple[tuple[Callable[[Array], Array], bool], ...]
    scale = 1.0  # what the last one's load has to be divided by
    count = 0  # iterations
    tangent = None  # that is kept
    solve = None  # a factorization of the last one

    @classmethod
    def of(cls, s: Model, group: Sequence[System], factors: Factors, who: str) -> "Together":
        """From systems of a plan. Raises ValueError for a singular effective matrix and as `_apart`."""
        unknowns, every = group[0].unknowns, [rows_by_matrix(s, system) for system in group]
        by = {name: np.array([rows[name] for rows in every]) for name in every[0]}
        rows, matrices, shares = list[Array](), list[Matrix](), list[Array]()
        for name, matrix in {"M": s.M, "C": s.damping, "K": s.K}.items():
            known = by[name][:, : unknowns.start]
            read = np.flatnonzero(known.any(axis=0))
            of_vectors = len(read) < len(group)
            rows += [*(np.eye(unknowns.start)[read] if of_vectors else known)]
            shares += [*(-known[:, read].T if of_vectors else -np.eye(len(group)))]
            matrices += [matrix] * (len(rows) - len(matrices))
        before, after, solutions = list[Array](), list[Array](), list[tuple[Callable[[Array], Array], bool]]()
        for c, k, left, right in _apart(*(table[:, unknowns] for table in by.values()), who):
            scale, solve = factors.scaled(s, 1.0, c, k, f"a step of {who}")
            pair = isinstance(k, complex)
            before += [(left / scale).real, (left / scale).imag][: 1 + pair]
            after += [2.0 * right.real, -2.0 * right.imag] if pair else [right.real]
            solutions.append((solve, pair))
        return cls(
            unknowns, np.reshape(rows, (-1, unknowns.start)), tuple(matrices), np.reshape(shares, (-1, len(group))).T,
            np.array(before), np.array(after).T, tuple(solutions),
        )  # fmt: skip

    def begin(self, X: Array) -> None:
        """Put into the unknowns' places of X (V, n), or of L cases (V, n, L), the right sides without loads."""
        products = np.zeros((len(self.rows), *X.shape[1:]))
        for matrix, y, total in zip(
            self.matrices, combined(self.rows, X[: self.unknowns.start]), products, strict=True
        ):
            add_product(matrix, y, total)
        combined(self.shares, products, X[self.unknowns])

    def put(self, X: Array, load: Array | None, t: float, ahead: int = 0, pressing: Pressing | None = None) -> None:
        """Put the unknowns in place of their right sides; load (n,), or (n, L): that of the last one."""
        if load is not None:
            X[self.unknowns.stop - 1] += load
        b = X[self.unknowns]
        self._solved(b, b)
        if pressing is not None:
            pressing.begin()

            def factors(right: Array) -> Array:
                return self._solved(right.reshape(*b.shape, -1)).reshape(right.shape)

            b[:] = pressing.settled(X, b.ravel(), factors).reshape(b.shape)

    def _solved(self, right: Array, out: Array | None = None) -> Array:
        """The unknowns (s, n) of right sides b, or (s, n, L) of L such, in `out` if given."""
        w, j = combined(self.before, right), 0
        for solution, pair in self.solutions:
            if pair:
                found = solution(w[j] + 1j * w[j + 1])
                w[j], w[j + 1] = found.real, found.imag
            else:
                w[j] = solution(w[j])
            j += 1 + pair
        return combined(self.after, w, out)


class Whole(Protocol):
    """What solves balances together, at the place of the last one."""

    unknowns: slice
    count: int

    def begin(self, X: Array) -> None:
        """Put into the unknowns' places of X their right sides without loads."""
        ...


@dataclass(frozen=True)
class Joined:
    """One of the systems that are solved together, but the last: it adds its load to its right side."""

    place: int
    whole: Whole
    scale = 1.0  # what its load has to be divided by
    tangent = None  # that is kept
    solve = None  # a factorization of its own

    @property
    def count(self) -> int:
        """The iterations of the whole."""
        return self.whole.count

    def put(self, X: Array, load: Array | None, t: float, ahead: int = 0, pressing: Pressing | None = None) -> None:
        """As that of `LinearSystem`; nothing of it is known ahead, and no contact presses."""
        if self.place == self.whole.unknowns.start:
            self.whole.begin(X)
        if load is not None:
            X[self.place] += load


def _apart(m: Array, c: Array, k: Array, who: str) -> list[tuple[float | complex, float | complex, Array, Array]]:
    """Of each real w, and one of each pair of complex ones: numbers of C and K, row of Q^-1/m (s,), column of Q (s,).

    Raises ValueError for tables m, c, k (s, s) that cannot be taken apart so.
    """
    regular = np.linalg.cond(m) < WORST
    inverse = np.linalg.inv(m) if regular else m
    c, k = inverse @ c, inverse @ k
    values, Q = np.linalg.eig(sum(x / (np.abs(x).max() or 1.0) for x in (c, k)))
    condition = float(np.linalg.cond(Q))
    back = np.linalg.inv(Q) if condition < WORST else Q
    numbers = [np.diag(back @ x @ Q) for x in (c, k)]
    off = [np.abs((Q * of) @ back - x).max() / (np.abs(x).max() or 1.0) for of, x in zip(numbers, (c, k), strict=True)]
    if not (regular and condition < WORST and max(off) < APART * condition):
        raise ValueError(
            f"{who} solves balances together whose coefficients of M, C and K have no eigenvectors in common: expected "
            "ones that have, as those of Runge-Kutta methods whose table has different eigenvalues, on a structure; "
            "take another scheme, or march its modes or a scene"
        )
    found = []
    for j in np.flatnonzero(values.imag >= 0.0):
        of = [complex(x[j]) if values[j].imag else float(x[j].real) for x in numbers]
        found.append((*of, back[j] @ inverse, Q[:, j]))
    return found
