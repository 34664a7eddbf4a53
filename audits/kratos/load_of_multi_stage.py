"""Kratos's explicit two-stage scheme of Kim: both stages of a step take one and the same load.

Source, StructuralMechanicsApplication (10.4.4 of the Python package index behaves so),
custom_strategies/custom_schemes/ explicit_multi_stage_kim_scheme.hpp, Update: it moves the displacement to t(n) plus
fraction_delta_time of a step and calls CalculateAndAddRHS, then to t(n+1) and calls it again, without a change of TIME
and without a call that would set the load anew. A load that was set at the beginning of the step to its value at TIME,
as AnalysisStage's processes do, is therefore that of t(n+1) in the first stage, too, which stands at t(n) plus the
fraction: forced motion is of first order. Without a load the same steps are of fourth order where there is no damping,
as the scheme's paper has it (W. Kim, Int. J. Numer. Methods Eng. 120 (2019) 1-28, fraction 1/3), and a user who sets
the load of the middle of each step gets second order.

Integrators, by their names in the report: explicit_multi_stage.
"""

import math

import KratosMultiphysics as kratos
import KratosMultiphysics.StructuralMechanicsApplication as structures

kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)


def march(dt: float, n: int, load, behind: float) -> float:
    """Last u of u'' + u = load from u(0) = 1, v(0) = 0, where a step has the load of `behind` before its TIME."""
    owner = kratos.Model()
    part = owner.CreateModelPart("oscillator")
    for variable in (kratos.DISPLACEMENT, kratos.VELOCITY, kratos.ACCELERATION, kratos.VOLUME_ACCELERATION):
        part.AddNodalSolutionStepVariable(variable)
    for variable in (kratos.NODAL_MASS, kratos.FORCE_RESIDUAL, kratos.RESIDUAL_VECTOR, structures.MIDDLE_VELOCITY):
        part.AddNodalSolutionStepVariable(variable)
    part.AddNodalSolutionStepVariable(structures.FRACTIONAL_ACCELERATION)
    part.SetBufferSize(3)
    part.ProcessInfo[kratos.DOMAIN_SIZE] = 3
    node = part.CreateNewNode(1, 0.0, 0.0, 0.0)
    for variable in (kratos.DISPLACEMENT_X, kratos.DISPLACEMENT_Y, kratos.DISPLACEMENT_Z):
        node.AddDof(variable)
    node.Fix(kratos.DISPLACEMENT_Y)
    node.Fix(kratos.DISPLACEMENT_Z)
    element = part.CreateNewElement("NodalConcentratedDampedElement3D1N", 1, [1], part.CreateNewProperties(1))
    element.SetValue(kratos.NODAL_MASS, 1.0)
    element.SetValue(structures.NODAL_DISPLACEMENT_STIFFNESS, [1.0, 0.0, 0.0])
    element.SetValue(structures.NODAL_DAMPING_RATIO, [0.0, 0.0, 0.0])
    strategy = structures.MechanicalExplicitStrategy(
        part, structures.ExplicitMultiStageKimScheme(1.0 / 3.0), False, False, False
    )
    strategy.SetRebuildLevel(0)
    strategy.SetEchoLevel(0)
    part.ProcessInfo[kratos.TIME] = -dt
    part.CloneTimeStep(0.0)
    node.SetSolutionStepValue(kratos.DISPLACEMENT_X, 0, 1.0)
    node.SetSolutionStepValue(kratos.ACCELERATION_X, 0, load(0.0) - 1.0)
    node.SetSolutionStepValue(kratos.VOLUME_ACCELERATION_X, 0, load(0.0))
    strategy.Initialize()
    for i in range(1, n + 1):
        part.CloneTimeStep(i * dt)
        node.SetSolutionStepValue(kratos.VOLUME_ACCELERATION_X, 0, load(i * dt - behind))
        strategy.InitializeSolutionStep()
        strategy.Predict()
        strategy.SolveSolutionStep()
        strategy.FinalizeSolutionStep()
    return node.GetSolutionStepValue(kratos.DISPLACEMENT_X, 0)


def order(errors: list[float]) -> str:
    """Errors under halved steps, and the order from the last two."""
    return " ".join(f"{e:.1e}" for e in errors) + f", order {math.log2(errors[1] / errors[2]):.2f}"


steps = (0.08, 0.04, 0.02)
free = [abs(march(h, round(2 / h), lambda t: 0.0, 0.0) - math.cos(2.0)) for h in steps]
print(f"no load: errors {order(free)}")
# the motion under sin 2t is cos t + (2 sin t - sin 2t)/3
exact = math.cos(2.0) + (2 * math.sin(2.0) - math.sin(4.0)) / 3
for name, behind in (("at TIME", 0.0), ("at TIME - dt/2", 0.5)):
    forced = [abs(march(h, round(2 / h), lambda t: math.sin(2 * t), behind * h) - exact) for h in steps]
    print(f"load sin 2t set once a step to its value {name}: errors {order(forced)}")
