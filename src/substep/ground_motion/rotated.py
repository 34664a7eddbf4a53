"""Response spectra of two horizontal components, over all directions in which they can be rotated."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..core.arrays import Array, named
from ..core.coefficients import refuse_damping
from ..core.errors import called_as, damping_ratio, real_array, real_number
from ..core.loads import Record
from ..core.schemes import Scheme
from ..marching.histories import histories
from ..run.schemes import numbers_only
from .peaks import at_rest, is_stable
from .spectrum import attributes, natural_periods, of_oscillators, record_of

if TYPE_CHECKING:
    from xarray import Dataset, Variable

ANGLES = np.arange(180)  # degrees from x towards y; beyond them each direction comes back, with the other sign
COS, SIN = np.sin(np.deg2rad(90 - ANGLES)), np.sin(np.deg2rad(ANGLES))  # at 90 degrees the cosine is 0


@called_as("response_spectrum_rotated(x, y, dt=0.01, xi=0.05)")
def response_spectrum_rotated(
    x: ArrayLike | str | Path | Record,
    y: ArrayLike | str | Path | Record,
    dt: float | None = None,
    periods: ArrayLike | None = None,  # 200 from 0.02 to 10 s
    xi: float = 0.05,
    scheme: str | Scheme = "average_acceleration",
    *,
    percentiles: ArrayLike = (0, 50, 100),
    unit: str | float | None = None,
) -> Dataset:
    """RotD00, RotD50 and RotD100: percentiles, over all directions, of the peak response to two horizontal components.

    x, y: ground accelerations at right angles to each other, of the same dt and length; dt, periods (P,), scheme and
    unit: as in `substep.response_spectrum`. xi: one damping ratio. percentiles (Q,): from 0, the least direction, to
    100, the largest, linear between the 180 values, of which that of 50 is the median.

    Returns a Dataset over percentile and period: displacement (m), relative to the ground, and pseudo_acceleration
    (m/s^2), omega^2 times it; of the period 0 it is the ground's own acceleration. For each period alone, the motion
    x cos(angle) + y sin(angle) takes the angles 0, 1, ..., 179 degrees (D. M. Boore, Orientation-independent,
    nongeometric-mean measures of seismic intensity from two horizontal components of motion, Bull. Seism. Soc. Am. 100,
    1830-1835, 2010). larger and geometric_mean (P,), m/s^2, are those of the two pseudo-accelerations as recorded.
    Peaks are at the record's samples; where the scheme is unstable, values are inf and attrs["unstable"] counts them.

    Raises ValueError for components of different steps or lengths, for percentiles that are not from 0 to 100 and as
    `substep.response_spectrum` does; OSError for a file that cannot be read.

    >>> t = np.arange(0.0, 10.0, 0.02)  # the same motion along x and y is largest at 45 degrees, and none at 135
    >>> spectrum = ss.response_spectrum_rotated(np.sin(t), np.sin(t), dt=0.02, periods=[1.0])
    >>> [round(float(ratio), 3) for ratio in spectrum.pseudo_acceleration[:, 0] / spectrum.larger[0]]
    [0.0, 1.0, 1.414]
    """
    from ..core.result_dataset import ResultDataset  # noqa: PLC0415 (loads xarray)

    first, second = (record_of(component, dt, unit) for component in (x, y))
    _require_alike(first, second)
    T, damping = natural_periods(periods), damping_ratio("xi", real_number("xi", xi))
    s = numbers_only(scheme, "call once for each")
    refuse_damping(s, damping)
    parts = real_array("percentiles", percentiles)
    if parts.ndim != 1 or not parts.size or (parts < 0.0).any() or (parts > 100.0).any():
        raise ValueError(f"expected percentiles from 0 to 100 in one row, got {parts.tolist()}; give (0, 50, 100)")
    displacement, pseudo = _over_angles(s, T, float(damping), first, second)
    found = np.isfinite(displacement).all(axis=0)

    def variable(values: Array, long_name: str, units: str) -> Variable:
        """Percentiles of values (180, P), inf where not all are found."""
        whole = np.full((len(parts), len(T)), np.inf)
        whole[:, found] = np.percentile(values[:, found], parts, axis=0)
        return named(("percentile", "period"), whole, {"long_name": long_name, "units": units})

    variables = {
        "displacement": variable(displacement, "spectral displacement RotD, relative to the ground", "m"),
        "pseudo_acceleration": variable(pseudo, "pseudo-spectral acceleration RotD, omega^2 SD", "m s-2"),
    }
    recorded = pseudo[[0, 90]]
    for name, values in (("larger", recorded.max(axis=0)), ("geometric_mean", np.sqrt(recorded.prod(axis=0)))):
        text = f"{name.replace('_', ' ')} of the pseudo-spectral accelerations of both components as recorded"
        variables[name] = named("period", values, {"long_name": text, "units": "m s-2"})
    coordinates = {
        "percentile": named("percentile", parts, {"long_name": "percentile over the directions", "units": "percent"}),
        **of_oscillators(T, damping),
    }
    return ResultDataset(variables, coordinates, attributes(s, (first, second), int(np.count_nonzero(~found))))


def _require_alike(x: Record, y: Record) -> None:
    """Raise ValueError for components whose samples are not at the same instants."""
    if x.dt != y.dt:
        raise ValueError(
            f"expected two components of one step, got dt = {x.dt:g} s and {y.dt:g} s; resample one of them"
        )
    if len(x.samples) != len(y.samples):
        raise ValueError(
            f"expected two components of one length, got {len(x.samples)} and {len(y.samples)} samples; cut the longer "
            "one, or append zeros to the shorter one, from the instant on at which both begin"
        )


def _over_angles(s: Scheme, T: Array, xi: float, x: Record, y: Record) -> tuple[Array, Array]:
    """Peak displacement and pseudo-acceleration (180, P) at each of ANGLES; inf where the scheme is not stable."""
    ground = T == 0.0
    omega = 2.0 * np.pi / np.where(ground, np.inf, T)
    lanes = np.flatnonzero(~ground & is_stable(s, omega, xi, x.dt))
    displacement = np.full((len(ANGLES), len(T)), np.inf)
    displacement[:, ground] = 0.0
    displacement[:, lanes] = _peaks(_histories(s, omega[lanes], xi, x, y), len(lanes))
    displacement[:, ~np.isfinite(displacement).all(axis=0)] = np.inf
    pseudo = omega**2 * displacement
    pseudo[:, ground] = _peaks([(x.samples[:, None], y.samples[:, None])], 1)
    return displacement, pseudo


def _histories(s: Scheme, omega: Array, xi: float, x: Record, y: Record) -> Iterator[tuple[Array, Array]]:
    """Displacements (rows, P) under both components, a block of rows at a time: never the whole histories."""
    ratios, n = np.full(len(omega), xi), len(x.samples) - 1
    runs = (histories(s, at_rest(omega, ratios, load), n, load) for load in (x, y))
    for (_, under_x), (_, under_y) in zip(*runs, strict=True):
        yield np.ascontiguousarray(under_x[:, 0]), np.ascontiguousarray(under_y[:, 0])


def _peaks(blocks: Iterable[tuple[Array, Array]], lanes: int) -> Array:
    """Largest modulus (180, P) of pairs of histories (rows, P), rotated by each of ANGLES."""
    peaks = np.zeros((len(ANGLES), lanes))
    with np.errstate(over="ignore", invalid="ignore"):  # of a lane that overflows
        for x, y in blocks:
            for peak, cos, sin in zip(peaks, COS, SIN, strict=True):
                np.maximum(peak, np.abs(cos * x + sin * y).max(axis=0), out=peak)
    return peaks
