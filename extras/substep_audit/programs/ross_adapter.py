"""ROSS: the function `ross.utils.newmark`, which integrates the rotors' time response.

It starts from rest, with an acceleration that it assumes to be zero, and knows no initial state. Newmark's formulas
reproduce u0 + v0 t exactly, so that motion from u0 and v0 can be superposed without a change of the scheme.
"""

from importlib.metadata import version

import numpy as np
from adapter import Integrator, serve
from quiet import printing_aside

with printing_aside():
    from ross.utils import newmark

PLACE = "docstring of ross.utils.newmark"


def method(gamma: float, beta: float, quotation: str, defaults: bool = False) -> Integrator:
    """The function with its two parameters, or with these as the defaults that they have."""
    values = {"gamma": gamma, "beta": beta}
    claims = {name: (value, quotation, PLACE) for name, value in ({"scheme": "newmark"} | values).items()}
    given, left_out = ({}, values) if defaults else (values, {})
    return Integrator(given, left_out, sets="", outputs="u", load="each step", digits=12.0, claims=claims)


INTEGRATORS = {
    "newmark": method(0.5, 0.25, "gamma: Default is 0.5. beta: Default is 0.25.", defaults=True),
    "newmark_linear": method(
        0.5, 1 / 6, "Parameter of the integration algorithm related to the displacement interpolation"
    ),
    "newmark_damped": method(
        0.6, 0.3025, "Parameter of the integration algorithm related to the velocity interpolation"
    ),
}


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    """Displacements; the tolerance, which is one of forces, is twelve digits of the largest force at hand."""
    t = dt * np.arange(n + 1)
    k, c = omega**2, 2 * xi * omega
    mass, damping, stiffness = np.eye(1), np.array([[c]]), np.array([[k]])
    largest = max(abs(load.at(x)) for x in t)
    y = newmark(
        lambda step, **state: (mass, damping, stiffness, np.array([load(t[step])])),
        t,
        1,
        tol=max(1e-12 * largest, 1e-300),
        **arguments,
    )
    return y[:, 0], None, None


if __name__ == "__main__":
    serve("ROSS", version("ross-rotordynamics"), "Apache-2.0", INTEGRATORS, run)
