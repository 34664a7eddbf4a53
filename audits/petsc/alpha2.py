"""PETSc 3.18's TSALPHA2 starts with twice the acceleration, and solves problems that are declared linear wrongly.

Source, PETSc v3.18.5, src/ts/impls/implicit/alpha/alpha2.c.
First acceleration: TSAlpha_Restart sets ts->time_step to half the step (line 129) and finds the acceleration at the
start from two half steps, (-3 V0 + 4 V1 - V2) / ts->time_step (lines 160-162); that formula is divided by the whole
step. Later versions divide by time_step, which is the whole one. With a radius of 1 the first acceleration has no
effect; below it the solution is of first order, though TSAlpha2SetRadius chooses parameters for which
TSAlpha2SetParams states "Second-order accuracy" (line 589). alpha1.c, for first-order systems,
does likewise (lines 111 and 138-140; "Second-order accuracy", line 517).
Linear problems: TSStep_Alpha (line 219) solves for X1 and then takes V1 (line 226), which TSAlpha_StageVecs computes
only when SNES evaluates the function (line 345). SNESKSPONLY, which TSSetProblemType(TS_LINEAR) selects, does not
evaluate the function at its solution, so V1 is that of the guess.

Integrators, by their names in the report: alpha2_0.6, alpha2_0, alpha.
"""

import math

import numpy as np
import petsc4py

petsc4py.init([])

from petsc4py import PETSc  # noqa: E402


def march(dt: float, n: int, radius: float, linear: bool) -> np.ndarray:
    """Rows (u, v) of u'' + u = 0 from u = 1, v = 0.3."""

    def balance(ts, t, u, v, a, residual):
        residual[0] = a[0] + u[0]
        residual.assemble()

    def slope(ts, t, u, v, a, shift_v, shift_a, matrix, same):
        matrix[0, 0] = shift_a + 1.0
        matrix.assemble()

    options = PETSc.Options()
    options["ts_adapt_type"] = "none"
    options["ts_alpha_radius"] = radius
    options["snes_rtol"] = 1e-14
    options["snes_max_it"] = 3
    options["ksp_type"] = "preonly"
    options["pc_type"] = "lu"
    ts = PETSc.TS().create(comm=PETSc.COMM_SELF)
    ts.setType("alpha2")
    if linear:
        ts.setProblemType(PETSc.TS.ProblemType.LINEAR)
    matrix = PETSc.Mat().createDense([1, 1])
    matrix.setUp()
    ts.setI2Function(balance, PETSc.Vec().createSeq(1))
    ts.setI2Jacobian(slope, matrix, matrix)
    ts.setTime(0.0)
    ts.setTimeStep(dt)
    ts.setMaxSteps(n)
    ts.setMaxTime(1e9)
    ts.setExactFinalTime(PETSc.TS.ExactFinalTime.STEPOVER)
    ts.setFromOptions()
    u, v = PETSc.Vec().createSeq(1), PETSc.Vec().createSeq(1)
    u[0], v[0] = 1.0, 0.3
    ts.setSolution2(u, v)
    rows = [(1.0, 0.3)]
    for _ in range(n):
        ts.step()
        rows.append((u[0], v[0]))
    return np.array(rows)


def march_first_order(dt: float, n: int, radius: float) -> float:
    """u after n steps of the same motion by alpha, as two equations of first order."""

    def balance(ts, t, y, rate, residual):
        residual[0], residual[1] = rate[0] - y[1], rate[1] + y[0]
        residual.assemble()

    def slope(ts, t, y, rate, shift, matrix, same):
        matrix[0, 0], matrix[0, 1], matrix[1, 0], matrix[1, 1] = shift, -1.0, 1.0, shift
        matrix.assemble()

    PETSc.Options()["ts_alpha_radius"] = radius
    ts = PETSc.TS().create(comm=PETSc.COMM_SELF)
    ts.setType("alpha")
    matrix = PETSc.Mat().createDense([2, 2])
    matrix.setUp()
    ts.setIFunction(balance, PETSc.Vec().createSeq(2))
    ts.setIJacobian(slope, matrix, matrix)
    ts.setTimeStep(dt)
    ts.setMaxSteps(n)
    ts.setMaxTime(1e9)
    ts.setExactFinalTime(PETSc.TS.ExactFinalTime.STEPOVER)
    ts.setFromOptions()
    y = PETSc.Vec().createSeq(2)
    y[0], y[1] = 1.0, 0.3
    ts.setSolution(y)
    for _ in range(n):
        ts.step()
    return y[0]


def first(dt: float, rho: float, a: float) -> float:
    """Velocity after one step of the generalized alpha method that starts with acceleration a."""
    alpha_m, alpha_f = (2 - rho) / (1 + rho), 1 / (1 + rho)
    gamma, beta = 0.5 + alpha_m - alpha_f, (1 + alpha_m - alpha_f) ** 2 / 4
    predicted = 1 + dt * 0.3 + dt**2 * (0.5 - beta) * a
    force = (1 - alpha_f) * 1 + alpha_f * predicted
    new = (-(1 - alpha_m) * a - force) / (alpha_m + alpha_f * beta * dt**2)
    return 0.3 + dt * ((1 - gamma) * a + gamma * new)


print("PETSc", ".".join(map(str, PETSc.Sys.getVersion())))
for dt in (0.1, 0.01):
    v = march(dt, 1, 0.6, False)[1, 1]
    low, high = first(dt, 0.6, 0.0), first(dt, 0.6, 1.0)
    shown = (v - low) / (high - low)
    print(f"radius 0.6, step {dt}: first acceleration that the first step shows {shown:.6f}, expected -1")
exact = math.cos(2.0) + 0.3 * math.sin(2.0)
for linear in (False, True):
    for radius in (1.0, 0.6):
        errors = [abs(march(dt, round(2 / dt), radius, linear)[-1, 0] - exact) for dt in (0.02, 0.01, 0.005)]
        print(
            f"declared {'linear' if linear else 'nonlinear'}, radius {radius}: errors",
            *(f"{e:.1e}" for e in errors),
            end="",
        )
        print(f", order {math.log2(errors[1] / errors[2]):.2f}, expected 2")
for radius in (1.0, 0.6):
    errors = [abs(march_first_order(dt, round(2 / dt), radius) - exact) for dt in (0.02, 0.01, 0.005)]
    print(f"alpha, of first order, radius {radius}: errors", *(f"{e:.1e}" for e in errors), end="")
    print(f", order {math.log2(errors[1] / errors[2]):.2f}, expected 2")
