"""SfePy: its elastodynamics solvers, on one unit square whose field is constant.

The terms are integrals of rho u'' v, c u' v and k u v less a volume load, which is a material function of time, as the
program's users write loads; the variables are declared by hand, since with the option auto_transform_equations the
program drops terms without an unknown, which loads are. With an approximation of order zero there is one degree of
freedom.
"""

import sys
from importlib.metadata import version
from typing import Any

import numpy as np
from adapter import Integrator, Load, serve
from quiet import printing_aside

with printing_aside():
    from sfepy.base.base import output
    from sfepy.base.conf import ProblemConf
    from sfepy.discrete import Problem
    from sfepy.discrete.fem.meshio import UserMeshIO
    from sfepy.mesh.mesh_generators import gen_block_mesh

output.set_output(quiet=True)
PLACE = "docstring of sfepy.solvers.ts_solvers.{}"
EQUIVALENT = "It is mathematically equivalent to the CentralDifferenceTS method"
ALPHA = "The method is second-order accurate provided gamma = 1/2 - alpha_m + alpha_f. This is used when gamma is None"
TABLE = "All of these methods are 2-order of accuracy"


def solver(kind: str, place: str, quotation: str, arguments: dict[str, Any] | None = None, **values: Any) -> Integrator:
    """A solver by its name in the program."""
    claims = {name: (value, quotation, PLACE.format(place)) for name, value in values.items()}
    return Integrator(arguments={"kind": kind} | (arguments or {}), claims=claims)


def newmark(beta: float, gamma: float = 0.5, **values: Any) -> Integrator:
    """Newmark's method, with the line of the program's table that belongs to it."""
    arguments = {"beta": beta, "gamma": gamma}
    return solver("newmark", "NewmarkTS", TABLE, arguments, scheme="newmark", beta=beta, gamma=gamma, **values)


def radius(rho: float) -> Integrator:
    """The generalized alpha method for a spectral radius."""
    values = {"scheme": "generalized_alpha", "rho_inf": rho, "order": 2}
    return solver("generalized_alpha", "GeneralizedAlphaTS", ALPHA, {"rho_inf": rho}, **values)


INTEGRATORS = {
    "velocity_verlet": solver("velocity_verlet", "VelocityVerletTS", EQUIVALENT, scheme="central_difference"),
    "central_difference": solver(
        "central_difference", "CentralDifferenceTS", "NewmarkTS with beta = 0, gamma = 1/2", scheme="newmark", beta=0.0
    ),
    "newmark_trapezoidal": newmark(1 / 4, order=2, unconditional=True),
    "newmark_linear": newmark(1 / 6, order=2, critical_Omega=12**0.5),
    "newmark_fox_goodwin": newmark(1 / 12, order=2, critical_Omega=6**0.5),
    "newmark_central": newmark(0.0, order=2, critical_Omega=2.0),
    "newmark_damped": newmark(0.3025, 0.6),
    "generalized_alpha_0.5": radius(0.5),
    "generalized_alpha_0": radius(0.0),
    "generalized_alpha_1": radius(1.0),
    "bathe": solver("bathe", "BatheTS", "Solve elastodynamics problems by the Bathe method", scheme="bathe"),
}


def problem(
    arguments: dict[str, Any], omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Load
) -> Any:
    """The declarative description of the oscillator and of its solver."""

    def mesh(mesh: Any, mode: str) -> Any:
        return gen_block_mesh([1.0, 1.0], [2, 2], [0.5, 0.5], name="square", verbose=False) if mode == "read" else None

    def force(ts: Any, coordinates: np.ndarray, mode: str | None = None, **others: Any) -> Any:
        if mode == "qp":
            return {"f": np.full((coordinates.shape[0], 1, 1), load(ts.time))}
        return None

    options = {name: value for name, value in arguments.items() if name != "kind"}
    names = {"u": "u", "du": "du", "ddu": "ddu"}
    time = {"t0": 0.0, "t1": n * dt, "n_step": n + 1, "is_linear": False, "var_names": names}
    description = {
        "filename_mesh": UserMeshIO(mesh),
        "regions": {"Omega": "all"},
        "materials": {"m": ({"rho": 1.0, "c": 2 * xi * omega, "k": omega**2},), "load": "force"},
        "functions": {"force": (force,)},
        "fields": {"displacement": ("real", "scalar", "Omega", 0)},
        "integrals": {"i": 1},
        "variables": {name: ("unknown field", "displacement", i) for i, name in enumerate(("u", "du", "ddu"))}
        | {test: ("test field", "displacement", name) for test, name in (("v", "u"), ("dv", "du"), ("ddv", "ddu"))},
        "ics": {"ic": ("Omega", {"u.0": u0, "du.0": v0})},
        "equations": {
            "inertia": "dw_dot.i.Omega(m.rho, ddv, ddu) = 0",
            "damping": "dw_dot.i.Omega(m.c, dv, du) = 0",
            "balance": "dw_dot.i.Omega(m.k, v, u) - dw_volume_lvf.i.Omega(load.f, v) = 0",
        },
        "solvers": {
            "ls": ("ls.scipy_direct", {}),
            "newton": ("nls.newton", {"i_max": 2, "eps_a": 1e-300, "eps_r": 1e-15, "is_linear": False}),
            "ts": (f"ts.{arguments['kind']}", options | time),
        },
        "options": {"ts": "ts", "nls": "newton", "ls": "ls", "save_times": []},
    }
    return Problem.from_conf(ProblemConf.from_dict(description, sys.modules[__name__]))


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    """Histories that a hook gathers after each step; the program finds the first acceleration itself."""
    rows: list[tuple[float, ...]] = []

    def gather(problem: Any, ts: Any, variables: Any) -> None:
        rows.append(tuple(float(variables[name]()[0]) for name in ("u", "du", "ddu")))

    oscillator = problem(arguments, omega, xi, dt, n, u0, v0, load)
    oscillator.solve(save_results=False, step_hook=gather, verbose=False)
    if len(rows) != n + 1:
        raise RuntimeError(f"expected {n + 1} rows, got {len(rows)}")
    return tuple(zip(*rows, strict=True))


if __name__ == "__main__":
    serve("SfePy", version("sfepy"), "BSD-3-Clause", INTEGRATORS, run)
