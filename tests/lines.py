"""Rows u, v, a, and u and v as functions of an unknown acceleration: what steps of the nonlinear oracle are made of."""

from typing import NamedTuple

import numpy as np
import tables

Array = np.ndarray


def solve(matrix: Array, right: Array) -> Array:
    """The solution for one right side or several, also in mpmath's numbers."""
    if matrix.dtype != object:
        return np.linalg.solve(matrix, right)
    if len(matrix) == 1:
        return right / matrix[0, 0]
    if right.ndim == 2:
        return np.array([solve(matrix, column) for column in right.T]).T
    return np.array(tables.solved([[*row, x] for row, x in zip(matrix, right, strict=True)]))


def norm(x: Array) -> float:
    return abs(x).max()


class Row(NamedTuple):
    u: Array
    v: Array
    a: Array


class Line(NamedTuple):  # u = u_p + c_u a, v = v_p + c_v a for the unknown a
    u_p: Array
    c_u: float
    v_p: Array
    c_v: float

    def end(self, a: Array) -> Row:
        return Row(self.u_p + self.c_u * a, self.v_p + self.c_v * a, a)


def newmark_line(row: Row, h: float, beta: float, gamma: float) -> Line:
    u0, v0, a0 = row
    return Line(u0 + h * v0 + h**2 * (0.5 - beta) * a0, beta * h**2, v0 + h * (1 - gamma) * a0, gamma * h)


def same_line(known_u: Array, known_v: Array, w: float) -> Line:
    """y1 = known_y + w y1', one formula for u and v."""
    return Line(known_u + w * known_v, w * w, known_v, w)
