"""Loads per unit mass, functions of time that a march samples at the scheme's own instants."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from .arrays import Array
from .errors import real_array, real_number


class Load(Protocol):
    """Anything that gives the load per unit mass at an array of times."""

    def __call__(self, t: Array) -> Array:
        """Load at the times t, of the same shape."""
        ...


@dataclass(frozen=True)
class Harmonic:
    """amplitude * sin(omega*t + phase)."""

    amplitude: float
    omega: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        for name in ("amplitude", "omega", "phase"):
            real_number(name, getattr(self, name))

    def __call__(self, t: Array) -> Array:
        """Load at the times t."""
        return self.amplitude * np.sin(self.omega * t + self.phase)


@dataclass(frozen=True)
class Step:
    """amplitude from t = start on, 0 before."""

    amplitude: float
    start: float = 0.0

    def __post_init__(self) -> None:
        real_number("amplitude", self.amplitude)
        real_number("start", self.start)

    def __call__(self, t: Array) -> Array:
        """Load at the times t."""
        return np.where(t >= self.start, self.amplitude, 0.0)


@dataclass(frozen=True)
class HalfSine:
    """amplitude * sin(pi*t/duration) for 0 <= t <= duration, 0 elsewhere."""

    amplitude: float
    duration: float

    def __post_init__(self) -> None:
        real_number("amplitude", self.amplitude)
        real_number("duration", self.duration, positive=True)

    def __call__(self, t: Array) -> Array:
        """Load at the times t."""
        inside = (t >= 0) & (t <= self.duration)
        return np.where(inside, self.amplitude * np.sin(np.pi * t / self.duration), 0.0)


@dataclass(frozen=True, eq=False)
class Record:
    """Samples at 0, dt, 2 dt, ..., linear between them, 0 after the last. Two are equal for equal dt and samples."""

    dt: float
    values: ArrayLike
    _values: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        real_number("dt of the record", self.dt, positive=True)
        values = real_array("values of the record", self.values).copy()
        if values.ndim != 1 or values.size < 2:
            raise ValueError(f"expected a record of at least two samples in one row, got shape {values.shape}")
        values.flags.writeable = False
        object.__setattr__(self, "_values", values)

    @property
    def samples(self) -> Array:
        """The values (n,), read only."""
        return self._values

    def __call__(self, t: Array) -> Array:
        """Load at the times t."""
        position = np.asarray(t) / self.dt
        nearest = np.rint(position)  # an instant that differs from a sample's only by rounding counts as the sample's
        position = np.where(np.abs(position - nearest) <= 1e-9, nearest, position)
        last = self._values.size - 1
        before = np.clip(np.floor(position), 0, last - 1).astype(np.int64)
        share = position - before
        between = self._values[before] * (1.0 - share) + self._values[before + 1] * share
        return np.where((position >= 0.0) & (position <= last), between, 0.0)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Record) and self.dt == other.dt and np.array_equal(self._values, other._values)

    def __hash__(self) -> int:
        return hash((self.dt, len(self._values), *self._values[:16].tolist()))
