"""What a run is measured against: the exact motion where it is known, else a converged one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ...core.scenes import Scene
from ...core.schemes import Array, scheme
from ...exact import motions
from ...marching.run import march

MOST_STEPS = 1 << 22
LOADED = 1 << 16  # steps at least under a load, so that no pulse falls between two instants
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
    """u, v, a (n, d) at times t (n,), s; error: how far what is compared is off at most, relative to its largest."""

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
    quantity within wished, relative to its largest; they are extrapolated. That they agree is asked of the runs as they
    are, since fast vibration that coarse steps damp, or a load that jumps, does not follow the order. Raises ValueError
    where 4 million steps do not reach that.
    """
    t = np.linspace(0.0, t_end, samples + 1)
    known = motions.motion(scene)
    if known is not None:
        u, v = known(t)
        return Reference(scene, t, u, v, scene.acceleration(t, u, v), 1e-15, "exact motion")

    def told(u: Array, v: Array) -> Array:
        return QUANTITIES[quantity](scene, t, u, v, scene.acceleration(t, u, v))

    rk4, steps, coarse, off = scheme("rk4"), samples, None, np.inf
    while scene.load is not None and steps < LOADED:
        steps *= 2
    while steps <= MOST_STEPS:
        r = march(scene, rk4, t_end / steps, t_end, stride=steps // samples)
        fine = np.stack([r.u, r.v]) if r.status == "completed" else None
        if fine is not None and coarse is not None:
            should = told(*fine)
            off = float(np.abs(should - told(*coarse)).max() / (np.abs(should).max() or 1.0))
            if off <= wished:
                u, v = fine + (fine - coarse) / (2**ORDER - 1)
                return Reference(scene, t, u, v, scene.acceleration(t, u, v), off, f"rk4, {steps} steps, extrapolated")
        coarse, steps = fine, 2 * steps
    raise ValueError(
        f"expected a motion of {scene.name} that {MOST_STEPS} steps over {t_end:.12g} s resolve to {wished:g}, got "
        f"an error of {quantity} of about {off:.3g}; ask for a shorter span or less accuracy"
    )
