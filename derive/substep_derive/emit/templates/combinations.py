"""Fixed text of the module that combines long vectors."""

COMBINATIONS = '''"""Combinations of long vectors: with products and solutions, all that a step of a structure needs."""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True)
def combine(rows, X, out):
    """rows (R, V) times the vectors X (V, n), in out (R, n); vectors of which a row has 0 are not read for it.

    Up to four vectors are read side by side, so that each sum is stored once: what limits it is memory. Where fewer
    are left, the last one stands in for the others, times 0.
    """
    for r in range(len(rows)):
        used, sums = np.flatnonzero(rows[r]), out[r]
        last = used.size - 1
        if last < 0:
            sums[:] = 0.0
        for first in range(0, last + 1, 4):
            i, j = used[first], used[min(first + 1, last)]
            k, m = used[min(first + 2, last)], used[min(first + 3, last)]
            a = rows[r, i]
            b = rows[r, j] if first < last else 0.0
            c = rows[r, k] if first + 1 < last else 0.0
            d = rows[r, m] if first + 2 < last else 0.0
            x, y, z, w = X[i], X[j], X[k], X[m]
            if first == 0:
                for n in range(sums.size):
                    sums[n] = a * x[n] + b * y[n] + c * z[n] + d * w[n]
            else:
                for n in range(sums.size):
                    sums[n] += a * x[n] + b * y[n] + c * z[n] + d * w[n]
'''
