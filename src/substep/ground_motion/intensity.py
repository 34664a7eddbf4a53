"""How strong a ground motion is: peaks, Arias intensity, cumulative absolute velocity, significant durations."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ..core.arrays import Array
from ..core.errors import called_as
from ..core.exports import Exported
from ..core.loads import Record
from ..core.units import STANDARD_GRAVITY, unit_of
from .spectrum import record_of


@dataclass(frozen=True, repr=False)
class Intensity(Exported):
    """Measures of the intensity of a ground motion; see `substep.intensity`.

    pga: peak ground acceleration, m/s^2. pgv: peak ground velocity, m/s. pgd: peak ground displacement, m. arias: Arias
    intensity, m/s. cav: cumulative absolute velocity, m/s. d5_95, d5_75: significant durations, s, both of which begin
    at `start`, s after the first sample. unit: of the accelerations as they were given.
    """

    pga: float
    pgv: float
    pgd: float
    arias: float
    cav: float
    d5_95: float
    d5_75: float
    start: float
    unit: str

    def __repr__(self) -> str:
        return (
            f"Intensity(PGA {self.pga:.4g} m/s^2, PGV {self.pgv:.4g} m/s, PGD {self.pgd:.4g} m, "
            f"Arias {self.arias:.4g} m/s, CAV {self.cav:.4g} m/s, D5-95 {self.d5_95:.4g} s and "
            f"D5-75 {self.d5_75:.4g} s from {self.start:.4g} s on)"
        )


@called_as("intensity(accelerations, dt=0.01)")
def intensity(
    record: ArrayLike | str | Path | Record, dt: float | None = None, unit: str | float | None = None
) -> Intensity:
    """Measures of the intensity of a ground motion, each exact for a record that is linear between its samples.

    record, dt, unit: as in `substep.response_spectrum`. Returns a `substep.ground_motion.intensity.Intensity`:
    pga, pgv, pgd: the largest ground acceleration (m/s^2), velocity (m/s) and displacement (m), also within steps.
    Velocity and displacement are integrated from rest at the first sample without a correction of the baseline, so that
    a record which was not processed drifts, and its pgd, then also its pgv, are those of the drift.
    arias: pi/(2g) times the integral of a^2, m/s, with g = 9.80665 m/s^2 (A. Arias, A measure of earthquake intensity,
    in R. J. Hansen, ed., Seismic Design for Nuclear Power Plants, MIT Press, 438-483, 1970).
    cav: the integral of |a|, m/s, over the whole record, as in EPRI NP-5930, A criterion for determining exceedance of
    the operating basis earthquake, 1988; not the standardized one of later reports, which leaves weak seconds out.
    d5_95, d5_75: the times, s, in which the integral of a^2 goes from 5 to 95 %, or to 75 %, of its last value, and
    start, when it is at 5 % (M. D. Trifunac, A. G. Brady, A study on the duration of strong earthquake ground motion,
    Bull. Seism. Soc. Am. 65, 581-626, 1975, who take 5 to 95 %); NaN for a record of zeros.

    Raises ValueError and OSError as `substep.response_spectrum` does.

    >>> ss.intensity([2.0, 2.0, 2.0], dt=0.5)  # 2 m/s^2 for 1 s
    Intensity(PGA 2 m/s^2, PGV 2 m/s, PGD 1 m, Arias 0.6407 m/s, CAV 2 m/s, D5-95 0.9 s and D5-75 0.7 s from 0.05 s on)
    """
    load = record_of(record, dt, unit)
    a, h = load.samples, float(load.dt)
    before, after = a[:-1], a[1:]
    velocity, displacement = _peaks(a, h)
    squares = np.concatenate([[0.0], np.cumsum(h / 6.0 * (before**2 + after**2 + (before + after) ** 2))])
    start, at_75, at_95 = (_time_of(part, squares, a, h) for part in (0.05, 0.75, 0.95))
    return Intensity(
        pga=float(np.abs(a).max()),
        pgv=velocity,
        pgd=displacement,
        arias=np.pi / (2.0 * STANDARD_GRAVITY) * float(squares[-1]),
        cav=_absolute_integral(a, h),
        d5_95=at_95 - start,
        d5_75=at_75 - start,
        start=start,
        unit=unit_of(load.unit)[0],
    )


def _absolute_integral(a: Array, h: float) -> float:
    """The integral of |a|: of two triangles in a step where the sign changes, else of a trapezoid."""
    before, after = np.abs(a[:-1]), np.abs(a[1:])
    both = before + after
    changes = np.sign(a[:-1]) * np.sign(a[1:]) < 0.0
    return 0.5 * h * float(np.where(changes, (before**2 + after**2) / np.where(both > 0.0, both, 1.0), both).sum())


def _peaks(a: Array, h: float) -> tuple[float, float]:
    """Largest |velocity| and |displacement| from rest, of a linear acceleration in each step.

    They are found at samples and, within steps, where the acceleration or the velocity is 0.
    """
    before, after = a[:-1], a[1:]
    v = np.concatenate([[0.0], np.cumsum(0.5 * h * (before + after))])
    u = np.concatenate([[0.0], np.cumsum(h * v[:-1] + h**2 / 6.0 * (2.0 * before + after))])
    first, rise = v[:-1], (after - before) / h
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        at_0_acceleration = -before / rise
        q = -before - np.copysign(np.sqrt(before**2 - 2.0 * rise * first), before)
        at_0_velocity = np.array([q / rise, 2.0 * first / q])  # both roots, without cancellation

    def largest(samples: Array, times: Array, *coefficients: Array) -> float:
        """Of samples, and of the polynomial in the time within a step at such times, if they are within it."""
        t = np.where((times > 0.0) & (times < h), times, 0.0)  # NaN is not
        within = np.zeros_like(t)
        for coefficient in coefficients:
            within = within * t + coefficient
        return max(float(np.abs(samples).max()), float(np.abs(within).max()))

    velocity = largest(v, at_0_acceleration, 0.5 * rise, before, first)
    return velocity, largest(u, at_0_velocity, rise / 6.0, 0.5 * before, first, u[:-1])


def _time_of(part: float, squares: Array, a: Array, h: float) -> float:
    """When the integral of a^2, whose values at the samples are `squares`, is at a part of its last one; NaN if 0.

    In a step, a^3 - a0^3 = 3 a' times the integral of a^2 from the step's start on.
    """
    if squares[-1] == 0.0:
        return math.nan
    target = part * float(squares[-1])
    k = int(np.searchsorted(squares, target)) - 1
    rest, a0, rise = float(target - squares[k]), float(a[k]), float(a[k + 1] - a[k]) / h
    y = math.cbrt(a0**3 + 3.0 * rise * rest)
    return h * k + min(3.0 * rest / (y * y + y * a0 + a0 * a0), h)
