"""Composite schemes: a one-step rule over gamma_t*h, three-point backward Euler over the rest."""

from sympy import Expr, Interval, Rational, Symbol, oo, sqrt

from ..parameter import Family, Parameter, Root
from ..published import Published
from ..scheme import Balance, Scheme
from ..symbols import beta, beta1, beta2, gamma, gamma_t, h, knot, rho_inf

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
    synonyms=("tr_bdf2", "trbdf2"),
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
    published=Published("Bathe & Noh, Comput. Struct. 98-99 (2012) 1-6", 2, 0, oo),
    synonyms=("two_step_bathe", "bathe_composite", "bathe_baig", "tr_bdf2", "trbdf2"),
)

silva_bezerra = newmark_bdf2.fix(
    {"beta": quarter, "gamma": half},
    name="silva_bezerra",
    reference="Silva & Bezerra, Math. Probl. Eng. 10 (2008) 1-25",
).known_as("tr_bdf2", "trbdf2")

_trapezoid = {
    ug: u0 + gamma_t * h / 2 * (v0 + vg),
    vg: v0 + gamma_t * h / 2 * (a0 + ag),
}

_q1 = (1 + rho_inf) / (2 * gamma_t * (rho_inf - 1) + 4)
_q2 = half - gamma_t * _q1
_q0 = 1 - _q1 - _q2

rho_inf_bathe = Scheme(
    "rho_inf_bathe",
    parameters=(
        Parameter(rho_inf, Interval(0, 1), half),
        Parameter(gamma_t, Interval.open(0, 1), 2 / (2 + sqrt(2 + 2 * rho_inf))),
    ),
    relations={
        **_trapezoid,
        u1: u0 + h * (_q0 * v0 + _q1 * vg + _q2 * v1),
        v1: v0 + h * (_q0 * a0 + _q1 * ag + _q2 * a1),
    },
    balances=(Balance.at(inner, gamma_t), Balance.at(end, 1)),
    reference="Noh & Bathe, Comput. Struct. 212 (2019) 299-310",
    published=Published("Noh & Bathe (2019)", 2, rho_inf, oo),
    synonyms=("rho_infinity_bathe", "rho_bathe"),
)

_w0, _w1, _w2 = gamma_t * (1 - beta1), gamma_t * beta1 + (1 - gamma_t) * (1 - beta2), (1 - gamma_t) * beta2

beta1_beta2_bathe = Scheme(
    "beta1_beta2_bathe",
    parameters=(
        Parameter(beta1, Interval(0, 1), Rational(1, 3)),
        Parameter(beta2, Interval.Lopen(0, 1), 2 * beta1),
        Parameter(gamma_t, Interval.open(0, 1), half),
    ),
    families=(
        Family(
            Parameter(rho_inf, Interval(0, 1), half),
            {beta1: (1 + rho_inf) / (3 + rho_inf), beta2: 2 / (3 + rho_inf), gamma_t: half},
        ),
    ),
    relations={
        **_trapezoid,
        u1: u0 + h * (_w0 * v0 + _w1 * vg + _w2 * v1),
        v1: v0 + h * (_w0 * a0 + _w1 * ag + _w2 * a1),
    },
    balances=(Balance.at(inner, gamma_t), Balance.at(end, 1)),
    reference="Malakiyeh, Shojaee & Bathe, Comput. Struct. 212 (2019) 289-298",
    published=Published("Malakiyeh, Shojaee & Bathe (2019)", 2, rho_inf, oo),
    synonyms=("malakiyeh", "beta_bathe"),
)

_uk, _vk, _ak = later = knot("k")
_d1, _d2 = 1 - 3 * gamma / 2, half - 3 * gamma / 2 + 3 * gamma**2 / 4
_d3 = rho_inf * gamma**3 / 8
_b0 = gamma / 2
_b1 = gamma / 8 + _d1 / 4 + _d2 / (2 * gamma) + _d3 / gamma**2
_b2 = gamma / 2 + _d1 / 2 - 2 * _d3 / gamma**2
_b3 = 3 * gamma / 8 + _d1 / 4 - _d2 / (2 * gamma) + _d3 / gamma**2

three_substep = Scheme(
    "three_substep",
    parameters=(
        Parameter(rho_inf, Interval(0, 1), half),
        # where the y^4 term of |den(iy)|^2 - |num(iy)|^2 vanishes, num/den the stability function of the step
        Parameter(
            gamma, Interval(Rational(33, 100), Rational(37, 100)), Root(_d2**2 - 2 * _d1 * _d3 - 3 * gamma**4 / 16)
        ),
    ),
    relations={
        ug: u0 + gamma * h / 2 * (v0 + vg),
        vg: v0 + gamma * h / 2 * (a0 + ag),
        _uk: ug + gamma * h / 2 * (vg + _vk),
        _vk: vg + gamma * h / 2 * (ag + _ak),
        u1: u0 + h * (_b3 * v0 + _b2 * vg + _b1 * _vk + _b0 * v1),
        v1: v0 + h * (_b3 * a0 + _b2 * ag + _b1 * _ak + _b0 * a1),
    },
    balances=(Balance.at(inner, gamma), Balance.at(later, 2 * gamma), Balance.at(end, 1)),
    reference="Zhang et al., Int. J. Numer. Methods Eng. 121 (2020); three sub-steps, controllable rho_inf",
    published=Published("Zhang et al. (2020)", 2, rho_inf, oo),
    synonyms=("msstc", "msstc3"),
)

_third = h / 3

trbdf3 = Scheme(
    "trbdf3",
    relations={
        ug: u0 + _third / 2 * (v0 + vg),
        vg: v0 + _third / 2 * (a0 + ag),
        _vk: (3 * _uk - 4 * ug + u0) / (2 * _third),
        _ak: (3 * _vk - 4 * vg + v0) / (2 * _third),
        v1: (11 * u1 - 18 * _uk + 9 * ug - 2 * u0) / (6 * _third),
        a1: (2 * u1 - 5 * _uk + 4 * ug - u0) / _third**2,
    },
    balances=(Balance.at(inner, Rational(1, 3)), Balance.at(later, Rational(2, 3)), Balance.at(end, 1)),
    reference="OpenSees, integrator TRBDF3 (2012): trapezoidal rule, three-point backward Euler, Houbolt",
)

ALL = (bathe, silva_bezerra, newmark_bdf2, rho_inf_bathe, beta1_beta2_bathe, three_substep, trbdf3)
