"""sdof: the generalized alpha method of `integrate`, in C, and `sdof.integration.newmark`, in Python."""

from importlib.metadata import version
from typing import Any

import numpy as np
from adapter import Integrator, serve
from sdof import integrate
from sdof.integration.newmark import newmark

PLACE = "docstring of sdof.integrate"
NAMED = "comments of sdof/integration/newmark.py:{}"
ALPHA = "Integration is carried out using a Generalized - alpha scheme by calling the C function sdof_integrate"


def alpha(beta: float, gamma: float, alpha_m: float, alpha_f: float) -> Integrator:
    """`integrate` with weights alpha_m and alpha_f of the new values."""
    arguments = {"beta": beta, "gamma": gamma, "alpha_m": alpha_m, "alpha_f": alpha_f}
    claims: dict[str, tuple[Any, str, str]] = {"scheme": ("generalized_alpha", ALPHA, PLACE)}
    declared = arguments | {"alpha_m": 1 - alpha_m, "alpha_f": 1 - alpha_f}  # weights of the old values
    claims |= {name: (value, f"{name} (float, optional)", PLACE) for name, value in declared.items()}
    return Integrator(arguments=arguments, load="samples", claims=claims)


def named(n: int, line: int, quotation: str, beta: float, gamma: float, **others: Any) -> Integrator:
    """`newmark` with the number of one of its schemes."""
    values = {"scheme": "newmark", "beta": beta, "gamma": gamma} | others
    claims = {name: (value, quotation, NAMED.format(line)) for name, value in values.items()}
    return Integrator(arguments={"n": n}, load="samples", claims=claims)


STABLE = {"unconditional": True}
INTEGRATORS = {
    "integrate": alpha(0.25, 0.5, 1.0, 1.0),
    "integrate_linear_acceleration": alpha(1 / 6, 0.5, 1.0, 1.0),
    "integrate_hht": alpha(0.3025, 0.6, 1.0, 0.9),
    "integrate_alpha": alpha(0.4225, 0.8, 1.1, 0.8),
    "integrate_yielding_never": Integrator(arguments={"fy": 1e300}, load="samples"),
    "newmark_0": named(0, 76, "0 - the constant-average accelaration method (stable)", 1 / 4, 1 / 2, **STABLE),
    "newmark_1": named(1, 77, "1 - the linear accelaration method (conditionally stable)", 1 / 6, 1 / 2),
    "newmark_3": named(3, 79, "3 - the Galerkin method (stable)", 4 / 5, 3 / 2, **STABLE),
    "newmark_4": named(4, 80, "4 - the backward difference method (stable)", 1.0, 3 / 2, **STABLE),
}


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    """Histories of one of the two functions."""
    f = np.array([load.at(i * dt) for i in range(n + 1)])
    k, c = omega**2, 2 * xi * omega
    if integrator.startswith("integrate"):
        return tuple(integrate(f, dt, k=k, c=c, m=1.0, u0=u0, v0=v0, **arguments))
    return newmark(1.0, c, k, f, dt, u0=u0, v0=v0, **arguments)


if __name__ == "__main__":
    serve("sdof", version("sdof"), "BSD-2-Clause", INTEGRATORS, run)
