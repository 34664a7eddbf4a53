"""Every scene written down by hand from its equation of motion: what the derived kernels are checked against."""

from collections.abc import Callable
from dataclasses import dataclass

import mpmath
import numpy as np
from nonlinear_oracle import System

Array = np.ndarray


@dataclass(frozen=True)
class ByHand:
    """A scene's parameters for tests, its system, start, energy, and a step at which every scheme is stable."""

    parameters: dict[str, float]
    system: System
    u0: Array
    v0: Array
    energy: Callable[[float, Array, Array], float]
    dt: float
    a0: Array | None = None  # None: consistent


def one(value: float) -> Array:
    return np.array([value], dtype=float)


def single(force, tangent, gradient, *, mass=1.0, damping=0.0, load=lambda t: 0.0) -> System:
    """A system of one coordinate from scalar functions."""
    return System(
        np.array([[mass]]),
        np.array([[damping]]),
        lambda u: one(force(u[0])),
        lambda u: one(tangent(u[0]))[None],
        load,
        lambda u0, u1: one(gradient(u0[0], u1[0])),
    )


def quotient(potential: Callable) -> Callable[[float, float], float]:
    """(V(u1) - V(u0))/(u1 - u0) with 60 digits; the derivative where they meet."""

    def gradient(u0: float, u1: float) -> float:
        with mpmath.workdps(60):
            old, new = mpmath.mpf(float(u0)), mpmath.mpf(float(u1))
            if old == new:
                new += mpmath.mpf(10) ** -30
            return float((potential(new) - potential(old)) / (new - old))

    return gradient


def bar(EA: float, L: float, m: float) -> System:
    """Green-Lagrange strain."""
    c = EA / (2 * L**3)
    return System(
        m * np.eye(2),
        np.zeros((2, 2)),
        lambda u: c * (u @ u - L**2) * u,
        lambda u: c * ((u @ u - L**2) * np.eye(2) + 2 * np.outer(u, u)),
        discrete_gradient=lambda u0, u1: c * ((u0 @ u0 + u1 @ u1) / 2 - L**2) * (u0 + u1) / 2,
    )


def engineering_bar(EA: float, L: float, m: float) -> System:
    def tangent(u: Array) -> Array:
        length = np.linalg.norm(u)
        n = u / length
        return EA / L * np.outer(n, n) + EA * (1 / L - 1 / length) * (np.eye(2) - np.outer(n, n))

    def gradient(u0: Array, u1: Array) -> Array:  # (V1 - V0)/(s1 - s0) with s = l^2, times u0 + u1
        l0, l1 = np.linalg.norm(u0), np.linalg.norm(u1)
        return EA / (2 * L) * (l0 + l1 - 2 * L) / (l0 + l1) * (u0 + u1)

    return System(
        m * np.eye(2), np.zeros((2, 2)), lambda u: EA / L * (1 - L / np.linalg.norm(u)) * u, tangent,
        discrete_gradient=gradient,
    )  # fmt: skip


def push(t: float) -> float:
    return 3.0 * np.sin(2.0 * t)


L, M, V0 = 3.0443, 10.0, 7.72
K = np.array([[1e3 + 1.0, -1.0], [-1.0, 1.0]])
START = np.array([L, 0.0]), np.array([0.0, V0])

SCENES: dict[str, ByHand] = {
    "linear_oscillator": ByHand(
        {"omega": 5.0, "xi": 0.05, "u0": 0.7, "v0": -0.2},
        single(
            lambda u: 25.0 * u, lambda u: 25.0, lambda u0, u1: 12.5 * (u0 + u1), damping=0.5, load=push
        ),
        one(0.7), one(-0.2), lambda t, u, v: float(v @ v / 2 + 12.5 * u @ u), 0.04,
    ),
    "bathe_noh": ByHand(
        {"k1": 1e3},
        System(
            np.eye(2), np.zeros((2, 2)), lambda u: K @ u, lambda u: K,
            lambda t: np.array([1e3 * np.sin(1.2 * t), 0.0]), lambda u0, u1: K @ (u0 + u1) / 2,
        ),
        np.zeros(2), np.zeros(2),
        lambda t, u, v: float(v @ v / 2 + 500 * (u[0] - np.sin(1.2 * t)) ** 2 + (u[1] - u[0]) ** 2 / 2), 0.01,
    ),
    "elastic_pendulum": ByHand(
        {"EA": 1e4}, bar(1e4, L, M), *START,
        lambda t, u, v: float(M * v @ v / 2 + 1e4 * L / 2 * ((u @ u - L**2) / (2 * L**2)) ** 2), 0.01, np.zeros(2),
    ),
    "elastic_pendulum_engineering": ByHand(
        {"EA": 1e4}, engineering_bar(1e4, L, M), *START,
        lambda t, u, v: float(M * v @ v / 2 + 1e4 / (2 * L) * (np.linalg.norm(u) - L) ** 2), 0.01, np.zeros(2),
    ),
    "rigid_pendulum": ByHand(
        {}, single(lambda u: 0.0, lambda u: 0.0, lambda u0, u1: 0.0, mass=M * L**2),
        one(0.0), one(V0 / L), lambda t, u, v: float(M * L**2 * v @ v / 2), 0.1,
    ),
    "simple_pendulum": ByHand(
        {"u0": 0.3, "v0": 1.5}, single(np.sin, np.cos, quotient(lambda u: 1 - mpmath.cos(u))),
        one(0.3), one(1.5), lambda t, u, v: float(v @ v / 2 + 1 - np.cos(u[0])), 0.1,
    ),
    "duffing": ByHand(
        {"k": 100.0, "eps": 10.0, "u0": 1.5},
        single(
            lambda u: 100 * u * (1 + 10 * u**2), lambda u: 100 * (1 + 30 * u**2),
            quotient(lambda u: 50 * u**2 + 250 * u**4),
        ),
        one(1.5), one(0.0), lambda t, u, v: float(v @ v / 2 + 50 * u[0] ** 2 + 250 * u[0] ** 4), 0.002,
    ),
    "softening": ByHand(
        {"k": 100.0, "u0": 4.0},
        single(
            lambda u: 100 * np.tanh(u), lambda u: 100 / np.cosh(u) ** 2,
            quotient(lambda u: 100 * mpmath.log(mpmath.cosh(u))),
        ),
        one(4.0), one(0.0), lambda t, u, v: float(v @ v / 2 + 100 * np.log(np.cosh(u[0]))), 0.01,
    ),
    "penalty_bounce": ByHand(
        {"k": 1e6, "u0": 2e-4, "v0": -1.0},
        single(
            lambda u: 1e6 * min(u, 0.0), lambda u: 1e6 if u < 0 else 0.0,
            quotient(lambda u: 5e5 * min(u, mpmath.mpf(0)) ** 2),
        ),
        one(2e-4), one(-1.0), lambda t, u, v: float(v @ v / 2 + 5e5 * min(u[0], 0.0) ** 2), 1e-4,
    ),
}  # fmt: skip
