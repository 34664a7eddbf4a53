"""With no_mult, every step of MFEM's NewmarkSolver and GeneralizedAlpha2Solver is a midpoint step.

Manual: linalg/ode.hpp, "The classical newmark method" with the argument no_mult, which is for operators that cannot
find the first acceleration themselves.
Source, linalg/ode.cpp (as of August 2026; PyMFEM 4.10.0.1 behaves so): NewmarkSolver::Step, lines 1279-1290, takes the
midpoint step where the state is empty and returns before state.Increment(), so the state is empty in the next step,
too; GeneralizedAlpha2Solver::Step, lines 1355-1366, likewise. beta, gamma and rho_inf are then without effect.
"""

import mfem.ser as mfem
import numpy as np

DT, STEPS = 0.5, 10


class Oscillator(mfem.SecondOrderTimeDependentOperator):
    """u'' = -u."""

    def Mult(self, x, v, a):
        """The acceleration of a state."""
        a[0] = -x[0]

    def ImplicitSolve(self, fac0, fac1, x, v, a):
        """The acceleration a of the state x + fac0 a, v + fac1 a."""
        a[0] = -x[0] / (1 + fac0)


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
