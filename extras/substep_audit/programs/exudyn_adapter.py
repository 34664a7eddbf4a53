"""Exudyn: its implicit and explicit dynamic solvers, on a point mass with a coordinate spring-damper."""

from typing import Any

import exudyn as exu
import numpy as np
from adapter import Integrator, Load, serve
from exudyn.itemInterface import (
    CoordinateSpringDamper,
    LoadCoordinate,
    MarkerNodeCoordinate,
    Mass1D,
    Node1D,
    NodePointGround,
)

THEORY = "Exudyn documentation, docs/theDoc/solver.tex, section {}"
SETTINGS = "exudyn/__init__.pyi, GeneralizedAlphaSettings.{}"
NEWMARK = "Implicit Trapezoidal Rule-based, Newmark and Generalized-alpha solver"
EXPLICIT = "Explicit solvers"


def implicit(claims: dict[str, tuple[Any, str, str]], sets: str, **settings: Any) -> Integrator:
    """A setting of the implicit solver.

    Newmark's first acceleration can be given. The generalized alpha method reports the acceleration of the balance at
    the end of the step and keeps an algorithmic one beside it; what is given would start both, so it is not offered.
    """
    return Integrator(arguments={"solver": "GeneralizedAlpha", **settings}, sets=sets, claims=claims)


def radius(rho: float) -> Integrator:
    """The generalized alpha method for a spectral radius."""
    quotation = "spectral radius for Generalized-alpha solver"
    claims: dict[str, tuple[Any, str, str]] = {
        "scheme": (
            "generalized_alpha",
            "generalized-alpha method, Chung and Hulbert; Arnold and Bruels",
            THEORY.format(NEWMARK),
        ),
        "rho_inf": (rho, quotation, SETTINGS.format("spectralRadius")),
    }
    return implicit(claims, "uv", spectralRadius=rho)


def newmark(beta: float, gamma: float) -> Integrator:
    """Newmark's method, as the solver's settings describe it."""
    claims: dict[str, tuple[Any, str, str]] = {
        "scheme": ("newmark", "Newmark's method has two parameters beta and gamma", THEORY.format(NEWMARK)),
        "beta": (beta, "value beta for Newmark method", SETTINGS.format("newmarkBeta")),
        "gamma": (gamma, "value gamma for Newmark method", SETTINGS.format("newmarkGamma")),
    }
    return implicit(claims, "uva", useNewmark=True, newmarkBeta=beta, newmarkGamma=gamma)


def explicit(solver: str, order: int | None, quotation: str) -> Integrator:
    """An explicit solver, with the order that its name or the theory states."""
    place = THEORY.format(EXPLICIT)
    claims: dict[str, tuple[Any, str, str]] = {"scheme": (SCHEMES.get(solver, solver), quotation, place)}
    if order is not None:
        claims["order"] = (order, quotation, place)
    return Integrator(arguments={"solver": solver}, adaptive=solver in ("ODE23", "DOPRI5"), claims=claims)


SCHEMES = {  # names of the solvers that the catalogue of schemes has
    "ExplicitEuler": "forward_euler",
    "ExplicitMidpoint": "rk2",
    "RK44": "rk4",
    "ODE23": "bogacki_shampine",
    "DOPRI5": "dormand_prince",
}
INTEGRATORS = {
    "GeneralizedAlpha": radius(0.9),
    "GeneralizedAlpha_0.6": radius(0.6),
    "GeneralizedAlpha_0": radius(0.0),
    "GeneralizedAlpha_1": radius(1.0),
    "Newmark": newmark(0.25, 0.5),
    "Newmark_damped": newmark(0.3025, 0.6),
    "TrapezoidalIndex2": Integrator(
        arguments={"solver": "TrapezoidalIndex2"},
        sets="uva",
        claims={
            "scheme": (
                "newmark",
                "Implicit trapezoidal rule (Newmark with beta = 1/4 and gamma = 1/2)",
                THEORY.format(NEWMARK),
            )
        },
    ),
    "ExplicitEuler": explicit("ExplicitEuler", 1, "Explicit Euler method, number of stages s=1, order p=1"),
    "ExplicitMidpoint": explicit("ExplicitMidpoint", 2, "Explicit midpoint rule, number of stages s=2, order p=2"),
    "RK33": explicit("RK33", None, "RK33"),
    "RK44": explicit("RK44", 4, "Classical explicit Runge-Kutta method (RK44), number of stages s=4, order p=4"),
    "RK67": explicit("RK67", 6, "such as for RK67, which as order 6 but 7 stages"),
    "ODE23": explicit("ODE23", None, "Advanced solvers, such as ODE23 and DOPRI5"),
    "DOPRI5": explicit("DOPRI5", None, "Advanced solvers, such as ODE23 and DOPRI5"),
    "VelocityVerlet": explicit("VelocityVerlet", None, "VelocityVerlet: still under development"),
}


