"""Composite schemes: a one-step rule over gamma_t*h, three-point backward Euler over the rest."""

from sympy import Expr, Interval, Rational, Symbol, oo

from ..scheme import Balance, Parameter, Scheme
from ..symbols import beta, gamma, gamma_t, h, knot

u0, v0, a0 = knot(0)
ug, vg, ag = inner = knot("g")
u1, v1, a1 = end = knot(1)
half, quarter = Rational(1, 2), Rational(1, 4)


def three_point_backward_euler(split: Expr) -> dict[Symbol, Expr]:
    """Thesis (3.13)-(3.16): v1 and a1 from the states at 0, split*h and h."""
    c1 = (1 - split) / (split * h)
    c2 = -1 / ((1 - split) * split * h)
    c3 = (2 - split) / ((1 - split) * h)
    return {v1: c1 * u0 + c2 * ug + c3 * u1, a1: c1 * v0 + c2 * vg + c3 * v1}


newmark_bdf2 = Scheme(
    "newmark_bdf2",
    parameters=(
        Parameter(gamma_t, Interval.open(0, 1), half),
        Parameter(beta, Interval(0, oo), quarter),
        Parameter(gamma, Interval(0, oo), half),
    ),
    relations={
        ug: u0 + gamma_t * h * v0 + (gamma_t * h) ** 2 * ((half - beta) * a0 + beta * ag),
        vg: v0 + gamma_t * h * ((1 - gamma) * a0 + gamma * ag),
        **three_point_backward_euler(gamma_t),
    },
    balances=(Balance.at(inner, gamma_t), Balance.at(end, 1)),
    reference="Kumar, M.Tech thesis, IIT Guwahati (2015), (3.2)-(3.24)",
)

bathe = Scheme(
    "bathe",
    relations={
        ug: u0 + h / 4 * (v0 + vg),
        vg: v0 + h / 4 * (a0 + ag),
        **three_point_backward_euler(half),
    },
    balances=(Balance.at(inner, half), Balance.at(end, 1)),
    reference="Bathe & Baig, Comput. Struct. 83 (2005) 2513-2524",
)

silva_bezerra = newmark_bdf2.fix(
    {"beta": quarter, "gamma": half},
    name="silva_bezerra",
    reference="Silva & Bezerra, Math. Probl. Eng. 10 (2008) 1-25",
)

ALL = (bathe, silva_bezerra, newmark_bdf2)
