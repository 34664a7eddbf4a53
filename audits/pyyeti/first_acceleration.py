"""pyYeti's SolveNewmark starts as if its first acceleration were zero, which makes other motion of first order.

Manual: the docstring of pyyeti.ode.SolveNewmark says how it starts, u(-1) = u(0) - h v(0), and F(-1) and F(0) replaced
by K u + B v, after the Nastran Theoretical Manual, so that massless degrees of freedom do not ring under a step load;
it says that accelerations "should be approximately correct by the third time step", not what it costs in order.
Source, pyYeti 1.4.7, pyyeti/ode/solvenewmark.py:689 (u(-1)), :704 (F(0), the load that is given there is dropped) and
:709 (F(-1)). Motion whose acceleration is zero at t = 0, such as that from rest under a load that starts at zero, is
of second order.

Integrators, by their names in the report: SolveNewmark.
"""

import math

import numpy as np
from pyyeti import ode

XI, T = 0.1, 4.0
RATE = math.sqrt(1 - XI**2)


def error(dt: float, u0: float, v0: float, step: float) -> float:
    """Error of u at T of u'' + 2 XI u' + u = step from u0 and v0."""
    load = np.full((1, round(T / dt) + 1), step)
    one = np.ones(1)
    solution = ode.SolveNewmark(one, 2 * XI * one, one, dt).tsolve(load, d0=u0 * one, v0=v0 * one)
    free = (u0 - step) * math.cos(RATE * T) + (v0 + XI * (u0 - step)) / RATE * math.sin(RATE * T)
    return abs(solution.d[0, -1] - step - math.exp(-XI * T) * free)


for name, u0, v0, step in (
    ("from u = 1, v = 0, no load, u'' = -1", 1.0, 0.0, 0.0),
    ("from u = 0, v = 1, no load, u'' = -2 XI", 0.0, 1.0, 0.0),
    ("from rest, load 1, u'' = 1", 0.0, 0.0, 1.0),
    ("from u = -2 XI, v = 1, no load, u'' = 0", -2 * XI, 1.0, 0.0),
):
    errors = [error(dt, u0, v0, step) for dt in (0.02, 0.01, 0.005)]
    print(f"{name:40s}", *(f"{e:.2e}" for e in errors), f" order {math.log2(errors[1] / errors[2]):.2f}, expected 2")
