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
def _used(rows):
    """Of rows (R, V) the places of entries that are not 0, in the first columns (R, V), and how many there are (R,)."""
    R, V = rows.shape
    used, count = np.empty((R, V), np.int64), np.zeros(R, np.int64)
    for r in range(R):
        for v in range(V):
            if rows[r, v] != 0.0:
                used[r, count[r]] = v
                count[r] += 1
    return used, count


@_compiled
def _combine_block(rows, used, count, X, out, begin, end):
    """Rows times the vectors X, in out, from place `begin` to `end` of each.

    Up to four vectors are read side by side, so that each sum is stored once. Where fewer are left, the last one stands
    in for the others, times 0.
    """
    for r in range(len(rows)):
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


@_compiled
def combine(rows, then, X, out):
    """rows (R, V) times the vectors X (V, n), and `then` (S, R) times what these give, in out (R + S, n).

    Vectors of which a row has 0 are not read for it.
    """
    used, count = _used(rows)
    used_then, count_then = _used(then)
    made, more = out[: len(rows)], out[len(rows) :]
    for begin in range(0, X.shape[1], BLOCK):
        end = min(begin + BLOCK, X.shape[1])
        _combine_block(rows, used, count, X, made, begin, end)
        _combine_block(then, used_then, count_then, made, more, begin, end)


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


@_summed
def sums_over_modes(X, before, weights, forces, h, out):
    """Sums over modes of what a step's energies consist of, in out (r, 5 + 2 J), for steps of length h.

    X (r, 3, m): coordinates q, their rates v and accelerations after each step; before (2, m): q and v before the first
    one. weights (3, m): of v^2, q^2 and damping. A row has the sums of v^2 and q^2 with their weights; with those of
    damping those of d^2, (v - v0)^2 and (h (v0 + v) - 2 d)^2, d being the change of q and v0 the rate before; and with
    forces (J, m) those of all d, then of all v.
    """
    J, m = forces.shape
    of_v, of_q, of_damping = weights[0], weights[1], weights[2]
    for i in range(X.shape[0]):
        q0, v0 = (before[0], before[1]) if i == 0 else (X[i - 1, 0], X[i - 1, 1])
        q, v = X[i, 0], X[i, 1]
        kinetic = strain = along = odd = even = 0.0
        for k in range(m):
            d, faster, twice = q[k] - q0[k], v[k] - v0[k], h * (v0[k] + v[k])
            rest = twice - 2.0 * d
            kinetic += of_v[k] * v[k] * v[k]
            strain += of_q[k] * q[k] * q[k]
            along += of_damping[k] * d * d
            odd += of_damping[k] * faster * faster
            even += of_damping[k] * rest * rest
        out[i, 0], out[i, 1], out[i, 2], out[i, 3], out[i, 4] = kinetic, strain, along, odd, even
        for j in range(J):
            force, moved, rate = forces[j], 0.0, 0.0
            for k in range(m):
                moved += force[k] * (q[k] - q0[k])
                rate += force[k] * v[k]
            out[i, 5 + j], out[i, 5 + J + j] = moved, rate
'''
