"""Unilateral contact by a penalty spring."""

from sympy import Interval, Rational, Symbol, oo, sqrt

from ..parameter import REAL
from ..potentials import negative_part
from ..scene import Scene, optional
from ..symbols import rate

u, k, u0, v0 = (Symbol(name) for name in ("u", "k", "u0", "v0"))

penalty_bounce = Scene(
    "penalty_bounce",
    coordinates={u: "m"},
    kinetic=rate(u) ** 2 / 2,
    potential=k * negative_part(u) ** 2 / 2,
    parameters=(
        optional(k, 10**6),
        optional(u0, Rational(1, 1000), REAL),
        optional(v0, -1, Interval.open(-oo, 0)),
    ),
    start={u: u0, rate(u): v0},
    length=abs(v0) / sqrt(k),
    reference="a unit mass against a penalty spring: restitution should be 1",
)

ALL = (penalty_bounce,)
