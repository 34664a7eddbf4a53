"""Explicit schemes."""

from sympy import Interval, Rational, oo, sqrt

from ..parameter import Parameter
from ..published import Published
from ..scheme import Balance, Scheme
from ..symbols import C, M, N, f, gamma_t, h, knot, p, phi

u0, v0, a0 = start = knot(0)
u1, v1, a1 = end = knot(1)
half = Rational(1, 2)

forward_euler = Scheme(
    "forward_euler",
    relations={u1: u0 + h * v0, v1: v0 + h * a0},
    balances=(Balance.at(start, 0),),
    reference="Euler; thesis (2.10)-(2.11)",
    published=Published("Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), II.1", 1, oo, 0),
    synonyms=("explicit_euler", "euler"),
)

_vb = knot("-1/2").v
_vf = knot("1/2").v
_lagged = (f(1) - C * _vf - N(u1)) / M

central_difference_lagged = Scheme(
    "central_difference_lagged",
    relations={_vf: _vb + h * a0, u1: u0 + h * _vf},
    balances=(Balance(a0, _vb, N(u0), f(0)),),
    start={_vb: v0 - h / 2 * (f(0) - C * v0 - N(u0)) / M},
    report={v1: _vf + h / 2 * _lagged, a1: _lagged},
    reference="Belytschko, Liu & Moran, Nonlinear Finite Elements (2000), box 6.1",
    synonyms=("leapfrog", "leap_frog", "lagged_central_difference"),
)

_up, _vp, _ap = second = knot("p")
_uq, _vq, _aq = third = knot("q")
_ur, _vr, _ar = fourth = knot("r")

rk2 = Scheme(
    "rk2",
    relations={_up: u0 + h / 2 * v0, _vp: v0 + h / 2 * a0, u1: u0 + h * _vp, v1: v0 + h * _ap},
    balances=(Balance.at(start, 0), Balance.at(second, half)),
    reference="Runge's midpoint rule; thesis (2.7)",
    published=Published("Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), II.1", 2, oo, 0),
    synonyms=("runge_kutta", "explicit_midpoint", "midpoint", "midpoint_rule"),
)

rk4 = Scheme(
    "rk4",
    relations={
        _up: u0 + h / 2 * v0,
        _vp: v0 + h / 2 * a0,
        _uq: u0 + h / 2 * _vp,
        _vq: v0 + h / 2 * _ap,
        _ur: u0 + h * _vq,
        _vr: v0 + h * _aq,
        u1: u0 + h / 6 * (v0 + 2 * _vp + 2 * _vq + _vr),
        v1: v0 + h / 6 * (a0 + 2 * _ap + 2 * _aq + _ar),
    },
    balances=(Balance.at(start, 0), Balance.at(second, half), Balance.at(third, half), Balance.at(fourth, 1)),
    reference="Kutta, Z. Math. Phys. 46 (1901) 435-453; thesis (2.8)-(2.9)",
    published=Published("Hairer & Wanner, Solving Ordinary Differential Equations II (1996), IV.2", 4, oo, 2 * sqrt(2)),
    synonyms=("runge_kutta", "runge_kutta_4", "classical_runge_kutta"),
)

_q1 = (1 - 2 * p) / (2 * p * (1 - p))
_q2 = half - p * _q1
_q0 = half - _q1 - _q2
_rh = (1 - p) * h

noh_bathe = Scheme(
    "noh_bathe",
    parameters=(Parameter(p, Interval.Ropen(half, 1), Rational(27, 50)),),
    relations={
        _up: u0 + p * h * v0 + (p * h) ** 2 / 2 * a0,
        _vp: v0 + p * h / 2 * (a0 + _ap),
        u1: _up + _rh * _vp + _rh**2 / 2 * _ap,
        v1: _vp + _rh * (_q0 * a0 + (half + _q1) * _ap + _q2 * a1),
    },
    balances=(Balance(_ap, v0 + p * h * a0, N(_up), f(p)), Balance(a1, _vp + _rh * _ap, N(u1), f(1))),
    reference="Noh & Bathe, Comput. Struct. 129 (2013) 178-193",
    synonyms=("explicit_bathe", "noh_bathe_explicit"),
)

tchamwa_wielgosz = Scheme(
    "tchamwa_wielgosz",
    parameters=(Parameter(phi, Interval(1, 2), Rational(11, 10)),),
    relations={u1: u0 + h * v0 + phi * h**2 * a0, v1: v0 + h * a0},
    balances=(Balance.at(end, 1),),
    reference="Tchamwa, Conway & Wielgosz, ASME PVP 398 (1999); Maheo, Grolleau & Rio, Comput. Mech. 51 (2013)",
    synonyms=("tchamwa", "symplectic_euler: phi=1", "semi_implicit_euler: phi=1", "euler_cromer: phi=1"),
)

_gp, _gq = 1 / gamma_t, 1 / (1 - gamma_t)

kim_two_stage = Scheme(
    "kim_two_stage",
    parameters=(Parameter(gamma_t, Interval.open(0, 1), Rational(1, 3)),),
    relations={
        _up: u0 + gamma_t * h * v0 + (gamma_t * h) ** 2 / 2 * a0,
        _vp: v0 + gamma_t * h * a0,
        _uq: u0 + h * v0 + h**2 / 6 * ((3 - _gp) * a0 + _gp * _ap),
        _vq: v0 + h / 2 * ((2 - _gp) * a0 + _gp * _ap),
        u1: u0 + h * v0 + h**2 / 12 * ((4 - _gp) * a0 + _gp * _gq * _ap + (2 - _gq) * a1),
        v1: v0 + h / 6 * ((3 - _gp) * a0 + _gp * _gq * _ap + (3 - _gq) * a1),
    },
    balances=(Balance.at(second, gamma_t), Balance(a1, _vq, N(_uq), f(1))),  # a1 stays that of the second stage
    reference="Kim, Int. J. Numer. Methods Eng. 120 (2019) 1-28, as in Kratos, explicit_multi_stage_kim_scheme.hpp",
)

ALL = (forward_euler, central_difference_lagged, rk2, rk4, noh_bathe, tchamwa_wielgosz, kim_two_stage)
