"""GetFEM: its time integration schemes of second order, on one element whose field is constant.

The inertia, damping and stiffness are mass bricks of the variable and its time derivatives, the load is a source term
whose value is set before each step to that at the end of the step.
"""

import subprocess
from typing import Any

import getfem
import numpy as np
from adapter import Integrator, serve

PLACE = "docstring of getfem.Model.add_{}"
THETA = "Attach a theta method for the time discretization of the variable"
HOUBOLT = "Attach a Houbolt method for the time discretization of the variable"


def theta(value: float) -> Integrator:
    """The theta method for the displacement and the velocity alike."""
    name = "theta_method_for_second_order"
    claims: dict[str, tuple[Any, str, str]] = {"scheme": ("theta", THETA, PLACE.format(name))}
    return Integrator(arguments={"kind": name, "theta": value}, sets="uva", load="each step", claims=claims)


def newmark(beta: float, gamma: float) -> Integrator:
    """Newmark's method; GetFEM's description of it is that of the theta method, and its arguments are beta, gamma."""
    name = "Newmark_scheme"
    values = {"scheme": "newmark", "beta": beta, "gamma": gamma}
    claims = {
        key: (value, "add_Newmark_scheme(varname, beta, gamma)", PLACE.format(name)) for key, value in values.items()
    }
    arguments = {"kind": name, "beta": beta, "gamma": gamma}
    return Integrator(arguments=arguments, sets="uva", load="each step", claims=claims)


INTEGRATORS = {
    "newmark": newmark(0.25, 0.5),
    "newmark_damped": newmark(0.3025, 0.6),
    "theta_half": theta(0.5),
    "theta_0.6": theta(0.6),
    "theta_1": theta(1.0),
    "houbolt": Integrator(
        arguments={"kind": "Houbolt_scheme"},
        history=2,
        load="each step",
        claims={"scheme": ("houbolt", HOUBOLT, PLACE.format("Houbolt_scheme"))},
    ),
}


def version() -> str:
    """The version of Debian's package: the module does not tell its own."""
    query = ["dpkg-query", "--show", "--showformat=${Version}", "python3-getfem"]
    return subprocess.run(query, capture_output=True, text=True, check=True).stdout.split("+")[0]


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load, before=None):
    """Histories of the variable and of its derivatives; the first acceleration, if none is given, is the balance's."""
    values = dict(arguments)
    kind = values.pop("kind")
    mesh = getfem.Mesh("cartesian", np.array([0.0, 1.0]))
    field = getfem.MeshFem(mesh, 1)
    field.set_fem(getfem.Fem("FEM_PK(1,0)"))
    integration = getfem.MeshIm(mesh, getfem.Integ("IM_GAUSS1D(3)"))
    model = getfem.Model("real")
    model.add_fem_variable("u", field)
    model.add_initialized_data("c", [2 * xi * omega])
    model.add_initialized_data("k", [omega**2])
    model.add_initialized_data("f", [0.0])
    getattr(model, f"add_{kind}")("u", *values.values())
    model.add_mass_brick(integration, "Dot2_u")
    model.add_mass_brick(integration, "Dot_u", "c")
    model.add_mass_brick(integration, "u", "k")
    model.add_source_term_brick(integration, "u", "f")
    model.set_time_step(dt)
    start = load.at(0.0) - 2 * xi * omega * v0 - omega**2 * u0 if a0 is None else a0
    if kind == "Houbolt_scheme":
        assert before is not None
        initial = {"Previous_u": u0, "Previous2_u": before[0][0], "Previous3_u": before[1][0]}
    else:
        initial = {"Previous_u": u0, "Previous_Dot_u": v0, "Previous_Dot2_u": start}
    for name, value in initial.items():
        model.set_variable(name, [value])
    rows = [(u0, v0, start)]
    for i in range(1, n + 1):
        model.set_variable("f", [load(i * dt)])
        model.solve()
        rows.append(tuple(float(np.ravel(model.variable(name))[0]) for name in ("u", "Dot_u", "Dot2_u")))
        model.shift_variables_for_time_integration()
    return tuple(zip(*rows, strict=True))


if __name__ == "__main__":
    serve("GetFEM", version(), "LGPL-3.0-or-later", INTEGRATORS, run)
