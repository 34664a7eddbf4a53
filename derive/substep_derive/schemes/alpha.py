"""Schemes whose balance mixes the two ends of the step."""

from sympy import Interval, Rational

from ..scheme import Balance, Parameter, Scheme
from ..symbols import K0, C, M, N, alpha_f, alpha_m, beta, f, gamma, h, knot, rho_inf
from .newmark import newmark

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
half = Rational(1, 2)

_gamma = half - alpha_m + alpha_f
_beta = (1 - alpha_m + alpha_f) ** 2 / 4

generalized_alpha = Scheme(
    "generalized_alpha",
    parameters=(
        Parameter(alpha_m, Interval(-1, half), Rational(0)),
        Parameter(alpha_f, Interval(0, half), Rational(1, 3)),
    ),
    relations={symbol: e.subs({beta: _beta, gamma: _gamma}) for symbol, e in newmark.relations.items()},
    balances=(
        Balance(
            (1 - alpha_m) * a1 + alpha_m * a0,
            (1 - alpha_f) * v1 + alpha_f * v0,
            (1 - alpha_f) * N(u1) + alpha_f * N(u0),
            f(1 - alpha_f),
        ),
    ),
    reference="Chung & Hulbert, J. Appl. Mech. 60 (1993) 371-375; thesis (2.31)-(2.38)",
)

_am, _af = (2 - rho_inf) / (1 + rho_inf), 1 / (1 + rho_inf)
_b, _g = 1 / (1 + rho_inf) ** 2, (3 - rho_inf) / (2 * (1 + rho_inf))
_D = M + _g * h * C + _b * h**2 * K0
_alpha1 = M / _D
_alpha3 = (_am * M + _af * _g * h * C + _af * _b * h**2 * K0) / _D

kr_alpha_plain_start = Scheme(
    "kr_alpha_plain_start",
    parameters=(Parameter(rho_inf, Interval(0, 1), half),),
    relations={u1: u0 + h * v0 + h**2 * (half + _g) * _alpha1 * a0, v1: v0 + h * _alpha1 * a0},
    balances=(
        Balance(
            _alpha3 * a1 + (1 - _alpha3) * a0,
            _af * v1 + (1 - _af) * v0,
            _af * N(u1) + (1 - _af) * N(u0),
            f(_af),
        ),
    ),
    reference="Kolay & Ricles, Earthq. Eng. Struct. Dyn. 43 (2014) 1361-1380",
)
