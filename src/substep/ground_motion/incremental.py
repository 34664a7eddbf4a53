"""Incremental dynamic analysis: what records demand of yielding oscillators as they are scaled up to collapse."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core.arrays import Array, named
from ..core.coefficients import refuse_damping
from ..core.device import Device, on
from ..core.errors import called_as, damping_ratio, inside, number_or_row, real_number, unknown_name
from ..core.loads import Record
from ..core.schemes import Scheme
from ..run.schemes import numbers_only
from .inelastic import yielding_periods
from .peaks import peaks_at_samples
from .spectrum import attributes, record_of
from .yielding import LAWS, Yielding, peaks

if TYPE_CHECKING:
    from xarray import Dataset

FRACTILES = (0.16, 0.5, 0.84)
MEASURES = {
    "scale": ("factor by which each record is multiplied", "1"),
    "S_a": ("pseudo-spectral acceleration, to which each record is scaled at each period", "m s-2"),
}
INFINITE = 1e300  # stands for an infinite ductility between which fractiles are taken


@called_as("incremental_dynamic_analysis([first, second], periods=[0.5, 1], intensity=[1, 2, 4], strength=2)")
def incremental_dynamic_analysis(
    records: Sequence[ArrayLike | str | Path | Record],
    periods: ArrayLike,
    intensity: ArrayLike,
    strength: ArrayLike,
    *,
    measure: str = "S_a",
    collapse: float = 10.0,
    dt: float | None = None,
    xi: float = 0.05,
    scheme: str | Scheme = "average_acceleration",
    law: str = "bilinear",
    hardening: float = 0.0,
    unit: str | float | None = None,
    device: Device = "cpu",
) -> Dataset:
    """The ductility that scaled ground motions demand of oscillators of given strength, and where these collapse.

    records (R): each as `substep.response_spectrum` takes it, with dt and unit where it has none. periods (P,) > 0 in
    s; strength, m/s^2, a number or (P,): that at which each yields, per unit mass; law, hardening and device: as
    in `substep.inelastic_spectrum`. intensity (I,) > 0: with measure="S_a" the elastic pseudo-acceleration, m/s^2, to
    which each record is scaled at each period; with "scale" factors of the records as they are. collapse: the ductility
    from which on an oscillator counts as collapsed.

    Returns a Dataset over record, period and intensity: ductility, the largest displacement over the yield displacement
    at the samples, inf where the oscillator has collapsed; displacement, m, as it was marched, also beyond; collapsed;
    scale and S_a. Over fractile, period and intensity ductility_fractile, of the records, 0.16, 0.5 and 0.84, linear
    between two of them, inf where the upper one has collapsed; collapse_fraction, of the records, over period and
    intensity. Where the scheme is unstable values are NaN, these two also where it is so under one record;
    attrs["unstable"] counts oscillators.

    Method: D. Vamvatsikos and C. A. Cornell, Incremental dynamic analysis, Earthquake Engng Struct. Dyn. 31, 491-514,
    2002. Raises ValueError and OSError as `substep.inelastic_spectrum` does.

    >>> t = np.arange(0.0, 10.0, 0.02)
    >>> s = ss.incremental_dynamic_analysis(
    ...     [np.sin(6 * t), np.sin(t)], [0.5, 1.0], [1.0, 4.0], strength=2.0, measure="scale", dt=0.02)
    >>> s.ductility[1].to_numpy().round(2).tolist()  # a slow record; each period a row
    [[0.51, inf], [0.55, inf]]
    """
    from ..core.result_dataset import ResultDataset  # noqa: PLC0415 (loads xarray)

    loads = _records(records, dt, unit)
    T, s = yielding_periods(periods), numbers_only(scheme, "call once for each")
    damping = damping_ratio("xi", real_number("xi", xi))
    refuse_damping(s, damping)
    levels, yields = _positive("intensity", intensity), _positive("strength", strength)
    if yields.size not in (1, T.size):
        raise ValueError(f"expected strength as one number or {T.size}, one for each period, got {yields.size}")
    if measure not in MEASURES:
        raise unknown_name("a measure of intensity", str(measure), MEASURES)
    if law not in LAWS:
        raise unknown_name("a law", str(law), LAWS)
    alpha = float(inside("hardening", real_number("hardening", hardening), 0.0, 1.0, False, True))
    bound = float(inside("collapse", real_number("collapse", collapse), 1.0, None, True, True))
    omega, count = 2.0 * np.pi / T, len(levels)
    S_a, scale, ductility = np.full((3, len(loads), len(T), count), np.nan)
    with on(device):
        for r, load in enumerate(loads):
            elastic = (
                omega**2 * peaks_at_samples(s, omega, np.full(len(T), float(damping)), load, errors=False).found[0]
            )
            if measure == "S_a" and (still := elastic == 0.0).any():
                raise ValueError(
                    f"expected records that move an oscillator, to be scaled, got record {r + 1} of {len(loads)} under "
                    f"which one of T = {T[int(np.argmax(still))]:g} s stays at rest; leave it out"
                )
            with np.errstate(divide="ignore", invalid="ignore"):
                scale[r] = levels if measure == "scale" else levels / elastic[:, None]
                S_a[r] = elastic[:, None] * scale[r]
            known = np.isfinite(elastic) & np.isfinite(scale[r]).all(axis=1)
            weaker = (
                np.broadcast_to(yields, T.shape)[known, None] / scale[r, known]
            )  # as the record itself is not scaled
            lanes_xi = np.full(weaker.size, float(damping))
            o = Yielding(np.repeat(omega[known], count), lanes_xi, weaker.ravel(), alpha, law)
            if known.any():
                ductility[r, known] = (peaks(s, o, load) / o.yield_displacement).reshape(-1, count)
    collapsed = ductility >= bound
    over = ("record", "period", "intensity")
    displacement = ductility * (yields / omega**2)[:, None]
    ductility[collapsed] = np.inf
    text = "largest displacement over yield displacement"
    variables = {
        "ductility": named(over, ductility, {"long_name": f"{text}, inf: collapsed", "units": "1"}),
        "displacement": named(over, displacement, {"long_name": "largest displacement", "units": "m"}),
        "collapsed": named(over, collapsed, {"long_name": "whether the ductility reaches that of collapse"}),
        "scale": named(over, scale, dict(zip(("long_name", "units"), MEASURES["scale"], strict=True))),
        "S_a": named(over, S_a, {"long_name": "elastic pseudo-spectral acceleration", "units": "m s-2"}),
        "ductility_fractile": named(
            ("fractile", *over[1:]), _fractiles(ductility), {"long_name": f"{text}, of the records", "units": "1"}
        ),
        "collapse_fraction": named(
            over[1:], _fraction(ductility, collapsed), {"long_name": "part of the records that collapse", "units": "1"}
        ),
    }
    coordinates = {
        "period": named("period", T, {"long_name": "natural period of the initial stiffness", "units": "s"}),
        "intensity": named("intensity", levels, dict(zip(("long_name", "units"), MEASURES[measure], strict=True))),
        "fractile": named("fractile", np.array(FRACTILES), {"long_name": "fractile over the records", "units": "1"}),
        "source": ("record", [load.source for load in loads]),
        "strength": named(
            "period", np.broadcast_to(yields, T.shape), {"long_name": "yield strength", "units": "m s-2"}
        ),
        "xi": named((), damping, {"long_name": "damping ratio", "units": "1"}),
    }
    unstable = int(np.count_nonzero(~np.isfinite(S_a[:, :, 0])))
    of_first = attributes(s, loads, unstable)
    attrs = {name: of_first[name] for name in ("scheme", "parameters", "unit", "unstable")}
    return ResultDataset(variables, coordinates, attrs | {"law": law, "hardening": alpha, "collapse": bound})


def _records(
    records: Sequence[ArrayLike | str | Path | Record], dt: float | None, unit: str | float | None
) -> list[Record]:
    """Each record in m/s^2; raises ValueError for none, or for one alone in place of a list."""
    alone = isinstance(records, str | Path | Record) or not hasattr(records, "__len__")
    if alone or not len(records) or isinstance(records[0], float | int):
        raise ValueError("expected a list of records, got one alone or none; write [record]")
    return [record_of(record, None if isinstance(record, Record) else dt, unit) for record in records]


def _positive(name: str, values: ArrayLike) -> Array:
    """A number or a row of them > 0, as a row; else a ValueError."""
    row = np.atleast_1d(number_or_row(name, values))
    if not row.size or (row <= 0.0).any():
        raise ValueError(f"expected {name} > 0, got {row.min() if row.size else 'none'}; give positive values")
    return row


def _fraction(ductility: Array, collapsed: NDArray[np.bool_]) -> Array:
    """The part of the records, the first axis, that collapse; NaN where it is not known of all of them."""
    return np.where(np.isnan(ductility).any(axis=0), np.nan, collapsed.mean(axis=0))


def _fractiles(ductility: Array) -> Array:
    """FRACTILES over the first axis, linear between two values, infinite where the upper one is."""
    found = np.quantile(np.where(np.isinf(ductility), INFINITE, ductility), FRACTILES, axis=0)
    found[found > 1e-9 * INFINITE] = np.inf
    return found
