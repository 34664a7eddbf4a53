"""Random energies and constraints of up to four coordinates: steps are those of plain iterations in NumPy."""

import os
from collections.abc import Callable

import numpy as np
import pytest
from constrained_steps import root
from lagrange_oracle import Equations, equations
from substep_derive import Scene, rate, t
from sympy import Matrix, Rational, cos, lambdify, sin, symbols

import substep as ss

VERIFY = bool(os.environ.get("SUBSTEP_VERIFY"))
SYMBOLS = symbols("q1:5")
Array = np.ndarray
State = tuple[Array, Array, Array, Array]  # u, v, a and the multipliers at a knot


def drawn(seed: int) -> Scene:
    """Of two to four coordinates and one to three constraints, which the start satisfies."""
    rng = np.random.default_rng(seed)
    n = 2 + seed % 3
    q, count = SYMBOLS[:n], int(rng.integers(1, n))

    def some(low: int, high: int) -> Rational:
        return Rational(int(rng.integers(low, high)), 7)

    start = {x: some(-6, 7) for x in (*q, *map(rate, q))}
    rows = [
        rate(x) + some(-2, 3) * cos(q[i - 1]) * rate(q[i - 1]) + some(-1, 2) * sin(t + q[i - 1])
        for i, x in enumerate(q)
    ]
    potential = sum(
        some(1, 9) * x**2 / 2 - some(0, 5) * cos(x + i) + some(0, 3) * x * q[i - 1] for i, x in enumerate(q)
    )
    held = {}
    for k in range(count):
        g = (
            q[k]
            + some(-3, 4) * q[k - 1] * q[k + 1]
            + some(-3, 4) * q[k + 1] ** 2 / 3
            + some(-3, 4) * sin(t + q[-1]) / 3
        )
        held[f"g{k}"] = g - g.subs({**start, t: 0})
    g = Matrix(list(held.values()))
    G, by_time, v = (e.subs({**start, t: 0}) for e in (g.jacobian(list(q)), g.diff(t), Matrix(list(map(rate, q)))))
    G, by_time, v = (np.array(e.evalf(20), dtype=float) for e in (G, by_time, v))
    v -= np.linalg.pinv(G) @ (G @ v + by_time)
    start |= {rate(x): Rational(float(value)) for x, (value,) in zip(q, v, strict=True)}
    return Scene(
        f"held_{seed}",
        coordinates=dict.fromkeys(q, "m"),
        kinetic=sum(some(2, 9) * r**2 for r in rows) / 2,
        potential=potential,
        forces={q[0]: -some(0, 4) * rate(q[0]) * (1 + q[-1] ** 2)},
        constraints=held,
        parameters=(),
        start=start,
        length=1,
    )


class Held:
    """u'' of the scene's equations of motion less M^-1 G^T times multipliers, and g, with their times."""

    def __init__(self, scene: Scene) -> None:
        self.motion: Equations = equations(scene, {})
        g = Matrix([c.expression for c in scene.constraints.values()])
        self._g, self._G = (lambdify([list(scene.coordinates), t], e) for e in (g, g.jacobian(list(scene.coordinates))))

    def g(self, u: Array, time: float) -> Array:
        return self._g(u, time)[:, 0].astype(float)

    def acceleration(self, u: Array, v: Array, time: float, multipliers: Array) -> Array:
        pushed = np.asarray(self._G(u, time), dtype=float).T @ multipliers
        return self.motion.at(u, v, time) - self.motion.inverse(u, time) @ pushed


def newmark(p: Held, h: float, time: float, x: State, beta: float = 0.25, gamma: float = 0.5) -> State:
    u, v, a, multipliers = x

    def ends(z: Array) -> tuple[Array, Array]:
        return u + h * v + h**2 * ((0.5 - beta) * a + beta * z), v + h * ((1 - gamma) * a + gamma * z)

    def F(y: Array) -> Array:
        z, m = np.split(y, [len(u)])
        rest = z - p.acceleration(*ends(z), time + h, m)
        return np.append(rest, p.g(ends(z)[0], time + h) / (beta * h**2))

    z, m = np.split(root(F, np.append(a, multipliers)), [len(u)])
    return *ends(z), z, m


