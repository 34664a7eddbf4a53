"""With damping, fedoo's CentralDifference is not Newmark's method, and its other explicit integrators are first order.

Manual: fedoo 1.1.0, docstring of fedoo.time.CentralDifference, "the explicit Newmark specialization beta=0 and
gamma=1/2", and of ExplicitGeneralizedAlpha, which is ExplicitNewmark, too: "Their second-order defaults follow the
generalized-alpha relations".
Source: fedoo/problem/explicit_dynamic.py:612-617 takes the damping force of the end of the step from v + dt a, and
that of the next step (:396) from the velocity itself, where Newmark's method has the velocity v + dt/2 (a + new a):
order 2 remains, the limit omega dt = 2, which Newmark's method keeps under any damping, does not.
fedoo/time/explicit.py:193-201 takes the damping force of the other integrators from the predicted velocity
v + dt (1 - gamma) a, which is behind by gamma dt a; the velocity is corrected after the only solution (:246-247).
Besides, explicit_dynamic.py:283-287 finds the first acceleration for beta = 0 alone; the others begin with zero where
the user sets none, which is of first order, too.

Integrators, by their names in the report: CentralDifference, ExplicitNewmark, ExplicitGeneralizedAlpha.
"""

import math
import warnings

import numpy as np

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import fedoo

T = 4.0


def fedoo_march(name: str, arguments: tuple, dt: float, n: int, xi: float, balanced: bool = True) -> np.ndarray:
    """Displacements of u'' + 2 xi u' + u = 0 from u = 1, v = 0, and from a = -1 or none, on one element."""
    fedoo.ModelingSpace("2Dstress")
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    mesh = fedoo.Mesh(corners, np.array([[0, 1, 2, 3]]), "quad4", name="square")
    material = fedoo.constitutivelaw.ElasticIsotrop(1.0, 0.0, name="material")
    material.set_density(2.0)  # of which the free side moves 1
    form = fedoo.weakform.StressEquilibrium(material, name="form")
    form.set_dissipation(fedoo.time.RayleighDamping(2 * xi, 0.0))
    assembly = fedoo.Assembly.create(form, mesh, name="assembly")
    problem = fedoo.problem.ExplicitDynamic(assembly, dt, getattr(fedoo.time, name)(*arguments))
    problem.bc.add("Dirichlet", [0, 3], "DispX", 0)
    problem.bc.add("Dirichlet", [0, 1, 2, 3], "DispY", 0)
    problem.set_initial_displacement("DispX", np.array([0.0, 1.0, 1.0, 0.0]))
    if balanced:
        problem.set_initial_acceleration("DispX", np.array([0.0, -1.0, -1.0, 0.0]))
    history = [1.0]
    for _ in range(n):
        problem.solve_time_increment()
        history.append(problem.get_disp("DispX")[1])
    return np.array(history)


def newmark(dt: float, n: int, xi: float) -> np.ndarray:
    """The same by Newmark's method with beta = 0 and gamma = 1/2."""
    u, v, a = 1.0, 0.0, -1.0
    history = [u]
    for _ in range(n):
        u += dt * v + dt**2 / 2 * a
        new = -(u + 2 * xi * (v + dt / 2 * a)) / (1 + xi * dt)
        v, a = v + dt / 2 * (a + new), new
        history.append(u)
    return np.array(history)


for xi in (0.0, 0.1):
    for dt, n in ((0.01, 400), (1.9, 100)):
        program, rule = fedoo_march("CentralDifference", (), dt, n, xi), newmark(dt, n, xi)
        print(f"CentralDifference, xi = {xi}, dt = {dt}: |u| at the end {abs(program[-1]):.3e}, Newmark's", end=" ")
        print(f"{abs(rule[-1]):.3e}, largest difference {abs(program - rule).max():.1e}")
for name, arguments in (
    ("CentralDifference", ()),
    ("ExplicitNewmark", ()),
    ("ExplicitGeneralizedAlpha", (-0.1, 0.2)),
):
    for xi, balanced in ((0.0, True), (0.1, True), (0.0, False)):
        rate = math.sqrt(1 - xi**2)
        exact = math.exp(-xi * T) * (math.cos(rate * T) + xi / rate * math.sin(rate * T))
        ends = [fedoo_march(name, arguments, dt, round(T / dt), xi, balanced)[-1] for dt in (0.02, 0.01, 0.005)]
        errors = [abs(u - exact) for u in ends]
        print(f"{name}{arguments}, xi = {xi}, first acceleration {'set' if balanced else 'not set'}: errors", end=" ")
        print(*(f"{e:.1e}" for e in errors), f"order {math.log2(errors[1] / errors[2]):.2f}, expected 2")
