"""Inelastic response spectra: yielding oscillators of constant ductility, strength or reduction of strength."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core.arrays import Array, named
from ..core.coefficients import refuse_damping
from ..core.device import Device, on
from ..core.errors import called_as, damping_ratio, inside, number_or_row, real_number, unknown_name, whole
from ..core.loads import Record
from ..core.schemes import Scheme
from ..run.schemes import numbers_only
from .peaks import refined, relative
from .spectrum import attributes, natural_periods, record_of
from .yield_strengths import Asked, Found, strengths
from .yielding import LAWS, RESTING, Demand, Yielding, demands

if TYPE_CHECKING:
    from xarray import Variable

    from .inelastic_history import InelasticSpectrum

DUCTILITIES = (1.0, 1.5, 2.0, 4.0, 8.0)
KEPT = {  # what may be constant: long name, unit
    "ductility": ("ductility, peak over yield displacement, that was asked for", "1"),
    "strength": ("yield strength per unit mass", "m s-2"),
    "R_y": ("elastic strength over yield strength", "1"),
}


@called_as("inelastic_spectrum(accelerations, dt=0.01, ductility=[1, 2, 4])")
def inelastic_spectrum(
    record: ArrayLike | str | Path | Record,
    dt: float | None = None,
    periods: ArrayLike | None = None,  # 200 from 0.02 to 10 s
    xi: float = 0.05,
    scheme: str | Scheme = "average_acceleration",
    *,
    ductility: ArrayLike | None = None,  # 1, 1.5, 2, 4, 8
    strength: ArrayLike | None = None,
    R_y: ArrayLike | None = None,
    law: str = "bilinear",
    hardening: float = 0.0,
    tolerance: float = 0.01,
    steps: int = 1,
    errors: bool = True,
    unit: str | float | None = None,
    device: Device = "cpu",
) -> InelasticSpectrum:
    """What a ground motion demands of yielding oscillators: their strength, displacement, what remains and is lost.

    Per unit mass, u'' + 2 xi omega u' + q = -a_g from rest, omega = 2 pi/period, where the spring's force q has the
    initial stiffness omega^2 and yields at the strength A_y, m/s^2; after that its stiffness is hardening*omega^2.
    record, dt, unit, scheme, device: as in `substep.response_spectrum`. periods (P,) > 0 in s. xi: one damping ratio,
    of the initial stiffness. law: "bilinear" or "isotropic_bilinear", which unload with the initial stiffness, or
    "clough", which reloads towards the largest displacement of each side. hardening: in [0, 1), 0 for elastic-perfectly
    plastic. steps: of the scheme from sample to sample, equal ones.

    Constant is one of three, a number or a row (K,): ductility >= 1, the largest displacement over that of first yield,
    by default (1, 1.5, 2, 4, 8); strength > 0, A_y in m/s^2; R_y > 0, the strength that the oscillator would need to
    stay elastic over A_y. Of a ductility A_y is the largest strength that gives it, on a grid of strengths a factor
    2^0.1 apart, refined in between until the ductility is within `tolerance`, relative; `solutions` counts how often
    the grid crosses it. Where none is found, values are NaN and solutions 0.

    Returns a Dataset over what is constant, if that is a row, and period: A_y, m/s^2, a pseudo-acceleration, of
    ductility 1 that of `response_spectrum`; displacement, the largest |u|, m; ductility_demand, that over the yield
    displacement A_y/omega^2; R_y; hysteretic_energy, lost by yielding, J/kg; yield_excursions, how often it began to
    yield; all of them at the ends of steps. residual_displacement, m, with its sign: where the oscillator comes to
    rest, after a free vibration that may yield once more; NaN where that takes more than 256 periods; left out with
    "clough", which is not elastic about any displacement.
    errors: also displacement_error, which the ductility has too, and hysteretic_energy_error, relative, and
    residual_displacement_error, of the largest displacement: how far the value is from that of the same oscillator in
    half the step, at the same instants. Of a scheme of second order this is three quarters of its error. Where the
    scheme is unstable at dt, values are NaN; attrs["unstable"] counts them. attrs["marched"]: oscillators marched.

    `history(T=0.5, ductility=4)` of the result is the `substep.Response` of one oscillator: see docs/inelastic.md.

    Raises ValueError for input outside of these ranges or shapes, and for more than one of ductility, strength and
    R_y; OSError for a file that cannot be read.

    >>> shaken = 3.0 * np.sin(2 * np.pi * np.arange(0.0, 10.0, 0.02))  # m/s^2, with a period of 1 s
    >>> s = ss.inelastic_spectrum(shaken, dt=0.02, periods=[0.5, 1.0], ductility=[1, 4])
    >>> [[round(float(x), 1) for x in row] for row in s.A_y]  # m/s^2; at resonance yielding helps most
    [[4.8, 28.4], [2.5, 1.6]]
    """
    from .inelastic_history import InelasticSpectrum  # noqa: PLC0415 (loads xarray)

    ground, each = record_of(record, dt, unit), whole("steps", steps, 1, "", "1 is from sample to sample")
    load = refined(ground, each)
    T, s = yielding_periods(periods), numbers_only(scheme, "call once for each")
    damping = damping_ratio("xi", real_number("xi", xi))
    refuse_damping(s, damping)
    kept, values = _kept(ductility, strength, R_y)
    if law not in LAWS:
        raise unknown_name("a law", str(law), LAWS)
    alpha = float(inside("hardening", real_number("hardening", hardening), 0.0, 1.0, False, True))
    within = float(inside("tolerance", real_number("tolerance", tolerance), 0.0, 1.0, True, True))
    asked = Asked(load, s, float(damping), kept, values, law, alpha, within)
    omega = 2.0 * np.pi / T
    with on(device):
        found = strengths(asked, omega)
        demand, halved = _demands(asked, omega, found, errors)
    dims = (kept, "period")[-1 - values.ndim :]

    def variable(x: Array | NDArray[np.int64], long_name: str, units: str) -> Variable:
        return named(dims, x.reshape(*values.shape, len(T)), {"long_name": long_name, "units": units})

    with np.errstate(invalid="ignore"):
        R = found.elastic / found.strength
        mu = demand.peak * omega**2 / found.strength
    remains = "displacement at which it rests at last, relative to the ground"
    variables = {
        "A_y": variable(found.strength, "yield strength per unit mass, a pseudo-acceleration", "m s-2"),
        "displacement": variable(demand.peak, "largest displacement, relative to the ground", "m"),
        "ductility_demand": variable(mu, "largest displacement over yield displacement", "1"),
        "R_y": variable(R, *KEPT["R_y"]),
        "residual_displacement": variable(demand.residual, remains, "m"),
        "hysteretic_energy": variable(demand.energy, "energy lost by yielding, per unit mass", "J kg-1"),
        "yield_excursions": variable(demand.excursions, "how often it began to yield", "1"),
    }
    for name in (kept, *([] if law in RESTING else ["residual_displacement"])):
        variables.pop(name, None)
    if found.solutions is not None:
        text = "strengths that give the ductility, as the grid crosses it"
        variables["solutions"] = variable(found.solutions, text, "1")
    if halved is not None:
        text = "from half the step, relative"
        moved = demand.residual - halved.residual
        off = {
            "displacement": relative(demand.peak, halved.peak),
            "hysteretic_energy": relative(demand.energy, halved.energy),
            "residual_displacement": np.divide(moved, halved.peak, out=moved, where=halved.peak != 0.0),
        }
        for name, x in off.items() if law in RESTING else [*off.items()][:-1]:
            of = ", to the largest displacement" if name.startswith("residual") else ""
            variables[f"{name}_error"] = variable(x, f"distance of the {name.replace('_', ' ')} {text}{of}", "1")
    coordinates = {
        "period": named("period", T, {"long_name": "natural period of the initial stiffness", "units": "s"}),
        kept: named(dims[:-1], values, dict(zip(("long_name", "units"), KEPT[kept], strict=True))),
        "xi": named((), damping, {"long_name": "damping ratio", "units": "1"}),
    }
    attrs = attributes(s, (ground,), int(np.count_nonzero(~np.isfinite(found.elastic))))
    attrs |= {"steps": each, "law": law, "hardening": alpha, "tolerance": within, "marched": found.marched}
    spectrum = InelasticSpectrum(variables, coordinates, attrs)
    spectrum.asked = asked
    return spectrum


def _demands(asked: Asked, omega: Array, found: Found, errors: bool) -> tuple[Demand, Demand | None]:
    """What is demanded at the strengths (K, P) that were found, NaN elsewhere; with errors also in half the step."""
    known = found.strength > 0.0
    of = np.nonzero(known)[-1]
    o = Yielding(omega[of], np.full(len(of), asked.xi), found.strength[known], asked.hardening, asked.law)

    def whole(times: int) -> Demand:
        values = np.full((4, *known.shape), np.nan)
        if len(of):
            values[:, known] = demands(asked.scheme, o, asked.record, times)
        return Demand(*values)

    return whole(1), whole(2) if errors else None


def yielding_periods(periods: ArrayLike | None) -> Array:
    """Periods (P,) > 0 in s; raises ValueError for others, and for 0."""
    T = natural_periods(periods)
    if (T == 0.0).any():
        raise ValueError("expected periods > 0, got 0, the ground itself, which does not yield; leave it out")
    return T


def _kept(ductility: ArrayLike | None, strength: ArrayLike | None, R_y: ArrayLike | None) -> tuple[str, Array]:
    """Which of the three is constant, and at which values."""
    given = {name: x for name, x in zip(KEPT, (ductility, strength, R_y), strict=True) if x is not None}
    if len(given) > 1:
        raise ValueError(f"expected one of ductility, strength and R_y, got {' and '.join(given)}; leave out the rest")
    ((name, value),) = given.items() or (("ductility", DUCTILITIES),)
    values = number_or_row(name, value)
    if not values.size:
        raise ValueError(f"expected {name} to be a number or a row of them, got none; give at least one")
    least, cure = (1.0, "; 1 is the elastic spectrum") if name == "ductility" else (0.0, "; give positive values")
    if (values < least).any() or (least == 0.0 and (values == 0.0).any()):
        raise ValueError(f"expected {name} {'>=' if least else '>'} {least:g}, got {values.min():g}{cure}")
    return name, values
