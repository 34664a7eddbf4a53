"""CALFEM for Python: step2, Newmark's method with its arguments alpha (Newmark's beta) and delta (Newmark's gamma)."""

from importlib.metadata import version
from typing import Any

import numpy as np
from adapter import Integrator, serve
from calfem.core import step2

PLACE = "docstring of calfem.core.step2, parameter ip"
FAMILY = "alpha and delta are time integration constants for the Newmark family of methods"


def newmark(alpha: float, delta: float, quotation: str) -> Integrator:
    """step2 with the two constants that its manual names for a scheme."""
    claims: dict[str, tuple[Any, str, str]] = {
        "scheme": ("newmark", FAMILY, PLACE),
        "beta": (alpha, quotation, PLACE),
        "gamma": (delta, quotation, PLACE),
    }
    return Integrator(arguments={"alpha": alpha, "delta": delta}, load="samples", claims=claims)


INTEGRATORS = {
    "trapezoidal": newmark(1 / 4, 1 / 2, "alpha=1/4, delta=1/2: average acceleration (trapezoidal) rule"),
    "linear_acceleration": newmark(1 / 6, 1 / 2, "alpha=1/6, delta=1/2: linear acceleration"),
    "central_difference": newmark(0.0, 1 / 2, "alpha=0, delta=1/2: central difference"),
    "damped": newmark(0.3025, 0.6, FAMILY),
}


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    """Histories of step2, whose total time stands half a step beyond the last one: it truncates their quotient."""
    f = np.array([[load.at(i * dt) for i in range(n + 1)]])
    ip = [dt, (n + 0.5) * dt, arguments["alpha"], arguments["delta"]]
    k, c, m, u, v = (np.array([[x]]) for x in (omega**2, 2 * xi * omega, 1.0, u0, v0))
    histories, _ = step2(k, c, m, f, u, v, [], ip, [], np.array([]))
    return histories["a"][0], histories["da"][0], histories["d2a"][0]


if __name__ == "__main__":
    serve("CALFEM for Python", version("calfem-python"), "MIT", INTEGRATORS, run)
