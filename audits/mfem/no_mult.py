"""With no_mult, every step of MFEM's NewmarkSolver and GeneralizedAlpha2Solver is a midpoint step.

Manual: linalg/ode.hpp, "The classical newmark method" with the argument no_mult, which is for operators that cannot
find the first acceleration themselves.
Source, linalg/ode.cpp (as of August 2026; PyMFEM 4.10.0.1 behaves so): NewmarkSolver::Step, lines 1279-1290, takes the
midpoint step where the state is empty and returns before state.Increment(), so the state is empty in the next step,
too; GeneralizedAlpha2Solver::Step, lines 1355-1366, likewise. beta, gamma and rho_inf are then without effect. The
midpoint step takes the load at the end, lines 1220-1232, so forced motion is of first order.

Integrators, by their names in the report: NewmarkSolver_no_mult, NewmarkSolver_damped_no_mult,
GeneralizedAlpha2Solver_no_mult.
"""

import math

import mfem.ser as mfem
import numpy as np

DT, STEPS = 0.5, 10


class Oscillator(mfem.SecondOrderTimeDependentOperator):
    """u'' = load sin 2t - u."""

    load = 0.0

    def Mult(self, x, v, a):
        """The acceleration of a state."""
        a[0] = self.load * math.sin(2 * self.GetTime()) - x[0]

    def ImplicitSolve(self, fac0, fac1, x, v, a):
        """The acceleration a of the state x + fac0 a, v + fac1 a."""
        a[0] = (self.load * math.sin(2 * self.GetTime()) - x[0]) / (1 + fac0)


def forced(solver, dt: float) -> float:
    """Error of u at t = 4 under sin 2t from u = 0 and u' = -2/3, whose motion is -sin(2t)/3."""
    oscillator = Oscillator(1, 0.0)
    oscillator.load = 1.0
    solver.Init(oscillator)
    x, v, t = mfem.Vector(1), mfem.Vector(1), 0.0
    x[0], v[0] = 0.0, -2 / 3
    for _ in range(round(4 / dt)):
        t, _ = solver.Step(x, v, t, dt)
    return abs(x[0] + math.sin(8.0) / 3)


def displacements(solver) -> np.ndarray:
    """Free vibration from u = 1."""
    oscillator = Oscillator(1, 0.0)
    solver.Init(oscillator)
    x, v, t = mfem.Vector(1), mfem.Vector(1), 0.0
    x[0], v[0] = 1.0, 0.0
    history = [1.0]
    for _ in range(STEPS):
        t, _ = solver.Step(x, v, t, DT)
        history.append(x[0])
    return np.array(history)


def midpoint() -> np.ndarray:
    """The same by the midpoint rule."""
    u, v = 1.0, 0.0
    history = [u]
    for _ in range(STEPS):
        a = -(u + DT / 2 * v) / (1 + DT**2 / 4)
        u, v = u + DT * v + DT**2 / 2 * a, v + DT * a
        history.append(u)
    return np.array(history)


rule = midpoint()
for name, plain, without in (
    ("NewmarkSolver(0.3025, 0.6)", mfem.NewmarkSolver(0.3025, 0.6), mfem.NewmarkSolver(0.3025, 0.6, True)),
    ("NewmarkSolver(0, 0.5)", mfem.NewmarkSolver(0.0, 0.5), mfem.NewmarkSolver(0.0, 0.5, True)),
    ("GeneralizedAlpha2Solver(0)", mfem.GeneralizedAlpha2Solver(0.0), mfem.GeneralizedAlpha2Solver(0.0, True)),
):
    u = displacements(without)
    print(f"{name}: u(5) = {displacements(plain)[-1]:.12f}; with no_mult {u[-1]:.12f}, midpoint rule {rule[-1]:.12f},")
    print(f"  largest difference of no_mult from the midpoint rule {abs(u - rule).max():.1e}")
for name, make in (
    ("NewmarkSolver(0.25, 0.5)", lambda: mfem.NewmarkSolver(0.25, 0.5)),
    ("NewmarkSolver(0.25, 0.5, True)", lambda: mfem.NewmarkSolver(0.25, 0.5, True)),
    ("GeneralizedAlpha2Solver(0.6, True)", lambda: mfem.GeneralizedAlpha2Solver(0.6, True)),
):
    errors = [forced(make(), dt) for dt in (0.02, 0.01, 0.005)]
    print(f"{name}, load sin 2t: errors", *(f"{e:.2e}" for e in errors), end="")
    print(f", order {math.log2(errors[1] / errors[2]):.2f}, expected 2")
