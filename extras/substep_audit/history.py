"""States of the exact motion before t = 0, for programs that have to be given them."""

import math

import numpy as np

from substep.core.arrays import Array

from .programs.adapter import Load

RESOLVED = 10.0  # omega h beyond which there is no motion before t = 0 to resolve, and a damped one overflows


def states_before(omega: float, xi: float, h: float, rows: int, u0: float, v0: float, load: Load) -> Array:
    """u, v, a (rows, 3) of the exact motion at t = -h, -2 h, ...; copies of the start above omega h = 10."""
    from scipy.linalg import expm  # noqa: PLC0415 (slow to import)

    p = load.omega
    constant = load.offset + (load.amplitude if load.kind == "constant" else 0.0)
    slope = load.slope + (load.amplitude if load.kind == "ramp" else 0.0)
    sine = load.amplitude if load.kind == "harmonic" else 0.0
    rates = np.zeros((6, 6))  # of u, v, 1, t, sin(p t + phase), cos(p t + phase)
    rates[0, 1] = rates[3, 2] = 1.0
    rates[1] = -(omega**2), -2 * xi * omega, constant, slope, sine, 0.0
    rates[4, 5], rates[5, 4] = p, -p
    state = np.array([u0, v0, 1.0, 0.0, math.sin(load.phase), math.cos(load.phase)])
    step = np.eye(6) if omega * h > RESOLVED else expm(-h * rates)
    states = [np.linalg.matrix_power(step, k) @ state for k in range(1, rows + 1)]
    return np.array([[x[0], x[1], rates[1] @ x] for x in states])
