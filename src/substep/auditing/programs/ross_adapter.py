"""ROSS: the function `ross.utils.newmark`, which integrates the rotors' time response.

It starts from rest and knows no initial state. A motion from u0 and v0 is u0 + v0 t and a motion from rest under the
load that this one leaves, and Newmark's formulas reproduce u0 + v0 t exactly: so a start from u0, v0 and the
acceleration that the function assumes, which is zero, is run without a change of the scheme.
"""

from importlib.metadata import version
from typing import Any

import numpy as np
from adapter import Integrator, Load, serve
from quiet import printing_aside

with printing_aside():
    from ross.utils import newmark

PLACE = "docstring of ross.utils.newmark"


def method(gamma: float, beta: float, quotation: str) -> Integrator:
    """The function with its two parameters."""
    values = {"scheme": "newmark", "gamma": gamma, "beta": beta}
    claims = {name: (value, quotation, PLACE) for name, value in values.items()}
    return Integrator(arguments={"gamma": gamma, "beta": beta}, outputs="u", load="samples", digits=12.0, claims=claims)


INTEGRATORS = {
    "newmark": method(0.5, 0.25, "gamma: Default is 0.5. beta: Default is 0.25."),
    "newmark_linear": method(
        0.5, 1 / 6, "Parameter of the integration algorithm related to the displacement interpolation"
    ),
    "newmark_damped": method(
        0.6, 0.3025, "Parameter of the integration algorithm related to the velocity interpolation"
    ),
}


def run(
    integrator: str,
    arguments: dict[str, Any],
    omega: float,
    xi: float,
    dt: float,
    n: int,
    u0: float,
    v0: float,
    a0: float | None,
    load: Load,
) -> tuple[Any, Any, Any]:
    """Displacements; the tolerance, which is one of forces, is twelve digits of the largest force at hand."""
    t = dt * np.arange(n + 1)
    k, c = omega**2, 2 * xi * omega
    drift = u0 + v0 * t
    force = np.array([load.at(x) for x in t]) - k * drift - c * v0
    mass, damping, stiffness = np.eye(1), np.array([[c]]), np.array([[k]])
    largest = float(abs(force).max())
    y = newmark(
        lambda step, **state: (mass, damping, stiffness, force[step : step + 1]),
        t,
        1,
        tol=max(1e-12 * largest, 1e-300),
        **arguments,
    )
    return y[:, 0] + drift, None, None


if __name__ == "__main__":
    serve("ROSS", version("ross-rotordynamics"), "Apache-2.0", INTEGRATORS, run)