def settings(arguments: dict[str, Any], dt: float, n: int, a0: float | None) -> Any:
    """Fixed steps, Newton's method to all digits, and no files."""
    chosen = exu.SimulationSettings()
    time = chosen.timeIntegration
    time.numberOfSteps = n
    time.endTime = n * dt
    time.automaticStepSize = False
    time.adaptiveStep = False
    time.relativeTolerance = 1e300  # of the pairs of Runge and Kutta, which then accept every step
    time.absoluteTolerance = 1e300
    time.newton.useModifiedNewton = False
    time.newton.relativeTolerance = 1e-14
    time.newton.absoluteTolerance = 1e-15
    time.verboseMode = 0
    alpha = time.generalizedAlpha
    alpha.computeInitialAccelerations = a0 is None
    for name, value in arguments.items():
        if name != "solver":
            setattr(alpha, name, value)
    chosen.solution.file.write = False
    return chosen


def controlled(
    integrator: str, arguments: dict[str, Any], omega: float, xi: float, tol: float, t_end: float, u0: float, v0: float
) -> tuple[Any, Any, Any, None]:
    """The automatic steps of ODE23 and DOPRI5; the estimates are not handed out."""
    _container, system, rows = oscillator(omega, xi, u0, v0, Load())
    chosen = settings(arguments, t_end, 1, None)
    chosen.timeIntegration.automaticStepSize = True
    chosen.timeIntegration.initialStepSize = 0.01 / omega
    chosen.timeIntegration.minimumStepSize = 1e-9 / omega
    chosen.timeIntegration.relativeTolerance = tol
    chosen.timeIntegration.absoluteTolerance = tol
    solver = getattr(exu.DynamicSolverType, arguments["solver"])
    system.SolveDynamic(chosen, solverType=solver, showHints=False)
    t, u, v, _ = zip(*rows, strict=True)
    return t, u, v, None


def oscillator(omega: float, xi: float, u0: float, v0: float, load: Load) -> tuple[Any, Any, list[tuple[float, ...]]]:
    """The container, its assembled system, and the rows t, u, v, a gathered before the first and after every step."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    ground = system.AddNode(NodePointGround(referenceCoordinates=[0, 0, 0]))
    node = system.AddNode(Node1D(referenceCoordinates=[0.0], initialCoordinates=[u0], initialVelocities=[v0]))
    system.AddObject(Mass1D(mass=1.0, nodeNumber=node))
    fixed = system.AddMarker(MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    free = system.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=0))
    system.AddObject(CoordinateSpringDamper(markerNumbers=[fixed, free], stiffness=omega**2, damping=2 * xi * omega))
    if load.kind != "none":
        system.AddLoad(LoadCoordinate(markerNumber=free, load=1.0, loadUserFunction=lambda mbs, t, factor: load(t)))
    rows: list[tuple[float, ...]] = []

    def gather(mbs: Any, t: float) -> bool:
        data = mbs.systemData
        outputs = (data.GetODE2Coordinates, data.GetODE2Coordinates_t, data.GetODE2Coordinates_tt)
        rows.append((data.GetTime(), *(float(y()[0]) for y in outputs)))
        return True

    system.Assemble()
    system.SetPostStepUserFunction(gather)
    return container, system, rows


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    """Histories that a function called after every step gathers, and once before the first."""
    _container, system, rows = oscillator(omega, xi, u0, v0, load)
    if a0 is not None:
        system.systemData.SetODE2Coordinates_tt([a0], configuration=exu.ConfigurationType.Initial)
    solver = getattr(exu.DynamicSolverType, arguments["solver"])
    system.SolveDynamic(settings(arguments, dt, n, a0), solverType=solver, showHints=False)
    if len(rows) != n + 1:
        raise RuntimeError(f"expected {n + 1} rows, got {len(rows)}")
    return tuple(np.array(rows).T[1:])


if __name__ == "__main__":
    serve("Exudyn", exu.__version__, "EXUDYN General License 1.0 (BSD-3-Clause)", INTEGRATORS, run, controlled)
