"""Exact motions of the scenes that have one: in closed form or, for the elastic pendulum, by quadrature."""

from collections.abc import Callable, Sequence
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

    return lambda t: _columns([at(x) for x in t.tolist()])


def _simple(g_over_L: float, u0: float, v0: float) -> Motion | None:
    """2 asin(k sn(w t | k^2)), w^2 = g/L, v0 = 2 w k, for a swing from the lowest point that does not turn over."""
    if u0 != 0.0 or g_over_L <= 0.0:
        return None
    w = _MP.sqrt(_MP.mpf(repr(float(g_over_L))))
    k = _MP.mpf(repr(float(v0))) / (2 * w)
    if abs(k) >= 1:
        return None

    def at(t: float) -> tuple[Any, Any]:
        sn, cn = (_MP.ellipfun(kind, w * t, m=k * k) for kind in ("sn", "cn"))
        return 2 * _MP.asin(k * sn), 2 * w * k * cn

    return lambda t: _columns([at(x) for x in t.tolist()])


def _bounce(k: float, u0: float, v0: float) -> Motion | None:
    """Free flight, half a sine in contact, free flight back."""
    if u0 < 0.0 or k <= 0.0:
        return None
    w, begin = np.sqrt(k), -u0 / v0
    end = begin + np.pi / w

    def of(t: Array) -> tuple[Array, Array]:
        within, parts = w * (t - begin), (t < begin, t < end)
        u = np.select(parts, (u0 + v0 * t, v0 / w * np.sin(within)), -v0 * (t - end))
        v = np.select(parts, (np.full_like(t, v0), v0 * np.cos(within)), -v0)
        return u[:, None], v[:, None]

    return of


def _bathe_noh(k1: float, k2: float, omega_p: float) -> Motion | None:
    """By modes: from rest, q'' + w^2 q = f sin(p t) has q = f/(w^2 - p^2) (sin(p t) - p/w sin(w t))."""
    stiff, soft, p = (_MP.mpf(repr(float(x))) for x in (k1, k2, omega_p))
    values, shapes = _MP.eigsy(_MP.matrix([[stiff + soft, -soft], [-soft, soft]]))
    if min(values) <= 0 or any(x == p * p for x in values):
        return None

    def at(t: float) -> tuple[Any, ...]:
        u, v = _MP.matrix(2, 1), _MP.matrix(2, 1)
        for i, square in enumerate(values):
            w, factor = _MP.sqrt(square), stiff * shapes[0, i] / (square - p * p)
            u += shapes[:, i] * factor * (_MP.sin(p * t) - p / w * _MP.sin(w * t))
            v += shapes[:, i] * factor * p * (_MP.cos(p * t) - _MP.cos(w * t))
        return (*u, *v)

    return lambda t: _columns([at(x) for x in t.tolist()])


def _columns(rows: Sequence[Sequence[Any]]) -> tuple[Array, Array]:
    """u and v (n, d) from rows of u, then v."""
    table = np.array(rows, dtype=np.float64).reshape(len(rows), -1)
    return table[:, : table.shape[1] // 2], table[:, table.shape[1] // 2 :]


_MOTIONS: dict[str, Callable[..., Motion | None]] = {
    "linear_oscillator": _oscillator,
    "elastic_pendulum": _elastic,
    "rigid_pendulum": _rigid,
    "duffing": _duffing,
    "simple_pendulum": _simple,
    "penalty_bounce": _bounce,
    "bathe_noh": _bathe_noh,
}
