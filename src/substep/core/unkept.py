"""Constraints that a run cannot keep: which of them contradict each other, and where they repeat each other."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, cast

import numpy as np

from .arrays import Array
from .constraints import ALLOWED
from .fighting import listed
from .rows import Rows

NEARLY = 1e-4  # of the least singular value at the start: where directions have less, constraints repeat each other
SHOWS = 1e-2  # of the largest part in what repeats, or is left: a constraint with less has none
PLACES = 17  # in a step, at which it is looked at for the least singular value
HALVINGS = 40
ROWS = 64  # of a completed run that are looked at


class _Reached(NamedTuple):
    """The displacement u (n,) nearest to one at a time t, s, what constraints leave there (c,), and how they stand.

    least: the least singular value of their directions, of that at the start; shares (c,): of what is then 0.
    """

    t: float
    u: Array
    left: Array
    least: float
    shares: Array


class _Directions:
    """The gradients of the constraints of a run, each over its size at the start."""

    def __init__(self, r: Rows) -> None:
        self.scene, self.names = r.scene, r.scene.info.multipliers
        self.sizes, self.first = np.ones(len(self.names)), 1.0
        t, u = r.t[:1], np.asarray(r.u)[:1]
        self.sizes = np.linalg.norm(self.at(t, u)[0], axis=1)
        self.first = float(self.least(t, u)[0])

    def at(self, t: Array, u: Array) -> Array:
        """They at times t (k,) and u (k, n), (k, c, n)."""
        return self.scene.directions(t, u)[:, : len(self.names)] / self.sizes[:, None]

    def least(self, t: Array, u: Array) -> Array:
        """Their least singular values (k,), of that at the start."""
        return _least(self.at(t, u)) / self.first

    def reached(self, t: float, u: Array) -> _Reached:
        """From u (n,) at the time t to the nearest displacement at which no other leaves less of the constraints."""
        from scipy.optimize import least_squares  # noqa: PLC0415  # pyright: ignore

        at = np.array([t])

        def left(x: Array) -> Array:
            return self.scene.drift(at, x[None], np.zeros((1, len(x))))[0][0, : len(self.names)] / self.sizes

        def slopes(x: Array) -> Array:
            return self.at(at, x[None])[0]

        solve, end = cast("Callable[..., Any]", least_squares), dict.fromkeys(("xtol", "ftol", "gtol"), 1e-15)
        found: Array = solve(left, u, slopes, method="dogbox", max_nfev=200, **end).x
        shares, values, _ = np.linalg.svd(slopes(found))
        return _Reached(t, found, left(found), float(values[-1]) / self.first, shares[:, -1])


def _least(directions: Array) -> Array:
    """The least singular values (k,) of directions (k, c, n)."""
    if directions.shape[1] == 1:
        return np.linalg.norm(directions[:, 0], axis=-1)
    return np.asarray(np.linalg.svd(directions, compute_uv=False)[:, -1], dtype=np.float64)


def unkept(r: Rows, end: float) -> str:
    """Why no motion of a run from its last row to the time `end`, s, keeps its constraints, and the cure; else nothing.

    From where the motion leads straight ahead, and from the last row, what constraints leave is made least: where that
    is not 0, those that are left contradict each other. Else the place is looked for at which they repeat each other.
    """
    if not r.scene.info.multipliers or not np.isfinite(r.u[-1]).all():
        return ""
    of, last, u, v = _Directions(r), float(r.t[-1]), np.asarray(r.u)[-1], np.asarray(r.v)[-1]

    def contradicts(x: _Reached) -> bool:
        return float(np.abs(x.left).max()) > ALLOWED * float(r.scene.length)

    def ahead(t: float) -> _Reached:
        found = of.reached(t, u + (t - last) * v)
        return of.reached(t, u) if contradicts(found) else found

    places = [ahead(t) for t in np.linspace(last, end, PLACES).tolist()]
    if contradicts(places[-1]):
        kept, none = last, places[-1]
        for _ in range(HALVINGS):
            between = ahead(0.5 * (kept + none.t))
            kept, none = (kept, between) if contradicts(between) else (between.t, none)
        which = _shown(of.names, places[-1].left)
        are = "is not kept" if len(which) == 1 else f"are not {'both' if len(which) == 2 else 'all'} kept"
        return (
            f"{listed(which)} {are} after t = {none.t:.6g} s by any displacement near the last row; declare "
            "constraints that can be kept together, or end the run before"
        )
    k = int(np.argmin([x.least for x in places]))
    low, high = places[max(k - 1, 0)].t, places[min(k + 1, PLACES - 1)].t
    found = places[k]
    for _ in range(HALVINGS):
        near = [found, *(ahead(low + part * (high - low)) for part in (0.25, 0.75))]
        found = near[int(np.argmin([x.least for x in near]))]
        middle, half = found.t, 0.25 * (high - low)
        low, high = max(low, middle - half), min(high, middle + half)
    return _repeated(of.names, found.shares, f"at t = {found.t:.6g} s") if found.least < NEARLY else ""


def staying(r: Rows) -> str:
    """That a completed run stays where its constraints repeat each other, with the time and the cure; else nothing.

    Of at most 64 of its rows, evenly apart, two in a row are then such: a motion that passes over the place leaves one
    at most. What u and v are from there on is nothing that the equations of motion say.
    """
    names = r.scene.info.multipliers
    if not names or len(r.u) < 2:
        return ""
    rows = np.linspace(0, len(r.u) - 1, min(ROWS, len(r.u))).astype(int)
    t, u = r.t[rows], np.asarray(r.u)[rows]
    directions = r.scene.directions(t, u)[:, : len(names)]
    directions = directions / np.linalg.norm(directions[0], axis=1)[:, None]
    least = _least(directions)
    lost = least < NEARLY * least[0]
    if not (both := lost[1:] & lost[:-1]).any():
        return ""
    k = int(np.argmax(both))
    return f"{r.scene.name}: {_repeated(names, np.linalg.svd(directions[k])[0][:, -1], f'from t = {t[k]:.6g} s on')}"


def _repeated(names: Sequence[str], shares: Array, when: str) -> str:
    """That the constraints with these shares repeat each other then, and the cure."""
    which = _shown(names, shares)
    what = "repeat each other" if len(which) > 1 else "holds no direction"
    return (
        f"{listed(which)} {what} {when}, so that the motion is not determined there; leave one out, end the run "
        "before, or where it can go on beyond, take steps that pass over the position"
    )


def _shown(names: Sequence[str], parts: Array) -> list[str]:
    least = SHOWS * float(np.abs(parts).max())
    return [f"constraint '{name}'" for name, part in zip(names, parts, strict=True) if abs(part) > least]
