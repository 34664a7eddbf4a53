"""The linear complementarity problem of a few reactions: none is negative, no gap is, and of each pair one is 0."""

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


def _closing(q: Array, W: Array, closed: NDArray[np.bool_]) -> Array | None:
    """p that is 0 where gaps are open, and closes the others; None where these are dependent."""
    p, A, right = np.zeros(len(q)), W[np.ix_(closed, closed)], -q[closed]
    try:
        p[closed] = found = np.linalg.solve(A, right)
    except np.linalg.LinAlgError:
        return None
    left = np.abs(A @ found - right)
    return p if (left <= 1e-9 * (np.abs(A).max(initial=0.0) * np.abs(found).sum() + np.abs(right))).all() else None
