"""Points on rigid rods, in Cartesian coordinates, with the rods as constraints."""

from sympy import Integer, Rational, Symbol, sqrt

from ..parameter import NOT_NEGATIVE, REAL
from ..scene import Scene, optional
from ..symbols import rate
from .rods import rod_double_pendulum

L, m, v0, g, r0 = (Symbol(name) for name in ("L", "m", "v0", "g", "r0"))
x, y, z, x1, y1, x2, y2 = (Symbol(name) for name in ("x", "y", "z", "x1", "y1", "x2", "y2"))
s, s1, s2, s21 = (Symbol(name) for name in ("s", "s1", "s2", "s21"))

rod_pendulum = Scene(
    "rod_pendulum",
    coordinates={x: "m", y: "m"},
    kinetic=m * (rate(x) ** 2 + rate(y) ** 2) / 2,
    invariants={s: x**2 + y**2},
    potential=m * g * y,
    constraints={"rod": (s - L**2) / 2},
    parameters=(
        optional(L, Rational("3.0443")),
        optional(m, 10),
        optional(v0, Rational("7.72"), REAL),
        optional(g, 0, NOT_NEGATIVE),
    ),
    start={x: L, y: 0, rate(x): 0, rate(y): v0},
    length=L,
    energy_scale=m * g * L,
    reference="the elastic pendulum with a rod in place of the bar, under gravity g along -y; the tension is rod*L",
)

spatial_pendulum = Scene(
    "spatial_pendulum",
    coordinates={x: "m", y: "m", z: "m"},
    kinetic=m * (rate(x) ** 2 + rate(y) ** 2 + rate(z) ** 2) / 2,
    invariants={s: x**2 + y**2 + z**2},
    potential=m * g * z,
    constraints={"rod": (s - L**2) / 2},
    parameters=(
        optional(L, 1),
        optional(m, 1),
        optional(r0, Rational(3, 5), REAL),
        optional(v0, 1, REAL),
        optional(g, Rational("9.81"), NOT_NEGATIVE),
    ),
    start={x: r0, y: 0, z: -sqrt(L**2 - r0**2), rate(x): 0, rate(y): v0, rate(z): 0},
    length=L,
    energy_scale=m * g * L,
    reference="a point on a rod in space, at r0 from the vertical with v0 across: a cone where v0^2 = g*r0^2/|z|",
)


four_bar = Scene(
    "four_bar",
    coordinates={x1: "m", y1: "m", x2: "m", y2: "m"},
    kinetic=m * (rate(x1) ** 2 + rate(y1) ** 2 + rate(x2) ** 2 + rate(y2) ** 2) / 2,
    invariants={s1: x1**2 + y1**2, s2: (x2 - L) ** 2 + y2**2, s21: (x2 - x1) ** 2 + (y2 - y1) ** 2},
    potential=m * g * (y1 + y2),
    constraints={"crank": (s1 - L**2) / 2, "coupler": (s21 - L**2) / 2, "rocker": (s2 - L**2) / 2},
    parameters=(
        optional(L, 1),
        optional(m, 1),
        optional(v0, 1, REAL),
        optional(g, Rational("9.81"), NOT_NEGATIVE),
    ),
    start={x1: 0, y1: L, x2: L, y2: L, rate(x1): v0, rate(y1): Integer(0), rate(x2): v0, rate(y2): Integer(0)},
    length=L,
    energy_scale=m * g * L,
    reference="a rhombus of rods, pinned at the origin and at (L, 0); all in line with the ground it is singular",
)

ALL = (rod_pendulum, spatial_pendulum, rod_double_pendulum, four_bar)
