"""Response spectra of an acceleration record, with the relative error of each value that the scheme causes."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core.arrays import Array, named
from ..core.coefficients import refuse_damping
from ..core.errors import called_as, non_negative, real_array, real_number
from ..core.loads import Record
from ..core.schemes import Scheme
from ..core.schemes import scheme as make_scheme
from ..exact.oscillator import exact_peaks
from ..marching.linear import march_linear
from ..marching.oscillators import Oscillators
from .records import read_record
from .units import unit_of

if TYPE_CHECKING:
    from xarray import Dataset

PERIODS = np.geomspace(0.02, 10.0, 200)
PERIODS.flags.writeable = False
UNSTABLE = 1.0 + 1e-6  # largest spectral radius of a stable step; it may have only half its digits near 1

QUANTITIES = {
    "displacement": ("spectral displacement SD, relative to the ground", "m"),
    "velocity": ("spectral velocity SV, relative to the ground", "m s-1"),
    "acceleration": ("spectral acceleration SA, absolute", "m s-2"),
}


@called_as("response_spectrum(accelerations, dt=0.01, xi=0.05)")
def response_spectrum(
    record: ArrayLike | str | Path | Record,
    dt: float | None = None,
    periods: ArrayLike = PERIODS,
    xi: ArrayLike = 0.05,
    scheme: str | Scheme = "average_acceleration",
    *,
    errors: bool = True,
    unit: str | float | None = None,
) -> "Dataset":
    """Peak response of oscillators u'' + 2 xi omega u' + omega^2 u = -a_g, omega = 2 pi/period, from rest.

    record: ground acceleration (n,) with its step dt in s, or the path of a file: two columns, time (s) and
    acceleration, or PEER's .AT2 (g); a file, or a `Record`, has its own dt, and another one is an error. unit: of the
    accelerations, "g", "m/s^2", "cm/s^2", "gal", "in/s^2" or a factor to m/s^2, by default m/s^2 or what the file says;
    attrs["unit"] is the one that was taken.
    periods (P,) in s, by default 200 from 0.02 to 10 s. xi: damping ratio, or several (X,). scheme: a name or a handle,
    whose parameters are numbers; it steps from sample to sample.

    Returns a Dataset over period, and over xi where several were given: displacement (m) and velocity (m/s) relative to
    the ground, acceleration (m/s^2) absolute, |2 xi omega v + omega^2 u|; pseudo_velocity = omega*SD,
    pseudo_acceleration = omega^2*SD. Peaks are those at the record's samples: between them, and of periods of a few
    dt, the response may be larger; append zeros to a record to include the free vibration that follows it.
    errors: also displacement_error, velocity_error, acceleration_error, each the relative error of that peak against
    the exact response to the record, linear between its samples, at the same instants (Nigam & Jennings 1969). Where
    the scheme is unstable at dt, or overflows, values and errors are inf; attrs["unstable"] counts them.

    Raises ValueError for input outside of these ranges or shapes, OSError for a file that cannot be read.

    >>> shaken = np.sin(2 * np.pi * np.arange(0.0, 10.0, 0.02))  # m/s^2, with a period of 1 s
    >>> spectrum = ss.response_spectrum(shaken, dt=0.02, periods=[0.5, 1.0, 2.0])
    >>> float(spectrum.displacement.idxmax())  # s
    1.0
    """
    from xarray import Dataset  # noqa: PLC0415 (on first use)

    source = str(record) if isinstance(record, str | Path) else "array"
    load, taken = record_in(record, dt, unit)
    T, damping, s = _periods(periods), non_negative("xi", xi), _numbers_only(scheme)
    refuse_damping(s, damping)
    if damping.ndim > 1 or not damping.size:
        raise ValueError(f"expected xi to be a number or a row of them, got shape {damping.shape}")
    shape = (*damping.shape, len(T))
    omega, lanes_xi = (np.broadcast_to(x, shape).flatten() for x in (2.0 * np.pi / T, damping[..., None]))
    peaks, stable = _peaks(s, omega, lanes_xi, load)
    dims = ("xi", "period")[-len(shape) :]
    variables = {
        name: named(dims, peak.reshape(shape), {"long_name": text, "units": unit})
        for (name, (text, unit)), peak in zip(QUANTITIES.items(), peaks, strict=True)
    }
    for power, name in ((1, "velocity"), (2, "acceleration")):
        text = {"long_name": f"pseudo-spectral {name}, omega^{power} SD", "units": QUANTITIES[name][1]}
        variables[f"pseudo_{name}"] = named(dims, (omega**power * peaks[0]).reshape(shape), text)
    if errors:
        for name, peak, exact in zip(QUANTITIES, peaks, exact_peaks(omega, lanes_xi, load), strict=True):
            text = {"long_name": f"relative error of the scheme's spectral {name}", "units": "1"}
            variables[f"{name}_error"] = named(dims, relative(peak, exact).reshape(shape), text)
    coordinates = {
        "period": named("period", T, {"long_name": "natural period", "units": "s"}),
        "xi": named(dims[:-1], damping, {"long_name": "damping ratio", "units": "1"}),
    }
    attrs = {
        "scheme": s.name,
        "parameters": ", ".join(f"{key} = {float(value)}" for key, value in s.parameters.items()),
        "dt": load.dt,
        "samples": len(load.samples),
        "source": source,
        "unit": taken,
        "unstable": int(np.count_nonzero(~stable)),
    }
    return Dataset(variables, coordinates, attrs)


def as_record(record: ArrayLike | str | Path | Record, dt: float | None = None) -> Record:
    """A record of ground acceleration as `response_spectrum` takes it, with its step; raises what that raises."""
    return record_in(record, dt)[0]


def record_in(
    record: ArrayLike | str | Path | Record, dt: float | None = None, unit: str | float | None = None
) -> tuple[Record, str]:
    """The record in m/s^2, and the unit in which it was given; see `response_spectrum`."""
    if isinstance(record, str | Path):
        found = read_record(Path(record), dt, unit)
        return Record(found.dt, found.values), found.unit
    name, factor = ("m/s^2", 1.0) if unit is None else unit_of(unit)
    if isinstance(record, Record):
        if dt is not None and real_number("dt of the record", dt) != record.dt:
            raise ValueError(f"expected the record's own dt = {record.dt:g} s, got {dt:g} s; leave dt out")
        return record if factor == 1.0 else Record(record.dt, factor * record.samples), name
    if dt is None:
        raise ValueError("expected dt of the record, got none; give the step between its samples in s")
    step = real_number("dt of the record", dt, positive=True)
    return Record(step, record if factor == 1.0 else factor * real_array("record", record)), name


def _periods(periods: ArrayLike) -> Array:
    T = real_array("periods", periods)
    if T.ndim != 1 or not T.size:
        raise ValueError(f"expected periods in one row, got shape {T.shape}; give a list of them, in s")
    if (T <= 0.0).any():
        raise ValueError(f"expected periods > 0, got {T.min()}; give positive periods, in s")
    return T


def _numbers_only(scheme: str | Scheme) -> Scheme:
    s = make_scheme(scheme)
    for key, value in s.parameters.items():
        if value.ndim:
            raise ValueError(f"expected one number for {key} of {s.name}, got shape {value.shape}; call once for each")
    return s


def _peaks(s: Scheme, omega: Array, xi: Array, load: Record) -> tuple[Array, NDArray[np.bool_]]:
    """Largest |u|, |v|, |2 xi omega v + omega^2 u| (3, P), inf where not stable; and where it is stable (P,)."""
    peaks = np.full((3, len(omega)), np.inf)
    stable = s.spectral_radius(omega * load.dt, xi) <= UNSTABLE
    some = _at_rest(omega[stable], xi[stable], load)
    peaks[:, stable] = march_linear(s, some, len(load.samples) - 1, load, keep="peak_absolute").peak
    peaks[:, ~np.isfinite(peaks).all(axis=0)] = np.inf
    return peaks, np.isfinite(peaks[0])


def _at_rest(omega: Array, xi: Array, load: Record) -> Oscillators:
    start = np.zeros((3, len(omega)))
    start[2] = load.samples[0]
    return Oscillators(omega, xi, np.ones(len(omega)), np.full(len(omega), load.dt), start)


def relative(found: Array, exact: Array) -> Array:
    """found/exact - 1; 0 where both are equal, also to 0; inf where only exact is 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(found == exact, 0.0, found / exact - 1.0)
