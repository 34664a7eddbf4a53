"""Diagonally implicit Runge-Kutta schemes: every stage has the same effective stiffness.

Where gamma is irrational it is a parameter whose default is a root of its equation, and the other entries are rational
in it, as the order conditions require.
"""

from sympy import Expr, Interval, Rational, factor, oo, sqrt

from ..parameter import Parameter, Root
from ..published import Published
from ..symbols import gamma
from ..tableau import tableau

_Q = Rational
half = _Q(1, 2)

sdirk2 = tableau(
    "sdirk2",
    A=((gamma,), (1 - gamma, gamma)),
    b=(1 - gamma, gamma),
    c=(gamma, 1),
    parameters=(Parameter(gamma, Interval(_Q(1, 4), half), Root(2 * gamma**2 - 4 * gamma + 1)),),
    reference="Alexander, SIAM J. Numer. Anal. 14 (1977) 1006-1021, two stages, gamma = 1 - sqrt(2)/2",
    published=Published("Alexander (1977)", 2, 0, oo),
).known_as("alexander")

_L_STABLE = Root(6 * gamma**3 - 18 * gamma**2 + 9 * gamma - 1)  # of third order, L-stable
_b1, _b2 = -(6 * gamma**2 - 16 * gamma + 1) / 4, (6 * gamma**2 - 20 * gamma + 5) / 4

sdirk3 = tableau(
    "sdirk3",
    A=((gamma,), ((1 - gamma) / 2, gamma), (_b1, _b2, gamma)),
    b=(_b1, _b2, gamma),
    c=(gamma, (1 + gamma) / 2, 1),
    parameters=(Parameter(gamma, Interval(_Q(2, 5), half), _L_STABLE),),
    reference="Alexander, SIAM J. Numer. Anal. 14 (1977) 1006-1021, three stages",
    published=Published("Alexander (1977)", 3, 0, oo),
).known_as("alexander")

crouzeix3 = tableau(
    "crouzeix3",
    A=((gamma,), (1 - 2 * gamma, gamma)),
    b=(half, half),
    c=(gamma, 1 - gamma),
    parameters=(Parameter(gamma, Interval(half, 1), Root(6 * gamma**2 - 6 * gamma + 1)),),
    reference="Crouzeix, thesis, Paris (1975); Norsett (1974), gamma = (3 + sqrt(3))/6",
    published=Published("Hairer & Wanner, Solving Ordinary Differential Equations II (1996), IV.6", 3, sqrt(3) - 1, oo),
).known_as("norsett")

_delta = 1 / (6 * (2 * gamma - 1) ** 2)

crouzeix4 = tableau(
    "crouzeix4",
    A=((gamma,), (half - gamma, gamma), (2 * gamma, 1 - 4 * gamma, gamma)),
    b=(_delta, 1 - 2 * _delta, _delta),
    c=(gamma, half, 1 - gamma),
    parameters=(Parameter(gamma, Interval(1, _Q(6, 5)), Root(24 * gamma**3 - 36 * gamma**2 + 12 * gamma - 1)),),
    reference="Crouzeix, thesis, Paris (1975); Norsett (1974), gamma = 1/2 + cos(pi/18)/sqrt(3)",
    published=Published("Hairer & Wanner, Solving Ordinary Differential Equations II (1996), IV.6", 4, None, oo),
).known_as("norsett")


def _second_stage_order(c3: Expr) -> tuple[Expr, Expr]:
    """a_31 and a_32 with c_2 = 2 gamma that integrate t exactly up to c_3."""
    a32 = (c3**2 / 2 - gamma * c3) / (2 * gamma)
    return c3 - gamma - a32, a32


_c2, _c3 = 2 * gamma, _Q(3, 5)
_a31, _a32 = _second_stage_order(_c3)
# Second order and b_1 = b_2 + b_3 (a_31 - a_32)/gamma, with which R(oo) = 0 whatever gamma is; third order at the root.
# b_hat_3 and b_hat_4 are the published ones, the rest is of second order.
_r3 = (_a31 - _a32) / gamma
_b3 = ((1 - gamma) * gamma - (half - gamma)) / (_c2 * (1 + _r3) / 2 - _c3)
_b2 = (half - gamma - _b3 * _c3) / _c2
_b = tuple(map(factor, (_b2 + _r3 * _b3, _b2, _b3, gamma)))
_e3, _e4 = _Q(9247589265047, 10645013368117), _Q(2193209047091, 5459859503100)
_e2 = (half - _e3 * _c3 - _e4) / _c2

esdirk32 = tableau(
    "esdirk32",
    A=((), (gamma, gamma), (_a31, _a32, gamma), _b),
    b=_b,
    c=(0, _c2, _c3, 1),
    b_hat=(1 - _e2 - _e3 - _e4, _e2, _e3, _e4),
    parameters=(Parameter(gamma, Interval(_Q(2, 5), half), _L_STABLE),),
    reference="Kennedy & Carpenter, Appl. Numer. Math. 44 (2003) 139-181, ARK3(2)4L[2]SA, implicit part, made exact",
    published=Published("Kennedy & Carpenter (2003)", 3, 0, oo),
)

_b = (_Q(82889, 524892), 0, _Q(15625, 83664), _Q(69875, 102672), _Q(-2260, 8211), _Q(1, 4))

esdirk43 = tableau(
    "esdirk43",
    A=(
        (),
        (_Q(1, 4), _Q(1, 4)),
        (_Q(8611, 62500), _Q(-1743, 31250), _Q(1, 4)),
        (_Q(5012029, 34652500), _Q(-654441, 2922500), _Q(174375, 388108), _Q(1, 4)),
        (
            *(_Q(15267082809, 155376265600), _Q(-71443401, 120774400), _Q(730878875, 902184768)),
            *(_Q(2285395, 8070912), _Q(1, 4)),
        ),
        _b,
    ),
    b=_b,
    c=(0, half, _Q(83, 250), _Q(31, 50), _Q(17, 20), 1),
    b_hat=(
        *(_Q(4586570599, 29645900160), 0, _Q(178811875, 945068544), _Q(814220225, 1159782912)),
        *(_Q(-3700637, 11593932), _Q(61727, 225920)),
    ),
    reference="Kennedy & Carpenter, Appl. Numer. Math. 44 (2003) 139-181, ARK4(3)6L[2]SA, implicit part",
    published=Published("Kennedy & Carpenter (2003)", 4, 0, oo),
)

ALL = (sdirk2, sdirk3, crouzeix3, crouzeix4, esdirk32, esdirk43)
