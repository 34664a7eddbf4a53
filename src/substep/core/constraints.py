"""Constraints and contacts of a scene: accelerations, multipliers and pressures, and the starts that they allow.

G are the derivatives by the coordinates of what constraints keep at 0, and of minus the gaps of contacts.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .arrays import Array
from .entries import SceneInfo

ALLOWED = 1e-8  # of the scene's length, and of the velocity: how far a start may be from what constraints allow
MOST = 50  # corrections of a projection
DEPENDENT = 1e-12  # of the largest singular value of the directions: with a smaller one, constraints are dependent


class _Held(Protocol):
    """A scene, as far as it is asked about its constraints and contacts: see `substep.core.scenes.Scene`."""

    @property
    def info(self) -> SceneInfo: ...
    @property
    def u0(self) -> Array: ...
    @property
    def name(self) -> str: ...
    @property
    def coordinates(self) -> tuple[tuple[str, str], ...]: ...
    @property
    def length(self) -> Any: ...
    def lanes(self, where: slice) -> "_Held": ...
    def acceleration(self, t: Array, u: Array, v: Array, memory: Array | None = None) -> Array: ...
    def drift(self, t: Array, u: Array, v: Array) -> tuple[Array, Array, Array]: ...
    def directions(self, t: Array, u: Array) -> Array: ...
    def constrained(self, t: Array, u: Array, v: Array) -> Array: ...
    def limits(self, t: Array, u: Array) -> Array: ...


def parts(values: Array, n: int, c: int) -> tuple[Array, Array]:
    """Matrix (..., n + c, n + c) and right side (..., n + c) from what a scene's module gives."""
    m = n + c
    return values[..., : m * m].reshape(*values.shape[:-1], m, m), values[..., m * m :]


def solved(values: Array, n: int, c: int) -> Array:
    """Accelerations and multipliers (..., n + c); NaN where the equations do not determine them."""
    matrix, right = parts(values, n, c)
    try:
        return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0], dtype=np.float64)
    except np.linalg.LinAlgError:  # in one of many rows
        found = np.full(right.shape, np.nan)
        for at in np.ndindex(right.shape[:-1]):
            if np.linalg.matrix_rank(matrix[at]) == n + c:
                found[at] = np.linalg.solve(matrix[at], right[at])
        return found


def pressures(scene: _Held, t: Array, u: Array, v: Array, memory: Array) -> Array:
    """Pressures (..., d) of contacts at u, v (..., n): of those that are closed and at rest, else 0.

    They are those under which no gap begins to close, none negative; NaN where there are none such.
    """
    closed = _closed(scene, t, u, v)
    found = np.zeros(closed.shape)
    for at in np.ndindex(closed.shape[:-1]):
        if closed[at].any():
            one = scene.lanes(slice(at[0], at[0] + 1)) if scene.u0.ndim > 1 else scene
            found[at] = _at_rest(one, (t[at][None], u[at][None], v[at][None]), memory[at], np.flatnonzero(closed[at]))
    return found


def _closed(scene: _Held, t: Array, u: Array, v: Array) -> NDArray[np.bool_]:
    """Which contacts (..., d) are closed and at rest at u, v (..., n)."""
    c, d = len(scene.info.multipliers), len(scene.info.contacts)
    x, rate = (part[..., c : c + d] for part in scene.drift(t, u, v)[:2])
    across = np.linalg.norm(scene.directions(t, u)[..., c : c + d, :], axis=-1)
    lengths = np.reshape(scene.length, (*np.shape(scene.length), *(1,) * (x.ndim - np.ndim(scene.length))))
    speeds = np.linalg.norm(v, axis=-1, keepdims=True)
    return np.asarray((np.abs(x) <= ALLOWED * across * lengths) & (np.abs(rate) <= ALLOWED * across * speeds))


def _subsets(places: NDArray[np.intp]) -> Iterator[list[int]]:
    """All subsets, the smallest first."""
    return (list(some) for count in range(len(places) + 1) for some in combinations(places.tolist(), count))


