"""Exact motions of beams and plates after a sudden load, as series of modes without any mesh."""

import math
from typing import Any

import numpy as np
from scipy.linalg import eigh


def after_a_step(omega: float, alpha: float, beta: float, t: Any) -> Any:
    """x(t)/static of x'' + (alpha + beta omega^2) x' + omega^2 x = omega^2 from rest."""
    xi = 0.5 * (alpha / omega + beta * omega)
    root = omega * np.emath.sqrt(xi * xi - 1.0)
    first, second = -xi * omega + root, -xi * omega - root
    return 1.0 - np.real((first * np.exp(second * t) - second * np.exp(first * t)) / (first - second))


def navier_plate(
    t: Any, *, side: float, thickness: float, E: float, nu: float, rho: float, pressure: float, alpha: float,
    beta: float, terms: int,
) -> tuple[Any, float]:  # fmt: skip
    """Deflection of the centre of a simply supported square plate, over t and static, of terms x terms sines."""
    D, mass = E * thickness**3 / (12 * (1 - nu**2)), rho * thickness
    moving, static = np.zeros_like(t), 0.0
    for m in range(1, 2 * terms, 2):
        for n in range(1, 2 * terms, 2):
            stiffness = D * (math.pi / side) ** 4 * (m * m + n * n) ** 2
            at = math.sin(m * math.pi / 2) * math.sin(n * math.pi / 2)
            part = at * 16 * pressure / (math.pi**2 * m * n) / stiffness
            moving += part * after_a_step(math.sqrt(stiffness / mass), alpha, beta, t)
            static += part
    return moving, static


def timoshenko_beam(
    t: Any, *, length: float, EI: float, GA: float, mass: float, rotary: float, force: float, alpha: float,
    beta: float, terms: int,
) -> tuple[Any, float]:  # fmt: skip
    """Deflection of the middle of a simply supported beam under a force per length, over t and static."""
    moving, static = np.zeros_like(t), 0.0
    for n in range(1, 2 * terms, 2):
        k, at = n * math.pi / length, math.sin(n * math.pi / 2)
        squares, shapes = eigh([[GA * k * k, -GA * k], [-GA * k, EI * k * k + GA]], np.diag([mass, rotary]))
        for square, shape in zip(squares, shapes.T, strict=True):
            part = at * shape[0] ** 2 * 4 * force / (n * math.pi) / square
            moving += part * after_a_step(math.sqrt(square), alpha, beta, t)
            static += part
    return moving, static
