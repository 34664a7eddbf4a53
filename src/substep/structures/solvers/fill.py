"""How many numbers the triangular factor of a symmetric matrix holds, known before it is computed."""

import numpy as np
from numba import njit

from ...core.arrays import Array


@njit
def factor_entries(starts: Array, rows: Array) -> int:
    """Entries of L in A = L L^T, the diagonal included, of a pattern in compressed columns and in the order of A.

    The elimination tree is that of Liu (ACM Trans. Math. Softw. 12, 1986, 127-148): parent of j is the first row below
    the diagonal of column j of L. Row j of L then holds the unknowns on the ways from the entries left of the diagonal
    in row j of A up to j, each counted once.
    """
    n = len(starts) - 1
    parent, root = np.full(n, -1), np.full(n, -1)
    for j in range(n):
        for p in range(starts[j], starts[j + 1]):
            i = rows[p]
            while i != -1 and i < j:  # root: a shorter way up the tree that is known so far
                above, root[i] = root[i], j
                if above == -1:
                    parent[i] = j
                i = above
    entries, counted = n, np.full(n, -1)
    for j in range(n):
        counted[j] = j
        for p in range(starts[j], starts[j + 1]):
            i = rows[p]
            while i < j and counted[i] != j:
                counted[i] = j
                entries += 1
                i = parent[i]
    return entries
