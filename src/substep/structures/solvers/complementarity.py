"""The linear complementarity problem of a few reactions: none is negative, no gap is, and of each pair one is 0.

With friction, reactions between bounds that others give are among them.
"""

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array

ROUNDING = 64 * np.finfo(np.float64).eps  # of the parts of a number, within which it counts as 0
SPARE = 3  # changes of all at fault that may make no progress before they are made one at a time


class NotFound(ArithmeticError):
    """A solution that was not found."""


def complementary(q: Array, W: Array, before: Array) -> Array:
    """p (d,) >= 0 with w = q + W p >= 0 and p w = 0, for W (d, d) symmetric and positive semidefinite.

    before (d,): a guess, of which the signs count. Places at fault change sides all at once, which takes a few rounds;
    where that makes no progress, the last of them alone, which ends (Judice & Pires, Computers Math. Applic. 22 (1991),
    and Murty's rule of least index), and the worst where all of them are dependent. q may be infinite where p is 0.
    Raises NotFound.
    """
    d = len(q)
    if np.isnan(q).any():
        return np.full(d, np.nan)
    closed, wrong, faults = before > 0.0, np.zeros(d, np.bool_), np.zeros(d)
    fewest, spare = d + 1, SPARE
    for _ in range(100 + 2 ** min(d, 16)):
        if (p := _closing(q, W, closed)) is None:
            worst = (np.arange(d) == int(np.argmax(np.where(wrong, faults, -1.0)))) & wrong
            closed = closed ^ wrong ^ worst if wrong.sum() > 1 else np.zeros(d, np.bool_)
            wrong = worst
            continue
        w = q + W @ p
        near = ROUNDING * (np.abs(q) + np.abs(W) @ np.abs(p))
        wrong = np.where(closed, p < -ROUNDING * np.abs(p).max(), w < -near)
        faults = np.where(closed, -p, -w)
        count = int(wrong.sum())
        if count == 0:
            return np.maximum(p, 0.0)
        if count < fewest:
            fewest, spare = count, SPARE
        elif spare:
            spare -= 1
        else:
            wrong[: np.flatnonzero(wrong)[-1]] = False
        closed = closed ^ wrong
    raise NotFound


def with_friction(q: Array, W: Array, before: Array, least: Array, shares: Array) -> Array:
    """p (d,) of reactions as in `complementary`, and of f frictions behind them, with w = q + W p.

    A friction is from -L to L, L = least + shares times the other reactions, least (f,) and shares (f, d - f), and at
    the bound against w unless w = 0. before (d,): a guess. Which are closed, stick or slide is iterated as by Alart and
    Curnier (Comput. Methods Appl. Mech. Engrg. 92 (1991) 353), and where that goes round in a circle begun anew from
    sweeps of projections (Jean, ibid. 177 (1999) 235). Raises NotFound.
    """
    if np.isnan(q).any():
        return np.full(len(q), np.nan)
    m, p = np.diag(W) + (np.diag(W) == 0.0), before
    finite = np.where(np.isfinite(q), np.abs(q), 0.0)
    for sweeps in (0, 20, 200, 2000):
        for i in [*range(len(p))] * sweeps:
            y = p.copy()
            y[i] -= (q[i] + W[i] @ p) / m[i]
            p = _projected(y, p, least, shares)
        at, seen = _sides(p - (q + W @ p) / m, p, least, shares), set[bytes]()
        while at.tobytes() not in seen:
            seen.add(at.tobytes())
            p = _on(at, q, W, least, shares)
            w, near = q + W @ p, ROUNDING * (finite + np.abs(W) @ np.abs(p))
            after = _sides(p - w / m, p, least, shares, near / m)
            if (after == at).all() and (np.abs(w) <= 1e5 * near)[at == 0].all():
                return _projected(p, p, least, shares)
            at = after
    raise NotFound


def _projected(y: Array, p: Array, least: Array, shares: Array) -> Array:
    """The nearest to y (d,) between the bounds that p gives."""
    g = len(y) - len(least)
    most = least + shares @ np.maximum(p[:g], 0.0)
    return np.concatenate([np.maximum(y[:g], 0.0), np.clip(y[g:], -most, most)])


def _sides(y: Array, p: Array, least: Array, shares: Array, near: Array | float = 0.0) -> NDArray[np.int64]:
    """Of each reaction p (d,) -1 or 1 where y = p - w/m is beyond that bound, by more than near, and 0 elsewhere."""
    off = y - _projected(y, p, least, shares)
    return np.where(np.abs(off) > near, np.sign(off), 0.0).astype(np.int64)


def _on(at: NDArray[np.int64], q: Array, W: Array, least: Array, shares: Array) -> Array:
    """p (d,) at the bounds that `at` says, and with w = 0 where that is 0."""
    g, holds = len(q) - len(least), at == 0
    A, right = np.where(holds[:, None], W, np.eye(len(q))), np.where(holds, -q, 0.0)
    slides = np.flatnonzero(at[g:])
    A[g + slides, :g] = -at[g + slides, None] * shares[slides]
    right[g + slides] = at[g + slides] * least[slides]
    try:
        return np.linalg.solve(A, right)
    except np.linalg.LinAlgError:
        return np.linalg.lstsq(A, right, rcond=None)[0]


def _closing(q: Array, W: Array, closed: NDArray[np.bool_]) -> Array | None:
    """p that is 0 where gaps are open, and closes the others; None where these are dependent."""
    p, A, right = np.zeros(len(q)), W[np.ix_(closed, closed)], -q[closed]
    try:
        p[closed] = found = np.linalg.solve(A, right)
    except np.linalg.LinAlgError:
        return None
    left = np.abs(A @ found - right)
    return p if (left <= 1e-9 * (np.abs(A).max(initial=0.0) * np.abs(found).sum() + np.abs(right))).all() else None
