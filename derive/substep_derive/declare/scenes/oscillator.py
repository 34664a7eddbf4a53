"""Linear scenes: the oscillator of chapter 4, and Bathe and Noh's chain with a prescribed motion."""

from sympy import Rational, Symbol, sin

from ..parameter import NOT_NEGATIVE, REAL
from ..scene import Scene, optional, required
from ..symbols import omega, rate, sampled, t, xi

u, u0, v0 = (Symbol(name) for name in ("u", "u0", "v0"))

linear_oscillator = Scene(
    "linear_oscillator",
    coordinates={u: "m"},
    kinetic=rate(u) ** 2 / 2,
    potential=omega**2 * u**2 / 2,
    dissipation=xi * omega * rate(u) ** 2,
    load={u: sampled},
    parameters=(
        required(omega),
        optional(xi, 0, NOT_NEGATIVE),
        optional(u0, 1, REAL),
        optional(v0, 0, REAL),
    ),
    start={u: u0, rate(u): v0},
    length=1,
    reference="thesis, chapter 4; per unit mass",
)

u2, u3, k1, k2, omega_p = (Symbol(name) for name in ("u2", "u3", "k1", "k2", "omega_p"))
# elongations of the two springs, the first one's end moved by sin(omega_p t)
e2, e3 = Symbol("e2"), Symbol("e3")

bathe_noh = Scene(
    "bathe_noh",
    coordinates={u2: "m", u3: "m"},
    kinetic=(rate(u2) ** 2 + rate(u3) ** 2) / 2,
    invariants={e2: u2, e3: u3 - u2},
    potential=k1 * (e2 - sin(omega_p * t)) ** 2 / 2 + k2 * e3**2 / 2,
    parameters=(optional(k1, 10**7), optional(k2, 1), optional(omega_p, Rational(6, 5))),
    start={u2: 0, u3: 0, rate(u2): 0, rate(u3): 0},
    length=1,
    energy_scale=k1 / 2,  # the stiff spring, at the prescribed amplitude
    reference="Bathe & Noh, Comput. Struct. 98-99 (2012) 1-6; m1 = 0, m2 = m3 = 1 kg",
)

ALL = (linear_oscillator, bathe_noh)
