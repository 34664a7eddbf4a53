"""MFEM's second-order generalized alpha solvers evaluate a load at the end of the step: forced motion of first order.

Source, linalg/ode.cpp (as of August 2026; PyMFEM 4.10.0.1 behaves so): GeneralizedAlpha2Solver::Step, lines 1374-1376,
solves the balance of the states at t + alpha_f dt after SetTime(t + dt); the solver of first-order equations,
GeneralizedAlphaSolver::Step, line 1047, sets t + alpha_f dt. HHTAlphaSolver, WBZAlphaSolver (whose alpha_f is 1, so
that nothing is amiss) and AverageAccelerationSolver ("The classical midpoint method") inherit the step, and
MidPointStep, lines 1220-1232, also sets the end. Free vibration is of second order, as it should.

Integrators, by their names in the report: GeneralizedAlpha2Solver, GeneralizedAlpha2Solver_0.6, HHTAlphaSolver,
AverageAccelerationSolver.
"""

import math

import mfem.ser as mfem


class Oscillator(mfem.SecondOrderTimeDependentOperator):
    """u'' = f(t) - u with f(t) = sin 2t, whose motion from u = 0 and u' = -2/3 is -sin(2t)/3."""

    def Mult(self, x, v, a):
        """The acceleration of a state."""
        a[0] = math.sin(2 * self.GetTime()) - x[0]

    def ImplicitSolve(self, fac0, fac1, x, v, a):
        """The acceleration a of the state x + fac0 a, v + fac1 a."""
        a[0] = (math.sin(2 * self.GetTime()) - x[0]) / (1 + fac0)


def error(solver, dt: float) -> float:
    """Error of u at t = 4."""
    oscillator = Oscillator(1, 0.0)
    solver.Init(oscillator)
    x, v, t = mfem.Vector(1), mfem.Vector(1), 0.0
    x[0], v[0] = 0.0, -2 / 3
    for _ in range(round(4 / dt)):
        t, _ = solver.Step(x, v, t, dt)
    return abs(x[0] + math.sin(8.0) / 3)


for name, make in (
    ("NewmarkSolver()", mfem.NewmarkSolver),
    ("WBZAlphaSolver(0.6)", lambda: mfem.WBZAlphaSolver(0.6)),
    ("GeneralizedAlpha2Solver(0.6)", lambda: mfem.GeneralizedAlpha2Solver(0.6)),
    ("HHTAlphaSolver(0.9)", lambda: mfem.HHTAlphaSolver(0.9)),
    ("AverageAccelerationSolver()", mfem.AverageAccelerationSolver),
):
    errors = [error(make(), dt) for dt in (0.02, 0.01, 0.005)]
    order = math.log2(errors[1] / errors[2])
    print(f"{name:30s}", *(f"{e:.2e}" for e in errors), f" order {order:.2f}, expected 2")
