"""What an internal force with a memory does within a step of chosen length, where no estimate of its error looks.

Yielding bends the acceleration between the ends of a step. So the motion between them, the polynomial through u, v and
the acceleration at both ends, is put into the equation of motion in the middle. What is left over, acting for a quarter
of the step, counts as an error of v where it is too large. How far an elongation of a spring that turns back within the
step goes beyond where it is committed counts as an error of u, if its force would be another one: as kernels of scenes
have it. Of a material without elongations the displacement that goes farthest beyond stands for these.
"""

import numpy as np

from ...core.arrays import Array
from ..model.memory import Memory, Recalled, RememberingForce
from .sided_loads import Forces
from .step_lengths import Scales, rms

OTHER = 1e-9  # of a spring's force, from which on it is another one


def seen_within(
    forces: Forces, middle: float, t: float, h: float, here: Array, rows: Array, memories: tuple[Memory, Memory],
    scales: Scales, size: float,
) -> float:  # fmt: skip
    """The mean square of the errors over their scales, `size` without these; of a step of h from t.

    middle: a time on the side of which loads are taken; here, rows (2, n): u and v at its ends; memories: those there.
    """
    force, (before, after) = forces.structure.internal, memories
    assert isinstance(force, RememberingForce)
    (u_0, v_0), (u_1, v_1) = here, rows
    a_0 = forces.acceleration(t, middle, u_0, v_0, before)
    a_1 = forces.acceleration(t + h, middle, u_1, v_1, after)
    u = 0.5 * (u_0 + u_1) + h * (5 / 32 * (v_0 - v_1) + h / 64 * (a_0 + a_1))
    v = 1.875 / h * (u_1 - u_0) - 0.4375 * (v_0 + v_1) + h / 32 * (a_1 - a_0)
    a = 1.5 / h * (v_1 - v_0) - 0.25 * (a_0 + a_1)
    half = t + 0.5 * h
    kept = force.committed(half, u, v, Recalled(before, 0.5 * h))
    left = forces.acceleration(half, middle, u, v, kept) - a
    late = rms(0.25 * h * left / scales.of(1, v_0, v_1)) ** 2
    size = size if late <= 1.0 else max(size, late)
    path = np.array([u_0, u_1, h * v_0, h * v_1, h * h * a_0, h * h * a_1])
    if force.springs is not None:
        of_springs, springs = np.array([force.springs.compressed @ x for x in path]), force.springs
        turns, x, beyond = _turns(of_springs, scales.over(0, rms(u_1), np.abs(of_springs[:2]).max(axis=0)))
        e_1, rate = of_springs[1], of_springs[3] / h
        turned = springs.at(_between(x, of_springs), np.zeros_like(x), before.springs, 0.5 * h).memory
        found, again = (springs.at(e_1, rate, *given).force for given in ((after.springs, 0.0), (turned, 0.5 * h)))
        other = turns & (np.abs(again - found) > OTHER * np.abs(found))
        size = max(size, float(beyond[other].max(initial=0.0)) ** 2)
    if force.material is not None:
        turns, x, beyond = _turns(path, scales.of(0, u_0, u_1))
        place = int(np.argmax(np.where(turns, beyond, 0.0)))
        at = float(x[place])
        there = _between(x[place], path), (1.0 - at) * v_0 + at * v_1
        turned = force.committed(t + at * h, *there, Recalled(before, at * h))
        recalled = Recalled(after), Recalled(turned, (1.0 - at) * h)
        found, again = (force(t + h, u_1, v_1, one) for one in recalled)
        if turns[place] and (np.abs(again - found) > OTHER * np.abs(found).max()).any():
            size = max(size, float(beyond[place]) ** 2)
    return size


def _turns(path: Array, scale: Array) -> tuple[Array, Array, Array]:
    """Of paths (6, n) which turn back, when, in steps (n,), and how far that is beyond their ends, over their scale."""
    begin, end = path[2], path[3]
    turns = begin * end < 0.0
    x = np.where(turns, begin / np.where(turns, begin - end, 1.0), 0.5)
    return turns, x, np.abs(_between(x, path) - path[:2]).min(axis=0) / scale


def _between(x: Array, path: Array) -> Array:
    """Hermite's polynomial of the fifth degree at x of a step of length 1; path (6, n): ends, then rates, then more."""
    e_0, e_1, v_0, v_1, a_0, a_1 = path
    y, cube = 1.0 - x, x**3
    rise = cube * (10.0 - x * (15.0 - 6.0 * x))
    speeds = x * y**3 * (1.0 + 3.0 * x) * v_0 - cube * y * (1.0 + 3.0 * y) * v_1
    return e_0 + rise * (e_1 - e_0) + speeds + 0.5 * x * x * y * y * (y * a_0 + x * a_1)
