"""pyYeti's solvers of second-order equations: SolveNewmark, SolveUnc, SolveExp2 and SolveCDF."""

from importlib.metadata import version

import numpy as np
from adapter import Integrator, serve
from pyyeti import ode

LINEAR = "exact assuming piece-wise linear forces (if `order` is 1) or piece-wise constant forces (if `order` is 0)"
NASTRAN = (
    "This routine uses a fixed time step Newmark-Beta method based on the Nastran Theoretical Manual, section 11.4"
)
STABLE = "The algorithm is unconditionally stable but the size of the time step is still a concern"
WEIGHTS = "A u_{n+2} = 1/3 (F_{n+2} + F_{n+1} + F_{n}) + N_{n+1} + A_1 u_{n+1} + A_0 u_{n}"


def exact(place: str, order: int) -> Integrator:
    """A solver whose manual calls it exact under a load that is linear, or constant, over a step."""
    claims = {"scheme": ("exact propagator", LINEAR, f"docstring of pyyeti.ode.{place}")}
    given, defaults = ({}, {"order": 1}) if order == 1 else ({"order": order}, {})
    return Integrator(arguments=given, defaults=defaults, load="samples", claims=claims)


INTEGRATORS = {
    "SolveNewmark": Integrator(
        load="samples",
        claims={
            "scheme": ("newmark", NASTRAN, "docstring of pyyeti.ode.SolveNewmark"),
            "beta": (1 / 3, WEIGHTS, "docstring of pyyeti.ode.SolveNewmark"),
            "gamma": (1 / 2, WEIGHTS, "docstring of pyyeti.ode.SolveNewmark"),
            "unconditional": (True, STABLE, "docstring of pyyeti.ode.SolveNewmark"),
        },
    ),
    "SolveUnc": exact("SolveUnc", 1),
    "SolveUnc_order_0": exact("SolveUnc", 0),
    "SolveExp2": exact("SolveExp2", 1),
    "SolveExp2_order_0": exact("SolveExp2", 0),
    "SolveCDF": Integrator(
        defaults={"order": 1},
        load="samples",
        claims={
            "scheme": (
                "exact propagator",
                "For all other cases, using SolveCDF is the same as using SolveUnc",
                "docstring of pyyeti.ode.SolveCDF",
            )
        },
    ),
}


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    """Histories of one solver; rb = [] says that the oscillator, however soft, is no rigid-body mode.

    SolveNewmark wants two steps at least; a step more than is asked for would change how the last one's velocity is
    found, so a single step is refused.
    """
    if integrator == "SolveNewmark" and n < 2:
        raise ValueError(f"expected two steps or more for SolveNewmark, got {n}")
    solver = getattr(ode, integrator.split("_", maxsplit=1)[0])
    options = arguments if integrator == "SolveNewmark" else arguments | {"rb": []}
    m, b, k = np.ones(1), np.array([2 * xi * omega]), np.array([omega**2])
    f = np.array([[load.at(i * dt) for i in range(n + 1)]])
    solution = solver(m, b, k, dt, **options).tsolve(f, d0=np.array([u0]), v0=np.array([v0]))
    return solution.d[0], solution.v[0], solution.a[0]


if __name__ == "__main__":
    serve("pyYeti", version("pyyeti"), "BSD-3-Clause", INTEGRATORS, run)
