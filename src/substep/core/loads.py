"""Loads, functions of time that a march samples at the scheme's own instants."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike

from .arrays import Array, read_only
from .errors import float_array, made_as, real_array, real_number
from .exports import Exported
from .kernel_modules import loaded
from .units import TURN, require_angle, require_ground_motion, unit_of


class Load(Protocol):
    """Anything that gives the load at an array of times."""

    def __call__(self, t: Array) -> Array:
        """Load at the times t, of the same shape."""
        ...


@made_as("Harmonic(1.0, omega=6.28)")
@dataclass(frozen=True)
class Harmonic:
    """The load amplitude * sin(omega*t + phase) at t in s.

    amplitude: in N, or in the unit of the load that it stands for; omega: in rad/s; phase: in rad. Raises ValueError
    unless each is one finite number, and for a phase of whole degrees: a whole number beyond 2 pi.
    """

    amplitude: float
    omega: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        for name in ("amplitude", "omega", "phase"):
            real_number(name, getattr(self, name))
        if float(self.phase).is_integer():  # a phase that was computed hardly ever is
            require_angle("phase", float(self.phase))

    def __call__(self, t: Array) -> Array:
        """Load at the times t."""
        return self.formula(t, self.amplitude, self.omega, self.phase)

    def __repr__(self) -> str:
        period = f", T={TURN / abs(self.omega):.5g} s" if self.omega else ""
        return f"Harmonic(amplitude={self.amplitude}, omega={self.omega}{period}, phase={self.phase})"

    @staticmethod
    def formula(t: Array, amplitude: ArrayLike, omega: ArrayLike, phase: ArrayLike) -> Array:
        """Load at the times t for parameters that are numbers, or those of lanes: (P,) or (P, 1, ...)."""
        own = np.broadcast(amplitude, omega, phase).shape
        values = np.empty(np.broadcast(t, amplitude, omega, phase).shape)
        values[...] = t
        parameters = np.empty((3, *own))
        parameters[0], parameters[1], parameters[2] = amplitude, omega, phase
        if len(own) == 1 < own[0]:
            x, parameters = values.reshape(-1, *own), parameters[:, None]
        else:
            parameters = parameters.reshape(3, -1, 1)
            x = values.reshape(parameters.shape[1], -1)
        if not loaded("shared.loads").harmonic(x, parameters):
            values[...] = np.multiply(amplitude, np.sin(np.multiply(omega, values) + phase))
        return values[()]


@made_as("Step(1.0)")
@dataclass(frozen=True)
class Step:
    """The load amplitude from t = start on, 0 before; an instant that differs from start only by rounding is start.

    amplitude: in N, or in the unit of the load that it stands for; start: in s. Raises ValueError unless each is one
    finite number.
    """

    amplitude: float
    start: float = 0.0

    def __post_init__(self) -> None:
        real_number("amplitude", self.amplitude)
        real_number("start", self.start)

    def __call__(self, t: Array) -> Array:
        """Load at the times t."""
        return self.formula(t, self.amplitude, self.start)

    @staticmethod
    def formula(t: Array, amplitude: ArrayLike, start: ArrayLike) -> Array:
        """Load at the times t for parameters that broadcast with them."""
        return np.where(t >= np.asarray(start) - ROUNDING * np.abs(start), amplitude, 0.0)


@made_as("HalfSine(1.0, duration=0.1)")
@dataclass(frozen=True)
class HalfSine:
    """The load amplitude * sin(pi*t/duration) for 0 <= t <= duration, 0 elsewhere.

    amplitude: in N, or in the unit of the load that it stands for; duration: in s. Raises ValueError unless each is one
    finite number and the duration positive.
    """

    amplitude: float
    duration: float

    def __post_init__(self) -> None:
        real_number("amplitude", self.amplitude)
        real_number("duration", self.duration, positive=True)

    def __call__(self, t: Array) -> Array:
        """Load at the times t."""
        return self.formula(t, self.amplitude, self.duration)

    @staticmethod
    def formula(t: Array, amplitude: ArrayLike, duration: ArrayLike) -> Array:
        """Load at the times t for parameters that broadcast with them."""
        within = np.clip(t, 0.0, duration)
        wave = _sine(_changed(np.divide, np.pi * within, duration))
        return np.where(within == t, _changed(np.multiply, wave, amplitude), 0.0)


@made_as("Record(0.01, accelerations)")
@dataclass(frozen=True, eq=False, repr=False)
class Record(Exported):
    """Samples at 0, dt, 2 dt, ..., linear between them, 0 after the last. Two are equal for equal dt and samples.

    unit: of ground accelerations, "g", "m/s^2", "cm/s^2", "gal", "in/s^2" or a factor to m/s^2, in which `samples` are;
    without a unit, samples are the values. source: where they come from.
    """

    axes: ClassVar = {"values": ("sample",)}

    dt: float
    values: ArrayLike
    _values: Array = field(init=False)
    unit: str | float = field(default="", kw_only=True)
    source: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        real_number("dt of the record", self.dt, positive=True)
        given = values = real_array("values of the record", self.values).copy()
        object.__setattr__(self, "values", given)  # what changes later in the caller's is none of this record
        if values.ndim != 1 or values.size < 2:
            raise ValueError(f"expected a record of at least two samples in one row, got shape {values.shape}")
        if self.unit != "":
            name, factor = unit_of(self.unit)
            if isinstance(self.unit, str):
                object.__setattr__(self, "unit", name)
            values = values * factor
        object.__setattr__(self, "_values", values)
        for kept in (given, values):
            kept.flags.writeable = False

    @property
    def samples(self) -> Array:
        """The values (n,), with a unit in m/s^2, read only."""
        return self._values

    def of_ground(self) -> Record:
        """The same in m/s^2. Raises ValueError for one without a unit that is likely in another."""
        if self.unit != "":
            return self
        require_ground_motion(self.dt, self._values)
        return replace(self, unit="m/s^2")

    def __call__(self, t: Array) -> Array:
        """Load at the times t; an instant that differs from a sample's only by rounding counts as the sample's."""
        times = np.asarray(t, dtype=np.float64)
        values = np.empty(times.shape)
        loaded("shared.loads").interpolate(self._values, float(self.dt), read_only(times), values.reshape(-1))
        return values[()]

    def at_steps(self, steps: range, tau: float, dt: float) -> Array:
        """Load at the times (k + tau)*dt of the steps k, consecutive ones, to the last bit as at an array of them."""
        values = np.empty(len(steps))
        between = float(self.dt), float(dt), float(tau)
        loaded("shared.loads").interpolate_steps(self._values, *between, steps.start, values)
        return values

    def __repr__(self) -> str:
        known = "".join(f", {name}={x!r}" for name, x in (("unit", self.unit), ("source", self.source)) if x != "")
        return f"Record(dt={self.dt}, {len(self._values)} samples{known})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Record) and self.dt == other.dt and np.array_equal(self._values, other._values)

    def __hash__(self) -> int:
        return hash((self.dt, len(self._values), *self._values[:16].tolist()))


@dataclass(frozen=True, eq=False)
class LoadLanes:
    """The loads of P lanes, of one kind: parameters of `kind`, numbers or (P,)."""

    kind: type[Harmonic] | type[Step] | type[HalfSine]
    parameters: Mapping[str, Any]

    def __call__(self, t: Array) -> Array:
        """Load of each lane at the times t (..., P) or (..., 1), (..., P)."""
        return self.kind.formula(t, **self.parameters)

    def lanes(self, where: slice) -> LoadLanes:
        """Those of some of the lanes."""
        return LoadLanes(self.kind, {name: x[where] if np.ndim(x) else x for name, x in self.parameters.items()})

    def lane(self, j: int) -> Load:
        """That of lane j."""
        return self.kind(**{name: float(x[j] if np.ndim(x) else x) for name, x in self.parameters.items()})

    def along_first_axis(self, dimensions: int) -> LoadLanes:
        """The same for times (P, ...) or (1, ...) of so many dimensions, to loads (P, ...)."""
        inner = (1,) * (dimensions - 1)
        values = ((name, np.asarray(x)) for name, x in self.parameters.items())
        return LoadLanes(self.kind, {name: x.reshape(-1, *inner) if x.ndim else x for name, x in values})


ARRAY_OF_TIMES = "expected a load that takes an array of times and returns an array of the same shape"
VECTORISED = "in it use np.where in place of if, np.sin in place of math.sin, and 0*t + c for a constant c"
ROUNDING = 1e-12  # by which two times that are the same may differ, relative
NO_SAMPLES = read_only(np.zeros(2))
KINDS = (Harmonic, Step, HalfSine)  # whose parameters can differ from lane to lane


def is_known(load: Load | None) -> bool:
    """Whether the load is one of this module, which threads may evaluate piece by piece, and not the user's own."""
    return load is None or type(load) in (Record, LoadLanes, *KINDS)


