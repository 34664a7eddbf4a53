"""Nonlinear springs, per unit mass."""

from sympy import Rational, Symbol, cosh, log

from ..parameter import REAL
from ..scene import Scene, optional
from ..symbols import rate

u, k, eps, u0 = (Symbol(name) for name in ("u", "k", "eps", "u0"))

duffing = Scene(
    "duffing",
    coordinates={u: "m"},
    kinetic=rate(u) ** 2 / 2,
    potential=k * u**2 / 2 + k * eps * u**4 / 4,
    parameters=(optional(k, 100), optional(eps, 10), optional(u0, Rational(3, 2), REAL)),
    start={u: u0, rate(u): 0},
    length=abs(u0),
    reference="Duffing's hardening spring, u'' + k u (1 + eps u^2) = 0",
)

softening = Scene(
    "softening",
    coordinates={u: "m"},
    kinetic=rate(u) ** 2 / 2,
    potential=k * log(cosh(u)),
    parameters=(optional(k, 100), optional(u0, 4, REAL)),
    start={u: u0, rate(u): 0},
    length=abs(u0),
    reference="softening spring, u'' + k tanh u = 0",
)

ALL = (duffing, softening)
