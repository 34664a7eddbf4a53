"""fedoo: its implicit and explicit integrators of second order, on one plane element that is held at one side.

Both nodes of the free side move alike, so there is one oscillator; the density makes its mass one, for the consistent
mass of the implicit problem and for the lumped one of the explicit problem. The load is a boundary condition that is
set before each step to its value at the end of the step, where the manual has it.
"""

import warnings
from importlib.metadata import version
from typing import Any

import numpy as np
from adapter import Integrator, serve
from quiet import printing_aside

with printing_aside(), warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import fedoo

PLACE = "docstring of fedoo.time.{}"
DEFAULTS = "Their second-order defaults follow the generalized-alpha relations"
CENTRAL = "This is the explicit Newmark specialization beta=0 and gamma=1/2 without generalized-alpha filtering"


def described(name: str, quotation: str, arguments: dict[str, float], sets: str = "uva", **values: Any) -> Integrator:
    """An integrator of fedoo.time with its arguments."""
    claims = {key: (value, quotation, PLACE.format(name)) for key, value in values.items()}
    return Integrator(
        arguments={"integrator": name, **arguments},
        sets=sets,
        load="each step",
        digits=14.0,
        claims=claims,
    )


MIDDLE = "The internal force, stiffness, and damping are evaluated at the generalized mid-points t_{n+1-alpha_f}"
INTEGRATORS = {
    "Newmark": described(
        "Newmark", "Newmark-beta time integrator", {"beta": 0.25, "gamma": 0.5}, scheme="newmark", beta=0.25, gamma=0.5
    ),
    "Newmark_damped": described(
        "Newmark",
        "Newmark-beta time integrator",
        {"beta": 0.3025, "gamma": 0.6},
        scheme="newmark",
        beta=0.3025,
        gamma=0.6,
    ),
    "GeneralizedAlpha": described(
        "GeneralizedAlpha", MIDDLE, {"alpha_m": -0.1, "alpha_f": 0.2}, scheme="generalized_alpha"
    ),
    "GeneralizedAlpha_hht": described(
        "GeneralizedAlpha", MIDDLE, {"alpha_m": 0.0, "alpha_f": 0.1}, scheme="hht_alpha", alpha=-0.1
    ),
    "CentralDifference": described("CentralDifference", CENTRAL, {}, sets="uv", scheme="newmark", beta=0.0, gamma=0.5),
    "ExplicitNewmark": described("ExplicitNewmark", DEFAULTS, {}, sets="uv", order=2),
    "ExplicitGeneralizedAlpha": described(
        "ExplicitGeneralizedAlpha", DEFAULTS, {"alpha_m": -0.1, "alpha_f": 0.2}, sets="uv", order=2
    ),
}
LUMPED, CONSISTENT = 2.0, 3.0  # densities of a unit mass at the free side


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    """Histories of the free side; the first acceleration, if none is given, is that of the balance."""
    parameters = dict(arguments)
    kind = getattr(fedoo.time, parameters.pop("integrator"))(**parameters)
    explicit = integrator.startswith(("Central", "Explicit"))
    fedoo.ModelingSpace("2Dstress")
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    mesh = fedoo.Mesh(corners, np.array([[0, 1, 2, 3]]), "quad4", name="square")
    material = fedoo.constitutivelaw.ElasticIsotrop(omega**2, 0.0, name="material")
    material.set_density(LUMPED if explicit else CONSISTENT)
    form = fedoo.weakform.StressEquilibrium(material, name="form")
    if xi:
        form.set_dissipation(fedoo.time.RayleighDamping(2 * xi * omega, 0.0))
    assembly = fedoo.Assembly.create(form, mesh, name="assembly")
    if explicit:
        problem = fedoo.problem.ExplicitDynamic(assembly, dt, kind)
    else:
        problem = fedoo.problem.Linear(assembly, time_step=dt)
        problem.set_time_integrator("second_order", kind)
    problem.bc.add("Dirichlet", [0, 3], "DispX", 0)
    problem.bc.add("Dirichlet", [0, 1, 2, 3], "DispY", 0)
    force = problem.bc.add("Neumann", [1, 2], "DispX", 0.0)
    free = np.array([0.0, 1.0, 1.0, 0.0])
    start = load.at(0.0) - 2 * xi * omega * v0 - omega**2 * u0 if a0 is None else a0
    problem.set_initial_displacement("DispX", u0 * free)
    problem.set_initial_velocity("DispX", v0 * free)
    problem.set_initial_acceleration("DispX", start * free)
    rows = [(u0, v0, start)]
    for i in range(1, n + 1):
        problem.bc.remove(force)
        force = problem.bc.add("Neumann", [1, 2], "DispX", load(i * dt) / 2)
        problem.solve_time_increment()
        outputs = problem.get_disp, problem.get_velocity, problem.get_acceleration
        rows.append(tuple(float(output("DispX")[1]) for output in outputs))
    return tuple(zip(*rows, strict=True))


if __name__ == "__main__":
    serve("fedoo", version("fedoo"), "GPL-3.0", INTEGRATORS, run)
