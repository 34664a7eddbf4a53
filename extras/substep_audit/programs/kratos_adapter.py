"""Kratos Multiphysics with its application to structural mechanics: implicit schemes, BDF and two explicit ones.

The oscillator is a concentrated element, whose nodal damping is c itself; the load is the node's volume acceleration,
set before each step to its value at the end of the step, which is when the program's own processes set it.
"""

from importlib.metadata import version
from typing import Any

from adapter import Integrator, serve
from quiet import printing_aside

with printing_aside():
    import KratosMultiphysics as kratos
    import KratosMultiphysics.StructuralMechanicsApplication as structures

kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)

CORE = "kratos/solving_strategies/schemes/{}"
BOSSAK = "The Bossak Alpha parameter ranges from 0 to -0.5, and introduces damping"
NEWMARK = "A Bossak parameter (Alpha) of 0 results in the Newmark method"
STEPS = "The n order Backward Differentiation Formula (BDF) method is a two step n order accurate method"
Claims = dict[str, tuple[Any, str, str]]


def claims(place: str, quotation: str, **values: Any) -> Claims:
    """Claims with one quotation from the description of a class."""
    return {name: (value, quotation, place) for name, value in values.items()}


def bossak(alpha: float, beta: float, structural: bool = False) -> Integrator:
    """Bossak's method of the core, or the one that the structural solver uses for "newmark" and "bossak"."""
    place = CORE.format("residual_based_bossak_displacement_scheme.hpp, description of the class")
    arguments = {"damp_factor_m": alpha, "newmark_beta": beta} | ({"structural": True} if structural else {})
    said = claims(place, NEWMARK, scheme="newmark")
    if alpha != 0:
        said = claims(place, BOSSAK, scheme="wbz_alpha", alpha_B=alpha)
    return Integrator(arguments=arguments, sets="uva", load="each step", claims=said)


def bdf(order: int, history: int) -> Integrator:
    """Backward differences, from so many states of the motion before t = 0, or else from copies of the first one."""
    place = CORE.format("residual_based_bdf_scheme.h, description of the class")
    said = claims(place, STEPS, scheme=f"bdf{order}", order=order)
    return Integrator(arguments={"order": order}, history=history, load="each step", claims=said)


CENTRAL = "custom_schemes/explicit_central_differences_scheme.hpp, description of the class"
INTEGRATORS = {
    "newmark": Integrator(
        sets="uva",
        load="each step",
        claims=claims(
            CORE.format("residual_based_newmark_displacement_scheme.hpp"),
            "a dynamic implicit scheme based of the Newmark algorithm for displacements",
            scheme="newmark",
        ),
    ),
    "bossak": bossak(-0.3, 0.25),
    "bossak_most": bossak(-0.5, 0.25),
    "structural_newmark": bossak(0.0, 0.25, structural=True),
    "structural_bossak": bossak(-0.3, 0.25, structural=True),
    **{f"bdf{order}": bdf(order, order - 1) for order in range(1, 7)},
    "bdf2_copied_start": bdf(2, 0),
    "explicit_central_differences": Integrator(
        late={"v": -1.0, "a": -1.0},
        load="each step",
        claims=claims(CENTRAL, "An explicit central difference scheme", scheme="central_difference"),
    ),
    "explicit_multi_stage": Integrator(
        arguments={"fraction_delta_time": 0.333333333333333333},
        load="each step",
        claims=claims("structural_mechanics_explicit_dynamic_solver.py", '"multi_stage"', scheme="kim_two_stage"),
    ),
}
STATE = (kratos.DISPLACEMENT_X, kratos.VELOCITY_X, kratos.ACCELERATION_X)


