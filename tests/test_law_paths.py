"""Each law along random paths, against a second account of it: from event to event, or integrated by SciPy."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from plain_kernels import committed
from scipy.integrate import quad_vec, solve_ivp

import substep as ss

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
            meets = (k * x - q - slope * foot) / (k - slope) if slope < k else peak  # of unloading and that line
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


SMOOTH = {"k": 25.0, "q_y": 4.0, "alpha": 0.1, "A": 1.0, "beta": 0.5, "gamma": 0.5}
LAWS: list[tuple[str, Callable[..., Oracle], dict[str, float]]] = [
    *(("bilinear", bilinear, {"k": 25.0, "q_y": 4.0, "alpha": alpha}) for alpha in (0.0, 0.2)),
    *(("isotropic_bilinear", isotropic_bilinear, {"k": 25.0, "q_y": 4.0, "alpha": alpha}) for alpha in (0.0, 0.05)),
    ("coulomb", coulomb, {"stiffness": 100.0, "q_y": 3.0}),
    *(("slip", slip, {"stiffness": 30.0, "q_y": 4.0, "gap": gap}) for gap in (0.0, 0.1)),
    *(("clough", clough, {"k": 25.0, "q_y": 4.0, "alpha": alpha}) for alpha in (0.0, 0.1)),
    ("multilinear", multilinear, {"k": 25.0, "e_1": 0.1, "k_2": 5.0, "e_2": 0.3, "k_3": 40.0}),
    *(("bouc_wen", bouc_wen, SMOOTH | {"n": n}) for n in (1, 2)),
    *(("bouc_wen", bouc_wen, SMOOTH | {"A": 1.2, "beta": 0.7, "gamma": 0.1, "n": n}) for n in (1, 2)),
    ("bouc_wen", bouc_wen, SMOOTH | {"beta": 0.4, "gamma": -0.3, "n": 2}),
    ("maxwell", maxwell, {"stiffness": 20.0, "c": 3.0}),
]
IDS = [f"{name}-{'-'.join(f'{x:g}' for x in values.values())}" for name, _, values in LAWS]


ACCOUNTED = [name for name in IDS if not name.startswith("clough")]  # which keeps no account of what it dissipates


@cache
def plain(name: str) -> Any:
    return committed(f"laws.{name}")


def law(name: str, values: dict[str, float]) -> ss.Law:
    """The law with functions that are not compiled."""
    renamed = {"beta": "beta_bw", "gamma": "gamma_bw"}
    made = ss.law(name, **{renamed.get(key, key): x for key, x in values.items()})
    return replace(made, module=plain(name))


def path(seed: int, n: int = 40) -> Array:
    """Elongations, each a turn or on the way to one: at yield it is 0.16."""
    rng = np.random.default_rng(seed)
    return (rng.normal(size=n) * np.where(rng.random(n) < 0.5, 0.1, 0.4)).cumsum() * 0.7


@pytest.mark.parametrize(("name", "oracle", "values"), LAWS, ids=IDS)
@pytest.mark.parametrize("seed", [1, 2])
def test_force_along_a_path(name: str, oracle: Callable[..., Oracle], values: dict[str, float], seed: int) -> None:
    made, (memory, follow), elapsed = law(name, values), oracle(**values), 0.05
    kept, largest = made.unstrained(), 0.0
    for e in path(seed):
        found = made.evaluate([e], memory=kept, elapsed=elapsed)
        q, memory = follow(float(e), memory, elapsed)
        kept, largest = found.memory, max(largest, abs(q))
        assert found.force[0] == pytest.approx(q, abs=1e-10 * largest + 1e-13)
    assert largest > 2.0


@pytest.mark.parametrize(("name", "oracle", "values"), [x for x in LAWS if x[0] != "clough"], ids=ACCOUNTED)
def test_work_is_stored_or_dissipated(name: str, oracle: Callable[..., Oracle], values: dict[str, float]) -> None:
    """The integral of the oracle's force along the path, against the law's two energies."""
    made, (memory, follow), elapsed, x, work = law(name, values), oracle(**values), 0.05, 0.0, 0.0
    kept, before = made.unstrained(), 0.0
    for e in path(5, 8):

        def force(s: float, x: float = x, e: float = float(e), memory: Any = memory) -> float:
            return follow(x + s * (e - x), memory, s * elapsed)[0] if s else 0.0

        work += quad_vec(force, 0, 1, epsabs=1e-11, epsrel=1e-11)[0] * (e - x)
        found = made.evaluate([e], memory=kept, elapsed=elapsed)
        (_, memory), kept, x = follow(float(e), memory, elapsed), found.memory, float(e)
        dissipated = float(kept[0, made.memory.index("dissipated")]) if "dissipated" in made.memory else 0.0
        assert found.stored[0] + dissipated == pytest.approx(work, rel=1e-8, abs=1e-9)
        assert dissipated >= before - 1e-12
        before = dissipated


@pytest.mark.parametrize(("name", "oracle", "values"), LAWS, ids=IDS)
def test_tangent_is_the_slope_of_the_force(name: str, oracle: Callable[..., Oracle], values: dict[str, float]) -> None:
    made, elapsed, far = law(name, values), 0.05, 0
    kept, step = made.unstrained(), 1e-6
    for e in path(4):
        q = [made.evaluate([e + d], memory=kept, elapsed=elapsed).force[0] for d in (-step, 0.0, step)]
        found = made.evaluate([e], memory=kept, elapsed=elapsed)
        if abs(q[0] + q[2] - 2 * q[1]) < 1e-8:  # else it bends within
            assert found.tangent[0] == pytest.approx((q[2] - q[0]) / (2 * step), rel=1e-6, abs=1e-5)
            far += 1
        kept = found.memory
    assert far > 20


@pytest.mark.xfail(strict=True, reason="good to 1e-8 where n is not 1 or 2: the rule of ten points meets z^n at z = 0")
@pytest.mark.parametrize("n", [1.3, 1.7, 2.5])
def test_bouc_wen_of_any_exponent(n: float) -> None:
    test_force_along_a_path("bouc_wen", bouc_wen, SMOOTH | {"n": n}, 1)


@pytest.mark.parametrize("exponent", [0.1, 0.5, 1.0, 1.7, 2.0])
def test_a_damper_of_a_power_of_the_rate(exponent: float) -> None:
    made = law("power_damper", {"c": 3.0, "exponent": exponent})
    for rate in (-2.0, -1e-3, 1e-3, 0.5, 2.0):
        found = made.evaluate([0.3], [rate], elapsed=0.05)
        assert found.force[0] == pytest.approx(3.0 * np.sign(rate) * abs(rate) ** exponent, rel=1e-13)
        assert found.damping[0] == pytest.approx(3.0 * exponent * abs(rate) ** (exponent - 1), rel=1e-12)
