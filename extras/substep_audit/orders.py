"""The order of accuracy of a stepper, observed on motions that are known exactly."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from substep.core.arrays import Array

from .noise import QUIET, Noise
from .programs.adapter import Load
from .stepper import Stepper

OMEGA, RATIO, T = 1.0, 0.05, 6.0
STEPS = (24, 48, 96, 192, 384)
COARSE = 1e-6  # errors below which a motion is called exact
NOISY = 200.0  # times the noise: ten times what so many steps gather of it
ASYMPTOTIC = 3  # step sizes that show an order where not all can be looked at
SETTLED = 0.15  # a slope that is nearer than this to a whole number is that order


@dataclass(frozen=True)
class Motion:
    """A motion of an oscillator: start u0, v0 and load."""

    u0: float
    v0: float
    load: Load

    def exact(self, t: Array, xi: float) -> Array:
        """u, v, a (n, 3) of u'' + 2 xi omega u' + omega^2 u = A sin(p t + phi)."""
        p, phi = self.load.omega, self.load.phase
        amplitude = self.load.amplitude if self.load.kind == "harmonic" else 0.0
        driven = amplitude * np.exp(1j * phi) / (OMEGA**2 - p**2 + 2j * xi * OMEGA * p)
        turned = driven * np.exp(1j * p * t)
        u, v = turned.imag, (1j * p * turned).imag
        u0, v0 = self.u0 - driven.imag, self.v0 - (1j * p * driven).imag
        damped = OMEGA * np.sqrt(1.0 - xi**2)
        decay, cosine, sine = np.exp(-xi * OMEGA * t), np.cos(damped * t), np.sin(damped * t)
        u = u + decay * (u0 * cosine + (v0 + xi * OMEGA * u0) / damped * sine)
        v = v + decay * (v0 * cosine - (xi * OMEGA * v0 + OMEGA**2 * u0) / damped * sine)
        force = amplitude * np.sin(p * t + phi)
        return np.stack([u, v, force - 2.0 * xi * OMEGA * v - OMEGA**2 * u], axis=-1)


MOTIONS: Mapping[str, Motion] = {
    "free": Motion(1.0, 0.7, Load()),
    "driven": Motion(1.0, 0.7, Load("harmonic", 1.0, 1.3, 0.9)),  # f(0) is not 0
    "driven from rest": Motion(0.0, 0.0, Load("harmonic", 1.0, 1.3, 0.0)),  # neither u, v, a nor f at t = 0
}

UNDAMPED = "undamped "  # stands before the name of a motion

Order = tuple[float | None, float | None, float | None]


def observed_orders(stepper: Stepper, noise: Noise = QUIET) -> dict[str, Order]:
    """For each motion, damped and undamped, the order of u, v and a; None where not output, or exact but for rounding.

    NaN, which is not known, of a u that is not a number in any run.

    noise: of what is observed, or of what it is compared with: errors that it may hide are not looked at.
    """
    loaded = stepper.can.load != "none"
    return {
        before + name: _observed(stepper, motion, noise, xi)
        for before, xi in (("", RATIO), (UNDAMPED, 0.0))
        if stepper.can.damping or before
        for name, motion in MOTIONS.items()
        if loaded or motion.load.kind == "none"
    }


def _observed(stepper: Stepper, motion: Motion, noise: Noise, xi: float) -> Order:
    errors = []
    for n in STEPS:
        load = Load(motion.load.kind, motion.load.amplitude, motion.load.omega, motion.load.phase)
        rows = stepper.histories(OMEGA, xi, T / n, n, motion.u0, motion.v0, None, load)
        every = n // STEPS[0]
        exact = motion.exact(np.linspace(0.0, T, STEPS[0] + 1), xi)
        errors.append(np.abs(rows[::every] - exact)[STEPS[0] // 2 :].max(axis=0))
    floor = max(10.0 ** (4.0 - stepper.can.digits), NOISY * noise.size if noise.loud else 0.0)
    u, v, a = (_slope(np.array(column), floor) for column in zip(*errors, strict=True))
    return np.nan if np.isnan(errors)[:, 0].all() else u, v, a  # a u that is no number is not exact


def _slope(errors: Array, floor: float) -> float | None:
    """The order from the two smallest steps whose errors are not rounding; None where all are, or nothing is output.

    -inf where a run overflows; NaN where results have so few digits that rounding may hide what errors there are: the
    coarsest steps alone do not show an order.
    """
    if np.isnan(errors).all():
        return None
    if not np.isfinite(errors).all():
        return -np.inf
    known = np.flatnonzero(errors > floor)
    fewest = 2 if floor <= COARSE else ASYMPTOTIC
    if len(known) < fewest or known[-1] < fewest - 1:
        return None if floor <= COARSE else np.nan
    last = known[-1]
    slope = float(np.log2(errors[last - 1] / errors[last]))
    return float(round(slope)) if abs(slope - round(slope)) <= SETTLED else round(slope, 1)


def compared(
    observed: Mapping[str, Order],
    expected: Mapping[str, Order],
    model: Mapping[str, Order],
    scheme: Mapping[str, Order],
) -> tuple[dict[str, Order], dict[str, Order]]:
    """Observed orders beside the expected ones; where noise hides one, that of the model beside that of the scheme."""
    pairs = {
        motion: [
            (y, z) if any(x is not None and np.isnan(x) for x in (o, e)) else (o, e)
            for o, e, y, z in zip(observed[motion], expected[motion], model[motion], scheme[motion], strict=True)
        ]
        for motion in observed
    }
    first, second = ({m: (u[i], v[i], a[i]) for m, (u, v, a) in pairs.items()} for i in (0, 1))
    return first, second


def written(order: float | None) -> str:
    """An order in words: a number, "exact" but for rounding, or "diverges" where smaller steps make errors grow.

    "not measured" where results have too few digits.
    """
    if order is None:
        return "exact"
    if np.isnan(order):
        return "not measured"
    return "diverges" if order <= -1.0 else f"{order:g}"
