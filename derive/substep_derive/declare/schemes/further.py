"""Schemes that reviews and programs name beside those of the thesis."""

from sympy import Expr, Interval, Rational, Symbol, oo

from ..parameter import Parameter
from ..published import Published
from ..scheme import Balance, Scheme
from ..symbols import K0, C, M, N, alpha, beta, f, gamma, h, knot, phi
from .newmark import average_acceleration
from .runge_kutta import dormand_prince

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
um, vm, am = knot(-1)
amm = knot(-2).a
half = Rational(1, 2)
psi = Symbol("psi")

_D = M + h * C / 2 + h**2 * K0 / 4

_E = M + gamma * h * C + beta * h**2 * K0

# Newmark's scheme, explicit in u: the paper has beta = 1/4, gamma = 1/2
chang = Scheme(
    "chang",
    parameters=(Parameter(beta, Interval(0, oo), Rational(1, 4)), Parameter(gamma, Interval(0, oo), half)),
    relations={
        u1: u0 + h * (M + gamma * h * C) / _E * v0 + h**2 * (M / 2 + (gamma / 2 - beta) * h * C) / _E * a0,
        v1: v0 + h * ((1 - gamma) * a0 + gamma * a1),
    },
    balances=(Balance.at(end, 1),),
    reference="Chang, J. Eng. Mech. ASCE 128 (2002) 935-942",
    published=Published("Chang (2002)", 2, 1, oo),
)

chen_ricles = Scheme(
    "chen_ricles",
    relations={v1: v0 + h * M / _D * a0, u1: u0 + h * v0 + h**2 * M / _D * a0},
    balances=(Balance.at(end, 1),),
    reference="Chen & Ricles, J. Eng. Mech. ASCE 134 (2008) 676-683",
    published=Published("Chen & Ricles (2008)", None, 1, oo),
).known_as("cr", "cr_algorithm")

chung_lee = Scheme(
    "chung_lee",
    parameters=(Parameter(beta, Interval(1, Rational(28, 27)), Rational(55, 54)),),
    relations={
        u1: u0 + h * v0 + h**2 * ((half - beta) * a0 + beta * a1),
        v1: v0 + h * (3 * a1 - a0) / 2,
    },
    balances=(Balance(a1, v0, N(u0), f(0)),),
    reference="Chung & Lee, Int. J. Numer. Methods Eng. 37 (1994) 3961-3976",
    published=Published("Chung & Lee (1994)", 2, oo),
)


adams_moulton3 = Scheme(
    "adams_moulton3",
    relations={  # the acceleration over the step is the parabola through the last three
        u1: u0 + h * v0 + h**2 * (3 * a1 + 10 * a0 - am) / 24,
        v1: v0 + h * (5 * a1 + 8 * a0 - am) / 12,
    },
    balances=(Balance.at(end, 1),),
    start=average_acceleration,
    reference="Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), III.1, on the acceleration",
    published=Published("Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), III.2", 3),
)

adams_moulton4 = Scheme(
    "adams_moulton4",
    relations={  # the cubic through the last four
        u1: u0 + h * v0 + h**2 * (38 * a1 + 171 * a0 - 36 * am + 7 * amm) / 360,
        v1: v0 + h * (9 * a1 + 19 * a0 - 5 * am + amm) / 24,
    },
    balances=(Balance.at(end, 1),),
    start=dormand_prince,
    reference="Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), III.1, on the acceleration",
    published=Published("Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), III.2", 4),
)

_b = Rational(3, 2) + alpha

bdf_alpha = Scheme(
    "bdf_alpha",
    parameters=(Parameter(alpha, Interval(-half, 0), Rational(-3, 10)),),
    relations={
        u1: ((2 + 2 * alpha) * u0 - (half + alpha) * um + h * ((1 + alpha) * v1 - alpha * v0)) / _b,
        v1: ((2 + 2 * alpha) * v0 - (half + alpha) * vm + h * ((1 + alpha) * a1 - alpha * a0)) / _b,
    },
    balances=(Balance.at(end, 1),),
    start=average_acceleration,
    reference="Alberdi Celaya & Anza, Univ. J. Comput. Math. 1 (2013) 96-108",
    published=Published("Alberdi Celaya & Anza (2013)", 2, -alpha / (1 + alpha), oo),
)

zhai = Scheme(
    "zhai",
    parameters=(Parameter(psi, Interval(0, 1), half), Parameter(phi, Interval(0, 1), half)),
    relations={
        u1: u0 + h * v0 + h**2 * ((half + psi) * a0 - psi * am),
        v1: v0 + h * ((1 + phi) * a0 - phi * am),
    },
    balances=(Balance.at(end, 1),),
    start={am: a0},  # the first step is the one without psi and phi
    reference="Zhai, Int. J. Numer. Methods Eng. 39 (1996) 4199-4214",
    published=Published("Zhai (1996)", 2, oo),
)

_r1, _r2, _r3 = (Symbol(f"rho_{k}") for k in (1, 2, 3))
_q = (1 + _r1) * (1 + _r2)
_up, _vp, _ap = knot("p")


def gssss(name: str, L1: Expr, L2: Expr, L5: Expr, l3: Expr, l5: Expr) -> Scheme:
    """The generalized single step single solve family; Lambda and lambda of Zhou and Tamma by their numbers."""
    change = a1 - a0
    L3 = 1 / (_q * (1 + _r3))
    L6 = (2 + _r1 + _r2 + _r3 - _r1 * _r2 * _r3) / (_q * (1 + _r3))
    return Scheme(
        name,
        parameters=tuple(Parameter(r, Interval(0, 1), half) for r in (_r1, _r2, _r3)),
        relations={
            _up: u0 + L1 * h * v0 + L2 * h**2 * a0 + L3 * h**2 * change,
            _vp: v0 + L1 * h * a0 + L5 * h * change,
            u1: u0 + h * v0 + h**2 / 2 * a0 + l3 * h**2 * change,
            v1: v0 + h * a0 + l5 * h * change,
        },
        balances=(Balance(a0 + L6 * change, _vp, N(_up), (1 - L1) * f(0) + L1 * f(1)),),
        reference="Zhou & Tamma, Int. J. Numer. Methods Eng. 59 (2004) 597-668",
        published=Published("Zhou & Tamma (2004)", 2, half, oo),
    )


_S = 3 + _r1 + _r2 - _r1 * _r2
_half3 = 1 / (1 + _r3)
# U0, of overshoot 0 in displacement, has generalized-alpha where the three are equal; V0 has none in velocity
gssss_u0 = gssss("gssss_u0", _half3, _half3 / 2, _S * _half3 / (2 * _q), 1 / _q, _S / (2 * _q))
gssss_v0 = gssss("gssss_v0", _S / (2 * _q), 1 / _q, 2 / (_q * (1 + _r3)), _half3 / 2, _half3)

ALL = (chang, chen_ricles, chung_lee, adams_moulton3, adams_moulton4, bdf_alpha, zhai, gssss_u0, gssss_v0)
