"""Schemes that papers name and few programs have."""

from sympy import Expr, Interval, Rational, Symbol, oo

from ..composition import composition
from ..parameter import Parameter, Root
from ..published import Published
from ..scheme import Balance, Scheme
from ..symbols import K0, C, M, N, f, h, knot, rho_inf
from ..tableau import tableau
from .alpha import kolay_ricles, mixed
from .newmark import average_acceleration

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
half = Rational(1, 2)
_Q = Rational
before = knot(-1).a
_up, _vp, _ap = knot("p")
_us, _vs, _as = knot("s")
_t1, _t2, _t3 = (Symbol(f"theta_{k}") for k in (1, 2, 3))
_rs, _rb = Symbol("rho_s"), Symbol("rho_b")

beeman = Scheme(
    "beeman",
    relations={u1: u0 + h * v0 + h**2 * (4 * a0 - before) / 6, v1: v0 + h * (2 * a1 + 5 * a0 - before) / 6},
    balances=(Balance.at(end, 1),),
    start={before: a0},
    reference="Beeman, J. Comput. Phys. 20 (1976) 130-139",
    published=Published("Beeman (1976)", 2),
).known_as("beeman_schofield")

_m, _k, _c = (2 - rho_inf) / (1 + rho_inf), 1 / (1 + rho_inf), 2 * rho_inf**2 - 7 * rho_inf + 11
_g, _change = half + _m - _k, a1 - a0

oess = Scheme(
    "oess",
    parameters=(Parameter(rho_inf, Interval(0, 1), half),),
    relations={
        u1: u0 + h * v0 + h**2 / 2 * a0 + h**2 * _change / (1 + rho_inf) ** 2,
        v1: v0 + h * a0 + h * _g * _change,
    },
    balances=(
        Balance(
            a0 + _m * _change,
            v0 + _k * h * a0 + _c / (3 * (1 + rho_inf) * (3 - rho_inf)) * _g * h * _change,
            _k * N(u1) + (1 - _k) * N(u0),
            _k * f(1) + (1 - _k) * f(0),
        ),
    ),
    reference="Zhang, Comput. Methods Appl. Mech. Eng. 418 (2024) 116503",
    published=Published("Zhang (2024)", 2, rho_inf, oo),
)

ss22 = Scheme(
    "ss22",
    parameters=(Parameter(_t1, Interval(half, oo), half), Parameter(_t2, Interval(half, oo), half)),
    relations={
        _us: u0 + _t1 * h * v0 + _t2 / 2 * h**2 * _as,
        u1: u0 + h * v0 + h**2 / 2 * _as,
        v1: v0 + h * _as,
    },
    balances=(Balance(_as, v0 + _t1 * h * _as, N(_us), (1 - _t1) * f(0) + _t1 * f(1)),),
    reference="Zienkiewicz, Wood, Hine & Taylor, Int. J. Numer. Methods Eng. 20 (1984) 1529-1552",
    published=Published("Zienkiewicz, Wood, Hine & Taylor (1984)", 2, 1, oo),
)

ss32 = Scheme(
    "ss32",
    parameters=(
        Parameter(_t1, Interval(1, oo), _Q(7, 5)),
        Parameter(_t2, Interval(1, oo), _Q(49, 25)),
        Parameter(_t3, Interval(1, oo), _Q(343, 125)),
    ),
    relations={
        _us: u0 + _t1 * h * v0 + _t2 / 2 * h**2 * a0 + _t3 / 6 * h**2 * _change,
        _vs: v0 + _t1 * h * a0 + _t2 / 2 * h * _change,
        u1: u0 + h * v0 + h**2 * (2 * a0 + a1) / 6,
        v1: v0 + h * (a0 + a1) / 2,
    },
    balances=(Balance(a0 + _t1 * _change, _vs, N(_us), (1 - _t1) * f(0) + _t1 * f(1)),),
    reference="Zienkiewicz, Wood, Hine & Taylor, Int. J. Numer. Methods Eng. 20 (1984) 1529-1552",
    published=Published("Zienkiewicz, Wood, Hine & Taylor (1984)", 2, None, oo),
)

