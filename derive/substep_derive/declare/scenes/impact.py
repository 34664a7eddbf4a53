"""Bodies that meet a stop: contacts of a gap and a pressure, of which one is 0 and none is negative."""

from sympy import Interval, Rational, Symbol, oo

from ..scene import REAL, Scene, optional
from ..symbols import rate

u, w, m, k, g, u0, v0, b = (Symbol(name) for name in ("u", "w", "m", "k", "g", "u0", "v0", "b"))
NOT_NEGATIVE = Interval(0, oo)

mass_on_floor = Scene(
    "mass_on_floor",
    coordinates={u: "m"},
    kinetic=m * rate(u) ** 2 / 2,
    potential=m * g * u,
    contacts={"floor": u},
    parameters=(optional(m, 1), optional(u0, 1, NOT_NEGATIVE), optional(v0, -1, REAL), optional(g, 0, NOT_NEGATIVE)),
    start={u: u0, rate(u): v0},
    length=1,
    energy_scale=m,
    reference="a mass point meets a floor: how it leaves depends on the phase of the impact within the step",
)

two_masses_on_floor = Scene(
    "two_masses_on_floor",
    coordinates={u: "m", w: "m"},
    kinetic=m * (rate(u) ** 2 + rate(w) ** 2) / 2,
    potential=m * g * (u + w) + k * (w - u - b) ** 2 / 2,
    contacts={"floor": u},
    parameters=(
        optional(m, 1),
        optional(k, 1000),
        optional(b, Rational(1, 2)),
        optional(u0, Rational(1, 2), NOT_NEGATIVE),
        optional(v0, -1, REAL),
        optional(g, 0, NOT_NEGATIVE),
    ),
    start={u: u0, w: u0 + b, rate(u): v0, rate(w): v0},
    length=1,
    energy_scale=m,
    reference="two masses joined by a spring of length b, one above the other, fall on a floor: the shortest bar",
)

impact_oscillator = Scene(
    "impact_oscillator",
    coordinates={u: "m"},
    kinetic=m * rate(u) ** 2 / 2,
    potential=k * u**2 / 2,
    contacts={"stop": b - u},
    parameters=(optional(m, 1), optional(k, 1), optional(b, 0, REAL), optional(u0, -1, REAL), optional(v0, 0, REAL)),
    start={u: u0, rate(u): v0},
    length=1,
    energy_scale=k,
    reference="a mass on a spring with a stop at u = b",
)

ALL = (mass_on_floor, two_masses_on_floor, impact_oscillator)
