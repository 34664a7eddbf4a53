"""Schemes that papers name and no step of which needs the tangent stiffness where the motion has got to."""

from sympy import Interval, Rational, oo

from ..parameter import Parameter, Root
from ..published import Published
from ..scheme import Balance, Scheme
from ..symbols import K0, C, M, N, alpha, f, gamma, h, knot, rho_inf
from .alpha import mixed, newmark_relations

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
half = Rational(1, 2)
_Q = Rational
_up = knot("p").u

_am = (2 * rho_inf - 1) / (1 + rho_inf)
_af = _am - half
_b = (rho_inf**2 - 5 * rho_inf + 10) / (6 * (rho_inf - 2) * (rho_inf + 1))

fully_explicit_generalized_alpha = Scheme(
    "fully_explicit_generalized_alpha",
    parameters=(Parameter(rho_inf, Interval(0, 1), half),),
    relations={_up: u0 + h * v0 + h**2 * (half - _b) * a0, v1: v0 + h * a0, u1: _up + h**2 * _b * a1},
    balances=(Balance(mixed(a1, a0, _am), mixed(v1, v0, _af), mixed(N(_up), N(u0), _af), f(1 - _af)),),
    reference="Int. J. Numer. Methods Eng., doi 10.1002/nme.6574, as in suanPan, GeneralizedAlphaExplicit.cpp",
    published=Published("doi 10.1002/nme.6574", 2),
)

_hht_b, _hht_g = (1 - alpha) ** 2 / 4, half - alpha
_soft = K0 * h**2 * _hht_b / M  # M times it: the force from its predictor on, linear in the acceleration

alpha_os = Scheme(
    "alpha_os",
    parameters=(Parameter(alpha, Interval(-_Q(1, 3), 0), -_Q(1, 10)),),
    relations={_up: u0 + h * v0 + h**2 * (half - _hht_b) * a0, **newmark_relations(_hht_b, _hht_g)},
    balances=(
        Balance(
            a1 + (1 + alpha) * _hht_g * h * C / M * a1 + _soft * mixed(a1, a0, -alpha),
            v0 + (1 + alpha) * (1 - _hht_g) * h * a0,
            mixed(N(_up), N(u0 - _hht_b * h**2 * a0), -alpha),
            mixed(f(1), f(0), -alpha),
        ),
    ),
    reference="Combescure & Pegon, Soil Dyn. Earthq. Eng. 16 (1997) 427-443",
    published=Published("Combescure & Pegon (1997)", 2, None, oo),
).known_as("alpha_operator_splitting", "combescure_pegon", "operator_splitting: alpha=0", "nakashima: alpha=0")

_D = M + gamma * h * C + gamma**2 * h**2 * K0
_um, _vm, _am_ = knot("m")
_middle = gamma * (2 - gamma)  # 1/2 at the root; written so the scheme is L-stable for every gamma, to the last digit
_first = (_vm - v0) / _middle  # k_1 of v, and of u:
_moved = h * v0 + gamma * h * _first

lsrt2 = Scheme(
    "lsrt2",
    parameters=(Parameter(gamma, Interval(_Q(1, 4), half), Root(2 * gamma**2 - 4 * gamma + 1)),),
    relations={
        _vm: v0 + _middle * h * (M / _D * a0 - gamma * h * K0 / _D * v0),
        _um: u0 + _middle * _moved,
        v1: v0 + h * _am_ + gamma * h / _D * (K0 * _moved + C * _first - h * K0 * (_vm - gamma * _first)),
        u1: u0 + h * _vm + gamma * h * (v1 - v0 - _first),
    },
    balances=(Balance(_D / M * _am_, _vm, N(_um), f(_middle)), Balance.at(end, 1)),  # D a_m is M times the acceleration
    reference="Bursi, Gonzalez-Buelga, Vulcan, Neild & Wagg, Earthq. Eng. Struct. Dyn. 37 (2008) 339-360",
    published=Published("Bursi and others (2008)", 2, 0, oo),
).known_as("lsrt")

ALL = (fully_explicit_generalized_alpha, alpha_os, lsrt2)
