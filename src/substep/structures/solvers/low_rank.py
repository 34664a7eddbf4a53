"""Matrices of low rank, such as the damping of some modes: multiplied and solved with, never formed."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...core.arrays import Array
from .combine import spread, summed


@dataclass(frozen=True, eq=False)
class LowRank:
    """B diag(d) B^T (n, n), B (n, r), columns contiguous, d (r,); r is small beside n."""

    B: Array
    d: Array
    __array_ufunc__ = None  # a factor that is NumPy's leaves the product to `__rmul__`

    @property
    def shape(self) -> tuple[int, int]:
        """(n, n)."""
        return len(self.B), len(self.B)

    def __matmul__(self, x: Array) -> Array:
        """The product with x (n,) or (n, k), in 4 n r operations a column."""
        return spread(self.B, (self.d * summed(self.B, x).T).T)

    def __rmul__(self, factor: float) -> "LowRank":
        return LowRank(self.B, factor * self.d)

    def toarray(self) -> Array:
        """The full matrix (n, n)."""
        return (self.B * self.d) @ self.B.T

    def operator(self) -> Any:
        """As SciPy's LinearOperator, to be added to others of that kind."""
        from scipy.sparse.linalg import LinearOperator  # noqa: PLC0415 (slow to import)

        product = self.__matmul__
        return LinearOperator(self.shape, matvec=product, rmatvec=product, dtype=np.float64)  # type: ignore[call-arg]


@dataclass(frozen=True, eq=False)
class Updated:
    """base + low, of a matrix that can be factorized and one of low rank."""

    base: Any
    low: LowRank


def solved_with(solve: Callable[[Array], Array], low: LowRank) -> Callable[[Array], Array]:
    """b -> (A + B diag(d) B^T)^-1 b, from the factorization of A (Woodbury's formula).

    Solves with B once, at the cost of r right-hand sides; each solution then takes 4 n r operations more.
    """
    Z = solve(low.B)
    rank = len(low.d)
    middle = np.linalg.solve(np.eye(rank) + low.d[:, None] * (low.B.T @ Z), np.diag(low.d))
    back = np.asfortranarray(Z @ middle)

    def solved(b: Array) -> Array:
        x = solve(b)
        return x - spread(back, summed(low.B, x))

    return solved
