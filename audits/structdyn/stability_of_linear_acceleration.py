"""structdyn calls its linear acceleration method unconditionally stable; it is stable up to omega dt = sqrt(12).

Manual: structdyn 0.8.0, sdf/numerical_methods/newmark_beta.py:65, docstring of NewmarkBeta.__init__: '"linear": Linear
acceleration (unconditionally stable)'; mdf/numerical_methods/newmark_beta.py:21, docstring of NewmarkBetaMDF: "the
implicit, unconditionally stable Newmark-beta time integration algorithm", whose default is "linear". The program
itself warns above the limit (utils/stability_checks.py), and the docstring of get_newmark_parameters is right.

Integrators, by their names in the report: newmark_linear, newmark_many_linear.
"""

import warnings

import numpy as np
from structdyn.sdf.numerical_methods.newmark_beta import NewmarkBeta
from structdyn.sdf.sdf import SDF

warnings.simplefilter("ignore")
for ratio in (0.99, 1.01):
    dt = ratio * np.sqrt(12)
    steps = np.arange(201)
    u = NewmarkBeta(SDF(1.0, 1.0), dt, u0=1.0).compute_solution(dt * steps, 0.0 * steps)["displacement"]
    print(f"omega dt = {ratio} sqrt(12): largest |u| in 200 steps of free vibration from 1: {abs(u).max():.3e}")
