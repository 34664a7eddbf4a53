"""The one root of a polynomial in an interval, which is what an implicit default of a parameter is."""

import math
from collections.abc import Callable, Sequence
from functools import reduce
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from .arrays import Array

EPS = float(np.finfo(float).eps)


def only_root(
    what: str,
    coefficients: Sequence[ArrayLike],
    low: float | None,
    high: float | None,
    low_open: bool,
    high_open: bool,
) -> Array:
    """The root in the interval (None: no bound), of the shape to which the coefficients, from the lowest, broadcast.

    Between two neighbouring roots of its derivative a polynomial is monotone: it has one root there if its sign
    changes, which is found by bisection. A root of the derivative where the polynomial is 0 within rounding is one too.
    Raises ValueError, which says how many roots lie in the interval, unless there is exactly one.
    """
    arrays = np.broadcast_arrays(*(np.asarray(c, dtype=np.float64) for c in coefficients))
    found = np.empty(arrays[0].shape)
    for index in np.ndindex(found.shape):
        own = [float(a[index]) for a in arrays]
        roots = [x for x in real_roots(own, low, high) if not (low_open and x == low) and not (high_open and x == high)]
        if len(roots) != 1:
            interval = f"{'(' if low_open else '['}{low}, {high}{')' if high_open else ']'}"
            raise ValueError(
                f"{what} has no default here: expected one root of the polynomial with coefficients {own} in "
                f"{interval}, got {len(roots)}; give {what}"
            )
        found[index] = roots[0]
    return found


def real_roots(coefficients: Sequence[float], low: float | None, high: float | None) -> list[float]:
    """All distinct real roots in [low, high], ascending; none of a polynomial that is 0 everywhere."""
    c = list(coefficients)
    while c and c[-1] == 0.0:
        c.pop()
    if len(c) < 2:
        return []
    bound = 1.0 + max(abs(x / c[-1]) for x in c[:-1])  # Cauchy's
    low, high = -bound if low is None else low, bound if high is None else high
    derivative = [k * x for k, x in enumerate(c)][1:]
    ends = [low, *(x for x in real_roots(derivative, low, high) if low < x < high), high]

    def value(x: float) -> float:
        return reduce(lambda total, coefficient: total * x + coefficient, reversed(c))

    def sign(x: float) -> int:
        """The sign of the value; 0 for one that may be only rounding."""
        size = sum(abs(coefficient) * abs(x) ** k for k, coefficient in enumerate(c))
        return 0 if abs(value(x)) <= 4.0 * len(c) * EPS * size else 1 if value(x) > 0.0 else -1

    found = [x for x in ends if sign(x) == 0]
    found += [_bisected(value, a, b) for a, b in pairwise(ends) if sign(a) * sign(b) < 0]
    return sorted(set(found))


def _bisected(value: Callable[[float], float], low: float, high: float) -> float:
    """The root where the value changes its sign: the interval is halved until no double lies inside it."""
    rising = value(high) > 0.0
    while True:
        middle = low + 0.5 * (high - low)
        at = value(middle)
        if at == 0.0 or middle in (low, high) or not math.isfinite(middle):
            return middle
        if (at > 0.0) == rising:
            high = middle
        else:
            low = middle
