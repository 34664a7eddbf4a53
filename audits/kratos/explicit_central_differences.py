"""Kratos's explicit central differences: values of two instants side by side, and which load a step takes.

Source, StructuralMechanicsApplication (10.4.4 of the Python package index behaves so),
custom_strategies/custom_schemes/ explicit_central_differences_scheme.hpp, UpdateTranslationalDegreesOfFreedom: from
the balance at t(n) it writes the velocity of t(n), the middle velocity, and the displacement of t(n+1) = t(n) + dt
into one row of the nodal data, whose TIME is t(n+1): velocity and acceleration stand a step behind the displacement.
The residual of that balance, of the displacement of t(n), is formed in the same call, so a load that was set at the
beginning of the step to its value at TIME, as AnalysisStage's processes do, is that of t(n+1): forced motion is of
first order. Damping takes the velocity that is in the nodal data, that of t(n-1): damped motion is of first order,
too.

Integrators, by their names in the report: explicit_central_differences.
"""

import math

import KratosMultiphysics as kratos
import KratosMultiphysics.StructuralMechanicsApplication as structures
import numpy as np

kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)


def march(dt: float, n: int, load, damping: float, behind: float) -> np.ndarray:
    """Rows (u, v, a) of u'' + damping u' + u = load from u(0) = 1, v(0) = 0, the load taken `behind` before TIME."""
    owner = kratos.Model()
    part = owner.CreateModelPart("oscillator")
    for variable in (kratos.DISPLACEMENT, kratos.VELOCITY, kratos.ACCELERATION, kratos.VOLUME_ACCELERATION):
        part.AddNodalSolutionStepVariable(variable)
    for variable in (kratos.NODAL_MASS, kratos.FORCE_RESIDUAL, kratos.RESIDUAL_VECTOR, structures.MIDDLE_VELOCITY):
        part.AddNodalSolutionStepVariable(variable)
    part.SetBufferSize(2)
    part.ProcessInfo[kratos.DOMAIN_SIZE] = 3
    node = part.CreateNewNode(1, 0.0, 0.0, 0.0)
    for variable in (kratos.DISPLACEMENT_X, kratos.DISPLACEMENT_Y, kratos.DISPLACEMENT_Z):
        node.AddDof(variable)
    node.Fix(kratos.DISPLACEMENT_Y)
    node.Fix(kratos.DISPLACEMENT_Z)
    element = part.CreateNewElement("NodalConcentratedDampedElement3D1N", 1, [1], part.CreateNewProperties(1))
    element.SetValue(kratos.NODAL_MASS, 1.0)
    element.SetValue(structures.NODAL_DISPLACEMENT_STIFFNESS, [1.0, 0.0, 0.0])
    element.SetValue(structures.NODAL_DAMPING_RATIO, [damping, 0.0, 0.0])
    scheme = structures.ExplicitCentralDifferencesScheme(1.0, 1.0, 0.0)
    strategy = structures.MechanicalExplicitStrategy(part, scheme, False, False, False)
    strategy.SetRebuildLevel(0)
    strategy.SetEchoLevel(0)
    part.ProcessInfo[kratos.TIME] = -dt
    part.CloneTimeStep(0.0)
    node.SetSolutionStepValue(kratos.DISPLACEMENT_X, 0, 1.0)
    strategy.Initialize()
    rows = []
    for i in range(1, n + 1):
        part.CloneTimeStep(i * dt)
        node.SetSolutionStepValue(kratos.VOLUME_ACCELERATION_X, 0, load(i * dt - behind))
        strategy.InitializeSolutionStep()
        strategy.SolveSolutionStep()
        strategy.FinalizeSolutionStep()
        values = kratos.DISPLACEMENT_X, kratos.VELOCITY_X, kratos.ACCELERATION_X
        rows.append([node.GetSolutionStepValue(variable, 0) for variable in values])
    return np.array(rows)


def order(errors: list[float]) -> str:
    """Errors under halved steps, and the order from the last two."""
    return " ".join(f"{e:.1e}" for e in errors) + f", order {math.log2(errors[1] / errors[2]):.2f}, expected 2"


steps = (0.02, 0.01, 0.005)
dt = 0.01
rows = march(dt, 100, lambda t: 0.0, 0.0, 0.0)
t = dt * np.arange(1, 101)
print(
    f"free vibration cos t, dt = {dt}: largest error of v against -sin at TIME {abs(rows[:, 1] + np.sin(t)).max():.1e},"
)
print(
    f"  at TIME - dt {abs(rows[:, 1] + np.sin(t - dt)).max():.1e}; of a {abs(rows[:, 2] + np.cos(t)).max():.1e},",
    end=" ",
)
print(f"{abs(rows[:, 2] + np.cos(t - dt)).max():.1e}")
for name, behind in (("at TIME", 0.0), ("at TIME - dt", 1.0)):
    # the motion under sin 2t is cos t + (2 sin t - sin 2t)/3
    exact = math.cos(2.0) + (2 * math.sin(2.0) - math.sin(4.0)) / 3
    errors = [abs(march(h, round(2 / h), lambda t: math.sin(2 * t), 0.0, behind * h)[-1, 0] - exact) for h in steps]
    print(f"undamped, load sin 2t taken {name}: errors {order(errors)}")
rate = math.sqrt(1 - 0.1**2)
exact = math.exp(-0.2) * (math.cos(2 * rate) + 0.1 / rate * math.sin(2 * rate))
errors = [abs(march(h, round(2 / h), lambda t: 0.0, 0.2, 0.0)[-1, 0] - exact) for h in steps]
print(f"damped, xi = 0.1, no load: errors {order(errors)}")