_tp = (2 + _rs - _rb * _rs) / ((1 + _rb) * (1 + _rs))
_numerator = _rb * (_rb - 1) * _rs**3 + (_rb - 1) * (_rb**2 + 6 * _rb - 1) * _rs**2 / 2 + (1 - 5 * _rb) * _rs + 1 - _rb
_B = -_numerator / ((1 + _rb) * (1 + _rs) * (_rb * _rs - _rs - 2) ** 2)

gsse = Scheme(
    "gsse",
    parameters=(Parameter(_rb, Interval(0, 1), half), Parameter(_rs, Interval(0, 1), half)),
    relations={
        _up: u0 + _tp * h * v0 + (_tp * h) ** 2 / 2 * a0,
        _vp: v0 + _tp * h * a0,
        a1: a0 + (_ap - a0) / _tp,
        u1: u0 + h * v0 + h**2 * ((half - _B) * a0 + _B * _ap),
        v1: v0 + h * (a0 + (_ap - a0) / (2 * _tp)),
    },
    balances=(Balance.at(knot("p"), _tp),),
    reference="Int. J. Numer. Methods Eng., doi 10.1002/nme.6574, as in suanPan, GSSE.cpp",
    published=Published("doi 10.1002/nme.6574", 2),
)

_lam = Symbol("lambda_g")
_A = M / (M + h * C / 2 + h**2 * K0 / _lam)

gui_lambda = Scheme(
    "gui_lambda",
    parameters=(Parameter(_lam, Interval.open(0, oo), _Q(23, 2)),),
    relations={v1: v0 + h * _A * a0, u1: u0 + h * v0 + h**2 * _A * a0},
    balances=(Balance.at(end, 1),),
    reference="Gui, Wang, Jin, Chen & Zhou, Nonlinear Dyn. (2014), doi 10.1007/s11071-014-1368-3",
    published=Published("Gui and others (2014)", None),
).known_as("gui")

_r = rho_inf
_am = 1 - (2 * _r**3 + _r**2 - 1) / (_r**3 + _r**2 + _r + 1)
_gm = half + _am - 1 / (1 + _r)

mkr_alpha = kolay_ricles(
    "mkr_alpha",
    _am,
    (half + _gm) / 2,
    _gm,
    {},
    {},
    "Kolay & Ricles, J. Earthq. Eng. 23 (2019) 771-792",
    Published("Kolay & Ricles (2019)", None, rho_inf, oo),
).known_as("mkr", "modified_kr_alpha")

_third, _cubic = h / 3, Symbol("cubic")
_ux, _vx, _ax = one = knot("x")
_uy, _vy, _ay = two = knot("y")


def _backward(y0: Expr, y1: Expr, y2: Expr, y3: Expr) -> Expr:
    """The third of a step times the rate at y3: first to third backward differences of values a third apart."""
    return (y3 - y2) + (y3 - 2 * y2 + y1) / 2 + _cubic * (y3 - 3 * y2 + 3 * y1 - y0)


trapezoid_trapezoid_backward = Scheme(
    "trapezoid_trapezoid_backward",
    # BDF3 with 1/3 and Park's formula with 1/6 are unstable here at small Omega; up to (sqrt(7) - 2)/6 none is
    parameters=(Parameter(_cubic, Interval(0, half), _Q(1, 10)),),
    relations={
        _ux: u0 + _third / 2 * (v0 + _vx),
        _vx: v0 + _third / 2 * (a0 + _ax),
        _uy: _ux + _third / 2 * (_vx + _vy),
        _vy: _vx + _third / 2 * (_ax + _ay),
        v1: _backward(u0, _ux, _uy, u1) / _third,
        a1: _backward(v0, _vx, _vy, v1) / _third,
    },
    balances=(Balance.at(one, _Q(1, 3)), Balance.at(two, _Q(2, 3)), Balance.at(end, 1)),
    reference="Chandra and others (2015), the form",
    synonyms=("ttbdf", "chandra"),
)

_weight = Symbol("weight")

