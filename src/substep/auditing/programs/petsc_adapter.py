"""PETSc's time steppers by petsc4py: TSALPHA2 for second-order equations, and some for the same as a first-order
system.

Debian keeps petsc4py in a folder of PETSc's own; the environment script says how to start this adapter with it.
"""

from typing import Any

import petsc4py

petsc4py.init([])

from adapter import Integrator, Load, serve  # noqa: E402
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
    return Integrator(arguments={"type": "alpha2", "radius": rho}, outputs="uv", claims=claims)


def first(kind: str, scheme: str, quotation: str, accuracy: int, **arguments: Any) -> Integrator:
    """A stepper of first-order systems, given u' = v and v' = f - c v - k u."""
    place = MANUAL.format(f"TS{kind.upper()}")
    claims = {"scheme": (scheme, quotation, place), "order": (accuracy, quotation, place)}
    return Integrator(arguments={"type": kind, **arguments}, outputs="uv", claims=claims)


INTEGRATORS = {
    "alpha2": second(1.0),
    "alpha2_0.6": second(0.6),
    "alpha2_0": second(0.0),
    "alpha": first("alpha", "generalized_alpha_first_order", JANSEN, 2, radius=0.6),
    "beuler": first("beuler", "backward_euler", "ODE solver using the implicit backward Euler method", 1),
    "cn": first("cn", "newmark", "ODE solver using the implicit Crank-Nicolson method.", 2),
    "bdf2": first("bdf", "bdf2", "DAE solver using BDF methods", 2, order=2),
}


def second_order(ts: Any, omega: float, xi: float, load: Load) -> None:
    """The balance as u'' + c u' + k u - f = 0, and its derivative."""
    c, k = 2 * xi * omega, omega**2

    def balance(ts: Any, t: float, u: Any, v: Any, a: Any, residual: Any) -> None:
        residual[0] = a[0] + c * v[0] + k * u[0] - load(t)
        residual.assemble()

    def slope(ts: Any, t: float, u: Any, v: Any, a: Any, dv: float, da: float, matrix: Any, same: Any) -> None:
        matrix[0, 0] = da + dv * c + k
        matrix.assemble()

    matrix = PETSc.Mat().createDense([1, 1])
    matrix.setUp()
    ts.setI2Function(balance, PETSc.Vec().createSeq(1))
    ts.setI2Jacobian(slope, matrix, matrix)


def first_order(ts: Any, omega: float, xi: float, load: Load) -> None:
    """The same as two implicit equations in (u, v) and their rates, and their derivatives."""
    c, k = 2 * xi * omega, omega**2

    def balance(ts: Any, t: float, y: Any, rate: Any, residual: Any) -> None:
        residual[0] = rate[0] - y[1]
        residual[1] = rate[1] + c * y[1] + k * y[0] - load(t)
        residual.assemble()

    def slope(ts: Any, t: float, y: Any, rate: Any, shift: float, matrix: Any, same: Any) -> None:
        matrix[0, 0], matrix[0, 1] = shift, -1.0
        matrix[1, 0], matrix[1, 1] = k, shift + c
        matrix.assemble()

    matrix = PETSc.Mat().createDense([2, 2])
    matrix.setUp()
    ts.setIFunction(balance, PETSc.Vec().createSeq(2))
    ts.setIJacobian(slope, matrix, matrix)


def run(
    integrator: str,
    arguments: dict[str, Any],
    omega: float,
    xi: float,
    dt: float,
    n: int,
    u0: float,
    v0: float,
    a0: float | None,
    load: Load,
) -> tuple[Any, Any, Any]:
    """Histories after steps of fixed length.

    Newton's method with a second, idle step: PETSc's alpha steppers take the stage's rates from the last evaluation, so
    with the solver for linear problems alone, which evaluates no more after its solution, they would be wrong.
    """
    options = PETSc.Options()
    options["ts_adapt_type"] = "none"
    options["snes_type"] = "newtonls"
    options["snes_rtol"] = 1e-14
    options["snes_max_it"] = 3
    options["ksp_type"] = "preonly"
    options["pc_type"] = "lu"
    if "radius" in arguments:
        options["ts_alpha_radius"] = arguments["radius"]
    if "order" in arguments:
        options["ts_bdf_order"] = arguments["order"]
    ts = PETSc.TS().create(comm=PETSc.COMM_SELF)
    ts.setType(arguments["type"])
    second = arguments["type"] == "alpha2"
    (second_order if second else first_order)(ts, omega, xi, load)
    ts.setTime(0.0)
    ts.setTimeStep(dt)
    ts.setMaxSteps(n)
    ts.setMaxTime(2 * (n + 1) * dt)
    ts.setExactFinalTime(PETSc.TS.ExactFinalTime.STEPOVER)
    ts.setFromOptions()
    if second:
        u, v = PETSc.Vec().createSeq(1), PETSc.Vec().createSeq(1)
        u[0], v[0] = u0, v0
        ts.setSolution2(u, v)
    else:
        y = PETSc.Vec().createSeq(2)
        y[0], y[1] = u0, v0
        ts.setSolution(y)
    rows = [(u0, v0)]
    for _ in range(n):
        ts.step()
        rows.append((u[0], v[0]) if second else (y[0], y[1]))
    ts.destroy()
    histories = tuple(zip(*rows, strict=True))
    return histories[0], histories[1], None


if __name__ == "__main__":
    serve("PETSc", ".".join(map(str, PETSc.Sys.getVersion())), "BSD-2-Clause", INTEGRATORS, run)