def _at_rest(scene: _Held, state: tuple[Array, Array, Array], memory: Array, closed: NDArray[np.intp]) -> Array:
    """The pressures (d,) in one state t (1,), u, v (1, n), by trying which of the closed contacts stay so."""
    d = len(scene.info.contacts)
    G, rest = scene.directions(*state[:2])[0, -d:], scene.drift(*state)[2][0, -d:]

    def opening(p: Array) -> Array:
        """The second derivatives (d,) of the gaps under pressures."""
        given = np.append(memory[:-d], p)
        return -(G @ scene.acceleration(*state, given[None])[0] + rest)

    free = opening(np.zeros(d))
    by = np.array([opening(row) - free for row in np.eye(d)]).T
    for some in _subsets(closed):
        p = np.zeros(d)
        if some:
            p[some] = np.linalg.lstsq(by[np.ix_(some, some)], -free[some], rcond=None)[0]
        gaps = (free + by @ p)[closed]
        if (p >= 0.0).all() and (gaps >= -1e-9 * (1.0 + np.abs(free[closed]))).all():
            return p
    return np.full(d, np.nan)


def held_first(
    scene: _Held, t: Array, u: Array, v: Array, a: Array, factors: Sequence[Any], ahead: Array, places: list[int]
) -> tuple[Array, Array]:
    """Changes of acceleration (P, n) and reactions (P, c) that hold a displacement of the first step.

    It is factors * (u, v, a), numbers or (P,), of u, v, a (P, n) at the start t (P,), and is `ahead` s (P,) later; the
    constraints at these places are 0 there, and contacts that are closed and at rest do not close further. Of central
    differences that is SHAKE's first step (Ryckaert, Ciccotti & Berendsen, J. Comput. Phys. 23 (1977) 327-341).
    Frictions act as at the start: against what slides, and so that what is at rest stays, up to their limits.
    """
    given = t, u, v, a, *(np.broadcast_to(x, len(u)) for x in (*factors, ahead))
    change, found = _pressed(scene, given, places)
    if not scene.info.frictions:
        return change, found
    n, first = u.shape[-1], len(scene.info.multipliers) + len(scene.info.contacts)
    G, (_, rates, rest) = scene.directions(t, u)[:, first:], (x[:, first:] for x in scene.drift(t, u, v))
    by = np.linalg.pinv(scene.constrained(t, u, v)[:, :n, :n]) @ G.swapaxes(1, 2)
    alone, limits = np.einsum("pfn,pnf->pf", G, by), scene.limits(t, u)
    slides = np.abs(rates) > ALLOWED * np.linalg.norm(G, axis=-1) * np.linalg.norm(v, axis=-1, keepdims=True)
    force = np.zeros_like(rates)
    for _ in range(MOST):
        pressures = found[:, first - len(scene.info.contacts) : first]
        most = np.maximum(limits[..., 0] + np.einsum("pfd,pd->pf", limits[..., 1:], pressures), 0.0)
        along = np.einsum("pfn,pn->pf", G, a + change) + rest
        stays: Array = np.clip(force + along / alone, -most, most)
        new: Array = np.where(slides, np.sign(rates) * most, stays)
        rubbed = -np.einsum("pnf,pf->pn", by, new)
        more, found = _pressed(scene, (t, u, v, a + rubbed, *given[4:]), places)
        change, found[:, first:], done = rubbed + more, new, np.abs(new - force).max(initial=0.0)
        force = new
        if done <= 1e-13 * np.abs(new).max(initial=0.0):
            break
    return change, found


def _pressed(scene: _Held, given: tuple[Array, ...], places: Sequence[int]) -> tuple[Array, Array]:
    """Changes of acceleration (P, n) and reactions (P, c) of constraints at these places and of contacts, as above."""
    t, u, v, *_ = given
    c, closed = len(scene.info.multipliers), _closed(scene, t, u, v)
    change, found, _ = _held(scene, given, places)
    for k in np.flatnonzero(closed.any(axis=1)):
        at = slice(k, k + 1)
        one = scene.lanes(at) if scene.u0.ndim > 1 else scene
        for some in _subsets(c + np.flatnonzero(closed[k])):
            change[at], found[at], off = _held(one, tuple(x[at] for x in given), [*places, *some])
            others = np.setdiff1d(c + np.flatnonzero(closed[k]), some)
            if (found[k, some] >= 0.0).all() and (off[0, others] <= 0.0).all():
                break
    return change, found