tarnow_simo = composition(
    "tarnow_simo",
    average_acceleration,
    (_weight, 1 - 2 * _weight, _weight),
    # 2 w^3 + (1 - 2 w)^3 = 0, so that w = 1/(2 - 2^(1/3))
    parameters=(Parameter(_weight, Interval(1, _Q(3, 2)), Root(6 * _weight**3 - 12 * _weight**2 + 6 * _weight - 1)),),
    reference="Tarnow & Simo, Comput. Methods Appl. Mech. Eng. 115 (1994) 233-252",
    published=Published("Tarnow & Simo (1994)", 4, 1, oo),
)

_last = (_Q(25, 24), -_Q(49, 48), _Q(125, 16), -_Q(85, 12), _Q(1, 4))

# without its embedded weights, which a load that jumps in the first quarter of a step changes as little as the others
sdirk4 = tableau(
    "sdirk4",
    A=(
        (_Q(1, 4),),
        (half, _Q(1, 4)),
        (_Q(17, 50), -_Q(1, 25), _Q(1, 4)),
        (_Q(371, 1360), -_Q(137, 2720), _Q(15, 544), _Q(1, 4)),
        _last,
    ),
    b=_last,
    c=(_Q(1, 4), _Q(3, 4), _Q(11, 20), half, 1),
    reference="Hairer & Wanner, Solving Ordinary Differential Equations II (1996), IV.6, (6.16)",
    published=Published("Hairer & Wanner, Solving Ordinary Differential Equations II (1996), IV.6", 4, 0, oo),
)

# the second rate and the second acceleration that these carry are auxiliary states
_d0, _d1 = knot(0, "rate").v, knot(1, "rate").v
_m, _w = (3 - rho_inf) / (2 * (1 + rho_inf)), 1 - 1 / (1 + rho_inf)
_g = 1 - half - _m + 1 / (1 + rho_inf)  # 1 - gamma

first_order_generalized_alpha = Scheme(
    "first_order_generalized_alpha",
    parameters=(Parameter(rho_inf, Interval(0, 1), half),),
    relations={
        _d1: (mixed(v1, v0, _w) - (1 - _m) * _d0) / _m,
        u1: u0 + h * mixed(_d1, _d0, _g),
        v1: v0 + h * mixed(a1, a0, _g),
    },
    balances=(Balance(mixed(a1, a0, 1 - _m), mixed(v1, v0, _w), mixed(N(u1), N(u0), _w), f(1 - _w)),),
    start={_d0: v0},
    reference="Jansen, Whiting & Hulbert, CMAME 190 (2000) 305-319; Kadapa, Dettmer & Peric, Comput. Struct. (2017)",
    published=Published("Kadapa, Dettmer & Peric (2017)", 2, rho_inf, oo),
).known_as("jansen_whiting_hulbert", "generalized_alpha_first_order")

_x0, _x1 = knot(0, "weighted").a, knot(1, "weighted").a
_m, _w = (2 * rho_inf - 1) / (rho_inf + 1), rho_inf / (rho_inf + 1)

arnold_bruels = Scheme(
    "arnold_bruels",
    parameters=(Parameter(rho_inf, Interval(0, 1), Rational(4, 5)),),
    relations={
        _x1: (mixed(a1, a0, _w) - _m * _x0) / (1 - _m),
        u1: u0 + h * v0 + h**2 * mixed(_x1, _x0, 1 - 2 / (1 + rho_inf) ** 2) / 2,
        v1: v0 + h * mixed(_x1, _x0, half + _m - _w),
    },
    balances=(Balance.at(end, 1),),
    start={_x0: a0},
    reference="Arnold & Bruels, Multibody Syst. Dyn. 18 (2007) 185-202",
    published=Published("Arnold & Bruels (2007)", 2, rho_inf, oo),
).known_as("arnold_bruls", "lie_group_generalized_alpha", "gena")

ALL = (
    *(beeman, oess, ss22, ss32, gsse, gui_lambda, mkr_alpha, trapezoid_trapezoid_backward, tarnow_simo),
    *(sdirk4, first_order_generalized_alpha, arnold_bruels),
)
