"""SciPy's lsim, which carries a linear system exactly over a step: a control that the instrument must find exact."""

from typing import Any

import numpy as np
import scipy
from adapter import Integrator, Load, serve
from scipy.signal import lsim

MANUAL = "docstring of scipy.signal.lsim"
INTEGRATORS = {
    "lsim": Integrator(
        load="samples",
        outputs="uva",
        claims={"scheme": ("exact propagator", "Simulate output of a continuous-time linear system.", MANUAL)},
    ),
    "lsim_zero_order_hold": Integrator(
        arguments={"interp": False},
        load="samples",
        outputs="uva",
        claims={"scheme": ("exact propagator", "linear (True, the default) or zero-order-hold (False)", MANUAL)},
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
    """Histories of the system with states u and v and outputs u, v and a, driven by samples at ends of steps."""
    t = dt * np.arange(n + 1)
    f = np.array([load.at(x) for x in t])
    rate = [-(omega**2), -2 * xi * omega]
    system = [[0.0, 1.0], rate], [[0.0], [1.0]], [[1.0, 0.0], [0.0, 1.0], rate], [[0.0], [0.0], [1.0]]
    _, y, _ = lsim(system, f, t, X0=[u0, v0], **arguments)
    return tuple(y.T)


if __name__ == "__main__":
    serve("SciPy", scipy.__version__, "BSD-3-Clause", INTEGRATORS, run)
