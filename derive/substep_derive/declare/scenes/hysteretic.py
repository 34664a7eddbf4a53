"""Oscillators whose spring remembers: of unit mass, with the initial stiffness omega**2."""

from sympy import Interval, Symbol, oo

from ..laws import plastic
from ..scene import REAL, Scene, optional, required
from ..symbols import omega, rate, sampled, xi

u, u0, v0, strength, hardening = (Symbol(name) for name in ("u", "u0", "v0", "strength", "hardening"))

bilinear = Scene(
    "hysteretic_oscillator",
    coordinates={u: "m"},
    kinetic=rate(u) ** 2 / 2,
    potential=0 * u,
    dissipation=xi * omega * rate(u) ** 2,
    laws={"spring": plastic.bilinear.on(u, k=omega**2, q_y=strength, alpha=hardening)},
    load={u: sampled},
    parameters=(
        required(omega),
        optional(xi, 0, Interval(0, oo)),
        required(strength),
        optional(hardening, 0, Interval.Ropen(0, 1)),
        optional(u0, 0, REAL),
        optional(v0, 0, REAL),
    ),
    start={u: u0, rate(u): v0},
    length=strength / omega**2,
    energy_scale=strength**2 / omega**2 / 2,
    reference="a yielding oscillator per unit mass; strength in m/s^2",
)

ALL = (bilinear,)
