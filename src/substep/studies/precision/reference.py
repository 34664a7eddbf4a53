"""The reference from which errors are computed: the exact motion where it is known, else a converged one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ...core.scenes import Scene
from ...core.schemes import Array, scheme
from ...exact import motions
from ...marching.run import marched

MOST_STEPS = 1 << 22
LOADED = 1 << 16  # least number of steps under a load, so that no pulse falls between two of them
ORDER = 4  # of rk4, by which two runs are extrapolated
TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 3e-14)  # of DOP853, relative; the last is the least that SciPy takes

Quantity = Callable[[Scene, Array, Array, Array, Array], Array]


def _angle(scene: Scene, t: Array, u: Array, v: Array, a: Array) -> Array:
    del t, v, a
    turned = u[:, 0] if len(scene.coordinates) == 1 else np.arctan2(u[:, 1], u[:, 0])
    return np.stack([np.cos(turned), np.sin(turned)], axis=1)


QUANTITIES: Mapping[str, Quantity] = {
    "u": lambda scene, t, u, v, a: u,
    "v": lambda scene, t, u, v, a: v,
    "a": lambda scene, t, u, v, a: a,
    "energy": lambda scene, t, u, v, a: scene.energy(t, u, v)[:, None],
    "angle": _angle,
    "multipliers": lambda scene, t, u, v, a: scene.multipliers(t, u, v),
}


def places(scene: Scene) -> tuple[str, ...]:
    """Names of its coordinates and outputs, which may be compared one by one; not of what is a quantity anyway."""
    names = [*(name for name, _ in scene.coordinates), *scene.info.outputs]
    return tuple(name for name in names if name not in QUANTITIES)


def value(name: str, scene: Scene, t: Array, u: Array, v: Array, a: Array) -> Array:
    """A quantity, a coordinate or an output (n, k) of the scene at t (n,), from u, v, a (n, d)."""
    if name in QUANTITIES:
        return QUANTITIES[name](scene, t, u, v, a)
    of_coordinates = [x for x, _ in scene.coordinates]
    if name in of_coordinates:
        return u[:, [of_coordinates.index(name)]]
    return scene.outputs(t, u, v)[name][:, None]


@dataclass(frozen=True)
class Reference:
    """u, v, a (n, d) at times t (n,), s; error: of the compared quantity, relative to its largest value."""

    scene: Scene
    t: Array
    u: Array
    v: Array
    a: Array
    error: float
    source: str


def reference(scene: Scene, t_end: float, samples: int, wished: float, quantity: str = "u") -> Reference:
    """The motion at samples + 1 times from 0 to t_end, s.

    Where no closed form is known: the classical Runge-Kutta scheme, its step halved until two runs agree in the
    quantity within wished, relative to its largest value; then they are extrapolated. The runs themselves have to
    agree, not extrapolated ones, since errors from a vibration that coarse steps damp, or from a load that jumps, do
    not follow the order. Of a scene with constraints: SciPy's DOP853 on the accelerations that mass, forces and
    constraints give together, its tolerance lowered until two runs agree likewise. Raises ValueError where 4 million
    steps, or the least tolerance, do not reach agreement, and for contacts, frictions and laws that remember.
    """
    if others := [name for name in scene.info.memory if name not in scene.info.multipliers]:
        raise ValueError(
            f"expected a scene without contacts, frictions and laws that remember, got {scene.name} with "
            f"{', '.join(others)}; march it with a step and with half of it, and compare"
        )
    t = np.linspace(0.0, t_end, samples + 1)
    known = motions.motion(scene)
    if known is not None:
        u, v = known(t)
        return Reference(scene, t, u, v, scene.acceleration(t, u, v), 1e-15, "exact motion")

    def compared(u: Array, v: Array) -> Array:
        return value(quantity, scene, t, u, v, scene.acceleration(t, u, v))

    if scene.info.multipliers:
        return _constrained(scene, t, compared, wished)
    rk4, steps, coarse, error = scheme("rk4"), samples, None, np.inf
    while scene.load is not None and steps < LOADED:
        steps *= 2
    while steps <= MOST_STEPS:
        r = marched(scene, rk4, t_end / steps, t_end, stride=steps // samples)
        fine = np.stack([r.u, r.v]) if r.status == "completed" else None
        if fine is not None and coarse is not None:
            x = compared(*fine)
            error = float(np.abs(x - compared(*coarse)).max() / (np.abs(x).max() or 1.0))
            if error <= wished:
                u, v = fine + (fine - coarse) / (2**ORDER - 1)
                source = f"rk4, {steps} steps, extrapolated"
                return Reference(scene, t, u, v, scene.acceleration(t, u, v), error, source)
        coarse, steps = fine, 2 * steps
    raise ValueError(
        f"expected a motion of {scene.name} that {MOST_STEPS} steps over {t_end:.12g} s resolve to {wished:g}, got "
        f"an error of {quantity} of about {error:.3g}; ask for a shorter span or less accuracy"
    )


def _constrained(scene: Scene, t: Array, compared: Callable[[Array, Array], Array], wished: float) -> Reference:
    """The motion of a scene with constraints, whose accelerations keep what the start has of them."""
    from scipy.integrate import solve_ivp  # noqa: PLC0415 (on first use)

    d, start, coarse, error = len(scene.u0), np.concatenate([scene.u0, scene.v0]), None, np.inf

    def rates(at: float, y: Array) -> Array:
        return np.concatenate([y[d:], scene.acceleration(np.array(at), y[:d], y[d:])])

    for tol in TOLERANCES:
        r = solve_ivp(rates, (0.0, t[-1]), start, "DOP853", t, rtol=tol, atol=tol * scene.length, max_step=t[1])
        u, v = r.y[:d].T, r.y[d:].T
        fine = compared(u, v)
        if coarse is not None:
            error = float(np.abs(fine - coarse).max() / (np.abs(fine).max() or 1.0))
            if error <= wished:
                return Reference(scene, t, u, v, scene.acceleration(t, u, v), error, f"DOP853, rtol = {tol:g}")
        coarse = fine
    raise ValueError(
        f"expected a motion of {scene.name} that two runs of DOP853 over {t[-1]:.12g} s agree on to {wished:g}, got a "
        f"difference of {error:.3g}; ask for a shorter span or less accuracy"
    )
