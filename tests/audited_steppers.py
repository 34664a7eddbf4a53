"""Steppers written by hand, right and wrong ones, of which an audit has to find what they are."""

from collections.abc import Callable
from typing import Any

import numpy as np

import substep as ss

RHO = 0.8
OPTIMAL = ((2 * RHO - 1) / (RHO + 1), RHO / (RHO + 1))  # alpha_m and alpha_f of generalized-alpha at this rho_inf
BETA, GAMMA = (1 - OPTIMAL[0] + OPTIMAL[1]) ** 2 / 4, 0.5 - OPTIMAL[0] + OPTIMAL[1]
CHUNG = ss.Claims("generalized_alpha", rho_inf=RHO, order=2, unconditional=True)
TRAPEZOIDAL = ss.Claims("newmark", order=2, rho_inf=1.0, unconditional=True, parameters={"beta": 0.25, "gamma": 0.5})


def generalized_alpha(
    alpha_m: float,
    alpha_f: float,
    beta: float,
    gamma: float,
    *,
    late: float = 0.0,
    start: str = "computed",
    dtype: type = np.float64,
    sets_a0: bool = False,
) -> Callable[..., Any]:
    """Chung & Hulbert's method, J. Appl. Mech. 60 (1993) 371, (2) to (7), with weights of the old state.

    late: by how many steps the load is taken too late. start: "computed", "zero", or "unloaded", which leaves out the
    load, or "heavier", which adds stiffness to the mass. dtype: in which it computes.
    """

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any, a0: Any = None) -> Any:
        x = np.zeros((n + 1, 3), dtype)
        k, c, h = dtype(omega**2), dtype(2 * xi * omega), dtype(dt)
        first = {"computed": load(0.0), "unloaded": 0.0, "heavier": load(0.0)}
        x[0] = u0, v0, 0.0 if start == "zero" else first[start] - c * v0 - k * u0
        if start == "heavier":
            x[0, 2] /= 1 + k * h * h / 400
        if a0 is not None:
            x[0, 2] = a0
        b, g, m, f = (dtype(x) for x in (beta, gamma, alpha_m, alpha_f))
        for i in range(n):
            u, v, a = x[i]
            p, q = u + h * v + h * h * (dtype(0.5) - b) * a, v + h * (1 - g) * a
            force = dtype(load((i + 1 - alpha_f - late) * dt))
            right = force - m * a - c * (f * v + (1 - f) * q) - k * (f * u + (1 - f) * p)
            z = right / ((1 - m) + (1 - f) * (c * h * g + k * h * h * b))
            x[i + 1] = p + b * h * h * z, q + g * h * z, z
        return x.T.astype(np.float64)

    def started(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        return run(omega, xi, dt, n, u0, v0, load)

    return run if sets_a0 else started


def damped_by(velocity: str, alpha_f: float, beta: float, gamma: float) -> Callable[..., Any]:
    """Generalized-alpha with alpha_m = 0, damped by another velocity: "predicted", "start", "end", or "ahead".

    The predicted one is the declared one without the acceleration that the step is solved for. For beta = 0 the force
    takes u alone from the step before, and nothing is inverted but where "end" damps.
    """

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        k, c, w = omega**2, 2 * xi * omega, 1 - alpha_f
        rows = [(u0, v0, load(0.0) - c * v0 - k * u0)]
        for i in range(n):
            u, v, a = rows[-1]
            p, q = u + dt * v + dt * dt * (0.5 - beta) * a, v + dt * (1 - gamma) * a
            known, unknown = {
                "predicted": (alpha_f * v + w * q, 0.0),
                "start": (v, 0.0),
                "end": (q, gamma * dt),
                "ahead": (v + 0.7 * dt * a, 0.0),
            }[velocity]
            right = load((i + w) * dt) - c * known - k * (alpha_f * u + w * p)
            z = right / (1 + c * unknown + w * k * beta * dt * dt)
            rows.append((p + beta * dt * dt * z, q + gamma * dt * z, z))
        return zip(*rows, strict=True)

    return run


def trapezoidal_load(*weights: float) -> Callable[..., Any]:
    """The average acceleration method with the load as w0 f(t_n) + w1 f(t_n + h/2) + w2 f(t_n + h)."""

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        x = np.zeros((n + 1, 3))
        k, c = omega**2, 2 * xi * omega
        x[0] = u0, v0, load(0.0) - c * v0 - k * u0
        for i in range(n):
            u, v, a = x[i]
            p, q = u + dt * v + dt * dt / 4 * a, v + dt / 2 * a
            force = sum(w * load((i + tau) * dt) for w, tau in zip(weights, (0.0, 0.5, 1.0), strict=True))
            z = (force - c * q - k * p) / (1 + c * dt / 2 + k * dt * dt / 4)
            x[i + 1] = p + dt * dt / 4 * z, q + dt / 2 * z, z
        return x.T

    return run
