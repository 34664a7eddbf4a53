"""With a yield force, sdof.integrate leaves the spring out of the first acceleration: motion from u0 is of first order.

Manual: the docstring of sdof.integrate: "u0 (float, optional): Initial displacement". The argument fy, which selects
the elastic-plastic function, is in its signature only.
Source, sdof 0.0.12, src/_integrate.c:175 begins with the restoring force pa = 0.0, "TODO: Find pa for initial u0", and
:197 takes the first acceleration from it; the elastic function takes K u0 (:317). Nothing is amiss where u0 = 0.
The first load is used nowhere else, so a user cures it by taking k u0 from that one.

Integrators, by their names in the report: integrate_yielding_never.
"""

import math

import numpy as np
from sdof import integrate

T = 4.0


def error(dt: float, options: dict, first: float = 0.0) -> float:
    """Error of u at T of u'' + u = 0 from u = 1, v = 0, with a first load; a yield force of 1e300 is never reached."""
    load = np.zeros(round(T / dt) + 1)
    load[0] = first
    return abs(integrate(load, dt, k=1.0, c=0.0, m=1.0, u0=1.0, v0=0.0, **options)[0, -1] - math.cos(T))


for name, options, first in (
    ("integrate(...)", {}, 0.0),
    ("integrate(..., fy=1e300)", {"fy": 1e300}, 0.0),
    ("integrate(..., fy=1e300), first load -k u0", {"fy": 1e300}, -1.0),
):
    errors = [error(dt, options, first) for dt in (0.02, 0.01, 0.005)]
    print(f"{name:43s}", *(f"{e:.2e}" for e in errors), f" order {math.log2(errors[1] / errors[2]):.2f}, expected 2")
