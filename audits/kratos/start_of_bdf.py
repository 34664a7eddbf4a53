"""Kratos's BDF2 starts from copies of the initial state, so motion that starts with a velocity is of first order.

Manual: kratos/solving_strategies/schemes/residual_based_bdf_scheme.h, description of the class: "a two step n order
accurate method".
Source, Kratos 10.4.4, KratosMultiphysics/auxiliary_solver_utilities.py:51-74, SetAndFillBuffer, which the structural
solver calls (structural_mechanics_solver.py:410-415): it "sets all historical nodal solution step data to the current
value", the displacements before t = 0 among them, from which the scheme finds its velocities. No smaller step, lower
order or other scheme begins the motion. The cure for a user is a history of the motion before t = 0.

Integrators, by their names in the report: bdf2_copied_start.
"""

import math

import KratosMultiphysics as kratos
import KratosMultiphysics.StructuralMechanicsApplication as structures
from KratosMultiphysics.auxiliary_solver_utilities import SetAndFillBuffer

kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)
T = 2.0


def error(dt: float, u0: float, v0: float, history: bool) -> float:
    """Error of u at T of u'' + u = 0 from u0 and v0, with the motion before t = 0 or as the program fills its rows."""
    owner = kratos.Model()
    part = owner.CreateModelPart("oscillator")
    for variable in (kratos.DISPLACEMENT, kratos.VELOCITY, kratos.ACCELERATION, kratos.VOLUME_ACCELERATION):
        part.AddNodalSolutionStepVariable(variable)
    part.AddNodalSolutionStepVariable(kratos.REACTION)
    part.ProcessInfo[kratos.DOMAIN_SIZE] = 3
    node = part.CreateNewNode(1, 0.0, 0.0, 0.0)
    for variable in (kratos.DISPLACEMENT_X, kratos.DISPLACEMENT_Y, kratos.DISPLACEMENT_Z):
        node.AddDof(variable)
    node.Fix(kratos.DISPLACEMENT_Y)
    node.Fix(kratos.DISPLACEMENT_Z)
    element = part.CreateNewElement("NodalConcentratedElement3D1N", 1, [1], part.CreateNewProperties(1))
    element.SetValue(kratos.NODAL_MASS, 1.0)
    element.SetValue(structures.NODAL_DISPLACEMENT_STIFFNESS, [1.0, 0.0, 0.0])
    node.SetSolutionStepValue(kratos.DISPLACEMENT_X, 0, u0)
    node.SetSolutionStepValue(kratos.VELOCITY_X, 0, v0)
    node.SetSolutionStepValue(kratos.ACCELERATION_X, 0, -u0)
    SetAndFillBuffer(part, 3, dt)
    if history:
        for row in range(3):
            cosine, sine = math.cos(row * dt), math.sin(row * dt)  # of the motion at -row dt
            u, v = u0 * cosine - v0 * sine, u0 * sine + v0 * cosine
            node.SetSolutionStepValue(kratos.DISPLACEMENT_X, row, u)
            node.SetSolutionStepValue(kratos.VELOCITY_X, row, v)
            node.SetSolutionStepValue(kratos.ACCELERATION_X, row, -u)
    solver = kratos.ResidualBasedBlockBuilderAndSolver(kratos.SkylineLUFactorizationSolver())
    scheme = kratos.ResidualBasedBDFDisplacementScheme(2)
    strategy = kratos.ResidualBasedLinearStrategy(part, scheme, solver, False, False, False, False)
    strategy.SetEchoLevel(0)
    strategy.Initialize()
    for i in range(1, round(T / dt) + 1):
        part.CloneTimeStep(i * dt)
        part.ProcessInfo[kratos.STEP] += 1
        strategy.Solve()
    return abs(node.GetSolutionStepValue(kratos.DISPLACEMENT_X, 0) - u0 * math.cos(T) - v0 * math.sin(T))


for u0, v0, history in ((0.0, 1.0, False), (1.0, 0.0, False), (0.0, 1.0, True), (1.0, 0.0, True)):
    errors = [error(dt, u0, v0, history) for dt in (0.02, 0.01, 0.005)]
    print(f"from u = {u0:g}, v = {v0:g}, {'the motion before' if history else 'SetAndFillBuffer'}: errors", end=" ")
    print(*(f"{e:.1e}" for e in errors), f"order {math.log2(errors[1] / errors[2]):.2f}, expected 2")
