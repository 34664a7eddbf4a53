"""Constraints of a scene: accelerations and multipliers from its equations, and starts that constraints allow.

A scene's module has `constrained`, the matrix [M G^T; G 0] and the right side of the equations for accelerations and
multipliers, and `drift`, the constraints and their time derivatives, G those of the constraints by the coordinates.
"""

from collections.abc import Callable, Sequence

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
            f"expected a mass for each coordinate of {scene} that constraints leave free, got one without; give it one"
        )


def distances(matrix: Array, drift: Array) -> Array:
    """How far displacement and velocity (2, c) are from what each constraint allows, along its direction."""
    c = drift.shape[1]
    return drift / np.linalg.norm(matrix[:-c, -c:], axis=0)


def require_allowed(scene: str, names: Sequence[str], off: Array, length: float, v: Array) -> None:
    """Raises ValueError for a start that is away from a constraint, or leaves it, with the amount."""
    scales = length, max(float(np.linalg.norm(v)), float(np.abs(off[1]).max()))
    for what, x, scale in zip("uv", off, scales, strict=True):
        worst = int(np.abs(x).argmax())
        if abs(x[worst]) > ALLOWED * scale:
            raise ValueError(
                f"expected a start that the constraints of {scene} allow, got {what} off by {x[worst]:.3g} across "
                f"'{names[worst]}'; correct it, or march from start=scene.allowed(u, v), the nearest one"
            )


def nearest(
    scene: str, off: Callable[[Array, Array], tuple[Array, Array]], u: Array, v: Array, length: float
) -> tuple[Array, Array]:
    """u, v (d,) moved onto the constraints by as little as possible, measured by the mass; off: of u, v, see `Scene`.

    Raises ValueError where corrections do not end.
    """
    for _ in range(MOST):
        matrix, drift = off(u, v)
        c = drift.shape[1]
        right = np.zeros((len(matrix), 2))
        right[-c:] = -drift.T
        change = np.linalg.lstsq(matrix, right, rcond=None)[0][: len(u)]
        if np.abs(change[:, 0]).max() <= 1e-15 * length:
            return u, v + change[:, 1]
        u = u + change[:, 0]
        if not np.isfinite(u).all():
            break
    raise ValueError(
        f"expected a start near one that the constraints of {scene} allow, got one from which {MOST} corrections reach "
        "none; give a nearer one"
    )
