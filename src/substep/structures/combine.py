"""Sums and products of long vectors without BLAS.

A step combines a few vectors with few coefficients. OpenBLAS shares that out among threads, which wait for each other
longer than the sums take: on a core that is shared, twice as long as a solve with 26000 unknowns. A combination of
seven vectors of 100000 then takes 12 ms in place of 0.08; below some thousand unknowns it takes 3 us more than BLAS.
"""

import numpy as np

from ..core.arrays import Array


def combined(rows: Array, X: Array, out: Array | None = None) -> Array:
    """rows (R, V), many of them 0 or 1, times vectors X (V, n), or X (V, n, L) for L load cases; in `out`, if given."""
    if out is None:
        out = np.empty((len(rows), *X.shape[1:]))
    part = None
    for row, y in zip(rows.tolist(), out, strict=True):
        first = True
        for factor, x in zip(row, X, strict=True):
            if factor == 0.0:
                continue
            if first:
                np.multiply(x, factor, out=y)
            elif factor == 1.0:
                np.add(y, x, out=y)
            else:
                part = np.multiply(x, factor, out=part)
                np.add(y, part, out=y)
            first = False
        if first:
            y[...] = 0.0
    return out


def dot(x: Array, y: Array) -> float:
    """The inner product of two vectors."""
    return float(np.einsum("i,i->", x, y))


def summed(B: Array, x: Array) -> Array:
    """B^T x (r,) or (r, k), of B (n, r), columns contiguous, and x (n,) or (n, k)."""
    return np.einsum("rn,n->r", B.T, x) if x.ndim == 1 else B.T @ x


def spread(B: Array, c: Array) -> Array:
    """B c (n,) or (n, k), of B (n, r), columns contiguous, and c (r,) or (r, k)."""
    return np.einsum("rn,r->n", B.T, c) if c.ndim == 1 else B @ c
