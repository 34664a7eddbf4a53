"""A second account of each law: event by event, or its differential equation by SciPy."""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

Array = Any
# of an oracle: what it remembers before the law is strained, and (e, memory, elapsed) -> force and memory
Oracle = tuple[Any, Callable[[float, Any, float], tuple[float, Any]]]


def isotropic_bilinear(k: float, q_y: float, alpha: float) -> Oracle:
    """The elastic trial and its return along the flow."""
    H = alpha * k / (1 - alpha)

    def follow(e: float, memory: Any, _: float) -> tuple[float, Any]:
        p, kappa = memory
        trial = k * (e - p)
        beyond = max(abs(trial) - q_y - H * kappa, 0.0) / (k + H)
        p, kappa = p + np.sign(trial) * beyond, kappa + beyond
        return k * (e - p), (p, kappa)

    return (0.0, 0.0), follow


def bilinear(k: float, q_y: float, alpha: float) -> Oracle:
    """A linear spring beside one that slides."""
    _, slides = coulomb((1 - alpha) * k, (1 - alpha) * q_y)

    def follow(e: float, at: float, _: float) -> tuple[float, Any]:
        q, at = slides(e, at, 0.0)
        return alpha * k * e + q, at

    return 0.0, follow


def coulomb(stiffness: float, q_y: float) -> Oracle:
    """A spring whose foot is dragged."""

    def follow(e: float, foot: float, _: float) -> tuple[float, Any]:
        if stiffness * (e - foot) > q_y:
            foot = e - q_y / stiffness
        if stiffness * (foot - e) > q_y:
            foot = e + q_y / stiffness
        return stiffness * (e - foot), foot

    return 0.0, follow


def slip(stiffness: float, q_y: float, gap: float) -> Oracle:
    """A hook that catches at some elongation, which yielding moves on."""

    def follow(e: float, catches: float, _: float) -> tuple[float, Any]:
        q = max(stiffness * (e - catches), 0.0)
        if q > q_y:
            q, catches = q_y, e - q_y / stiffness
        return q, catches

    return gap, follow


def clough(k: float, q_y: float, alpha: float) -> Oracle:
    """Event by event: unloading to zero, then to the peak of the other side, then along the backbone.

    memory: e, q, then of each direction the peak's elongation and where the line to it begins.
    """

    def up(e: float, state: Array) -> Array:
        x, q, peak, foot, low, low_foot = state
        if q < 0:
            zero = x - q / k
            if e <= zero:
                return np.array([e, q + k * (e - x), peak, foot, low, low_foot])
            x, q, foot = zero, 0.0, zero
        at_peak = q_y + alpha * (k * peak - q_y)
        slope = at_peak / (peak - foot)
        if x < peak:
            meets = min((k * x - q - slope * foot) / (k - slope), peak) if slope < k else peak  # of unloading and it
            if e <= meets:
                return np.array([e, q + k * (e - x), peak, foot, low, low_foot])
            if e <= peak:
                return np.array([e, slope * (e - foot), peak, foot, low, low_foot])
        on = q_y + alpha * (k * e - q_y)
        return np.array([e, min(on, q + k * (e - x)), max(e, peak), foot, low, low_foot])

    def follow(e: float, state: Array, _: float) -> tuple[float, Any]:
        if e < state[0]:
            x, q, peak, foot, low, low_foot = -up(-e, -state[[0, 1, 4, 5, 2, 3]])
            state = np.array([x, q, low, low_foot, peak, foot])
        else:
            state = up(e, state)
        return float(state[1]), state

    return np.array([0.0, 0.0, q_y / k, 0.0, -q_y / k, 0.0]), follow


def bouc_wen(k: float, q_y: float, alpha: float, A: float, beta: float, gamma: float, n: float) -> Oracle:
    """Its differential equation along the way, in two pieces where z changes its sign."""
    e_y = q_y / k

    def follow(e: float, memory: Any, _: float) -> tuple[float, Any]:
        x, z = memory
        way = e - x

        def rate(s: float, y: Array) -> Array:
            sign = np.sign(y[0] * way) if y[0] else 1.0
            return np.array([way * (A - (beta * sign + gamma) * abs(y[0] / e_y) ** n)])

        def crossing(s: float, y: Array) -> float:
            return y[0]

        crossing.terminal = True  # type: ignore[attr-defined]
        s = 0.0
        if z * way < 0:
            done = solve_ivp(rate, (0, 1), [z], "DOP853", events=crossing, rtol=1e-13, atol=1e-15)
            s, z = done.t[-1], done.y[0, -1] if done.status == 0 else 0.0
        if s < 1:
            z = solve_ivp(rate, (s, 1), [z], "DOP853", rtol=1e-13, atol=1e-15).y[0, -1]
        return alpha * k * e + (1 - alpha) * k * z, (e, z)

    return (0.0, 0.0), follow


def maxwell(stiffness: float, c: float) -> Oracle:
    """q' = stiffness (e' - q/c), e' constant."""

    def follow(e: float, memory: Any, elapsed: float) -> tuple[float, Any]:
        x, q = memory
        if elapsed == 0:
            return q + stiffness * (e - x), (e, q + stiffness * (e - x))
        speed = (e - x) / elapsed
        steady = c * speed
        q = steady + (q - steady) * np.exp(-elapsed * stiffness / c)
        return q, (e, q)

    return (0.0, 0.0), follow


def multilinear(k: float, e_1: float, k_2: float, e_2: float, k_3: float) -> Oracle:
    """Interpolated between its corners."""
    q_1 = k * e_1
    q_2 = q_1 + k_2 * (e_2 - e_1)
    far = 1e3
    corners = np.array([0, e_1, e_2, far]), np.array([0, q_1, q_2, q_2 + k_3 * (far - e_2)])
    return None, lambda e, _, __: (float(np.sign(e) * np.interp(abs(e), *corners)), None)