def values_at(load: Load, t: Array, *, finite: bool = True) -> Array:
    """The load at the times t. Raises ValueError for another shape and, unless finite is False, for one not finite."""
    try:
        values = load(t)
    except (TypeError, ValueError) as error:
        if is_known(load) or np.ndim(t) == 0:
            raise
        raise ValueError(f"{ARRAY_OF_TIMES}, got from it {type(error).__name__}: {error}; {VECTORISED}") from error
    if type(load) is Record:
        return values  # finite as its samples are
    return _checked(values, np.shape(values if isinstance(load, LoadLanes) else t), finite)


def _checked(values: ArrayLike, shape: tuple[int, ...], finite: bool = True) -> Array:
    forces = float_array("the load", values)
    if forces.shape != shape:
        raise ValueError(f"{ARRAY_OF_TIMES}, of shape {shape} here, got from it shape {forces.shape}; {VECTORISED}")
    with np.errstate(over="ignore", invalid="ignore"):
        found = math.isfinite(forces.sum()) or np.isfinite(forces).all()  # the sum needs no array
    if finite and not found:
        bad = forces[~np.isfinite(forces)].flat[0]
        raise ValueError(f"expected a finite load at every time, got {bad}; correct the load function")
    return forces


def _changed(operation: np.ufunc, x: Array, y: ArrayLike) -> Array:
    """x + y or the like, in the place of x, an array of ours, where it has the shape for it: new memory is slow."""
    fits = np.broadcast_shapes(np.shape(x), np.shape(y)) == np.shape(x) != ()
    return operation(x, y, out=x if fits else None)


