"""Exact motions, with which runs in chosen steps are compared."""

import numpy as np
from scipy.integrate import solve_ivp

import substep as ss
from substep.marching import adaptive


def exact(scene: ss.Scene, t: np.ndarray) -> np.ndarray:
    """u and v (n, 2, d) by SciPy's DOP853, between the break points of a load one after the other; t[0] = 0."""
    d = len(scene.u0)
    breaks = adaptive.break_points(scene.load, float(t[-1]))
    ends, y = [*breaks, t[-1]], np.concatenate([scene.u0, scene.v0])
    begin, found = 0.0, [y]
    for end in ends:
        inside = t[(t > begin) & (t <= end)]
        eps = 1e-12 * (end - begin)  # a load that jumps is taken from within

        def rates(x: float, y: np.ndarray, low: float = begin + eps, high: float = end - eps) -> np.ndarray:
            a = scene.acceleration(np.asarray(min(max(x, low), high)), y[:d], y[d:])
            return np.concatenate([y[d:], np.reshape(a, -1)])

        r = solve_ivp(rates, (begin, end), y, "DOP853", np.unique([*inside, end]), rtol=1e-12, atol=1e-13)
        found += [*r.y.T[: len(inside)]]
        begin, y = end, r.y[:, -1]
    return np.array(found).reshape(-1, 2, d)
