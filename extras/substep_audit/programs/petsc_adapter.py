"""PETSc's time steppers by petsc4py: TSALPHA2 for second-order equations, and some for the same as a first-order
system.

Debian keeps petsc4py in a folder of PETSc's own; the environment script says how to start this adapter with it.
"""

from typing import Any

import petsc4py

petsc4py.init([])

from adapter import Integrator, Load, Spring, serve  # noqa: E402
from petsc4py import PETSc  # noqa: E402

MANUAL = "PETSc manual page {}"
CHUNG = "ODE/DAE solver using the implicit Generalized-Alpha method for second-order systems"
JANSEN = "ODE/DAE solver using the implicit Generalized-Alpha method for first-order systems"


def second(rho: float) -> Integrator:
    """TSALPHA2 for a spectral radius at infinity."""
    place = MANUAL.format("TSALPHA2")
    claims: dict[str, tuple[Any, str, str]] = {
        "scheme": ("generalized_alpha", CHUNG, place),
        "rho_inf": (rho, "the desired spectral radius of the method", MANUAL.format("TSAlpha2SetRadius")),
        "order": (2, "Second-order accuracy can be obtained so long as", MANUAL.format("TSAlpha2SetParams")),
    }
    return Integrator(
        arguments={"type": "alpha2", "radius": rho}, outputs="uv", nonlinear=True, adaptive=True, claims=claims
    )


def first(kind: str, scheme: str, quotation: str, accuracy: int, **arguments: Any) -> Integrator:
    """A stepper of first-order systems, given u' = v and v' = f - c v - k u."""
    place = MANUAL.format(f"TS{kind.upper()}")
    claims = {"scheme": (scheme, quotation, place), "order": (accuracy, quotation, place)}
    return Integrator(arguments={"type": kind, **arguments}, outputs="uv", nonlinear=True, adaptive=True, claims=claims)


INTEGRATORS = {
    "alpha2": second(1.0),
    "alpha2_0.6": second(0.6),
    "alpha2_0": second(0.0),
    "alpha": first("alpha", "generalized_alpha_first_order", JANSEN, 2, radius=0.6),
    "beuler": first("beuler", "backward_euler", "ODE solver using the implicit backward Euler method", 1),
    "cn": first("cn", "newmark", "ODE solver using the implicit Crank-Nicolson method.", 2),
    "bdf2": first("bdf", "bdf2", "DAE solver using BDF methods", 2, order=2),
}


def second_order(ts: Any, c: float, spring: Spring, load: Load) -> None:
    """The balance as u'' + c u' + N(u) - f = 0, and its derivative."""

    def balance(ts: Any, t: float, u: Any, v: Any, a: Any, residual: Any) -> None:
        residual[0] = a[0] + c * v[0] + spring(u[0]) - load(t)
        residual.assemble()

    def slope(ts: Any, t: float, u: Any, v: Any, a: Any, dv: float, da: float, matrix: Any, same: Any) -> None:
        matrix[0, 0] = da + dv * c + spring.slope(u[0])
        matrix.assemble()

    matrix = PETSc.Mat().createDense([1, 1])
    matrix.setUp()
    ts.setI2Function(balance, PETSc.Vec().createSeq(1))
    ts.setI2Jacobian(slope, matrix, matrix)


def first_order(ts: Any, c: float, spring: Spring, load: Load) -> None:
    """The same as two implicit equations in (u, v) and their rates, and their derivatives."""

    def balance(ts: Any, t: float, y: Any, rate: Any, residual: Any) -> None:
        residual[0] = rate[0] - y[1]
        residual[1] = rate[1] + c * y[1] + spring(y[0]) - load(t)
        residual.assemble()

    def slope(ts: Any, t: float, y: Any, rate: Any, shift: float, matrix: Any, same: Any) -> None:
        matrix[0, 0], matrix[0, 1] = shift, -1.0
        matrix[1, 0], matrix[1, 1] = spring.slope(y[0]), shift + c
        matrix.assemble()

    matrix = PETSc.Mat().createDense([2, 2])
    matrix.setUp()
    ts.setIFunction(balance, PETSc.Vec().createSeq(2))
    ts.setIJacobian(slope, matrix, matrix)


