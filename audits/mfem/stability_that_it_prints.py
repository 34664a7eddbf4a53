"""What NewmarkSolver.PrintProperties says of stability.

Source, linalg/ode.cpp (as of August 2026; PyMFEM 4.10.0.1 prints so), lines 1256-1267: "A-Stable" where gamma >= 1/2
and beta >= (gamma + 1/2)^2/4, else "Conditionally stable" where beta >= gamma/2, else "Unstable". But beta >= gamma/2
>= 1/4 is unconditional stability itself (Hughes, The Finite Element Method, section 9.1), and below it the method is
stable up to omega dt = 1/sqrt(gamma/2 - beta) undamped. So it calls its LinearAccelerationSolver (limit sqrt 12),
CentralDifferenceSolver (2) and FoxGoodwinSolver (sqrt 6) unstable.
"""

import math
import sys

import mfem.ser as mfem
import numpy as np


def radius(beta: float, gamma: float, omega_dt: float) -> float:
    """Spectral radius of Newmark's amplification matrix, undamped."""
    x = omega_dt**2
    trace = 2 - x * (gamma + 0.5) / (1 + beta * x)
    determinant = 1 - x * (gamma - 0.5) / (1 + beta * x)
    return float(abs(np.roots([1.0, -trace, determinant])).max())


for name, solver, beta, gamma in (
    ("LinearAccelerationSolver", mfem.LinearAccelerationSolver(), 1 / 6, 0.5),
    ("CentralDifferenceSolver", mfem.CentralDifferenceSolver(), 0.0, 0.5),
    ("FoxGoodwinSolver", mfem.FoxGoodwinSolver(), 1 / 12, 0.5),
    ("NewmarkSolver(0.3, 0.6)", mfem.NewmarkSolver(0.3, 0.6), 0.3, 0.6),
):
    limit = 1 / math.sqrt(gamma / 2 - beta) if gamma / 2 > beta + 1e-12 else math.inf
    below = [radius(beta, gamma, min(0.99 * limit, largest)) for largest in (1.0, 100.0)]
    print(
        f"{name}: stable up to omega dt = {limit:.4f}; radii below it {below[0]:.6f}, {below[1]:.6f}; it prints",
        flush=True,
    )
    solver.PrintProperties()
    sys.stdout.flush()
