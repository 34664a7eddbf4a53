"""Elastic design spectra of building codes, as curves beside the response spectra of records."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.arrays import Array, named
from ..core.errors import called_as, damping_ratio, real_array, real_number, unknown_name
from ..core.units import LARGEST, UNITS, readings, unit_of
from .spectrum import natural_periods, of_oscillators

if TYPE_CHECKING:
    from xarray import Dataset

SOIL = {  # type of spectrum: ground type: S, T_B, T_C, T_D; EN 1998-1:2004, tables 3.2 and 3.3, recommended values
    1: {
        "A": (1.0, 0.15, 0.4, 2.0),
        "B": (1.2, 0.15, 0.5, 2.0),
        "C": (1.15, 0.2, 0.6, 2.0),
        "D": (1.35, 0.2, 0.8, 2.0),
        "E": (1.4, 0.15, 0.5, 2.0),
    },
    2: {
        "A": (1.0, 0.05, 0.25, 1.2),
        "B": (1.35, 0.05, 0.25, 1.2),
        "C": (1.5, 0.1, 0.25, 1.2),
        "D": (1.8, 0.1, 0.3, 1.2),
        "E": (1.6, 0.05, 0.25, 1.2),
    },
}
LONGEST = 4.0  # s, the period up to which EN 1998-1, 3.2.2.2 goes
VERY_LOW = 0.39  # m/s^2, a_g at most, of what EN 1998-1, 3.2.1(5)P calls so, and where it need not be observed
NBCC_PERIODS = np.array([0.2, 0.5, 1.0, 2.0, 5.0, 10.0])  # s


@called_as('design_spectrum("ec8", periods, a_g=2.5, ground="B")')
def design_spectrum(code: str, periods: ArrayLike | None = None, **parameters: Any) -> Dataset:
    """The horizontal elastic design spectrum of a code: a Dataset with acceleration, m/s^2, over period.

    code: "ec8", EN 1998-1:2004, 3.2.2.2, equations (3.2) to (3.6), with the parameters a_g, design ground acceleration
    on ground of type A, m/s^2; ground, "A" to "E"; type, 1 by default, or 2, for surface-wave magnitudes up to 5.5; xi,
    0.05 by default, from which the damping correction eta = sqrt(10/(5 + 100 xi)) >= 0.55 follows. S, T_B, T_C and T_D
    are the recommended ones, of which a National Annex may have others. Beyond 4 s, where its Annex A begins, values
    are NaN.
    "asce7", ASCE 7-16, 11.4.6, equations (11.4-5) to (11.4-7), for a damping ratio of 0.05, with the parameters S_DS
    and S_D1, design spectral accelerations; T_L, long-period transition period, s.
    "nbcc", National Building Code of Canada 2015, 4.1.8.4.(9), for a damping ratio of 0.05, with the parameters S_a,
    spectral accelerations of the site on ground of class C at the periods 0.2, 0.5, 1, 2, 5 and 10 s, and F, by which
    the site's class multiplies each, by default 1, that of class C. S is F S_a at these periods, at 0.2 s the larger of
    its values at 0.2 and 0.5 s, linear between them, constant below 0.2 s and beyond 10 s. Not covered: hazard values
    of places, the tables of F, the cut-offs and importance factors of the base shear, the 2020 edition, whose values
    are of the site's own class.
    unit: of a_g, S_DS, S_D1 and S_a, "g", "m/s^2", "cm/s^2", "gal", "in/s^2" or a factor to m/s^2, by default m/s^2 for
    "ec8" and g for the others, as these codes print them. periods (P,) >= 0 in s, by default those of
    `substep.response_spectrum`.

    attrs name the clause, the parameters as they are given, their unit, and what follows: S, T_B, T_C, T_D and eta, or
    T_0 and T_S. Raises ValueError for a code, ground or type that there is not, for parameters that are not positive,
    for a T_L below T_S and for accelerations without a unit that are likely in another one: a_g up to 0.39 m/s^2, very
    low seismicity, and any above 5 g; TypeError for parameters that the code does not take, or that are missing.

    >>> code = ss.design_spectrum("ec8", [0.0, 0.3, 1.0], a_g=2.5, ground="B")
    >>> code.acceleration.to_numpy().round(3).tolist()  # m/s^2
    [3.0, 7.5, 3.75]
    >>> code = ss.design_spectrum("nbcc", [0.1, 0.75, 20.0], S_a=[0.85, 0.75, 0.42, 0.26, 0.08, 0.03])
    >>> (code.acceleration / 9.80665).to_numpy().round(3).tolist()  # g
    [0.85, 0.585, 0.03]
    """
    if code not in CODES:
        raise unknown_name("a code", str(code), CODES)
    return CODES[code](natural_periods(periods), **parameters)


@called_as('design_spectrum("ec8", periods, a_g=2.5, ground="B")')
def _ec8(
    periods: Array,
    *,
    a_g: float,
    ground: str,
    type: int = 1,
    xi: float = 0.05,
    unit: str | float | None = None,
) -> Dataset:
    if type not in SOIL:
        raise unknown_name("a type of spectrum", str(type), map(str, SOIL))
    if ground not in SOIL[type]:
        raise unknown_name("a type of ground", str(ground), SOIL[type])
    damping = float(damping_ratio("xi", real_number("xi", xi)))
    S, T_B, T_C, T_D = SOIL[type][ground]
    eta = max(float(np.sqrt(10.0 / (5.0 + 100.0 * damping))), 0.55)
    at_rock = real_number("a_g", a_g, positive=True)
    used, factor = _unit("a_g", at_rock, unit, "m/s^2")
    if unit is None and at_rock <= VERY_LOW:
        raise ValueError(
            f'expected a_g in m/s^2, got {at_rock:g}, which is very low seismicity; give unit="g" or unit="m/s^2"'
        )
    at_0 = at_rock * factor * S
    acceleration = _branches(periods, at_0, 2.5 * eta * at_0, T_B, T_C, T_D)
    acceleration[periods > LONGEST] = np.nan
    attrs = {"code": "EN 1998-1:2004, 3.2.2.2", "a_g": a_g, "unit": used, "ground": ground, "type": type}
    return _dataset(periods, acceleration, damping, attrs | {"S": S, "T_B": T_B, "T_C": T_C, "T_D": T_D, "eta": eta})


@called_as('design_spectrum("asce7", periods, S_DS=1.0, S_D1=0.6, T_L=8.0)')
def _asce7(periods: Array, *, S_DS: float, S_D1: float, T_L: float, unit: str | float | None = None) -> Dataset:
    given = {"S_DS": S_DS, "S_D1": S_D1, "T_L": T_L}
    plateau, at_1, T_D = (real_number(name, value, positive=True) for name, value in given.items())
    used, factor = _unit("S_DS and S_D1", max(plateau, at_1), unit, "g")
    T_S = at_1 / plateau
    if T_D < T_S:
        raise ValueError(f"expected T_L >= T_S = S_D1/S_DS = {T_S:g} s, got {T_D:g} s; correct one of the three")
    acceleration = factor * _branches(periods, 0.4 * plateau, plateau, 0.2 * T_S, T_S, T_D)
    attrs = {"code": "ASCE 7-16, 11.4.6", **given, "unit": used, "T_0": 0.2 * T_S, "T_S": T_S}
    return _dataset(periods, acceleration, 0.05, attrs)


@called_as('design_spectrum("nbcc", periods, S_a=[0.85, 0.75, 0.42, 0.26, 0.08, 0.03])')
def _nbcc(periods: Array, *, S_a: ArrayLike, F: ArrayLike = 1.0, unit: str | float | None = None) -> Dataset:
    hazard, site = real_array("S_a", S_a), real_array("F", F)
    for name, values, shapes in (("S_a", hazard, [(6,)]), ("F", site, [(6,), ()])):
        if values.shape not in shapes or not (values > 0.0).all():
            raise ValueError(
                f"expected {name} > 0 at the periods {', '.join(f'{T:g}' for T in NBCC_PERIODS)} s, got "
                f"{values.tolist()}; give six values"
            )
    used, factor = _unit("S_a", float(hazard.max()), unit, "g")
    S = site * hazard
    S[0] = max(S[0], S[1])
    attrs = {"code": "NBCC 2015, 4.1.8.4.(9)", "S_a": hazard, "F": np.broadcast_to(site, 6).copy(), "unit": used}
    return _dataset(periods, factor * np.interp(periods, NBCC_PERIODS, S), 0.05, attrs)


CODES: dict[str, Callable[..., Dataset]] = {"ec8": _ec8, "asce7": _asce7, "nbcc": _nbcc}


def _unit(name: str, value: float, unit: str | float | None, usual: str) -> tuple[str, float]:
    """The unit that was given, by name and factor to m/s^2, or the usual one, unless the value is too large for it."""
    if unit is None and value * UNITS[usual] > LARGEST:
        raise ValueError(
            f"expected {name} in {usual}, got {value:g}, which is {readings(value)}, {value / 100.0:.3g} g in % of g; "
            'give unit="m/s^2", "g", "cm/s^2" or "%g"'
        )
    return unit_of(usual if unit is None else unit)


def _branches(T: Array, at_0: float, plateau: float, T_B: float, T_C: float, T_D: float) -> Array:
    """Linear from T = 0 to T_B, constant to T_C, as 1/T to T_D, as 1/T^2 beyond."""
    falling = np.maximum(T, T_C)
    beyond = plateau * (T_C / falling) * np.minimum(1.0, T_D / falling)
    return np.where(T < T_B, at_0 + (plateau - at_0) * T / T_B, beyond)


def _dataset(T: Array, acceleration: Array, xi: float, attrs: Mapping[str, Any]) -> Dataset:
    from ..core.result_dataset import ResultDataset  # noqa: PLC0415 (loads xarray)

    text = {"long_name": "elastic design spectrum, pseudo-acceleration", "units": "m s-2"}
    return ResultDataset({"acceleration": named("period", acceleration, text)}, of_oscillators(T, np.array(xi)), attrs)
