"""The last row of structdyn's central differences: a velocity half a step and an acceleration a whole step too old.

Manual: structdyn 0.8.0, sdf/numerical_methods/central_difference.py, docstring of compute_solution: "Velocity at each
time point", "Acceleration at each time point" (lines 69-70).
Source: the same file, under "# Last step": v[-1] = (u[-1] - u[-2]) / dt (line 119), the velocity half a step before,
and acc[-1] from u[-1], u[-2], u[-3] (line 120), which is acc[-2] again. mdf/numerical_methods/central_difference.py
does likewise (line 224).
"""

import numpy as np
from structdyn.sdf.numerical_methods.central_difference import CentralDifference
from structdyn.sdf.sdf import SDF

for dt in (0.02, 0.01, 0.005):
    t = dt * np.arange(round(2 / dt) + 1)
    table = CentralDifference(SDF(1.0, 1.0), dt, u0=1.0).compute_solution(t, 0.0 * t)
    v, a = table["velocity"].to_numpy(), table["acceleration"].to_numpy()
    errors = np.abs(v + np.sin(t)), np.abs(a + np.cos(t))
    print(f"dt = {dt}: error of v in the last row {errors[0][-1]:.1e}, in the row before {errors[0][-2]:.1e};", end=" ")
    print(f"of a {errors[1][-1]:.1e}, {errors[1][-2]:.1e}; acc[-1] == acc[-2]: {a[-1] == a[-2]}")