def prepared(arguments: dict[str, Any], omega: float, xi: float, load: Load, force: Spring | None, **more: Any) -> Any:
    """A time stepper at t = 0, with more options.

    Newton's method with a second, idle step on a linear oscillator: PETSc's alpha steppers take the stage's rates from
    the last evaluation, so with the solver for linear problems alone, which evaluates no more after its solution, they
    would be wrong.
    """
    options = PETSc.Options()
    options["snes_type"] = "newtonls"
    options["snes_rtol"] = 1e-14
    options["snes_max_it"] = 3 if force is None else 50
    options["ksp_type"] = "preonly"
    options["pc_type"] = "lu"
    if "radius" in arguments:
        options["ts_alpha_radius"] = arguments["radius"]
    if "order" in arguments:
        options["ts_bdf_order"] = arguments["order"]
    for name, value in more.items():
        options[name] = value
    ts = PETSc.TS().create(comm=PETSc.COMM_SELF)
    ts.setType(arguments["type"])
    equations = second_order if arguments["type"] == "alpha2" else first_order
    equations(ts, 2 * xi * omega, force or Spring(omega**2, 0.0), load)
    ts.setTime(0.0)
    return ts


def started(ts: Any, arguments: dict[str, Any], u0: float, v0: float) -> Any:
    """Take the options and the start; a function that returns u and v as they are."""
    ts.setFromOptions()
    if arguments["type"] == "alpha2":
        u, v = PETSc.Vec().createSeq(1), PETSc.Vec().createSeq(1)
        u[0], v[0] = u0, v0
        ts.setSolution2(u, v)
        return lambda: (u[0], v[0])
    y = PETSc.Vec().createSeq(2)
    y[0], y[1] = u0, v0
    ts.setSolution(y)
    return lambda: (y[0], y[1])


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load, force=None):
    """Histories after steps of fixed length."""
    ts = prepared(arguments, omega, xi, load, force, ts_adapt_type="none")
    ts.setTimeStep(dt)
    ts.setMaxSteps(n)
    ts.setMaxTime(2 * (n + 1) * dt)
    ts.setExactFinalTime(PETSc.TS.ExactFinalTime.STEPOVER)
    now = started(ts, arguments, u0, v0)
    rows = [(u0, v0)]
    for _ in range(n):
        ts.step()
        rows.append(now())
    ts.destroy()
    u, v = zip(*rows, strict=True)
    return u, v, None


def controlled(
    integrator: str, arguments: dict[str, Any], omega: float, xi: float, tol: float, t_end: float, u0: float, v0: float
) -> tuple[Any, Any, Any, None]:
    """Steps chosen by TSADAPTBASIC; the estimates are not handed out."""
    ts = prepared(arguments, omega, xi, Load(), None, ts_adapt_type="basic", ts_rtol=tol, ts_atol=tol)
    ts.setTimeStep(0.01 / omega)
    ts.setMaxSteps(1000000)
    ts.setMaxTime(t_end)
    ts.setExactFinalTime(PETSc.TS.ExactFinalTime.MATCHSTEP)
    now = started(ts, arguments, u0, v0)
    rows = [(0.0, u0, v0)]
    while ts.getTime() < t_end * (1 - 1e-12) and ts.getConvergedReason() == 0:
        ts.step()
        rows.append((ts.getTime(), *now()))
    ts.destroy()
    return *zip(*rows, strict=True), None


if __name__ == "__main__":
    serve("PETSc", ".".join(map(str, PETSc.Sys.getVersion())), "BSD-2-Clause", INTEGRATORS, run, controlled)
