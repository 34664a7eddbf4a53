"""Sums and products of long vectors without BLAS.

A step combines a few vectors with few coefficients. OpenBLAS shares that out among threads, which wait for each other
longer than the sums take: on a core that is shared, twice as long as a solve with 26000 unknowns. A combination of
seven vectors of 100000 then takes 12 ms. The compiled kernel reads up to four vectors side by side, block by block: it
takes an eighth of the time of NumPy's sums of two with 26000 unknowns, alone or with 16 load cases of them.
Products of a sparse matrix with two vectors read it once, which takes two thirds of the time of two.
"""

import math
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.kernel_modules import loaded


def combined(rows: Array, X: Array, out: Array | None = None, then: Array | None = None) -> Array:
    """rows (R, V) times vectors X (V, n), or X (V, n, L) for L load cases, and `then` (S, R) times what these give.

    (R + S, n) or (R + S, n, L); in `out`, which is contiguous, if given.
    """
    if then is None:
        then = np.empty((0, len(rows)))
    if out is None:
        out = np.empty((len(rows) + len(then), *X.shape[1:]))
    n = math.prod(X.shape[1:])
    vectors = np.ascontiguousarray(X, dtype=np.float64).reshape(len(X), n)
    kernel = loaded("shared.combinations").combine
    kernel(np.ascontiguousarray(rows), np.ascontiguousarray(then), vectors, out.reshape(len(out), n))
    return out


def inner_products(X: Array, Y: Array) -> Array:
    """The inner products (V, W) of vectors X (V, n) with vectors Y (W, n)."""
    out = np.empty((len(X), len(Y)))
    loaded("shared.combinations").inner_products(np.ascontiguousarray(X), np.ascontiguousarray(Y), out)
    return out


def add_product(matrix: Any, x: Array, to: Array) -> None:
    """Add the product of a matrix, dense, sparse or of low rank, with x (n,) or (n, L) to `to`."""
    if x.ndim == 1 and (rows := _in_rows(matrix)):
        loaded("shared.combinations").add_product(*rows, x, to)
    else:
        np.add(to, matrix @ x, out=to)


def products(matrix: Any, X: Array) -> Array:
    """The products (V, n) of a matrix, dense, sparse or of low rank, with vectors X (V, n)."""
    found, rows = np.zeros(X.shape), _in_rows(matrix)
    if rows and len(X) == 2:
        loaded("shared.combinations").add_two_products(*rows, np.ascontiguousarray(X), found)
        return found
    for x, product in zip(X, found, strict=True):
        add_product(matrix, x, product)
    return found


def _in_rows(matrix: Any) -> tuple[Array, Array, Array] | None:
    """First places, columns and entries of a matrix in compressed rows, as kernels take them; None of any other."""
    if getattr(matrix, "format", None) != "csr":
        return None
    unsigned = np.uint32 if matrix.indices.itemsize == 4 else np.uint64
    return matrix.indptr.view(unsigned), matrix.indices.view(unsigned), matrix.data


def summed(B: Array, x: Array) -> Array:
    """B^T x (r,) or (r, k), of B (n, r), columns contiguous, and x (n,) or (n, k)."""
    return np.einsum("rn,n->r", B.T, x) if x.ndim == 1 else B.T @ x


def spread(B: Array, c: Array) -> Array:
    """B c (n,) or (n, k), of B (n, r), columns contiguous, and c (r,) or (r, k)."""
    return np.einsum("rn,r->n", B.T, c) if c.ndim == 1 else B @ c
