"""Akantu: the integration schemes of its solid mechanics model, on one bar element that is held at one end.

Bars have no damping, so the oscillator is undamped; the density makes the mass of the free end one, for the consistent
mass and for the lumped one that the explicit analysis takes. The external force is set before each step to its value at
the end of the step.
"""

import tempfile
from importlib.metadata import version
from pathlib import Path
from typing import Any

from adapter import Integrator, serve
from quiet import printing_aside

with printing_aside():
    import akantu

MESH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
2
1 0 0 0
2 1 0 0
$EndNodes
$Elements
1
1 1 2 1 1 1 2
$EndElements
"""
PLACE = "name of akantu.{}"


def scheme(kind: str, beta: float, unknown: str = "_acceleration") -> Integrator:
    """One of the schemes that setIntegrationScheme takes, solved for accelerations or displacements."""
    place = PLACE.format("IntegrationSchemeType")
    claims = {name: (value, kind, place) for name, value in {"scheme": "newmark", "beta": beta, "gamma": 0.5}.items()}
    arguments = {"scheme_type": kind, "solution_type": unknown}
    return Integrator(arguments=arguments, sets="uva", load="each step", damping=False, claims=claims)


def analysis(method: str, name: str) -> Integrator:
    """One of the program's own choices of scheme, solver and mass."""
    claims: dict[str, tuple[Any, str, str]] = {"scheme": (name, method, PLACE.format("AnalysisMethod"))}
    return Integrator(
        arguments={"analysis_method": method},
        sets="uva",
        load="each step",
        damping=False,
        digits=14.0,
        claims=claims,
    )


INTEGRATORS = {
    "explicit_lumped_mass": analysis("_explicit_lumped_mass", "central_difference"),
    "explicit_consistent_mass": analysis("_explicit_consistent_mass", "central_difference"),
    "trapezoidal_rule_2": scheme("trapezoidal_rule_2", 1 / 4),
    "trapezoidal_rule_2_displacement": scheme("trapezoidal_rule_2", 1 / 4, "_displacement"),
    "linear_acceleration": scheme("linear_acceleration", 1 / 6),
    "fox_goodwin": scheme("fox_goodwin", 1 / 12),
    "newmark_beta": Integrator(
        arguments={"scheme_type": "newmark_beta", "solution_type": "_acceleration"},
        sets="uva",
        load="each step",
        damping=False,
    ),
}
LUMPED, CONSISTENT = 2.0, 3.0  # densities of a unit mass at the free end


def bar(folder: Path, omega: float, density: float) -> Any:
    """The mesh, which must outlive its model, and the model, from files: so Akantu takes meshes and materials."""
    (folder / "bar.msh").write_text(MESH)
    (folder / "bar.dat").write_text(
        f"material elastic [\n name = bar\n rho = {density}\n E = {omega**2!r}\n nu = 0.\n]\n"
    )
    akantu.parseInput(str(folder / "bar.dat"))
    mesh = akantu.Mesh(1)
    mesh.read(str(folder / "bar.msh"))
    return mesh, akantu.SolidMechanicsModel(mesh)


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    """Histories of the free end; the first acceleration, which the program leaves as it is, is that of the balance."""
    if xi != 0:
        raise ValueError(f"expected no damping, got xi = {xi}")
    method = arguments.get("analysis_method")
    with tempfile.TemporaryDirectory() as folder:
        _mesh, model = bar(Path(folder), omega, LUMPED if method == "_explicit_lumped_mass" else CONSISTENT)
        solver = ""
        if method:
            model.initFull(_analysis_method=getattr(akantu, method))
        else:
            model.initFull(_analysis_method=akantu._static)
            solver = "own"
            model.getNewSolver(solver, akantu.TimeStepSolverType.dynamic, akantu.NonLinearSolverType.linear)
            kind = getattr(akantu.IntegrationSchemeType, arguments["scheme_type"])
            unknown = akantu.IntegrationScheme.SolutionType.__members__[arguments["solution_type"]]
            model.setIntegrationScheme(solver, "displacement", kind, unknown)
    model.getMaterial(0).setReal("E", omega**2)
    model.setTimeStep(dt, solver)
    model.getBlockedDOFs()[0, 0] = True
    u, v, a = model.getDisplacement(), model.getVelocity(), model.getAcceleration()
    force = model.getExternalForce()
    u[1, 0], v[1, 0] = u0, v0
    a[1, 0] = load.at(0.0) - omega**2 * u0 if a0 is None else a0
    rows = [(u0, v0, float(a[1, 0]))]
    for i in range(1, n + 1):
        force[1, 0] = load(i * dt)
        model.solveStep(solver)
        rows.append((float(u[1, 0]), float(v[1, 0]), float(a[1, 0])))
    return tuple(zip(*rows, strict=True))


if __name__ == "__main__":
    serve("Akantu", version("akantu"), "LGPL-3.0-or-later", INTEGRATORS, run)
