"""Lagrange's equations as SymPy's mechanics module derives them, and steps of a few schemes written by hand on them.

Nothing is shared with the derivation: neither how the equations are formed nor how a scheme reads them.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from substep_derive import Scene, rate, t
from sympy import Function, Matrix, Symbol, lambdify
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

Array = np.ndarray
TIME = dynamicsymbols._t


@dataclass(frozen=True)
class Equations:
    """q'' = known(q, v, t) + inverse(q, t) @ load(t)."""

    known: Callable[[Array, Array, float], Array]
    inverse: Callable[[Array, float], Array]
    load: Callable[[float], Array]

    def at(self, q: Array, v: Array, time: float) -> Array:
        """The acceleration."""
        return self.under(q, v, time, self.load(time))

    def under(self, q: Array, v: Array, time: float, load: Array) -> Array:
        """The acceleration under another load."""
        return self.known(q, v, time) + self.inverse(q, time) @ load


def equations(scene: Scene, parameters: Mapping[str, float]) -> Equations:
    """Of a scene at these parameters."""
    values = {Symbol(name): x for name, x in parameters.items()}
    moving = {q: Function(q.name)(TIME) for q in scene.coordinates}
    rates = {rate(q): function.diff(TIME) for q, function in moving.items()}
    names = {**values, **rates, **moving, t: TIME}

    def in_time(e: Any) -> Any:
        return Matrix([e]).subs(names)[0]

    potential = scene.potential.subs(scene.invariants)
    lost = [scene.dissipation.diff(v) for v in scene.rates]
    given = [scene.forces.get(q, 0) - e for q, e in zip(scene.coordinates, lost, strict=True)]
    # a frame is asked for where there are forces; each acts on one coordinate, so that its work is force * rate
    method = LagrangesMethod(in_time(scene.kinetic - potential), list(moving.values()))
    method.form_lagranges_equations()
    plain = {function.diff(TIME): v for v, function in zip(scene.rates, moving.values(), strict=True)}
    plain = {**plain, **{function: q for q, function in moving.items()}, TIME: t}
    forces = method.forcing.subs(plain) + Matrix(given).subs(values)
    arguments = [list(scene.coordinates), list(scene.rates), t]
    mass = lambdify(arguments, method.mass_matrix.subs(plain), MODULES)
    right = lambdify(arguments, forces, MODULES)
    pushed = lambdify([t], Matrix([scene.load.get(q, 0) for q in scene.coordinates]).subs(values), MODULES)
    still = np.zeros(len(moving))
    return Equations(
        lambda q, v, time: np.linalg.solve(mass(q, v, time), right(q, v, time)[:, 0]),
        lambda q, time: np.linalg.inv(mass(q, still, time)),
        lambda time: np.asarray(pushed(time), dtype=float)[:, 0],
    )


MODULES = [{"absolute": np.abs, "sign_of": np.sign}, "numpy"]


def settled(of: Callable[[Array], Array], guess: Array) -> Array:
    """The fixed point, by repetition, which converges for small steps."""
    for _ in range(200):
        new = of(guess)
        if np.abs(new - guess).max() <= 1e-15 * (1.0 + np.abs(new).max()):
            return new
        guess = new
    return guess


Step = Callable[[Equations, float, float, Array, Array, Array], tuple[Array, Array, Array]]


def newmark(e: Equations, h: float, time: float, q: Array, v: Array, a: Array, beta=0.25, gamma=0.5):
    def ends(new: Array) -> tuple[Array, Array]:
        return q + h * v + h * h * ((0.5 - beta) * a + beta * new), v + h * ((1 - gamma) * a + gamma * new)

    new = settled(lambda x: e.at(*ends(x), time + h), a)
    return *ends(new), new


def central_difference(e: Equations, h: float, time: float, q: Array, v: Array, a: Array):
    return newmark(e, h, time, q, v, a, beta=0.0)


def generalized_alpha(e: Equations, h: float, time: float, q: Array, v: Array, a: Array):
    """At rho_inf = 4/5: the means of auxiliary accelerations and of those of the motion are equal, the load at its own
    instant."""
    am, af = (2 * 0.8 - 1) / 1.8, 0.8 / 1.8
    beta, gamma = (1 - am + af) ** 2 / 4, 0.5 - am + af
    load = e.load(time + (1 - af) * h)

    def ends(new: Array) -> tuple[Array, Array]:
        return q + h * v + h * h * ((0.5 - beta) * a + beta * new), v + h * ((1 - gamma) * a + gamma * new)

    def again(new: Array) -> Array:
        mean = (1 - af) * e.under(*ends(new), time + h, load) + af * e.under(q, v, time, load)
        return (mean - am * a) / (1 - am)

    new = settled(again, a)
    return *ends(new), new


def generalized_alpha_of_forces(e: Equations, h: float, time: float, q: Array, v: Array, a: Array):
    """The same with forces of inertia, M(q) a, mixed in place of accelerations."""
    am, af = (2 * 0.8 - 1) / 1.8, 0.8 / 1.8
    beta, gamma = (1 - am + af) ** 2 / 4, 0.5 - am + af

    def ends(new: Array) -> tuple[Array, Array]:
        return q + h * v + h * h * ((0.5 - beta) * a + beta * new), v + h * ((1 - gamma) * a + gamma * new)

    old = np.linalg.inv(e.inverse(q, time))

    def again(new: Array) -> Array:
        inverse = e.inverse(ends(new)[0], time + h)
        mixed = (1 - af) * np.linalg.solve(inverse, e.at(*ends(new), time + h)) + af * old @ e.at(q, v, time)
        return inverse @ (mixed - am * old @ a) / (1 - am)

    new = settled(again, a)
    return *ends(new), new


def bathe(e: Equations, h: float, time: float, q: Array, v: Array, a: Array):
    qg, vg, _ = newmark(e, h / 2, time, q, v, a)

    def ends(new: Array) -> tuple[Array, Array]:
        """v1 = (q0 - 4 qg + 3 q1)/h and a1 = (v0 - 4 vg + 3 v1)/h."""
        v1 = (h * new - v + 4 * vg) / 3
        return (h * v1 - q + 4 * qg) / 3, v1

    new = settled(lambda x: e.at(*ends(x), time + h), a)
    return *ends(new), new


def rk4(e: Equations, h: float, time: float, q: Array, v: Array, a: Array):
    del a
    k1 = v, e.at(q, v, time)
    k2 = v + h / 2 * k1[1], e.at(q + h / 2 * k1[0], v + h / 2 * k1[1], time + h / 2)
    k3 = v + h / 2 * k2[1], e.at(q + h / 2 * k2[0], v + h / 2 * k2[1], time + h / 2)
    k4 = v + h * k3[1], e.at(q + h * k3[0], v + h * k3[1], time + h)
    u1, v1 = (x + h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]) for i, x in enumerate((q, v)))
    return u1, v1, e.at(u1, v1, time + h)


BY_HAND: Mapping[str, tuple[Step, Mapping[str, float]]] = {
    "average_acceleration": (newmark, {}),
    "central_difference": (central_difference, {}),
    "generalized_alpha": (generalized_alpha, {"rho_inf": 0.8}),
    "bathe": (bathe, {}),
    "rk4": (rk4, {}),
}


def marched(step: Step, e: Equations, h: float, n: int, q: Array, v: Array) -> Iterator[tuple[Array, Array, Array]]:
    """u, v, a at 0, h, ..., n h."""
    row = q, v, e.at(q, v, 0.0)
    yield row
    for i in range(n):
        row = step(e, h, i * h, *row)
        yield row
