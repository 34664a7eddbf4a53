"""Exact motions of the scenes that have one: in closed form or, for the elastic pendulum, by quadrature."""

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np

from ..core.scenes import Scene
from ..core.schemes import Array
from .pendulum import ElasticPendulum

Motion = Callable[[Array], tuple[Array, Array]]

_MP = mpmath.MPContext()  # a context of our own, since the precision of mpmath.mp is the user's
_MP.dps = 30


def motion(scene: Scene) -> Motion | None:
    """A function from times (n,) in s to the scene's exact u, v (n, d); None where no exact motion is known."""
    make = _MOTIONS.get(scene.name)
    return make(**scene.parameters) if make and scene.load is None and scene.info.declaration is None else None


def _oscillator(omega: float, xi: float, u0: float, v0: float) -> Motion | None:
    if xi >= 1.0:
        return None
    damped = omega * np.sqrt(1.0 - xi * xi)

    def of(t: Array) -> tuple[Array, Array]:
        decay, cosine, sine = np.exp(-xi * omega * t), np.cos(damped * t), np.sin(damped * t)
        u = decay * (u0 * cosine + (v0 + xi * omega * u0) / damped * sine)
        v = decay * (v0 * cosine - (xi * omega * v0 + omega**2 * u0) / damped * sine)
        return u[:, None], v[:, None]

    return of


def _elastic(EA: float, L: float, m: float, v0: float) -> Motion | None:
    return ElasticPendulum(EA, L, m, v0).motion if v0 > 0 else None


def _rigid(L: float, m: float, v0: float) -> Motion:
    del m
    return lambda t: ((v0 / L * t)[:, None], np.full((len(t), 1), v0 / L))


def _duffing(k: float, eps: float, u0: float) -> Motion:
    """u0*cn(w*t | M), w^2 = k*(1 + eps*u0^2), M = k*eps*u0^2/(2*w^2), which solves u'' + k*u*(1 + eps*u^2) = 0."""
    stiffness, given = (_MP.mpf(repr(float(x))) for x in (k, u0))
    cubic = _MP.mpf(repr(float(eps))) * given**2
    w = _MP.sqrt(stiffness * (1 + cubic))
    M = cubic / (2 * (1 + cubic))

    def at(t: float) -> tuple[Any, Any]:
        sn, cn, dn = (_MP.ellipfun(kind, w * t, m=M) for kind in ("sn", "cn", "dn"))
        return given * cn, -given * w * sn * dn

    def of(t: Array) -> tuple[Array, Array]:
        rows = np.array([at(x) for x in t.tolist()], dtype=np.float64).reshape(-1, 2)
        return rows[:, :1], rows[:, 1:]

    return of


_MOTIONS: dict[str, Callable[..., Motion | None]] = {
    "linear_oscillator": _oscillator,
    "elastic_pendulum": _elastic,
    "rigid_pendulum": _rigid,
    "duffing": _duffing,
}
