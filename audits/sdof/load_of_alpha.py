"""sdof.integrate with alpha_f below 1 takes the load at the end of the step, so its forced motion is of first order.

Manual: the docstring of sdof.integrate, "Integration is carried out using a Generalized - alpha scheme", whose balance
stands at t + alpha_f dt for all forces, the load among them.
Source, sdof 0.0.12, src/_integrate.c:120-127: displacement and velocity are weighted with alpha_f, the load scale*p[i]
is that at the end. With alpha_f = 1, the default, nothing is amiss.

Integrators, by their names in the report: integrate_hht, integrate_alpha.
"""

import math

import numpy as np
from sdof import integrate

RHO = 0.6
WEIGHTS = {"alpha_m": (2 - RHO) / (1 + RHO), "alpha_f": 1 / (1 + RHO)}
WEIGHTS |= {"gamma": 0.5 + WEIGHTS["alpha_m"] - WEIGHTS["alpha_f"], "beta": 1 / (1 + RHO) ** 2}


def error(dt: float, weighted: bool) -> float:
    """Error of u at t = 4 of u'' + u = sin 2t from u(0) = 0 and the velocity -2/3, whose motion is -sin(2t)/3."""
    t = dt * np.arange(round(4 / dt) + 1)
    load = np.sin(2 * t)
    if weighted:  # hand the program the load that the scheme asks for
        load[1:] = WEIGHTS["alpha_f"] * load[1:] + (1 - WEIGHTS["alpha_f"]) * load[:-1]
    u = integrate(load, dt, k=1.0, c=0.0, m=1.0, u0=0.0, v0=-2 / 3, **WEIGHTS)[0]
    return abs(u[-1] + math.sin(8.0) / 3)


for weighted in (False, True):
    errors = [error(dt, weighted) for dt in (0.02, 0.01, 0.005)]
    print(f"{'weighted by hand' if weighted else 'as it is':16s}", *(f"{e:.2e}" for e in errors), end="")
    print(f"  order {math.log2(errors[1] / errors[2]):.2f}, expected 2")
