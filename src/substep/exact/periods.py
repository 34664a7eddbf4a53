"""Exact periods of oscillating scenes, by elliptic integrals or one quadrature, to the last digit of a double."""

from collections.abc import Callable
from typing import Any

import mpmath

from ..core.scenes import Scene

_MP = mpmath.MPContext()  # a context of our own, since the precision of mpmath.mp is the user's
_MP.dps = 30


def period(scene: Scene) -> float:
    """Period in s of the undamped motion of "duffing", "softening" or a swinging "simple_pendulum".

    Parameters are read as the decimal numbers that print them. Raises ValueError for a scene without such a period:
    another scene, one that starts at rest in equilibrium, or a pendulum that reaches the top.
    """
    if scene.name not in _PERIODS or scene.info.declaration is not None:
        raise ValueError(f"expected a scene with a known period, one of: {', '.join(_PERIODS)}; got {scene.name}")
    return float(_PERIODS[scene.name](**{key: _MP.mpf(repr(float(x))) for key, x in scene.parameters.items()}))


def _duffing(k: Any, eps: Any, u0: Any) -> Any:
    """4 K(M)/w, w^2 = k*(1 + eps*u0^2), M = k*eps*u0^2/(2*w^2), for u'' + k*u*(1 + eps*u^2) = 0 from rest."""
    cubic = eps * u0**2
    _require(u0 != 0 and 1 + cubic > 0, "duffing", "u0 other than 0 with 1 + eps*u0^2 > 0", f"u0 = {u0}, eps = {eps}")
    return 4 * _MP.ellipk(cubic / (2 * (1 + cubic))) / _MP.sqrt(k * (1 + cubic))


def _softening(k: Any, u0: Any) -> Any:
    """4 times the integral of du/v from 0 to |u0|, v^2 = 2*k*(ln cosh u0 - ln cosh u), for u'' + k*tanh(u) = 0.

    With u = |u0|*(1 - s^2) the integrand stays finite where v vanishes; ln cosh u0 - ln cosh u is the logarithm of
    1 + x, x = cosh u0/cosh u - 1 = 2 sinh((u0 + u)/2) sinh((u0 - u)/2)/cosh u, which loses no digits there.
    """
    top = abs(u0)
    _require(top > 0, "softening", "u0 other than 0", f"u0 = {u0}")

    def integrand(s: Any) -> Any:
        gap = top * s * s
        u = top - gap
        x = 2 * _MP.sinh(top - gap / 2) * _MP.sinh(gap / 2) / _MP.cosh(u)
        return 2 * top * s / _MP.sqrt(2 * k * _MP.log1p(x))

    return 4 * _MP.quad(integrand, [0, 1])


def _simple_pendulum(g_over_L: Any, u0: Any, v0: Any) -> Any:
    """4 K(M)/w, w^2 = g/L, M = sin^2(u0/2) + v0^2/(4 g/L): the energy, relative to that of rest at the top."""
    M = _MP.sin(u0 / 2) ** 2 + v0**2 / (4 * g_over_L)
    _require(0 < M < 1, "simple_pendulum", "a swing that moves and turns back below the top", f"u0 = {u0}, v0 = {v0}")
    return 4 * _MP.ellipk(M) / _MP.sqrt(g_over_L)


def _require(holds: bool, scene: str, expected: str, got: object) -> None:
    if not holds:
        raise ValueError(f"{scene}: expected {expected}, which has a period; got {got}")


_PERIODS: dict[str, Callable[..., Any]] = {
    "duffing": _duffing,
    "softening": _softening,
    "simple_pendulum": _simple_pendulum,
}
