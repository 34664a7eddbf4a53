"""Eigenvalues of a stepper as its histories show them: spectral radius, critical Omega, overshoot."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from substep.core.arrays import Array

from .noise import QUIET, Noise
from .probes import STARTS, STEPS, Measured, measure, oscillators, own_runs
from .programs.adapter import Load
from .stepper import RunFailed, Stepper

LONGEST = 6  # steps that a recursion may reach back
FIRST = 3  # steps at the start that another scheme may have made
RECURSION = 8.0  # times the noise that a recursion's residual may be: its coefficients are a few at most
ROUNDED = 4e-16  # that a recursion's residual is for each unit of Omega^2
LONG = 128  # steps that show growth in spite of noise
CRITICAL = 1e-2  # relative, by how much the ends of stable steps by two bisections may differ
SCAN = np.geomspace(0.01, 1e4, 91)
Radius = Callable[[Array], Array]


@dataclass(frozen=True)
class Eigenvalues:
    """Of one oscillator: the coefficients of the recursion that its histories obey, and its roots.

    residual: how well they obey it. Of a double root, and so of the spectral radius there, half the digits are right.
    beyond: whether the histories grew beyond what is kept; there are no roots then.
    """

    coefficients: Array
    residual: float
    beyond: bool = False

    @property
    def roots(self) -> Array:
        """The eigenvalues that show in the histories."""
        return np.roots(self.coefficients)

    @property
    def radius(self) -> float:
        """The spectral radius."""
        return np.inf if self.beyond else float(np.abs(self.roots).max(initial=0.0))

    def damping_and_period(self, Omega: float, xi: float) -> tuple[float, float]:
        """Numerical damping and period error of the largest complex pair; NaN where there is none."""
        pairs = [x for x in self.roots if x.imag > 1e-12 * abs(x)]
        if not pairs or xi >= 1.0:
            return np.nan, np.nan
        largest = max(pairs, key=abs)
        phi, damped = float(np.angle(largest)), np.sqrt(1.0 - xi * xi)
        return -float(np.log(abs(largest))) / phi - xi / damped, Omega * damped / phi - 1.0


def eigenvalues(runs: Sequence[Measured], p: int, tolerance: float) -> Eigenvalues:
    """From the histories of oscillator p: the shortest recursion that they obey to a tolerance.

    A step magnifies rounding by Omega^2: a longer recursion would have roots of it.
    """
    tolerance = max(tolerance, ROUNDED * float(runs[0].at.Omega[p]) ** 2)
    series = [run.rows[p, max(FIRST, run.startup) :, kind] for run in runs for kind in range(3)]
    known = [x for x in series if np.isfinite(x).all() and x.any()]
    if any(np.isnan(run.rows[p, :, 0]).any() for run in runs):
        return Eigenvalues(np.ones(1), 0.0, beyond=True)
    if not known:
        return Eigenvalues(np.array([1.0, 0.0]), 0.0)
    best = None
    for order in range(1, LONGEST + 1):
        windows = np.concatenate([np.lib.stride_tricks.sliding_window_view(x, order + 1) for x in known])[:, ::-1]
        sizes = np.abs(windows).max(axis=1)
        windows = windows[sizes > 1e-280] / sizes[sizes > 1e-280, None]
        found = np.linalg.lstsq(windows[:, 1:], -windows[:, 0], rcond=None)[0]
        coefficients = np.concatenate([[1.0], found])
        residual = float(np.abs(windows @ coefficients).max()) if len(windows) else 0.0
        best = Eigenvalues(coefficients, residual)
        if residual <= tolerance:
            break
    assert best is not None
    return best


def tolerance_of(stepper: Stepper, noise: Noise = QUIET) -> float:
    """The residual that rounding, or a larger noise, leaves in a recursion."""
    return max(10.0 ** (6.0 - stepper.can.digits), RECURSION * noise.size)


def measured_radius(stepper: Stepper, noise: Noise = QUIET) -> Radius:
    """The spectral radius that histories show, undamped: of a double eigenvalue only half the digits.

    NaN, which is not known, where the program raises.
    """
    tolerance = tolerance_of(stepper, noise)
    return lambda Omega: _each(stepper, Omega, STEPS, lambda runs: eigenvalues(runs, 0, tolerance).radius)


def long_radius(stepper: Stepper) -> Radius:
    """At least the spectral radius of undamped motion that grows, from long runs, which gather little of the noise.

    By how much the largest state of the second half exceeds that of the first, as a factor of each step. NaN, which is
    not known, where the program raises.
    """

    def radius(runs: Sequence[Measured]) -> float:
        found = []
        for run in runs:
            first, second = np.split(run.energy_roots[0, 1:], 2)
            with np.errstate(invalid="ignore"):
                found.append(second.max() / np.maximum(first.max(), run.energy_roots[0, 0]))
        return float(np.nan_to_num(np.max(found), nan=np.inf) ** (2.0 / LONG))

    return lambda Omega: _each(stepper, Omega, LONG, radius)


def _each(stepper: Stepper, Omega: Array, n: int, radius: Callable[[Sequence[Measured]], float]) -> Array:
    """The radius at each Omega from undamped runs of n steps, NaN where one of them fails."""
    found = []
    for one in Omega.tolist():
        try:
            found.append(radius(own_runs(stepper, [one], [0.0], n)))
        except RunFailed:
            found.append(np.nan)
    return np.array(found)


def confirmed_radius(short: Radius, long: Radius) -> Radius:
    """The smaller one of the radii that short and long runs show: what is rounding in a short run does not grow."""
    return lambda Omega: np.minimum(short(Omega), long(Omega))


def critical_Omega(radius: Radius, margin: float) -> float | None:
    """The smallest Omega up to 10^4 beyond which the spectral radius exceeds 1 + margin max(1, Omega).

    None where there is none, 0 where it does so at 0.01 already, NaN where a radius that is not known hides it.
    Instability on an interval shorter than a sixth of its Omega may be missed.
    """

    def excess(Omega: Array) -> Array:
        return radius(Omega) - 1.0 - margin * np.maximum(1.0, Omega)

    found = excess(SCAN)
    beyond = np.flatnonzero(found > 0.0)
    if np.isnan(found[: beyond[0] if len(beyond) else None]).any():
        return np.nan
    if not len(beyond):
        return None
    if beyond[0] == 0:
        return 0.0
    low, high = float(SCAN[beyond[0] - 1]), float(SCAN[beyond[0]])
    while high - low > 1e-10 * high:
        middle = 0.5 * (low + high)
        there = excess(np.array([middle]))[0]
        if np.isnan(there):
            return np.nan
        low, high = (low, middle) if there > 0.0 else (middle, high)
    return 0.5 * (low + high)


def same_limit(measured: float | None, scheme: float | None, noise: Noise) -> bool:
    """Whether two bisections end at the same Omega, but for the noise; None is no end."""
    if measured is None or scheme is None:
        return measured == scheme
    return abs(measured - scheme) <= max(CRITICAL, noise.of_radius) * scheme


def overshoot(stepper: Stepper) -> str:
    """Powers of Omega with which u_1 and v_1/omega grow in the first step, such as U0-V1; ? for what is not returned.

    From unit u_0 and unit v_0/omega, as the catalogue has them.
    """
    Omegas = np.array([1e3, 1e4])
    at = oscillators(stepper, Omegas.tolist(), [0.0])
    try:
        from_u, from_v = (measure(stepper, at, start, Load()).rows for start in STARTS)
    except RunFailed:
        return "U?-V?"
    starts = (from_u[:, 1], from_v[:, 1] * Omegas[:, None])
    found = []
    for kind, power in ((0, 0.0), (1, 1.0)):
        sizes = [np.maximum(np.abs(rows[:, kind]) / Omegas**power, 1e-12) for rows in starts]
        slopes = [float(np.log10(size[1] / size[0])) for size in sizes]
        found.append(str(max(0, *map(round, slopes))) if np.isfinite(slopes).all() else "?")
    return f"U{found[0]}-V{found[1]}"