def _held(scene: _Held, given: tuple[Array, ...], places: Sequence[int]) -> tuple[Array, Array, Array]:
    """Changes of acceleration (P, n) and reactions (P, c) that make these constraints and gaps 0; all of them (P, c).

    given: t, u, v, a, the factors, and how much later the displacement is, of P lanes each.
    """
    t, u, v, a, *numbers, ahead = given
    n, matrix, along = u.shape[-1], scene.constrained(t, u, v), scene.directions(t, u)[:, places]
    by = np.linalg.pinv(matrix[:, :n, :n]) @ along.swapaxes(1, 2)
    of_u, of_v, of_a = (x[:, None] for x in numbers)
    change, found = np.zeros_like(a), np.zeros((len(u), len(scene.info.reactions)))
    every = np.zeros_like(found)
    for _ in range(MOST):
        there = of_u * u + of_v * v + of_a * (a + change)
        every = scene.drift(t + ahead, there, v)[0]
        off = every[:, places]
        slopes = of_a[..., None] * scene.directions(t + ahead, there)[:, places] @ by
        more = np.linalg.pinv(slopes) @ off[..., None]
        pushed = (by @ more)[..., 0]
        change, found[:, places] = change - pushed, found[:, places] + more[..., 0]
        if np.abs(of_a * pushed).max(initial=0.0) <= 1e-15 * np.max(scene.length):
            break
    return change, found, every


def require_allowed(scene: _Held, t: float, u: Array, v: Array) -> None:
    """Raises ValueError for constraints that repeat each other at u, v (n,), and where these are not allowed."""
    at = np.array([t]), u[None], v[None]
    (x,), (rate,), _ = scene.drift(*at)
    G, names = scene.directions(*at[:2])[0], scene.info.multipliers
    c, across = len(names), np.linalg.norm(G, axis=1)
    if c:
        _require_independent(scene, names, G[:c], scene.constrained(*at)[0])
    off = x / across, rate / across
    scales = float(scene.length), max(float(np.linalg.norm(v)), float(np.abs(off[1]).max()))
    for what, values, scale in zip("uv", off, scales, strict=True):
        worst = int(np.abs(values[:c]).argmax()) if c else 0
        if c and abs(values[worst]) > ALLOWED * scale:
            raise ValueError(
                f"expected a start that the constraints of {scene.name} allow, got {what} off by {values[worst]:.3g} "
                f"across '{names[worst]}'; correct it{_nearest(scene, t, u, v)}, or march from "
                "start=scene.allowed(u, v), the nearest one"
            )
    for name, beyond in zip(scene.info.contacts, off[0][c:], strict=False):
        if beyond > ALLOWED * scales[0]:
            raise ValueError(
                f"expected a start with gaps of 0 or more in {scene.name}, got {-beyond:.3g} of '{name}'; start outside"
            )


def _nearest(scene: _Held, t: float, u: Array, v: Array) -> str:
    """The nearest start that is allowed, in words; nothing where there is none near."""
    try:
        there = nearest(scene, t, u, v)
    except ValueError:
        return ""
    numbers = (f"{kind} = [{', '.join(f'{x:.12g}' for x in values)}]" for kind, values in zip("uv", there, strict=True))
    return f" to {' and '.join(numbers)}"


def _require_independent(scene: _Held, names: Sequence[str], G: Array, matrix: Array) -> None:
    """Raises ValueError where constraints repeat each other, or leave a coordinate without mass free."""
    *_, values, rows = np.linalg.svd(G.T, full_matrices=True)
    rank = int((values > DEPENDENT * values[0]).sum()) if values[0] > 0.0 else 0
    if rank < len(names):
        involved = [name for name, x in zip(names, rows[rank], strict=True) if abs(x) > 1e-6]
        raise ValueError(
            f"expected independent constraints of {scene.name}, got {rank} independent of {len(names)} at the start: "
            f"{', '.join(involved)} repeat each other there; leave one out, start elsewhere, or march the scene of "
            "ss.independent(declaration), which leaves out what repeats others"
        )
    if np.linalg.matrix_rank(matrix) < len(matrix):
        free = np.abs(np.linalg.svd(matrix)[2][-1, : len(scene.coordinates)])
        raise ValueError(
            f"expected a mass for each coordinate of {scene.name} that constraints leave free, got none for "
            f"'{scene.coordinates[int(free.argmax())][0]}'; give it one"
        )


def nearest(scene: _Held, t: float, u: Array, v: Array) -> tuple[Array, Array]:
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
        change: Array = np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0], dtype=np.float64)[: len(u)]
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
