"""Yield strengths that give a ductility: the largest of them, found on a grid of strengths and in brackets of it."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Array

RATIO = 2.0**0.1  # of neighbouring strengths of the grid
BEYOND = 2.0  # times the largest ductility is the reduction of strength to which the grid goes at first
WEAKEST = 1e6  # the reduction at which a target is given up
ROUNDS = 60  # of brackets, at most
NARROWEST = 1e-14  # the width of a bracket, in log reduction, at which a target is given up

# the ductility (L,) of L oscillators, by index, at reductions (L,) of the elastic strength
Ductility = Callable[[NDArray[np.int64], Array], Array]


class Strengths(NamedTuple):
    """For D ductilities of P oscillators: reduction (D, P) of the elastic strength, NaN where none was found.

    solutions (D, P): how often the grid of strengths crosses the ductility. lanes: oscillators marched in all.
    """

    reduction: Array
    solutions: NDArray[np.int64]
    lanes: int


class _Brackets(NamedTuple):
    """Of L targets: where each is (L,) in the flat (D, P); at both ends, from the stronger one, (2, L) each:

    log of the reduction; log of found/wanted ductility, below 0, then not; the weights of these in the next step.
    """

    target: NDArray[np.int64]
    x: Array
    off: Array
    weight: Array


def strengths_of(ductility: Ductility, targets: Array, oscillators: int, tolerance: float) -> Strengths:
    """The least reductions of strength at which P oscillators reach the ductilities `targets` (D,), each above 1.

    At a reduction of 1 the response is elastic and its ductility 1. It need not grow with the reduction: the first
    crossing on the grid is taken. Its bracket is narrowed by the Illinois rule in logarithms until the ductility at one
    of its ends is within the tolerance, relative.
    """
    x, off, lanes = _scan(ductility, targets, oscillators)
    reached = (off >= 0.0).reshape(-1, len(x))
    first, found = reached.argmax(axis=1), np.full(len(reached), np.nan)
    target = np.flatnonzero(first)
    ends = np.stack([first[target] - 1, first[target]])
    b = _Brackets(target, x[ends], off.reshape(-1, len(x))[target, ends], np.ones(ends.shape))
    close = np.log1p(tolerance)
    for _ in range(ROUNDS):
        good = np.abs(b.off) <= close
        ended = good.any(axis=0)
        found[b.target[ended]] = np.exp(np.where(good[0], b.x[0], b.x[1])[ended])
        left = ~ended & (b.x[1] - b.x[0] > NARROWEST)
        if not left.any():
            break
        b = _narrowed(ductility, targets, oscillators, _Brackets(b.target[left], *(v[:, left] for v in b[1:])))
        lanes += len(b.target)
    shape = len(targets), oscillators
    solutions = (reached[:, 1:] != reached[:, :-1]).sum(axis=1)
    return Strengths(found.reshape(shape), solutions.reshape(shape), lanes)


def _scan(ductility: Ductility, targets: Array, P: int) -> tuple[Array, Array, int]:
    """The grid: log reductions (K,), log of found/wanted ductility (D, P, K) there, and how many lanes were marched.

    It goes on for oscillators that have not reached all targets; of others it repeats the last value, a crossing less.
    """
    step = np.log(RATIO)
    more = int(np.ceil(np.log(BEYOND * targets.max()) / step))
    found, todo, lanes = np.ones((P, 1)), np.arange(P), 0
    while len(todo) and step * (found.shape[1] - 1) < np.log(WEAKEST):
        x = step * (found.shape[1] + np.arange(more))
        values = np.repeat(found[:, -1:], more, axis=1)
        values[todo] = _finite(ductility(np.repeat(todo, more), np.tile(np.exp(x), len(todo)))).reshape(-1, more)
        found, lanes = np.hstack([found, values]), lanes + len(todo) * more
        todo = todo[found[todo, -1] < targets.max()]
    return step * np.arange(found.shape[1]), np.log(found / targets[:, None, None]), lanes


def _narrowed(ductility: Ductility, targets: Array, P: int, b: _Brackets) -> _Brackets:
    """Brackets after one step; an end that stays twice counts half, as the Illinois rule has it."""
    low, high = b.off * b.weight
    part = np.where(np.isfinite(high), low / (low - np.where(np.isfinite(high), high, 1.0)), 0.5)
    x = b.x[0] + part * (b.x[1] - b.x[0])
    off = np.log(_finite(ductility(b.target % P, np.exp(x))) / targets[b.target // P])
    side = (off >= 0.0).astype(np.int64)
    every = np.arange(len(x))
    after = _Brackets(b.target, *(v.copy() for v in b[1:]))
    after.x[side, every], after.off[side, every] = x, off
    after.weight[side, every] = 1.0
    after.weight[1 - side, every] *= 0.5
    return after


def _finite(found: Array) -> Array:
    """Ductilities, infinite where a march failed."""
    return np.where(np.isfinite(found), found, np.inf)
