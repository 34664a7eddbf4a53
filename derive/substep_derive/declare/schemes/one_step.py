"""Implicit one-step schemes with one balance."""

from sympy import Interval, Rational, oo

from ..parameter import Parameter
from ..published import Published
from ..scheme import Balance, Scheme
from ..symbols import N, N_discrete, beta, f, gamma, h, knot, theta

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
half = Rational(1, 2)

backward_euler = Scheme(
    "backward_euler",
    relations={v1: (u1 - u0) / h, a1: (v1 - v0) / h},
    balances=(Balance.at(end, 1),),
    reference="Euler; Bathe, Finite Element Procedures (1996), ch. 9",
    published=Published("Hairer & Wanner, Solving Ordinary Differential Equations II (1996), IV.3", 1, 0, oo),
    synonyms=("implicit_euler", "bdf1"),
)

_ut, _vt, _at = knot("t")
_th = theta * h

wilson_theta = Scheme(
    "wilson_theta",
    parameters=(Parameter(theta, Interval(1, oo), Rational(7, 5)),),
    relations={
        _at: 6 / _th**2 * (_ut - u0) - 6 / _th * v0 - 2 * a0,
        _vt: 3 / _th * (_ut - u0) - 2 * v0 - _th / 2 * a0,
        a1: a0 + (_at - a0) / theta,
        v1: v0 + h / 2 * (a0 + a1),
        u1: u0 + h * v0 + h**2 / 6 * (2 * a0 + a1),
    },
    balances=(Balance(_at, _vt, N(_ut), f(0) + theta * (f(1) - f(0))),),
    reference="Wilson, Farhoomand & Bathe, Earthq. Eng. Struct. Dyn. 1 (1973) 241-252; thesis (2.18)-(2.22)",
    published=Published(
        "Bathe & Wilson, Earthq. Eng. Struct. Dyn. 1 (1973) 283-291", 2, None, oo, (2 * theta**2 - 2 * theta - 1 >= 0,)
    ),
    synonyms=("wilson", "wilsons_theta"),
)

collocation = Scheme(
    "collocation",
    parameters=(
        Parameter(theta, Interval(1, oo), Rational(6, 5)),
        Parameter(beta, Interval(0, oo), Rational(1, 5)),
        Parameter(gamma, Interval(0, oo), half),
    ),
    relations={
        _at: (1 - theta) * a0 + theta * a1,
        _ut: u0 + _th * v0 + _th**2 * ((half - beta) * a0 + beta * _at),
        _vt: v0 + _th * ((1 - gamma) * a0 + gamma * _at),
        u1: u0 + h * v0 + h**2 * ((half - beta) * a0 + beta * a1),
        v1: v0 + h * ((1 - gamma) * a0 + gamma * a1),
    },
    balances=(Balance(_at, _vt, N(_ut), f(0) + theta * (f(1) - f(0))),),
    reference="Hilber & Hughes, Earthq. Eng. Struct. Dyn. 6 (1978) 99-117",
    published=Published("Hilber & Hughes (1978)", 2, None, oo),
)

theta_method = Scheme(
    "theta_method",
    parameters=(Parameter(theta, Interval(0, 1), Rational(3, 5)),),
    relations={u1: u0 + h * (theta * v1 + (1 - theta) * v0)},
    balances=(
        Balance(
            (v1 - v0) / h,
            theta * v1 + (1 - theta) * v0,
            theta * N(u1) + (1 - theta) * N(u0),
            theta * f(1) + (1 - theta) * f(0),
        ),
    ),
    reference="Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), II.7; Moreau & Jean",
    published=Published(
        "Wood, Practical Time-stepping Schemes (1990), ch. 2", 1, (1 - theta) / theta, oo, (2 * theta >= 1,)
    ),
    synonyms=("theta", "one_step_theta", "moreau_jean", "moreau"),
)

energy_momentum = Scheme(
    "energy_momentum",
    relations={u1: u0 + h / 2 * (v0 + v1)},
    balances=(Balance((v1 - v0) / h, (v0 + v1) / 2, N_discrete(u0, u1), f(half)),),
    reference="Simo & Tarnow, ZAMP 43 (1992) 757-792; Gonzalez, J. Nonlinear Sci. 6 (1996) 449-467",
    published=Published("Simo & Tarnow, ZAMP 43 (1992) 757-792", 2, 1, oo),
    synonyms=("implicit_midpoint", "midpoint", "midpoint_rule", "simo_tarnow"),
)

ALL = (backward_euler, wilson_theta, collocation, theta_method, energy_momentum)
