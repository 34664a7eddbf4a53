"""Newmark's family and its named members."""

from sympy import Interval, Rational, oo, sqrt

from ..parameter import Parameter
from ..published import Published
from ..scheme import Balance, Scheme
from ..symbols import beta, gamma, h, knot

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
half = Rational(1, 2)

newmark = Scheme(
    "newmark",
    parameters=(
        Parameter(beta, Interval(0, oo), Rational(1, 4)),
        Parameter(gamma, Interval(0, oo), half),
    ),
    relations={
        u1: u0 + h * v0 + h**2 * ((half - beta) * a0 + beta * a1),
        v1: v0 + h * ((1 - gamma) * a0 + gamma * a1),
    },
    balances=(Balance.at(end, 1),),
    reference="Newmark, J. Eng. Mech. Div. ASCE 85 (1959) 67-94; thesis (2.13)-(2.16)",
    published=Published(
        "Hughes, The Finite Element Method (1987), ch. 9; thesis (2.17)", 2, 1, oo, (2 * beta >= gamma, gamma >= half)
    ),
    synonyms=("newmark_beta",),
)

_table = "Hughes, The Finite Element Method (1987), table 9.1.1"

average_acceleration = newmark.fix(
    {"beta": "1/4", "gamma": half}, name="average_acceleration", published=Published(_table, 2, 1, oo)
).known_as(
    "trapezoidal", "trapezoidal_rule", "trapezium_rule", "constant_average_acceleration", "crank_nicolson",
    "implicit_midpoint", "average_constant_acceleration",
)  # fmt: skip
linear_acceleration = newmark.fix(
    {"beta": "1/6", "gamma": half},
    name="linear_acceleration",
    published=Published(_table, 2, critical_Omega=2 * sqrt(3)),
)
fox_goodwin = newmark.fix(
    {"beta": "1/12", "gamma": half},
    name="fox_goodwin",
    reference="Fox & Goodwin, Proc. Camb. Phil. Soc. 45 (1949) 373-388",
    published=Published(_table, 2, critical_Omega=sqrt(6)),
).known_as("royal_road", "numerov")
central_difference = newmark.fix(
    {"beta": 0, "gamma": half},
    name="central_difference",
    reference="Newmark with beta = 0; thesis (2.2)-(2.5)",
    published=Published(_table, 2, oo, 2),
).known_as(
    "central_differences", "velocity_verlet", "verlet", "stormer_verlet", "stoermer_verlet", "leapfrog", "leap_frog",
    "stormer", "stoermer", "explicit_newmark", "newmark_explicit",
)  # fmt: skip

ALL = (newmark, average_acceleration, linear_acceleration, fox_goodwin, central_difference)
