"""Exact motion of the elastic pendulum without gravity, the scene of Kuhl & Crisfield 1999.

A point mass on a pinned bar with Green-Lagrange strain keeps its energy and its angular momentum, so the square s of
its length obeys s'^2 = cubic(s), and time and angle are quadratures. s moves between a = L^2, where it starts, and b,
and the third root of the cubic is a - b:

    s'^2 = EA/(m*L^3) * (s - a)*(b - s)*(s + b - a),    angle' = L*v0/s.

With s = (a + b)/2 - (b - a)/2*cos(psi) the first two factors cancel: dt/dpsi and dangle/dpsi are smooth, even and
periodic in psi, so the trapezoid rule gives their cosine series with geometric convergence.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import mpmath
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core.errors import real_array, real_number

_MP = mpmath.MPContext()  # a context of our own, since the precision of mpmath.mp is the user's
_MP.dps = 40
_NEGLIGIBLE = _MP.mpf(10) ** -30  # relative to the mean; ten more digits are left for round-off and for many periods
_MOST_POINTS = 1024

Number = Any  # mpf of _MP


@dataclass(frozen=True)
class ElasticPendulum:
    """A mass m (kg) on a bar pinned at the origin, of length L (m) and stiffness EA (N), from (L, 0) at (0, v0) (m/s).

    Strain energy EA*L*strain^2/2, strain = (l^2 - L^2)/(2*L^2), no gravity; the defaults are Kuhl & Crisfield 1999.
    Every parameter is read as the decimal number that prints it, mpmath.mpf(repr(value)): 3.0443 is not a binary
    number, and the published 18 digits belong to the decimal one.
    """

    EA: float
    L: float = 3.0443
    m: float = 10.0
    v0: float = 7.72

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            object.__setattr__(self, name, real_number(name, getattr(self, name), positive=True))

    def position(self, t: ArrayLike) -> NDArray[np.float64]:
        """Positions (x, y) in metres, shape (..., 2), at times t in seconds of shape (...), of either sign.

        By quadrature of the conserved quantities at 40 digits, rounded to float64; times are taken as the binary
        numbers they are, up to 1e15 periods. About 0.2 ms a time, and for a bar first met 10 ms, or 2 s if very soft.
        Raises ValueError for a bar so soft, EA*L below about 2e-5*m*v0^2, that its series need too many terms.
        """
        return self.motion(t)[0]

    def motion(self, t: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What `position` returns, and the velocity in m/s with the same shape and accuracy."""
        times = real_array("t", t)
        states = self._motion.states(times.ravel()).reshape(*times.shape, 4)
        return states[..., :2], states[..., 2:]

    @property
    def radial_period(self) -> float:
        """Time in seconds from one passage at length L to the next."""
        return float(self._motion.period)

    @property
    def angle_per_period(self) -> float:
        """Angle in rad swept in one radial period."""
        return float(self._motion.angle)

    @property
    def _motion(self) -> "_Motion":
        return _motion(self.EA, self.L, self.m, self.v0)


