"""ROSS's newmark takes the first acceleration as zero, so a load that is not zero at the start makes it first order.

Source, ROSS 2.3.0, ross/utils.py, newmark: y0, ydot0 and y2dot0 are zeros (lines 795-797), and the loop begins with
step 1 (line 802); RHS of step 0 is never asked for. The docstring gives no initial state and does not say so.

Integrators, by their names in the report: newmark, newmark_linear.
"""

import math

import numpy as np
from ross.utils import newmark


def error(dt: float, phase: float) -> float:
    """Error of y at t = 4 of y'' + y = sin(2t + phase) from rest."""
    t = dt * np.arange(round(4 / dt) + 1)
    load = np.sin(2 * t + phase)
    one, none = np.eye(1), np.zeros((1, 1))
    y = newmark(lambda step, **state: (one, none, one, load[step : step + 1]), t, 1, tol=1e-13)
    # y = -sin(2t + phase)/3 + p cos t + q sin t
    p, q = math.sin(phase) / 3, 2 * math.cos(phase) / 3
    return abs(y[-1, 0] - (-math.sin(8 + phase) / 3 + p * math.cos(4.0) + q * math.sin(4.0)))


for phase in (0.0, math.pi / 2):
    errors = [error(dt, phase) for dt in (0.02, 0.01, 0.005)]
    print(f"load at the start {math.sin(phase):.0f}: errors", *(f"{e:.2e}" for e in errors), end="")
    print(f", order {math.log2(errors[1] / errors[2]):.2f}, expected 2")
