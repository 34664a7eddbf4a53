"""SciPy, as a control: lsim, which is exact, and the pairs of solve_ivp, of which all is published."""

from typing import Any

import numpy as np
import scipy
from adapter import Integrator, Load, Spring, serve
from scipy.integrate import RK23, RK45
from scipy.signal import lsim

MANUAL = "docstring of scipy.signal.lsim"
ORDERS = {3: "third", 5: "fifth"}
NEVER_REJECTED = 1e300  # a tolerance with which every step is accepted


def pair(solver: str, scheme: str, order: int, quotation: str) -> Integrator:
    """A pair of solve_ivp; with its step bounded and nothing to reject, it takes equal steps."""
    place = f"docstring of scipy.integrate.{solver}"
    accuracy = f"steps are taken using the {ORDERS[order]}-order accurate formula"
    claims = {"scheme": (scheme, quotation, place), "order": (order, accuracy, place)}
    return Integrator(arguments={"solver": solver}, outputs="uv", nonlinear=True, adaptive=True, claims=claims)


INTEGRATORS = {
    "lsim": Integrator(
        defaults={"interp": True},
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
    "RK45": pair("RK45", "dormand_prince", 5, "This uses the Dormand-Prince pair of formulas"),
    "RK23": pair("RK23", "bogacki_shampine", 3, "This uses the Bogacki-Shampine pair of formulas"),
}
SOLVERS = {"RK45": RK45, "RK23": RK23}


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load, force=None):
    """Histories of lsim or of a pair."""
    if "solver" in arguments:
        rate = rates(omega, xi, load, force)
        solver = SOLVERS[arguments["solver"]](
            rate, 0.0, [u0, v0], np.inf, max_step=dt, first_step=dt, rtol=NEVER_REJECTED, atol=NEVER_REJECTED
        )
        rows = [(u0, v0)]
        for _ in range(n):
            solver.step()
            rows.append(tuple(solver.y))
        u, v = zip(*rows, strict=True)
        return u, v, None
    return by_lsim(arguments, omega, xi, dt, n, u0, v0, load)


def rates(omega: float, xi: float, load: Load, force: Spring | None) -> Any:
    """The rates of u and v, as a function."""

    def rate(t: float, y: Any) -> list[float]:
        return [y[1], load(t) - 2 * xi * omega * y[1] - (omega**2 * y[0] if force is None else force(y[0]))]

    return rate


def controlled(
    integrator: str, arguments: dict[str, Any], omega: float, xi: float, tol: float, t_end: float, u0: float, v0: float
) -> tuple[Any, Any, Any, Any]:
    """The steps of a pair, with the estimates that it bases them on."""
    solver = SOLVERS[arguments["solver"]](rates(omega, xi, Load(), None), 0.0, [u0, v0], t_end, rtol=tol, atol=tol)
    rows, errors = [(0.0, u0, v0)], []
    while solver.status == "running":
        solver.step()
        rows.append((solver.t, *solver.y))
        errors.append(solver._estimate_error(solver.K, solver.h_previous))
    return *zip(*rows, strict=True), list(zip(*errors, strict=True))


def by_lsim(
    arguments: dict[str, Any], omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Load
) -> tuple[Any, Any, Any]:
    """Histories of the system with states u and v and outputs u, v and a, driven by samples at ends of steps."""
    t = dt * np.arange(n + 1)
    f = np.array([load.at(x) for x in t])
    rate = [-(omega**2), -2 * xi * omega]
    system = [[0.0, 1.0], rate], [[0.0], [1.0]], [[1.0, 0.0], [0.0, 1.0], rate], [[0.0], [0.0], [1.0]]
    _, y, _ = lsim(system, f, t, X0=[u0, v0], **arguments)
    return tuple(y.T)


if __name__ == "__main__":
    serve("SciPy", scipy.__version__, "BSD-3-Clause", INTEGRATORS, run, controlled)
