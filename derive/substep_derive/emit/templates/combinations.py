"""Fixed text of the module of sums and products of long vectors."""

COMBINATIONS = '''"""Sums and products of long vectors, which steps of structures and their energies consist of.

What limits them is memory: they go through it block by block, and read a block of a vector once for all that takes it.
"""

import numpy as np
from numba import njit

BLOCK = 512  # numbers of a vector that stay in the first cache while others of the same place are read

_compiled = njit(cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True, fastmath={"contract"})
_summed = njit(cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True, fastmath={"contract", "reassoc"})


@_compiled
def combine(rows, X, out):
    """rows (R, V) times the vectors X (V, n), in out (R, n); vectors of which a row has 0 are not read for it.

    Up to four vectors are read side by side, so that each sum is stored once. Where fewer are left, the last one stands
    in for the others, times 0.
    """
    R, V = rows.shape
    used, count = np.empty((R, V), np.int64), np.zeros(R, np.int64)
    for r in range(R):
        for v in range(V):
            if rows[r, v] != 0.0:
                used[r, count[r]] = v
                count[r] += 1
    for begin in range(0, X.shape[1], BLOCK):
        end = min(begin + BLOCK, X.shape[1])
        for r in range(R):
            sums, last = out[r, begin:end], count[r] - 1
            if last < 0:
                sums[:] = 0.0
            for first in range(0, last + 1, 4):
                i, j = used[r, first], used[r, min(first + 1, last)]
                k, m = used[r, min(first + 2, last)], used[r, min(first + 3, last)]
                a = rows[r, i]
                b = rows[r, j] if first < last else 0.0
                c = rows[r, k] if first + 1 < last else 0.0
                d = rows[r, m] if first + 2 < last else 0.0
                x, y, z, w = X[i, begin:end], X[j, begin:end], X[k, begin:end], X[m, begin:end]
                if first == 0:
                    for n in range(sums.size):
                        sums[n] = a * x[n] + b * y[n] + c * z[n] + d * w[n]
                else:
                    for n in range(sums.size):
                        sums[n] += a * x[n] + b * y[n] + c * z[n] + d * w[n]


@_summed
def inner_products(X, Y, out):
    """The inner products of the vectors X (V, n) with the vectors Y (W, n), in out (V, W)."""
    out[:] = 0.0
    for begin in range(0, X.shape[1], BLOCK):
        end = min(begin + BLOCK, X.shape[1])
        for i in range(len(X)):
            for j in range(len(Y)):
                x, y, total = X[i, begin:end], Y[j, begin:end], 0.0
                for n in range(x.size):
                    total += x[n] * y[n]
                out[i, j] += total


@_summed
def add_product(first, columns, entries, x, y):
    """Add A x to y (n,), A in compressed rows; first (n+1,) and columns are unsigned: none is looked for below 0."""
    for i in range(y.size):
        total = 0.0
        for k in range(first[i], first[i + 1]):
            total += entries[k] * x[columns[k]]
        y[i] += total


@_summed
def add_two_products(first, columns, entries, X, Y):
    """Add A x to y for two vectors x and y, X and Y (2, n), with A as in `add_product`, which is read once."""
    x, w, y, z = X[0], X[1], Y[0], Y[1]
    for i in range(y.size):
        one = other = 0.0
        for k in range(first[i], first[i + 1]):
            entry, column = entries[k], columns[k]
            one += entry * x[column]
            other += entry * w[column]
        y[i] += one
        z[i] += other
'''
