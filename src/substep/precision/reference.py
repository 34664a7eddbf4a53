"""What a run is measured against: the exact motion where it is known, else a converged one."""

from dataclasses import dataclass

import numpy as np

from ..marching import march
from ..scenes import Scene
from ..schemes import Array, scheme
from . import exact

MOST_STEPS = 1 << 22
ORDER = 4  # of rk4, by which the error of the finer of two runs is told


@dataclass(frozen=True)
class Reference:
    """u, v, a (n, d) at times t (n,), s; error: how far u is off, relative to its largest, as far as is known."""

    scene: Scene
    t: Array
    u: Array
    v: Array
    a: Array
    error: float
    source: str


def reference(scene: Scene, t_end: float, samples: int, wished: float) -> Reference:
    """The motion at samples + 1 times from 0 to t_end, s.

    Where no closed form is known: the classical Runge-Kutta scheme, its step halved until two runs extrapolate to the
    same u within wished, relative to the largest u. Raises ValueError where 4 million steps do not reach that.
    """
    t = np.linspace(0.0, t_end, samples + 1)
    known = exact.motion(scene)
    if known is not None:
        u, v = known(t)
        return Reference(scene, t, u, v, scene.acceleration(t, u, v), 1e-15, "exact motion")
    rk4, steps, coarse, off = scheme("rk4"), samples, None, np.inf
    while steps <= MOST_STEPS:
        r = march(scene, rk4, t_end / steps, t_end, stride=steps // samples)
        fine = np.stack([r.u, r.v]) if r.status == "completed" else None
        if fine is not None and coarse is not None:
            change = (fine - coarse) / (2**ORDER - 1)
            off = float(np.abs(change[0]).max() / (np.abs(fine[0]).max() or 1.0))
            if off <= wished:
                u, v = fine + change
                return Reference(scene, t, u, v, scene.acceleration(t, u, v), off, f"rk4, {steps} steps, extrapolated")
        coarse, steps = fine, 2 * steps
    raise ValueError(
        f"expected a motion of {scene.name} that {MOST_STEPS} steps over {t_end:.12g} s resolve to {wished:g}, got an "
        f"error of about {off:.3g}; ask for a shorter span or less accuracy"
    )
