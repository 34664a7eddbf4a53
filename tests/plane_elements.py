"""Small structures for tests: shear buildings, and a cantilever of bilinear plane elements, assembled plainly."""

from typing import Any

import numpy as np
from scipy import sparse

Array = Any


def shear_building(masses: Any, stiffnesses: Any) -> tuple[Array, Array]:
    """M, K of storeys from the ground up, fixed at the base."""
    n = len(masses)
    K = np.zeros((n, n))
    for i, k in enumerate(stiffnesses):
        K[i, i] += k
        if i:
            K[i - 1, i - 1] += k
            K[i - 1, i] -= k
            K[i, i - 1] -= k
    return np.diag(np.asarray(masses, dtype=float)), K


def cantilever(
    nx: int, ny: int, *, length: float = 5.0, height: float = 1.0, E: float = 1e4, nu: float = 0.3, rho: float = 1.0
) -> tuple[Array, Array, Array, int]:
    """Consistent sparse M, K in plane stress, the degrees of freedom at x = 0, the vertical one of a free corner."""
    a, b = length / nx, height / ny
    D = E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    g = 1 / np.sqrt(3)
    ke, me = np.zeros((8, 8)), np.zeros((8, 8))
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    for x, y in corners * g:
        shape = (1 + corners[:, 0] * x) * (1 + corners[:, 1] * y) / 4
        dx = corners[:, 0] * (1 + corners[:, 1] * y) / 4 * 2 / a
        dy = corners[:, 1] * (1 + corners[:, 0] * x) / 4 * 2 / b
        B, N = np.zeros((3, 8)), np.zeros((2, 8))
        B[0, ::2], B[1, 1::2], B[2, ::2], B[2, 1::2] = dx, dy, dy, dx
        N[0, ::2], N[1, 1::2] = shape, shape
        ke += B.T @ D @ B * a * b / 4
        me += rho * N.T @ N * a * b / 4
    node = np.arange((nx + 1) * (ny + 1)).reshape(nx + 1, ny + 1)
    elements = np.stack([node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]], axis=-1).reshape(-1, 4)
    places = np.stack([2 * elements, 2 * elements + 1], axis=-1).reshape(-1, 8)
    rows, columns = np.repeat(places, 8, axis=1).ravel(), np.tile(places, (1, 8)).ravel()
    size = (2 * node.size,) * 2
    K = sparse.csr_array((np.tile(ke.ravel(), len(places)), (rows, columns)), shape=size)
    M = sparse.csr_array((np.tile(me.ravel(), len(places)), (rows, columns)), shape=size)
    fixed = np.concatenate([2 * node[0], 2 * node[0] + 1])
    return M, K, fixed, int(2 * node[-1, -1] + 1)
