"""structdyn: Newmark's method, central differences and the exact propagator, of one and of many degrees of freedom."""

from importlib.metadata import version
from typing import Any

import numpy as np
from adapter import Integrator, serve
from structdyn.mdf.mdf import MDF
from structdyn.mdf.numerical_methods.central_difference import CentralDifferenceMDF
from structdyn.mdf.numerical_methods.newmark_beta import NewmarkBetaMDF
from structdyn.sdf.numerical_methods.central_difference import CentralDifference
from structdyn.sdf.numerical_methods.interpolation import Interpolation
from structdyn.sdf.numerical_methods.newmark_beta import NewmarkBeta
from structdyn.sdf.sdf import SDF

PLACE = "docstring of structdyn.{}"
NEWMARK = "sdf.numerical_methods.newmark_beta.NewmarkBeta.__init__, parameter acc_type"
NEWMARK_MANY = "mdf.numerical_methods.newmark_beta.NewmarkBetaMDF"
CENTRAL = "requires the time step `dt` to be smaller than a critical value (dt_crit = T_n / pi)"


def newmark(kind: str, beta: float, place: str, quotation: str) -> Integrator:
    """Newmark's method with what the manual says of it."""
    there = PLACE.format(place)
    claims: dict[str, tuple[Any, str, str]] = {
        "scheme": ("newmark", quotation, there),
        "beta": (beta, quotation, there),
        "gamma": (0.5, quotation, there),
        "unconditional": (True, quotation, there),
    }
    return Integrator(arguments={"acc_type": kind}, load="samples", claims=claims)


def central(place: str) -> Integrator:
    """Central differences, of which the last row is dropped: see `run`."""
    there = PLACE.format(place)
    claims: dict[str, tuple[Any, str, str]] = {
        "scheme": ("central_difference", "the Central Difference Method", there),
        "critical_Omega": (2.0, CENTRAL, there),
    }
    return Integrator(load="samples", claims=claims)


IMPLICIT = "This class implements the implicit, unconditionally stable Newmark-beta time integration algorithm"
INTEGRATORS = {
    "newmark_average": newmark(
        "average", 1 / 4, NEWMARK, '"average": Constant-average acceleration (unconditionally stable)'
    ),
    "newmark_linear": newmark("linear", 1 / 6, NEWMARK, '"linear": Linear acceleration (unconditionally stable)'),
    "newmark_many_average": newmark("average", 1 / 4, NEWMARK_MANY, IMPLICIT),
    "newmark_many_linear": newmark("linear", 1 / 6, NEWMARK_MANY, IMPLICIT),
    "central_difference": central("sdf.numerical_methods.central_difference.CentralDifference"),
    "central_difference_many": central("mdf.numerical_methods.central_difference.CentralDifferenceMDF"),
    "interpolation": Integrator(
        load="samples",
        claims={
            "scheme": (
                "exact propagator",
                "the recurrence formulas derived from the exact solution of the differential equation",
                PLACE.format("sdf.numerical_methods.interpolation.Interpolation"),
            ),
            "unconditional": (
                True,
                "It is unconditionally stable and highly accurate for linear systems",
                PLACE.format("sdf.numerical_methods.interpolation.Interpolation"),
            ),
        },
    ),
}


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    """Histories of one solver.

    Central differences go a step further than is asked for and drop it, for the program finds the last velocity and
    acceleration of any run from other, one-sided formulas.
    """
    rows = n + 1 + integrator.startswith("central")
    t = dt * np.arange(rows)
    f = np.array([load.at(x) for x in t])
    if "many" in integrator:
        mass, stiffness, damping = np.eye(1), np.array([[omega**2]]), np.array([[2 * xi * omega]])
        system = MDF(mass, stiffness, damping)
        solver = (CentralDifferenceMDF if integrator.startswith("central") else NewmarkBetaMDF)(
            system, dt, u0=[u0], v0=[v0], **arguments
        )
        table = solver.compute_solution(t, f[:, None])
        names = ["u1", "v1", "a1"]
    else:
        oscillator = SDF(1.0, omega**2, xi)
        names = ["displacement", "velocity", "acceleration"]
        if integrator == "interpolation":
            table = Interpolation(oscillator, dt).compute_solution(t, f, u0=u0, v0=v0)
        else:
            solver = CentralDifference if integrator.startswith("central") else NewmarkBeta
            table = solver(oscillator, dt, u0=u0, v0=v0, **arguments).compute_solution(t, f)
    return tuple(table[name].to_numpy()[: n + 1] for name in names)


if __name__ == "__main__":
    serve("structdyn", version("structdyn"), "MIT", INTEGRATORS, run)
