"""Constraints and contacts of a scene: accelerations, multipliers and pressures, and the starts that they allow.

G are the derivatives by the coordinates of what constraints keep at 0, and of minus the gaps of contacts.
"""

from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from .arrays import Array

if TYPE_CHECKING:
    from .scenes import Scene

ALLOWED = 1e-8  # of the scene's length, and of the velocity: how far a start may be from what constraints allow
MOST = 50  # corrections of a projection
DEPENDENT = 1e-12  # of the largest singular value of the directions: with a smaller one, constraints are dependent


def parts(values: Array, n: int, c: int) -> tuple[Array, Array]:
    """Matrix (..., n + c, n + c) and right side (..., n + c) from what a scene's module gives."""
    m = n + c
    return values[..., : m * m].reshape(*values.shape[:-1], m, m), values[..., m * m :]


def solved(values: Array, n: int, c: int) -> Array:
    """Accelerations and multipliers (..., n + c); NaN where the equations do not determine them."""
    matrix, right = parts(values, n, c)
    try:
        return np.linalg.solve(matrix, right[..., None])[..., 0]
    except np.linalg.LinAlgError:  # in one of many rows
        found = np.full(right.shape, np.nan)
        for at in np.ndindex(right.shape[:-1]):
            if np.linalg.matrix_rank(matrix[at]) == n + c:
                found[at] = np.linalg.solve(matrix[at], right[at])
        return found


def pressures(scene: "Scene", t: Array, u: Array, v: Array, memory: Array) -> Array:
    """Pressures (..., d) of contacts at u, v (..., n), at rest in some: those under which no gap begins to close.

    NaN where none are, or friction aside several.
    """
    d = len(scene.info.contacts)
    x, rate, rest = (part[..., len(scene.info.multipliers) :] for part in scene.drift(t, u, v))
    G = scene.directions(t, u)[..., len(scene.info.multipliers) :, :]
    found = np.zeros(x.shape)
    slow = np.abs(rate) <= ALLOWED * np.linalg.norm(G, axis=-1) * np.linalg.norm(v, axis=-1, keepdims=True)
    closed = (np.abs(x) <= ALLOWED * np.linalg.norm(G, axis=-1) * np.reshape(scene.length, (-1,) + (1,) * (x.ndim - 1)
              if np.ndim(scene.length) else ())) & slow  # fmt: skip
    for at in np.ndindex(x.shape[:-1]):
        if closed[at].any():
            found[at] = _resting(scene, at, t, u, v, memory, G[at], rest[at], np.flatnonzero(closed[at]), d)
    return found


def _resting(
    scene: "Scene", at: tuple[int, ...], t: Array, u: Array, v: Array, memory: Array, G: Array, rest: Array,
    closed: Array, d: int,
) -> Array:  # fmt: skip
    """The pressures (d,) of one state, of the contacts that are closed, by trying which of them stay so."""
    one = scene.lanes(slice(at[0], at[0] + 1)) if at and u.ndim > 1 and scene.u0.ndim > 1 else scene

    def opening(p: Array) -> Array:
        """The second derivatives (d,) of the gaps under pressures."""
        given = memory[at].copy()
        given[len(given) - d :] = p
        a = one.acceleration(t[at][None], u[at][None], v[at][None], given[None])[0]
        return -(G @ a + rest)

    free = opening(np.zeros(d))
    by = np.array([opening(row) - free for row in np.eye(d)]).T
    for count in range(len(closed) + 1):
        for chosen in combinations(closed.tolist(), count):
            p, some = np.zeros(d), list(chosen)
            if some:
                p[some] = np.linalg.lstsq(by[np.ix_(some, some)], -free[some], rcond=None)[0]
            gap = free + by @ p
            if (p >= 0.0).all() and (gap[closed] >= -1e-9 * (1.0 + np.abs(free[closed]))).all():
                return p
    return np.full(d, np.nan)


def require_allowed(scene: "Scene", t: float, u: Array, v: Array) -> None:
    """Raises ValueError for constraints that repeat each other at u, v (n,), and where these are not allowed."""
    at = np.array([t]), u[None], v[None]
    (x,), (rate,), _ = scene.drift(*at)
    G, names = scene.directions(*at[:2])[0], scene.info.multipliers
    c, across = len(names), np.linalg.norm(G, axis=1)
    if c:
        _require_independent(scene.name, names, G[:c], scene.constrained(*at)[0])
    off = x / across, rate / across
    scales = float(scene.length), max(float(np.linalg.norm(v)), float(np.abs(off[1]).max()))
    for what, values, scale in zip("uv", off, scales, strict=True):
        worst = int(np.abs(values[:c]).argmax()) if c else 0
        if c and abs(values[worst]) > ALLOWED * scale:
            raise ValueError(
                f"expected a start that the constraints of {scene.name} allow, got {what} off by {values[worst]:.3g} "
                f"across '{names[worst]}'; correct it, or march from start=scene.allowed(u, v), the nearest one"
            )
    for name, beyond in zip(scene.info.contacts, off[0][c:], strict=True):
        if beyond > ALLOWED * scales[0]:
            raise ValueError(
                f"expected a start with gaps of 0 or more in {scene.name}, got {-beyond:.3g} of '{name}'; start outside"
            )


def _require_independent(scene: str, names: Sequence[str], G: Array, matrix: Array) -> None:
    """Raises ValueError where constraints repeat each other, or leave a coordinate without mass free."""
    *_, values, rows = np.linalg.svd(G.T, full_matrices=True)
    rank = int((values > DEPENDENT * values[0]).sum()) if values[0] > 0.0 else 0
    if rank < len(names):
        involved = [name for name, x in zip(names, rows[rank], strict=True) if abs(x) > 1e-6]
        raise ValueError(
            f"expected independent constraints of {scene}, got {rank} independent of {len(names)} at the start: "
            f"{', '.join(involved)} repeat each other there; leave one out, or start elsewhere"
        )
    if np.linalg.matrix_rank(matrix) < len(matrix):
        raise ValueError(
            f"expected a mass for each coordinate of {scene} that constraints leave free, got one without; give it one"
        )


def nearest(scene: "Scene", t: float, u: Array, v: Array) -> tuple[Array, Array]:
    """u, v (n,) moved onto the constraints by as little as possible, measured by the mass.

    Raises ValueError where corrections do not end.
    """
    c = len(scene.info.multipliers)
    for _ in range(MOST if c else 0):
        at = np.array([t]), u[None], v[None]
        (x,), (rate,), _ = scene.drift(*at)
        matrix = scene.constrained(*at)[0]
        right = np.zeros((len(matrix), 2))
        right[-c:] = -np.array([x[:c], rate[:c]]).T
        change = np.linalg.lstsq(matrix, right, rcond=None)[0][: len(u)]
        if np.abs(change[:, 0]).max() <= 1e-15 * float(scene.length):
            return u, v + change[:, 1]
        u = u + change[:, 0]
        if not np.isfinite(u).all():
            break
    if not c:
        return u, v
    raise ValueError(
        f"expected a start near one that the constraints of {scene.name} allow, got one from which {MOST} corrections "
        "reach none; give a nearer one"
    )
