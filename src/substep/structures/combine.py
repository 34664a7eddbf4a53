"""Sums and products of long vectors without BLAS.

A step combines a few vectors with few coefficients. OpenBLAS shares that out among threads, which wait for each other
longer than the sums take: on a core that is shared, twice as long as a solve with 26000 unknowns. A combination of
seven vectors of 100000 then takes 12 ms. The compiled kernel reads up to four vectors side by side: it takes a third of
the time of NumPy's sums of two with 26000 unknowns, and an eighth with 16 load cases of them.
"""

import math

import numpy as np

from ..core.arrays import Array
from ..core.kernel_modules import loaded


def combined(rows: Array, X: Array, out: Array | None = None) -> Array:
    """rows (R, V) times vectors X (V, n), or X (V, n, L) for L load cases; in `out`, which is contiguous, if given."""
    if out is None:
        out = np.empty((len(rows), *X.shape[1:]))
    n = math.prod(X.shape[1:])
    vectors = np.ascontiguousarray(X, dtype=np.float64).reshape(len(X), n)
    loaded("combinations").combine(np.ascontiguousarray(rows), vectors, out.reshape(len(rows), n))
    return out


def summed(B: Array, x: Array) -> Array:
    """B^T x (r,) or (r, k), of B (n, r), columns contiguous, and x (n,) or (n, k)."""
    return np.einsum("rn,n->r", B.T, x) if x.ndim == 1 else B.T @ x


def spread(B: Array, c: Array) -> Array:
    """B c (n,) or (n, k), of B (n, r), columns contiguous, and c (r,) or (r, k)."""
    return np.einsum("rn,r->n", B.T, c) if c.ndim == 1 else B @ c
