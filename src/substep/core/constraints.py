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
    Frictions act as at the start: against what slides, and so that what is at rest stays, up to their limits. NaN where
    there are no such reactions, as of friction that presses a contact harder than sliding relieves it.
    """
    given = t, u, v, a, *(np.broadcast_to(x, len(u)) for x in (*factors, ahead))
    if not scene.info.frictions:
        return _pressed(scene, given, places)
    n, first = u.shape[-1], len(scene.info.multipliers) + len(scene.info.contacts)
    G, (_, rates, rest) = scene.directions(t, u)[:, first:], (x[:, first:] for x in scene.drift(t, u, v))
    by = np.linalg.pinv(scene.constrained(t, u, v)[:, :n, :n]) @ G.swapaxes(1, 2)
    alone, limits = np.einsum("pfn,pnf->pf", G, by), scene.limits(t, u)
    slides = np.abs(rates) > ALLOWED * np.linalg.norm(G, axis=-1) * np.linalg.norm(v, axis=-1, keepdims=True)

    def rubbed(force: Array) -> tuple[Array, Array, Array]:
        """Changes and reactions under these forces of frictions (P, f), and the forces that then follow."""
        rubs = -np.einsum("pnf,pf->pn", by, force)
        more, found = _pressed(scene, (t, u, v, a + rubs, *given[4:]), places)
        pressures = found[:, first - len(scene.info.contacts) : first]
        most = np.maximum(limits[..., 0] + np.einsum("pfd,pd->pf", limits[..., 1:], pressures), 0.0)
        along = np.einsum("pfn,pn->pf", G, a + rubs + more) + rest
        stays: Array = np.clip(force + along / alone, -most, most)
        return rubs + more, found, np.where(slides, np.sign(rates) * most, stays)

    force = np.zeros_like(rates)
    change, found, new = rubbed(force)
    off = scale = np.empty(len(u))
    for _ in range(MOST):  # Newton's, as what follows is affine by branch
        off, scale = np.abs(new - force).max(axis=1), np.abs(new).max(axis=1)
        if (off <= 1e-13 * scale).all():
            break
        slopes, ahead_by = np.empty((*force.shape, force.shape[1])), 1e-2 * np.maximum(off, scale) + (off == 0.0)
        for k, unit in enumerate(np.eye(force.shape[1])):
            slopes[..., k] = (rubbed(force + ahead_by[:, None] * unit)[2] - new) / ahead_by[:, None] - unit
        force = force - (np.linalg.pinv(slopes) @ (new - force)[..., None])[..., 0]
        change, found, new = rubbed(force)
    found[:, first:] = new
    none = off > 0.1 * scale  # far beyond rounding, also that of short steps, which is that of u over ahead^2
    change[none], found[none] = np.nan, np.nan
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
    """Raises ValueError for constraints that depend on each other at u, v (n,), and where these are not allowed."""
    off, scales, G = _off(scene, t, u, v)
    names, when = scene.info.multipliers, _when(t)
    c = len(names)
    if c:
        _require_independent(scene, t, G[:c], _scaled(scene, t, u, v), (off, scales))
    for what, values, scale in zip("uv", off, scales, strict=True):
        worst = int(np.abs(values[:c]).argmax()) if c else 0
        if c and abs(values[worst]) > ALLOWED * scale:
            raise ValueError(
                f"expected a start that the constraints of {scene.name} allow, got {what} off by {values[worst]:.3g} "
                f"across '{names[worst]}'{when}; {_corrected(scene, t, u, v)}"
            )
    for name, beyond, along in zip(scene.info.contacts, off[0][c:], G[c:], strict=False):
        if beyond > ALLOWED * scales[0]:
            moved = ", ".join(q for (q, _), x in zip(scene.coordinates, along, strict=True) if x)
            raise ValueError(
                f"expected a start with gaps of 0 or more in {scene.name}, got {-beyond:.3g} of '{name}'"
                f"{moved and f' (of {moved})'}{when}; start outside"
            )


def sizes(G: Array) -> Array:
    """The norms of gradients (..., d), 1 for those that are 0."""
    found = np.linalg.norm(G, axis=-1)
    return np.where(found > 0.0, found, 1.0)


def _off(scene: _Held, t: float, u: Array, v: Array) -> tuple[Array, tuple[float, float], Array]:
    """How far u and v are off what constraints keep, and minus gaps, (2, c); the scales of both, and directions G."""
    at = np.array([t]), u[None], v[None]
    x, rate, _ = scene.drift(*at)
    G = scene.directions(*at[:2])[0]
    off = np.concatenate([x, rate]) / sizes(G)
    return off, (float(scene.length), max(float(np.linalg.norm(v)), float(np.abs(off[1]).max()))), G


def _scaled(scene: _Held, t: float, u: Array, v: Array) -> Array:
    """The matrix (n + c, n + c) of mass and directions of constraints, with the mass relative to its largest entry."""
    found = scene.constrained(np.array([t]), u[None], v[None])[0].astype(float)
    mass = found[: len(u), : len(u)]
    mass /= np.abs(mass).max() or 1.0
    return found


def _when(t: float) -> str:
    """The time of a start in words, where it is not 0."""
    return f" at t = {t:g} s" if t else ""


def _corrected(scene: _Held, t: float, u: Array, v: Array) -> str:
    """What to do about a start that constraints do not allow: the nearest one that they do, if there is one near."""
    try:
        there = nearest(scene, t, u, v)
    except ValueError:
        return "correct it"
    numbers = (f"{kind} = [{', '.join(f'{x:.12g}' for x in values)}]" for kind, values in zip("uv", there, strict=True))
    asked = f"u, v, {t:g}" if t else "u, v"
    return f"correct it to {' and '.join(numbers)}, or march from start=scene.allowed({asked}), the nearest one"


def _require_independent(
    scene: _Held, t: float, G: Array, matrix: Array, start: tuple[Array, tuple[float, float]]
) -> None:
    """Raises ValueError where constraints repeat or contradict each other, or leave a coordinate without mass free.

    start: see `_off`.
    """
    names, (*_, values, rows) = scene.info.multipliers, np.linalg.svd(G.T, full_matrices=True)
    rank = int((values > DEPENDENT * values[0]).sum()) if values[0] > 0.0 else 0
    if rank < len(names):
        raise ValueError(
            f"expected independent constraints of {scene.name}, got {rank} independent of {len(names)} at the start"
            f"{_when(t)}: {_dependence(names, G, rows[rank:], *start)}"
        )
    if np.linalg.matrix_rank(matrix) < len(matrix):
        free = np.abs(np.linalg.svd(matrix)[2][-1, : len(scene.coordinates)])
        raise ValueError(
            f"expected a mass for each coordinate of {scene.name} that constraints leave free, got none for "
            f"'{scene.coordinates[int(free.argmax())][0]}'; give it one"
        )


def _dependence(names: Sequence[str], G: Array, rows: Array, off: Array, scales: tuple[float, float]) -> str:
    """How constraints depend on each other, and the cure, in words; rows (k, c): sums of G that are 0.

    They contradict each other where no change of u, or of v, corrects by how much they are off.
    """
    if still := [name for name, x in zip(names, G, strict=True) if not x.any()]:
        return f"{', '.join(still)} has no direction there, as its gradient is 0; start elsewhere"
    unit = G / sizes(G)[:, None]
    for what, values, scale in zip("uv", off[:, : len(names)], scales, strict=True):
        left = np.abs(values - unit @ (np.linalg.pinv(unit, rcond=DEPENDENT) @ values))
        if (most := left.max()) > ALLOWED * scale:
            involved = ", ".join(name for name, x in zip(names, left, strict=True) if x > 1e-6 * most)
            return f"{involved} contradict each other there, by {left @ left / most:.3g} in {what}; correct one of them"
    involved = ", ".join(name for name, x in zip(names, np.abs(rows).max(axis=0), strict=True) if x > 1e-6)
    return (
        f"{involved} repeat each other there; leave one out, start elsewhere, or march the scene of "
        "ss.independent(declaration), which leaves out what repeats others"
    )


def corrections(scene: _Held, t: float, u: Array, v: Array) -> Array:
    """The least changes (n, 2) of u and of v (n,), measured by the mass, that keep constraints, of u to first order."""
    c = len(scene.info.multipliers)
    (x,), (rate,), _ = scene.drift(np.array([t]), u[None], v[None])
    matrix, right = _scaled(scene, t, u, v), np.zeros((len(u) + c, 2))
    right[-c:] = -np.array([x[:c], rate[:c]]).T
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0], dtype=np.float64)[: len(u)]


def nearest(scene: _Held, t: float, u: Array, v: Array) -> tuple[Array, Array]:
    """u, v (n,) moved onto the constraints by as little as possible, measured by the mass.

    Raises ValueError where corrections do not reach u, v that keep the constraints.
    """
    names, speed = scene.info.multipliers, float(np.linalg.norm(v))
    if not names:
        return u, v
    c, change = len(names), np.zeros((len(u), 2))
    for _ in range(MOST):
        change = corrections(scene, t, u, v)
        if np.abs(change[:, 0]).max() <= 1e-15 * float(scene.length):
            break
        u = u + change[:, 0]
        if not np.isfinite(u).all():
            break
    v = v + change[:, 1]
    off, (length, fast), _ = _off(scene, t, u, v)
    kept = np.abs(off[:, :c]) <= ALLOWED * np.array([[length], [max(fast, speed)]])
    if not kept.all():
        missed = ", ".join(f"'{names[k]}'" for k in np.flatnonzero(~kept.all(axis=0)))
        raise ValueError(
            f"expected a start near one that the constraints of {scene.name} allow, got one from which corrections do "
            f"not reach {missed}{_when(t)}; give a nearer one"
        )
    return u, v
