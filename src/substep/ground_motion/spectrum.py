"""Response spectra of an acceleration record, with the relative error of each value that the scheme causes."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core import single
from ..core.arrays import Array, named
from ..core.coefficients import refuse_damping
from ..core.device import Device, on
from ..core.errors import called_as, damping_ratio, real_array, real_number
from ..core.loads import Record
from ..core.schemes import Scheme
from ..core.units import require_step, unit_of
from ..run.schemes import numbers_only
from .peaks import GOOD, Peaks, peaks_at_samples, peaks_refined, relative
from .records import read_record

if TYPE_CHECKING:
    from xarray import Variable

    from .history import Spectrum

PERIODS = np.geomspace(0.02, 10.0, 200)
# names of what is no scheme of steps: the exact response to a record, linear between its samples
EXACT = ("exact", "nigam", "nigam_jennings", "piecewise_exact", "piecewise_linear", "duhamel")
PERIODS.flags.writeable = False

QUANTITIES = {
    "displacement": ("spectral displacement SD, relative to the ground", "m"),
    "velocity": ("spectral velocity SV, relative to the ground", "m s-1"),
    "acceleration": ("spectral acceleration SA, absolute", "m s-2"),
}


@called_as("response_spectrum(accelerations, dt=0.01, xi=0.05)")
def response_spectrum(
    record: ArrayLike | str | Path | Record,
    dt: float | None = None,
    periods: ArrayLike | None = None,  # 200 from 0.02 to 10 s
    xi: ArrayLike = 0.05,
    scheme: str | Scheme = "average_acceleration",
    *,
    frequencies: ArrayLike | None = None,
    errors: bool = True,
    unit: str | float | None = None,
    refine: str | None = None,
    device: Device = "cpu",
    dtype: single.Dtype = "float64",
) -> Spectrum:
    """Peak response of oscillators u'' + 2 xi omega u' + omega^2 u = -a_g, omega = 2 pi/period, from rest.

    record: ground acceleration (n,) with its step dt in s, or the path of a file, as `read_record` takes it with dt and
    unit; where a file, or a `Record`, has its own dt, another one is an error. unit: of the accelerations, "g",
    "m/s^2", "cm/s^2", "gal", "in/s^2" or a factor to m/s^2, by default what the file says, else m/s^2 if their peak is
    that of a ground motion, 1e-4 g to 5 g; attrs["unit"] is the one that was taken.
    periods (P,) in s, by default 200 from 0.02 to 10 s; 0 is the ground itself, with SD = SV = 0 and SA the largest
    ground acceleration, of which pseudo_acceleration has the limit. frequencies (P,) > 0 in Hz, in place of periods,
    are kept as a coordinate beside them. xi: damping ratio, or several (X,). scheme: a name or a handle, whose
    parameters are numbers; it steps from sample to sample.

    Returns a Dataset over period, and over xi where several were given: displacement (m) and velocity (m/s) relative to
    the ground, acceleration (m/s^2) absolute, |2 xi omega v + omega^2 u|; pseudo_velocity = omega*SD,
    pseudo_acceleration = omega^2*SD. Peaks are those at the record's samples: between them, and of periods of a few
    dt, the response may be larger; append zeros to a record to include the free vibration that follows it.
    errors: also displacement_error, velocity_error, acceleration_error, each the relative error of that peak against
    the exact response to the record, linear between its samples, at the same instants (Nigam & Jennings 1969), and
    attrs["good_from"], s: the shortest of the periods such that it and all longer ones have an acceleration_error of at
    most 1 %, at each xi; NaN if there is none. Where the scheme is unstable at dt, or overflows, values and errors are
    inf; attrs["unstable"] counts them.
    refine: "auto" steps each oscillator in 2, 4, 8, ... equal steps from sample to sample, where it needs them, through
    the same record, until its three peaks are within 1 % of the exact response at all times, to which the errors are
    relative then, not at the samples alone; `steps` is how many it took. A record of n samples allows 2^24/n of them;
    where that is too few, the errors say so.
    device: "cuda" for the threads of a GPU, an oscillator each, with values that differ by rounding alone; "auto" for a
    GPU if there is one. It pays for many thousands of oscillators: see docs/large_sweeps.md.
    dtype: "float32" marches in single precision, with twice the oscillators at once, and up to 64 of them, evenly
    chosen, in double precision too. attrs then say how many digits remain of the quantity that keeps fewest,
    float32_digits, and of each quantity the largest relative error found, float32_error; a warning, where fewer than
    three do or an oscillator overflows that does not in float64. Values are stored as float64.

    `history(T=0.5)` of the result is the `substep.Response` of one oscillator: see docs/spectra.md.

    Raises ValueError for input outside of these ranges or shapes, and for a dt above 1 s, likely in ms; OSError for a
    file that cannot be read; RuntimeError where there is no such device, ImportError where numba has no CUDA.

    >>> shaken = np.sin(2 * np.pi * np.arange(0.0, 10.0, 0.02))  # m/s^2, with a period of 1 s
    >>> spectrum = ss.response_spectrum(shaken, dt=0.02, periods=[0.5, 1.0, 2.0])
    >>> float(spectrum.displacement.idxmax())  # s
    1.0
    """
    from .history import MadeFrom, Spectrum  # noqa: PLC0415 (loads xarray)

    load = record_of(record, dt, unit)
    T, damping = natural_periods(periods, frequencies), damping_ratio("xi", xi)
    s = _scheme(scheme)
    refuse_damping(s, damping)
    if damping.ndim > 1 or not damping.size:
        raise ValueError(f"expected xi to be a number or a row of them, got shape {damping.shape}")
    swings = T > 0.0
    lanes = (*damping.shape, int(np.count_nonzero(swings)))
    omega, lanes_xi = (np.broadcast_to(x, lanes).flatten() for x in (2.0 * np.pi / T[swings], damping[..., None]))
    if refine not in (None, "auto"):
        raise ValueError(f'expected refine="auto", or none for the steps of the record, got {refine!r}')
    auto = refine is not None
    single.require_possible(dtype, {})

    def peaks_of(some: Any, errors: bool) -> Peaks:
        of = s, omega[some], lanes_xi[some], load
        return peaks_refined(*of) if auto else peaks_at_samples(*of, errors)

    with on(device), single.on(dtype):
        found = peaks_of(slice(None), errors)
    peaks = found.found
    dims = ("xi", "period")[-len(lanes) :]

    def variable(values: Array | NDArray[np.int64], of_ground: float, long_name: str, units: str) -> Variable:
        """Of all periods, from the values of the oscillators and that of the ground, where the period is 0."""
        whole = np.full((*damping.shape, len(T)), of_ground, values.dtype)
        whole[..., swings] = values.reshape(lanes)
        return named(dims, whole, {"long_name": long_name, "units": units})

    of_ground = (0.0, 0.0, float(np.abs(load.samples).max()))
    variables = {
        name: variable(peak, ground, text, unit)
        for (name, (text, unit)), peak, ground in zip(QUANTITIES.items(), peaks, of_ground, strict=True)
    }
    for power, name in ((1, "velocity"), (2, "acceleration")):
        text = f"pseudo-spectral {name}, omega^{power} SD"
        variables[f"pseudo_{name}"] = variable(omega**power * peaks[0], of_ground[power], text, QUANTITIES[name][1])
    attrs = attributes(s, (load,), int(np.count_nonzero(~np.isfinite(peaks[0]))))
    if auto:
        text = "steps of the scheme from sample to sample"
        variables["steps"] = variable(found.factor, 1, text, "1")
    if errors and found.exact is not None:
        for name, peak, exact in zip(QUANTITIES, peaks, found.exact, strict=True):
            text = f"relative error of the scheme's spectral {name}"
            variables[f"{name}_error"] = variable(relative(peak, exact), 0.0, text, "1")
        attrs["good_from"] = _good_from(T, variables["acceleration_error"].to_numpy())
    coordinates = of_oscillators(T, damping)
    if frequencies is not None:
        text = {"long_name": "natural frequency", "units": "Hz"}
        coordinates["frequency"] = named("period", real_array("frequencies", frequencies), text)
    spectrum = Spectrum(variables, coordinates, attrs)
    if dtype == "float32":
        _compare(spectrum, peaks, lambda some: peaks_of(some, errors=False).found)
    spectrum.made_from = MadeFrom(load, s, auto)
    return spectrum


def _compare(spectrum: Spectrum, peaks: Array, in_double: Callable[[NDArray[np.int64]], Array]) -> None:
    """Say in the attributes how peaks (3, P) in single precision differ from those of some oscillators in double."""
    some = single.sample(np.arange(peaks.shape[1], dtype=np.int64), np.flatnonzero(~np.isfinite(peaks).all(axis=0)))
    double, found = in_double(some), peaks[:, some]
    errors = {name: single.largest_error(x, d, d) for name, x, d in zip(QUANTITIES, found, double, strict=True)}
    for name, error in errors.items():
        spectrum[name].attrs["float32_error"] = error
    differ = np.isfinite(found).all(axis=0) != np.isfinite(double).all(axis=0)
    spectrum.attrs |= single.report(errors, len(some), int(differ.sum()))


def record_of(
    record: ArrayLike | str | Path | Record, dt: float | None = None, unit: str | float | None = None
) -> Record:
    """The record in m/s^2, with the unit in which it was given and where it comes from; see `response_spectrum`."""
    if isinstance(record, str | Path):
        return read_record(record, dt, unit)
    if not isinstance(record, Record):
        if dt is None:
            raise ValueError("expected dt of the record, got none; give the step between its samples in s")
        require_step("dt of the record", real_number("dt of the record", dt, positive=True))
        return _with_unit(Record(dt, record, source="array"), unit)
    if dt is not None and real_number("dt of the record", dt) != record.dt:
        raise ValueError(f"expected the record's own dt = {record.dt:g} s, got {dt:g} s; leave dt out")
    if record.unit == "":
        return _with_unit(replace(record, source=record.source or "array"), unit)
    if unit is not None and unit_of(unit)[1] != unit_of(record.unit)[1]:
        raise ValueError(f"expected unit={record.unit!r}, as the record says, got {unit!r}; leave it out")
    return record


def _with_unit(record: Record, unit: str | float | None) -> Record:
    """A record of plain numbers in the unit that is given, without one in m/s^2, or a ValueError if it cannot be."""
    return record.of_ground() if unit is None else replace(record, unit=unit)


def of_oscillators(T: Array, damping: Array) -> dict[str, Variable]:
    """The coordinates of a spectrum over periods T (P,), s, and damping ratios, one or (X,)."""
    return {
        "period": named("period", T, {"long_name": "natural period", "units": "s"}),
        "xi": named(("xi",)[: damping.ndim], damping, {"long_name": "damping ratio", "units": "1"}),
    }


def attributes(s: Scheme, records: Sequence[Record], unstable: int) -> dict[str, Any]:
    """Attributes of a spectrum: the scheme, records of one length, and at how many periods the scheme is unstable."""
    return {
        "scheme": s.name,
        "parameters": ", ".join(f"{key} = {float(value)}" for key, value in s.parameters.items()),
        "dt": records[0].dt,
        "samples": len(records[0].samples),
        "source": " and ".join(dict.fromkeys(record.source for record in records)),
        "unit": " and ".join(dict.fromkeys(unit_of(record.unit)[0] for record in records)),
        "unstable": unstable,
    }


def natural_periods(periods: ArrayLike | None, frequencies: ArrayLike | None = None) -> Array:
    """Periods (P,) >= 0 in s, as given or of frequencies (P,) > 0 in Hz; raises ValueError for others and for both."""
    if frequencies is None:
        T = PERIODS if periods is None else _row("periods", periods, "s")
        if (T < 0.0).any():
            raise ValueError(f"expected periods >= 0, got {T.min()}; give positive periods, in s, or 0 for the ground")
        return T
    if periods is not None:
        raise ValueError("expected either periods or frequencies, got both; leave one of them out")
    f = _row("frequencies", frequencies, "Hz")
    if (f <= 0.0).any():
        raise ValueError(f"expected frequencies > 0, got {f.min()}; give positive ones, in Hz; the ground is periods=0")
    return 1.0 / f


def _row(name: str, values: ArrayLike, unit: str) -> Array:
    row = real_array(name, values)
    if row.ndim != 1 or not row.size:
        raise ValueError(f"expected {name} in one row, got shape {row.shape}; give a list of them, in {unit}")
    return row


def _scheme(scheme: str | Scheme) -> Scheme:
    """The handle of a scheme. Raises ValueError for arrays of parameters, and for what the exact response is called."""
    if isinstance(scheme, str) and re.sub(r"[\W_]+", "_", scheme.lower()).strip("_") in EXACT:
        raise ValueError(
            f"expected a scheme, got '{scheme}', the exact response to a record that is linear between its samples, to "
            "which the errors of response_spectrum are relative; its peaks are displacement/(1 + displacement_error), "
            'or take scheme="dormand_prince", which comes closest to it, with refine="auto"'
        )
    return numbers_only(scheme, "call once for each")


def _good_from(T: Array, error: Array) -> float:
    """The shortest of the periods T (P,) from which on no error (..., P) is beyond GOOD; NaN if there is none."""
    good = (np.abs(error) <= GOOD).reshape(-1, len(T)).all(axis=0)
    longest_bad = T[~good].max(initial=-1.0)
    return float(min(T[longest_bad < T], default=np.nan))
