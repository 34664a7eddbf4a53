"""Steps of a few schemes on points with rods, written out by hand: Newton's iteration on all unknowns, in NumPy.

A motion is M a = f(u, v) - G(u)^T lambda with g(u) = 0. Nothing of the project is used.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Rods:
    """Masses (d,), a force f(u, v), and g(u) (c,) with its derivatives G(u) (c, d)."""

    masses: Array
    force: Callable[[Array, Array], Array]
    g: Callable[[Array], Array]
    G: Callable[[Array], Array]

    def reaction(self, u: Array, multipliers: Array) -> Array:
        return self.G(u).T @ multipliers


def root(F: Callable[[Array], Array], x: Array) -> Array:
    """Newton's iteration with differences, until corrections are rounding."""
    for _ in range(60):
        y = F(x)
        steps = 1e-7 * np.maximum(1.0, np.abs(x))
        J = np.array([(F(x + e) - F(x - e)) / (2 * s) for s, e in zip(steps, np.diag(steps), strict=True)]).T
        change = np.linalg.solve(J, y)
        x = x - change
        if np.abs(change).max() < 1e-13 * max(1.0, float(np.abs(x).max())):
            break
    return x


def newmark(
    p: Rods, h: float, state: tuple[Array, ...], beta: float, gamma: float, *, level: str = "position"
) -> tuple[Array, ...]:
    """level: of "both" a second multiplier moves the displacement along M^-1 G^T at the start of the step."""
    u, v, a, old = state
    d, c = len(u), len(old)
    along = (p.G(u) / p.masses).T

    def at(x: Array) -> tuple[Array, Array]:
        z = x[:d]
        moved = z + along @ x[d + c :] if level == "both" else z
        return u + h * v + h**2 * ((0.5 - beta) * a + beta * moved), v + h * ((1 - gamma) * a + gamma * z)

    def F(x: Array) -> Array:
        u1, v1 = at(x)
        rest = p.masses * x[:d] - p.force(u1, v1) + p.reaction(u1, x[d : d + c])
        held = {"position": [p.g(u1) / (beta * h**2)] if beta else [], "velocity": [p.G(u1) @ v1 / (gamma * h)]}
        return np.concatenate([rest, *(held.get(level) or [*held["position"], *held["velocity"]])])

    x = root(F, np.concatenate([a, old, 0.0 * old if level == "both" else []]))
    return (*at(x), x[:d], x[d : d + c])


def projected(p: Rods, u: Array, v: Array) -> tuple[Array, Array]:
    """u moved along the directions there to g = 0, v along those at the new u to G v = 0, measured by the masses."""
    along = (p.G(u) / p.masses).T
    u = u - along @ root(lambda x: p.g(u - along @ x), np.zeros(along.shape[1]))
    along = (p.G(u) / p.masses).T
    return u, v - along @ np.linalg.solve(p.G(u) @ along, p.G(u) @ v)


def generalized_alpha(p: Rods, h: float, state: tuple[Array, ...], rho: float) -> tuple[Array, ...]:
    """Inertia and forces at both ends, reactions with the weights of the forces."""
    alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    beta, gamma = (1 - alpha_m + alpha_f) ** 2 / 4, 0.5 - alpha_m + alpha_f
    u, v, a, old = state
    d = len(u)
    before = p.force(u, v) - p.reaction(u, old)

    def at(z: Array) -> tuple[Array, Array]:
        return u + h * v + h**2 * ((0.5 - beta) * a + beta * z), v + h * ((1 - gamma) * a + gamma * z)

    def F(x: Array) -> Array:
        u1, v1 = at(x[:d])
        now = p.force(u1, v1) - p.reaction(u1, x[d:])
        rest = p.masses * ((1 - alpha_m) * x[:d] + alpha_m * a) - (1 - alpha_f) * now - alpha_f * before
        return np.append(rest, p.g(u1) / (beta * h**2))

    x = root(F, np.append(a, old))
    return (*at(x[:d]), x[:d], x[d:])


def bathe(p: Rods, h: float, state: tuple[Array, ...], *, both: bool = False) -> tuple[Array, ...]:
    """The trapezoidal rule to the middle, then three-point backward Euler; both: as "both" of `newmark`."""
    u, v, *_ = state
    um, vm, am, middle = newmark(p, h / 2, state, 0.25, 0.5, level="both" if both else "position")
    d, c = len(u), len(middle)
    along = (p.G(u) / p.masses).T

    def at(x: Array) -> tuple[Array, Array]:
        v1 = (x[:d] * h - v + 4 * vm) / 3
        u1 = (v1 * h - u + 4 * um) / 3
        return (u1 + h**2 / 9 * along @ x[d + c :] if both else u1), v1

    def F(x: Array) -> Array:
        u1, v1 = at(x)
        rest = p.masses * x[:d] - p.force(u1, v1) + p.reaction(u1, x[d : d + c])
        return np.concatenate([rest, 9 * p.g(u1) / h**2, *([p.G(u1) @ v1 / h] if both else [])])

    x = root(F, np.concatenate([am, middle, *([0.0 * middle] if both else [])]))
    return (*at(x), x[:d], x[d : d + c])


def runge_kutta(p: Rods, h: float, state: tuple[Array, ...], table: list[list[float]]) -> tuple[Array, ...]:
    """Stages of which the last is the end of the step, each with accelerations and multipliers of its own."""
    (u, v, a, old), A = state, np.array(table)
    s, d, c = len(A), len(u), len(old)

    def at(z: Array) -> tuple[Array, Array]:
        speeds = v + h * A @ z.reshape(s, d)
        return u + h * A @ speeds, speeds

    def F(x: Array) -> Array:
        z, multipliers = x[: s * d], x[s * d :].reshape(s, c)
        rest = [
            p.masses * z[k * d : (k + 1) * d] - p.force(*both) + p.reaction(both[0], multipliers[k])
            for k, both in enumerate(zip(*at(z), strict=True))
        ]
        return np.concatenate([*rest, *(p.g(place) / h**2 for place in at(z)[0])])

    x = root(F, np.concatenate([*[a] * s, *[old] * s]))
    places, speeds = at(x[: s * d])
    return places[-1], speeds[-1], x[(s - 1) * d : s * d], x[-c:]


def shake(p: Rods, h: float, before: Array, u: Array) -> tuple[Array, Array]:
    """The displacement after u, with g = 0, and the multipliers at u: Ryckaert, Ciccotti & Berendsen (1977)."""
    free = 2 * u - before + h**2 * p.force(u, u) / p.masses
    along = (p.G(u) / p.masses).T * h**2
    multipliers = root(lambda x: p.g(free - along @ x) / h**2, np.zeros(len(p.g(u))))
    return free - along @ multipliers, multipliers


def rattle(p: Rods, h: float, state: tuple[Array, Array]) -> tuple[Array, Array]:
    """u with g = 0 and v with G v = 0, each by multipliers of its own: Andersen, J. Comput. Phys. 52 (1983) 24-34."""
    u, v = state
    free, along = v + h / 2 * p.force(u, v) / p.masses, (p.G(u) / p.masses).T * h / 2
    half = free - along @ root(lambda x: p.g(u + h * (free - along @ x)) / h**2, np.zeros(len(p.g(u))))
    u1 = u + h * half
    return projected(p, u1, half + h / 2 * p.force(u1, half) / p.masses)
