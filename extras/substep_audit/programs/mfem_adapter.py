"""PyMFEM: MFEM's solvers of second-order equations, given an oscillator as an operator written in Python."""

from importlib.metadata import version
from typing import Any

import mfem.ser as mfem
from adapter import Integrator, Load, serve

SOURCE = "MFEM 4.10, linalg/ode.hpp, class {}"
CHUNG = "Generalized-alpha ODE solver, A Time Integration Algorithm for Structural Dynamics, J.Chung and G.M. Hulbert"


def solver(name: str, quotation: str, arguments: dict[str, Any] | None = None, **values: Any) -> Integrator:
    """A solver with the arguments of its constructor in order, and what the header says of it."""
    claims = {key: (value, quotation, SOURCE.format(name)) for key, value in values.items()}
    given = arguments or {}
    sets = outputs = "uv" if "no_mult" in given else "uva"
    return Integrator(arguments={"solver": name} | given, sets=sets, outputs=outputs, claims=claims)


def newmark(beta: float, gamma: float, no_mult: bool = False) -> Integrator:
    """Newmark's method; no_mult says that the operator cannot find the first acceleration."""
    arguments = {"beta": beta, "gamma": gamma} | ({"no_mult": True} if no_mult else {})
    return solver("NewmarkSolver", "The classical newmark method", arguments, scheme="newmark", beta=beta, gamma=gamma)


def radius(rho: float, no_mult: bool = False) -> Integrator:
    """The generalized alpha method for a spectral radius at infinity."""
    arguments = {"rho_inf": rho} | ({"no_mult": True} if no_mult else {})
    return solver("GeneralizedAlpha2Solver", CHUNG, arguments, scheme="generalized_alpha", rho_inf=rho, order=2)


INTEGRATORS = {
    "NewmarkSolver": newmark(0.25, 0.5),
    "NewmarkSolver_damped": newmark(0.3025, 0.6),
    "NewmarkSolver_no_mult": newmark(0.25, 0.5, no_mult=True),
    "NewmarkSolver_damped_no_mult": newmark(0.3025, 0.6, no_mult=True),
    "LinearAccelerationSolver": solver(
        "LinearAccelerationSolver", "NewmarkSolver(1.0/6.0, 0.5)", scheme="newmark", beta=1 / 6, gamma=1 / 2
    ),
    "CentralDifferenceSolver": solver(
        "CentralDifferenceSolver", "NewmarkSolver(0.0, 0.5)", scheme="newmark", beta=0.0, gamma=1 / 2
    ),
    "FoxGoodwinSolver": solver(
        "FoxGoodwinSolver", "NewmarkSolver(1.0/12.0, 0.5)", scheme="newmark", beta=1 / 12, gamma=1 / 2
    ),
    "GeneralizedAlpha2Solver": radius(1.0),
    "GeneralizedAlpha2Solver_0.6": radius(0.6),
    "GeneralizedAlpha2Solver_0": radius(0.0),
    "GeneralizedAlpha2Solver_no_mult": radius(0.6, no_mult=True),
    "AverageAccelerationSolver": solver(
        "AverageAccelerationSolver", "The classical midpoint method.", scheme="midpoint"
    ),
    "HHTAlphaSolver": solver(
        "HHTAlphaSolver",
        "HHT-alpha ODE solver, alpha in [2/3,1] --> Defined differently than in paper.",
        {"alpha": 0.9},
        scheme="generalized_alpha",
        alpha_m=0.0,
        alpha_f=0.1,
        beta=0.3025,
        gamma=0.6,
        order=2,
    ),
    "WBZAlphaSolver": solver(
        "WBZAlphaSolver",
        "WBZ-alpha ODE solver, rho_inf in [0,1]",
        {"rho_inf": 0.6},
        scheme="wbz_alpha",
        rho_inf=0.6,
        order=2,
    ),
}


class Oscillator(mfem.SecondOrderTimeDependentOperator):
    """u'' = f(t) - c u' - k u, as an explicit and as an implicit operator, at the time that the solver sets."""

    def __init__(self, omega: float, xi: float, load: Load) -> None:
        super().__init__(1, 0.0)
        self.k, self.c, self.load = omega**2, 2 * xi * omega, load

    def Mult(self, x: Any, v: Any, a: Any) -> None:
        """The acceleration of a state."""
        a[0] = self.load(self.GetTime()) - self.c * v[0] - self.k * x[0]

    def ImplicitSolve(self, fac0: float, fac1: float, x: Any, v: Any, a: Any) -> None:
        """The acceleration a of the state x + fac0 a, v + fac1 a."""
        force = self.load(self.GetTime()) - self.c * v[0] - self.k * x[0]
        a[0] = force / (1 + self.k * fac0 + self.c * fac1)


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    """Histories of Step, with the acceleration that the solver keeps; with no_mult it keeps none."""
    values = dict(arguments)
    stepper = getattr(mfem, values.pop("solver"))(*values.values())
    operator = Oscillator(omega, xi, load)
    stepper.Init(operator)
    x, v, a = (mfem.Vector(1) for _ in range(3))
    x[0], v[0] = u0, v0
    if a0 is not None:
        a[0] = a0
        stepper.GetState().Append(a)
    rows = [(u0, v0, load.at(0.0) - 2 * xi * omega * v0 - omega**2 * u0 if a0 is None else a0)]
    t = 0.0
    for _ in range(n):
        t, _ = stepper.Step(x, v, t, dt)
        if "no_mult" not in values:
            stepper.GetState().Get(0, a)
        rows.append((x[0], v[0], a[0]))
    histories = tuple(zip(*rows, strict=True))
    return (*histories[:2], None) if "no_mult" in values else histories


if __name__ == "__main__":
    serve("PyMFEM", version("mfem"), "BSD-3-Clause", INTEGRATORS, run)