def _sine(x: Array) -> Array:
    """sin(x) of an array that may be overwritten, to 2 units in the last place."""
    x = np.asarray(x, dtype=np.float64, order="C")
    if not loaded("shared.loads").sine(x.reshape(-1)):
        np.sin(x, out=x)
    return x[()]


def of_ground(record: Any) -> Record:
    """The record in m/s^2. Raises ValueError for anything else, and as `Record.of_ground`."""
    if not isinstance(record, Record):
        raise ValueError(f"expected the ground acceleration as ss.Record(dt, values), got {type(record).__name__}")
    return record.of_ground()


def break_points(load: Load | None, t_end: float) -> Array:
    """Times within (0, t_end) at which a load or a derivative of it jumps, ascending."""
    if isinstance(load, Step):
        found = np.array([load.start])
    elif isinstance(load, HalfSine):
        found = np.array([load.duration])
    elif isinstance(load, Record):
        found = load.dt * np.arange(1.0, min(len(load.samples), int(min(t_end / load.dt, 1e9)) + 2))
    else:
        return np.empty(0)
    return found[(found > 0.0) & (found < t_end)]


def peak(load: Load, sizes: Array) -> float:
    """The largest modulus, whenever it is; of one of the user's own the largest of these, at some times."""
    if isinstance(load, KINDS):
        return abs(load.amplitude)
    return float(np.abs(load.samples).max() if isinstance(load, Record) else sizes.max())


def jumps(load: Load | None) -> Array:
    """Times at which a load jumps, ascending; one of the user's own is taken for continuous."""
    if isinstance(load, Step) and load.amplitude != 0.0:
        return np.array([load.start])
    if isinstance(load, Record) and load.samples[-1] != 0.0:
        return np.array([load.dt * (len(load.samples) - 1)])
    return np.empty(0)


def behind_jump(load: Load | None, t: float) -> float | None:
    """The value of a load just behind a jump at the time t, which may differ by rounding; None where there is none."""
    if load is None or not (np.abs(jumps(load) - t) <= ROUNDING * abs(t)).any():
        return None
    return float(values_at(load, np.array([t + 1.0 + abs(t)]))[0])  # what jumps stays as it is from there on


def one_sided(load: Load) -> Callable[[float, float], float]:
    """The load at a time, on the side of another time that lies between the same two of its break points."""
    if not is_known(load):
        return lambda t, middle: float(values_at(load, np.array([t]))[0])
    ((numbers,), samples), value = as_numbers(load), loaded("shared.step_control")._load
    return lambda t, middle: float(value(numbers, samples, middle, t))


def as_numbers(load: Load | None) -> tuple[Array, Array]:
    """A load of this module as kernels that choose their steps take it: kind and parameters (1, 4), samples.

    Raises ValueError for a function of the user's own, which compiled steps cannot call.
    """
    if load is None:
        return np.zeros((1, 4)), NO_SAMPLES
    if isinstance(load, Harmonic):
        return np.array([[1.0, load.amplitude, load.omega, load.phase]]), NO_SAMPLES
    if isinstance(load, Step):
        return np.array([[2.0, load.amplitude, load.start, 0.0]]), NO_SAMPLES
    if isinstance(load, HalfSine):
        return np.array([[3.0, load.amplitude, load.duration, 0.0]]), NO_SAMPLES
    if isinstance(load, Record):
        return np.array([[4.0, load.dt, 0.0, 0.0]]), load.samples
    raise ValueError(
        f"expected a load of substep's own where steps are chosen, got {type(load).__name__}, which compiled kernels "
        "cannot call; sample it as ss.Record(dt, values), or march with dt"
    )
