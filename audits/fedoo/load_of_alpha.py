"""fedoo's GeneralizedAlpha takes the load at the end of the step, so with alpha_f not 0 forced motion is first order.

Manual: the docstring of fedoo.time.GeneralizedAlpha warns of it: "External loads (Neumann/Dirichlet) are applied by the
problem at the step endpoint t_{n+1}, not at t_{n+1-alpha_f}", "a known follow-up".
Source, fedoo 1.1.0, fedoo/time/generalized_alpha.py:474-480: internal force and damping weigh both ends, the load is
no part of it. The cure for a user is to set (1 - alpha_f) f(t_{n+1}) + alpha_f f(t_n) for the step.

Integrators, by their names in the report: GeneralizedAlpha, GeneralizedAlpha_hht.
"""

import math
import warnings

import numpy as np

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import fedoo

T = 4.0


def error(dt: float, alpha_m: float, alpha_f: float, weighted: bool) -> float:
    """Error of u at T of u'' + u = sin 2t from u = 0 and u' = -2/3, whose motion is -sin(2t)/3, on one element."""
    fedoo.ModelingSpace("2Dstress")
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    mesh = fedoo.Mesh(corners, np.array([[0, 1, 2, 3]]), "quad4", name="square")
    material = fedoo.constitutivelaw.ElasticIsotrop(1.0, 0.0, name="material")
    material.set_density(3.0)  # of which the free side moves 1
    assembly = fedoo.Assembly.create(fedoo.weakform.StressEquilibrium(material, name="form"), mesh, name="assembly")
    problem = fedoo.problem.Linear(assembly, time_step=dt)
    problem.set_time_integrator("second_order", fedoo.time.GeneralizedAlpha(alpha_m, alpha_f))
    problem.bc.add("Dirichlet", [0, 3], "DispX", 0)
    problem.bc.add("Dirichlet", [0, 1, 2, 3], "DispY", 0)
    force = problem.bc.add("Neumann", [1, 2], "DispX", 0.0)
    problem.set_initial_velocity("DispX", np.array([0.0, -2 / 3, -2 / 3, 0.0]))
    problem.set_initial_acceleration("DispX", np.zeros(4))
    old = alpha_f if weighted else 0.0
    for i in range(1, round(T / dt) + 1):
        load = (1 - old) * math.sin(2 * i * dt) + old * math.sin(2 * (i - 1) * dt)
        problem.bc.remove(force)
        force = problem.bc.add("Neumann", [1, 2], "DispX", load / 2)
        problem.solve_time_increment()
    return abs(problem.get_disp("DispX")[1] + math.sin(2 * T) / 3)


for alpha_m, alpha_f in ((0.0, 0.0), (-0.1, 0.2), (0.0, 0.1)):
    for weighted in (False, True):
        errors = [error(dt, alpha_m, alpha_f, weighted) for dt in (0.02, 0.01, 0.005)]
        name = "weighted by hand" if weighted else "as it is"
        print(f"GeneralizedAlpha({alpha_m:4}, {alpha_f}), {name:16s}", *(f"{e:.2e}" for e in errors), end="")
        print(f"  order {math.log2(errors[1] / errors[2]):.2f}, expected 2")
