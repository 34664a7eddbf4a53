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
}


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
    not follow the order. Raises ValueError where 4 million steps do not reach agreement.
    """
    if scene.info.memory:
        raise ValueError(
            f"expected a scene without constraints and without laws that remember, got {scene.name} with "
            f"{', '.join(scene.info.memory)}; march it with a step and with half of it, and compare"
        )
    t = np.linspace(0.0, t_end, samples + 1)
    known = motions.motion(scene)
    if known is not None:
        u, v = known(t)
        return Reference(scene, t, u, v, scene.acceleration(t, u, v), 1e-15, "exact motion")

    def compared(u: Array, v: Array) -> Array:
        return QUANTITIES[quantity](scene, t, u, v, scene.acceleration(t, u, v))

    rk4, steps, coarse, error = scheme("rk4"), samples, None, np.inf
    while scene.load is not None and steps < LOADED:
        steps *= 2
    while steps <= MOST_STEPS:
        r = marched(scene, rk4, t_end / steps, t_end, stride=steps // samples)
        fine = np.stack([r.u, r.v]) if r.status == "completed" else None
        if fine is not None and coarse is not None:
            value = compared(*fine)
            error = float(np.abs(value - compared(*coarse)).max() / (np.abs(value).max() or 1.0))
            if error <= wished:
                u, v = fine + (fine - coarse) / (2**ORDER - 1)
                source = f"rk4, {steps} steps, extrapolated"
                return Reference(scene, t, u, v, scene.acceleration(t, u, v), error, source)
        coarse, steps = fine, 2 * steps
    raise ValueError(
        f"expected a motion of {scene.name} that {MOST_STEPS} steps over {t_end:.12g} s resolve to {wished:g}, got "
        f"an error of {quantity} of about {error:.3g}; ask for a shorter span or less accuracy"
    )