def generalized_alpha(p: Held, h: float, time: float, x: State, rho: float = 0.8) -> State:
    """The accelerations of the motion at both ends, those under the multipliers of their own, are mixed."""
    alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    beta, gamma = (1 - alpha_m + alpha_f) ** 2 / 4, 0.5 - alpha_m + alpha_f
    u, v, a, multipliers = x
    before = p.acceleration(u, v, time, multipliers)

    def ends(z: Array) -> tuple[Array, Array]:
        return u + h * v + h**2 * ((0.5 - beta) * a + beta * z), v + h * ((1 - gamma) * a + gamma * z)

    def F(y: Array) -> Array:
        z, m = np.split(y, [len(u)])
        now = p.acceleration(*ends(z), time + h, m)
        rest = (1 - alpha_m) * z + alpha_m * a - (1 - alpha_f) * now - alpha_f * before
        return np.append(rest, p.g(ends(z)[0], time + h) / (beta * h**2))

    z, m = np.split(root(F, np.append(a, multipliers)), [len(u)])
    return *ends(z), z, m


def bathe(p: Held, h: float, time: float, x: State) -> State:
    u, v, *_ = x
    um, vm, am, middle = newmark(p, h / 2, time, x)

    def ends(z: Array) -> tuple[Array, Array]:
        v1 = (z * h - v + 4 * vm) / 3
        return (v1 * h - u + 4 * um) / 3, v1

    def F(y: Array) -> Array:
        z, m = np.split(y, [len(u)])
        return np.append(z - p.acceleration(*ends(z), time + h, m), 9 * p.g(ends(z)[0], time + h) / h**2)

    z, m = np.split(root(F, np.append(am, middle)), [len(u)])
    return *ends(z), z, m


def radau(p: Held, h: float, time: float, x: State) -> State:
    """Radau IIA of two stages, which reports no acceleration of its own: that of the second stage is returned."""
    (u, v, a, multipliers), A = x, np.array([[5.0, -1.0], [9.0, 3.0]]) / 12
    n, at = len(u), time + h * A.sum(axis=1)

    def ends(z: Array) -> tuple[Array, Array]:
        speeds = v + h * A @ z.reshape(2, n)
        return u + h * A @ speeds, speeds

    def F(y: Array) -> Array:
        z, m = y[: 2 * n].reshape(2, n), y[2 * n :].reshape(2, -1)
        stages = [*zip(*ends(z.ravel()), at, m, strict=True)]
        rest = [z[k] - p.acceleration(*stage) for k, stage in enumerate(stages)]
        return np.concatenate([*rest, *(p.g(place, when) / h**2 for place, _, when, _ in stages)])

    y = root(F, np.concatenate([a, a, multipliers, multipliers]))
    places, speeds = ends(y[: 2 * n])
    return places[-1], speeds[-1], y[n : 2 * n], y[2 * n + len(multipliers) :]


STEPS: dict[str, tuple[dict[str, float], Callable[..., State]]] = {
    "average_acceleration": ({}, newmark),
    "generalized_alpha": ({"rho_inf": 0.8}, generalized_alpha),
    "bathe": ({}, bathe),
    "radau_iia2": ({}, radau),
}


@pytest.mark.matrix
@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("scheme", STEPS)
@pytest.mark.parametrize("seed", range(30 if VERIFY else 2))
def test_random_constraints_are_held_as_written_by_hand(seed: int, scheme: str) -> None:
    declared, (parameters, step) = drawn(seed), STEPS[scheme]
    scene, h, p = ss.scene(declared), 0.01, Held(declared)
    r = ss.march(scene, ss.scheme(scheme, **parameters), dt=h, t_end=10 * h)
    x = r.u[0], r.v[0], r.a[0], np.array([r.memory[name][0] for name in r.multipliers])
    assert p.acceleration(x[0], x[1], 0.0, x[3]) == pytest.approx(x[2], abs=1e-10)
    for k in range(10):
        x = step(p, h, k * h, x)
        own = "h^2*a" in ss.scheme(scheme).info.state
        for found, kind in ((r.u, 0), (r.v, 1), (r.a, 2))[: 3 if own else 2]:
            assert found[k + 1] == pytest.approx(x[kind], rel=0, abs=1e-8)
        assert [r.memory[name][k + 1] for name in r.multipliers] == pytest.approx(x[3], rel=1e-6, abs=1e-6)
