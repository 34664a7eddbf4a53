"""How well a program repeats itself: its noise, which every threshold of an audit follows."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from .probes import STARTS, Measured, measure
from .programs.adapter import Load
from .stepper import RunFailed, Stepper

Key = TypeVar("Key")
SHARES = (0.8, -0.6)  # of the two unit starts in the run that superposes them
MARGIN = 4.0  # times the noise that a candidate's deviation may reach: noise stands in all that it is compared with
MATCH = 1e-5  # deviation, in units of a step's condition, that constants of a few digits may cause without any noise
ROUNDING = 1e-11  # deviation that rounding in double precision may cause
MOST = 0.05  # noise beyond which a step is not that of a linear oscillator to any digit, and no scheme is looked for
RELATIVE = 10.0  # times: noise that is so much larger relative to a step than to the largest state so far is absolute
MEASURED = 1e-6  # by how much a spectral radius that is measured without any noise may be off, at Omega <= 1
DOUBLE = 3.0  # times the root of the noise by which eigenvalues that meet may be off


@dataclass(frozen=True)
class Noise:
    """size: of a number that the program returns, relative to the state, in units of a step's condition.

    absolute: whether it is relative to the largest state so far instead, since it does not shrink with the state.
    """

    size: float = 1e-15
    absolute: bool = False

    @property
    def match(self) -> float:
        """The largest deviation from what is the same."""
        return max(MATCH, MARGIN * self.size)

    @property
    def worth(self) -> float:
        """The largest deviation of a scheme that may match once its parameters are solved for to more digits."""
        return 10.0 * self.match

    @property
    def rounding(self) -> float:
        """The largest deviation where nothing but the noise may explain it."""
        return max(ROUNDING, MARGIN * self.size)

    @property
    def of_radius(self) -> float:
        """How far a spectral radius may be off, where two eigenvalues meet."""
        return DOUBLE * math.sqrt(self.size) if self.loud else 0.0

    @property
    def margin(self) -> float:
        """By how much a spectral radius of 1 that a short run shows may exceed 1, times max(1, Omega)."""
        return max(MEASURED, DOUBLE * MARGIN * math.sqrt(self.size))

    @property
    def loud(self) -> bool:
        """Whether it is more than rounding in double precision."""
        return self.size > ROUNDING

    @property
    def digits(self) -> int:
        """How many decimal digits the program repeats."""
        return max(0, round(-math.log10(self.size)))

    @property
    def text(self) -> str:
        """In words."""
        of = "the largest state so far" if self.absolute else "the state"
        return f"results repeat to {self.digits} digits of {of}"

    @property
    def hides(self) -> bool:
        """Whether it hides the scheme."""
        return self.size > MOST

    def least(self, errors: Mapping[Key, float]) -> Key:
        """The key of the smallest error; the first one, unless it is more than the noise."""
        first = next(iter(errors))
        return first if errors[first] <= self.rounding else min(errors, key=lambda key: errors[key])

    def over(self, runs: Sequence[Measured]) -> list[Measured]:
        """The same runs, whose deviations are relative to what this noise is relative to."""
        return [replace(run, absolute=self.absolute) for run in runs]


QUIET = Noise()  # that of rounding in double precision


def measured_noise(stepper: Stepper, own: Sequence[Measured]) -> Noise:
    """How far a run from both starts is off the sum of the runs from each, and not less than its digits allow.

    A step of a linear oscillator superposes whatever the scheme is; rounding, printed digits and an iteration that
    stops early do not. own: the runs from unit starts of u and h*v, or of u alone.
    """
    least = 10.0**-stepper.can.digits
    at, a, b = own[0].at, *SHARES
    try:
        both = measure(stepper, at, (a, b, None), Load())
        own = [*own, *(measure(stepper, at, start, Load()) for start in STARTS[len(own) :])]
    except RunFailed:
        return Noise(least)
    found = []
    for absolute in (False, True):
        x, y = (replace(run, absolute=absolute) for run in own)
        with np.errstate(all="ignore"):
            off = (both.rows - a * x.rows - b * y.rows) / at.scale[:, None] / at.scale[:, None, 2:]
            sizes = np.maximum(abs(a) * x.sizes, abs(b) * y.sizes)
            found.append(float(np.nanmax(np.abs(off / sizes)[:, 1:], initial=least)))
    relative, absolute = found
    return Noise(absolute, True) if relative > RELATIVE * absolute and relative > ROUNDING else Noise(relative)
