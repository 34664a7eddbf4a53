"""Constraints of a scene: accelerations and multipliers from its equations, and starts that constraints allow.

A scene's module has `constrained`, the matrix [M G^T; G 0] and the right side of the equations for accelerations and
multipliers, and `drift`, the constraints and their time derivatives, G those of the constraints by the coordinates.
"""

from collections.abc import Sequence

import numpy as np

from .arrays import Array

ALLOWED = 1e-8  # of the scene's length, and of the velocity: how far a start may be from what constraints allow
MOST = 50  # corrections of a projection
DEPENDENT = 1e-12  # of the largest singular value of the directions: with a smaller one, constraints are dependent


def parts(values: Array, d: int, c: int) -> tuple[Array, Array]:
    """Matrix (..., d + c, d + c) and right side (..., d + c) from what `constrained` gives."""
    n = d + c
    return values[..., : n * n].reshape(*values.shape[:-1], n, n), values[..., n * n :]


def solved(values: Array, d: int, c: int) -> Array:
    """Accelerations and multipliers (..., d + c); NaN where the equations do not determine them."""
    matrix, right = parts(values, d, c)
    try:
        return np.linalg.solve(matrix, right[..., None])[..., 0]
    except np.linalg.LinAlgError:  # in one of many rows
        found = np.full(right.shape, np.nan)
        for at in np.ndindex(right.shape[:-1]):
            if np.linalg.matrix_rank(matrix[at]) == d + c:
                found[at] = np.linalg.solve(matrix[at], right[at])
        return found


def require_independent(scene: str, names: Sequence[str], matrix: Array) -> None:
    """Raises ValueError where constraints repeat each other at the start, or leave a coordinate without mass free."""
    c = len(names)
    *_, values, rows = np.linalg.svd(matrix[:-c, -c:], full_matrices=True)
    rank = int((values > DEPENDENT * values[0]).sum()) if values[0] > 0.0 else 0
    if rank < c:
        involved = [name for name, x in zip(names, rows[rank], strict=True) if abs(x) > 1e-6]
        raise ValueError(
            f"expected independent constraints of {scene}, got {rank} independent of {c} at the start: "
            f"{', '.join(involved)} repeat each other there; leave one out, or start elsewhere"
        )
    if np.linalg.matrix_rank(matrix) < len(matrix):
        raise ValueError(
            f"expected a mass of each coordinate of {scene} that constraints leave free, got none of one; give it a mass"
        )


def distances(matrix: Array, drift: Array, c: int) -> tuple[Array, Array]:
    """How far displacement and velocity (c,) are from what each constraint allows, along its direction."""
    across = np.linalg.norm(matrix[:-c, -c:], axis=0)
    return drift[:c] / across, drift[c:] / across


def require_allowed(scene: str, names: Sequence[str], off: tuple[Array, Array], length: float, v: Array) -> None:
    """Raises ValueError for a start that is away from a constraint, or leaves it, with the amount."""
    scales = length, max(float(np.linalg.norm(v)), float(np.abs(off[1]).max()))
    for what, x, scale in zip(("u", "v"), off, scales, strict=True):
        worst = int(np.abs(x).argmax())
        if abs(x[worst]) > ALLOWED * scale:
            raise ValueError(
                f"expected a start that the constraints of {scene} allow, got {what} off by {x[worst]:.3g} across "
                f"'{names[worst]}'; correct it, or take the nearest one by project=True"
            )