def model(owner: Any, omega: float, xi: float, rows: int) -> tuple[Any, Any]:
    """A model part of one node that is free in one direction, with so many rows of history."""
    part = owner.CreateModelPart("oscillator")
    for variable in (
        kratos.DISPLACEMENT,
        kratos.VELOCITY,
        kratos.ACCELERATION,
        kratos.VOLUME_ACCELERATION,
        kratos.REACTION,
        kratos.NODAL_MASS,
        kratos.FORCE_RESIDUAL,
        kratos.RESIDUAL_VECTOR,
        structures.MIDDLE_VELOCITY,
        structures.FRACTIONAL_ACCELERATION,
    ):
        part.AddNodalSolutionStepVariable(variable)
    part.SetBufferSize(rows)
    part.ProcessInfo[kratos.DOMAIN_SIZE] = 3
    node = part.CreateNewNode(1, 0.0, 0.0, 0.0)
    for variable in (kratos.DISPLACEMENT_X, kratos.DISPLACEMENT_Y, kratos.DISPLACEMENT_Z):
        node.AddDof(variable)
    node.Fix(kratos.DISPLACEMENT_Y)
    node.Fix(kratos.DISPLACEMENT_Z)
    element = part.CreateNewElement("NodalConcentratedDampedElement3D1N", 1, [1], part.CreateNewProperties(1))
    element.SetValue(kratos.NODAL_MASS, 1.0)
    element.SetValue(structures.NODAL_DISPLACEMENT_STIFFNESS, [omega**2, 0.0, 0.0])
    element.SetValue(structures.NODAL_DAMPING_RATIO, [2 * xi * omega, 0.0, 0.0])
    return part, node


def scheme(integrator: str, arguments: dict[str, Any]) -> Any:
    """The scheme of a name."""
    if integrator == "newmark":
        return kratos.ResidualBasedNewmarkDisplacementScheme()
    if integrator.startswith("bdf"):
        return kratos.ResidualBasedBDFDisplacementScheme(arguments["order"])
    if integrator == "explicit_central_differences":
        return structures.ExplicitCentralDifferencesScheme(1.0, 1.0, 0.0)
    if integrator == "explicit_multi_stage":
        return structures.ExplicitMultiStageKimScheme(arguments["fraction_delta_time"])
    alpha, beta = arguments["damp_factor_m"], arguments["newmark_beta"]
    if "structural" in arguments:
        given = kratos.Parameters('{"name": "bossak_scheme"}')
        given.AddDouble("damp_factor_m", alpha)
        given.AddDouble("newmark_beta", beta)
        return structures.StructuralMechanicsBossakScheme(given)
    return kratos.ResidualBasedBossakDisplacementScheme(alpha, beta)


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load, before=None):
    """Histories of the node's values, of which the explicit schemes' velocities and accelerations are a step old."""
    explicit = integrator.startswith("explicit")
    rows = arguments.get("order", 1)
    owner = kratos.Model()
    part, node = model(owner, omega, xi, max(rows + 1, 3))
    if explicit:
        strategy = structures.MechanicalExplicitStrategy(part, scheme(integrator, arguments), False, False, False)
        strategy.SetRebuildLevel(0)
    else:
        solver = kratos.ResidualBasedBlockBuilderAndSolver(kratos.SkylineLUFactorizationSolver())
        strategy = kratos.ResidualBasedLinearStrategy(
            part, scheme(integrator, arguments), solver, False, False, False, False
        )
    strategy.SetEchoLevel(0)
    start = (u0, v0, load.at(0.0) - 2 * xi * omega * v0 - omega**2 * u0 if a0 is None else a0)
    history = [start, *(before or [start] * (rows - 1))]
    part.ProcessInfo[kratos.TIME] = -rows * dt
    for i, values in enumerate(reversed(history), start=1 - rows):
        part.CloneTimeStep(i * dt)
        part.ProcessInfo[kratos.STEP] = i
        for variable, value in zip(STATE, values, strict=True):
            node.SetSolutionStepValue(variable, 0, value)
    node.SetSolutionStepValue(kratos.VOLUME_ACCELERATION_X, 0, load(0.0))
    strategy.Initialize()
    table = [start]
    for i in range(1, n + 1):
        part.CloneTimeStep(i * dt)
        part.ProcessInfo[kratos.STEP] = i
        node.SetSolutionStepValue(kratos.VOLUME_ACCELERATION_X, 0, load(i * dt))
        strategy.InitializeSolutionStep()
        strategy.Predict()
        strategy.SolveSolutionStep()
        strategy.FinalizeSolutionStep()
        table.append(tuple(node.GetSolutionStepValue(variable, 0) for variable in STATE))
    return tuple(zip(*table, strict=True))


if __name__ == "__main__":
    serve("Kratos Multiphysics", version("KratosMultiphysics"), "BSD-4-Clause", INTEGRATORS, run)
