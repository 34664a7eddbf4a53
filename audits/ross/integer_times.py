"""ROSS's newmark returns displacements of the type of the times: integer times cut them to integers.

Source, ROSS 2.3.0, ross/utils.py:799, in newmark: yout = np.full((n_steps, ny), 1e-38, dtype=t.dtype). The docstring
asks for a "Time array" and returns "the state variables at each time step".
"""

import numpy as np
from ross.utils import newmark

one, none, load = np.eye(1), np.zeros((1, 1)), np.ones((6, 1))
for t in (np.arange(6), np.arange(6.0)):
    y = newmark(lambda step, **state: (one, none, one, load[step]), t, 1, tol=1e-13)
    print(f"y'' + y = 1 from rest, times of type {t.dtype}: y = {y[:, 0]}")