class _Motion(NamedTuple):
    """The motion by psi: t = period*psi/(2*pi) + sum of t_sines[k-1]*sin(k*psi), and the angle likewise."""

    a: Number
    span: Number  # b - a
    moment: Number  # L*v0, the angular momentum over the mass: s*angle' at any time
    pace: Number  # dt/dpsi*sqrt(s + span)
    period: Number
    t_sines: list[Number]
    angle: Number  # swept in one period
    angle_sines: list[Number]

    def states(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """x, y in metres and their rates, shape (n, 4), at n times in seconds."""
        periods = [_MP.nint(t / self.period) for t in times.tolist()]
        rests = [t - n * self.period for t, n in zip(times.tolist(), periods, strict=True)]
        near = self._near(np.array(rests, dtype=np.float64)).tolist()
        found = [self._state(*at) for at in zip(periods, rests, near, strict=True)]
        return np.array(found, dtype=np.float64).reshape(-1, 4)

    def _near(self, rests: NDArray[np.float64]) -> NDArray[np.float64]:
        """Psi in float64 at times within half a period, by Newton's method."""
        k, sines = np.arange(1, len(self.t_sines) + 1), np.array(self.t_sines, dtype=np.float64)
        mean = float(self.period) / (2 * np.pi)
        psi = rests / mean
        for _ in range(5):  # enough for the softest bar, as no two slopes differ by more than a factor of sqrt(2)
            phases = np.outer(psi, k)
            psi -= (mean * psi + np.sin(phases) @ sines - rests) / (mean + np.cos(phases) @ (k * sines))
        return psi

    def _state(self, periods: Number, rest: Number, near: float) -> tuple[float, ...]:
        """x, y and their rates at t = periods*period + rest; near: psi at the rest, in float64."""
        cosine, sines = _sines(near, len(self.t_sines))
        t = self.period * near / (2 * _MP.pi) + _MP.fdot(self.t_sines, sines)
        # one more step of Newton's method squares the error of float64
        psi = near + (rest - t) * _MP.sqrt(_square(self.a, self.span, cosine) + self.span) / self.pace
        cosine, sines = _sines(psi, len(self.angle_sines))
        angle = self.angle * (periods + psi / (2 * _MP.pi)) + _MP.fdot(self.angle_sines, sines)
        s = _square(self.a, self.span, cosine)
        length = _MP.sqrt(s)
        stretching = self.span * sines[0] / 2 * _MP.sqrt(s + self.span) / self.pace / (2 * s)  # length'/length
        x, y, rotation = length * _MP.cos(angle), length * _MP.sin(angle), self.moment / s  # rotation: angle'
        return float(x), float(y), float(stretching * x - rotation * y), float(stretching * y + rotation * x)


@lru_cache(maxsize=64)
def _motion(*parameters: float) -> _Motion:
    """The motion for EA, L, m, v0."""
    EA, L, m, v0 = (_MP.mpf(repr(value)) for value in parameters)
    a = L**2
    q = 4 * m * v0**2 * L**3 / EA  # b*(b - a), from the constant term of the cubic
    span = 2 * q / (a + _MP.sqrt(a**2 + 4 * q))
    pace = _MP.sqrt(m * L**3 / EA)

    def slope(cosine: Number) -> Number:
        return pace / _MP.sqrt(_square(a, span, cosine) + span)

    t = _integrated(slope)
    angle = _integrated(lambda cosine: slope(cosine) * L * v0 / _square(a, span, cosine))
    if t is None or angle is None:
        raise ValueError(
            f"expected a bar that stretches to about 20 L at most, got EA = {parameters[0]}, with which it "
            f"stretches to {_MP.nstr(_MP.sqrt(a + span) / L, 3)} L; give a larger EA or a smaller v0"
        )
    return _Motion(a, span, L * v0, pace, *t, *angle)


def _square(a: Number, span: Number, cosine: Number) -> Number:
    """The squared length s at the psi whose cosine is given."""
    return a + span * (1 - cosine) / 2


def _sines(psi: Number, count: int) -> tuple[Number, list[Number]]:
    """cos(psi), and sin(k*psi) for k = 1..count by their recurrence."""
    cosine, sine = _MP.cos_sin(psi)
    sines = [_MP.zero, sine]
    while len(sines) <= count:
        sines.append(2 * cosine * sines[-1] - sines[-2])
    return cosine, sines[1 : count + 1]


def _integrated(rate: Callable[[Number], Number]) -> tuple[Number, list[Number]] | None:
    """(period, sines): rate(cos(psi)) integrates to period*psi/(2*pi) + sum of sines[k-1]*sin(k*psi).

    The number of points doubles until the last quarter of the series is negligible; None if it never is.
    """
    n = 16  # points on half a period
    while n <= _MOST_POINTS:
        cosines = [_MP.cospi(_MP.mpf(j) / n) for j in range(2 * n)]
        rates = [rate(cosine) / n for cosine in cosines]
        series = [_MP.fdot((rates[j], cosines[j * k % (2 * n)]) for j in range(2 * n)) for k in range(n)]
        kept = max(k for k in range(n) if abs(series[k]) > _NEGLIGIBLE * series[0])
        if kept < 3 * n // 4:
            return _MP.pi * series[0], [series[k] / k for k in range(1, kept + 1)]
        n *= 2
    return None
