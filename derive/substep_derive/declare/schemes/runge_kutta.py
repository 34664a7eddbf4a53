"""Explicit Runge-Kutta pairs."""

from sympy import Rational, oo, sqrt

from ...algebra.constant import Constant
from ..published import Published
from ..tableau import tableau

_Q = Rational
_half = _Q(1, 2)

_b = (_Q(2, 9), _Q(1, 3), _Q(4, 9), 0)

bogacki_shampine = tableau(
    "bogacki_shampine",
    A=((), (_Q(1, 2),), (0, _Q(3, 4)), _b),
    b=_b,
    c=(0, _Q(1, 2), _Q(3, 4), 1),
    b_hat=(_Q(7, 24), _Q(1, 4), _Q(1, 3), _Q(1, 8)),
    reference="Bogacki & Shampine, Appl. Math. Lett. 2 (1989) 321-325",
    published=Published("Bogacki & Shampine (1989)", 3, oo),
).known_as("rk23", "ode23")

_b = (_Q(35, 384), 0, _Q(500, 1113), _Q(125, 192), _Q(-2187, 6784), _Q(11, 84), 0)

dormand_prince = tableau(
    "dormand_prince",
    A=(
        (),
        (_Q(1, 5),),
        (_Q(3, 40), _Q(9, 40)),
        (_Q(44, 45), _Q(-56, 15), _Q(32, 9)),
        (_Q(19372, 6561), _Q(-25360, 2187), _Q(64448, 6561), _Q(-212, 729)),
        (_Q(9017, 3168), _Q(-355, 33), _Q(46732, 5247), _Q(49, 176), _Q(-5103, 18656)),
        _b,
    ),
    b=_b,
    c=(0, _Q(1, 5), _Q(3, 10), _Q(4, 5), _Q(8, 9), 1, 1),
    b_hat=(
        *(_Q(5179, 57600), 0, _Q(7571, 16695), _Q(393, 640)),
        *(_Q(-92097, 339200), _Q(187, 2100), _Q(1, 40)),
    ),
    reference="Dormand & Prince, J. Comput. Appl. Math. 6 (1980) 19-26",
    published=Published("Dormand & Prince (1980)", 5, oo),
).known_as("dopri5", "rk45", "ode45", "dormand_prince_5")

_r = Constant("theta", sqrt(5))

butcher6 = tableau(
    "butcher6",
    A=(
        (),
        (_half - _r / 10,),
        (-_r / 10, _half + _r / 5),
        (7 * _r / 20 - _Q(3, 4), _r / 4 - _Q(1, 4), _Q(3, 2) - 7 * _r / 10),
        (_Q(1, 12) - _r / 60, 0, _Q(1, 6), 7 * _r / 60 + _Q(1, 4)),
        (_r / 60 + _Q(1, 12), 0, _Q(3, 4) - 5 * _r / 12, _Q(1, 6), 3 * _r / 10 - _half),
        (_Q(1, 6), 0, 25 * _r / 12 - _Q(55, 12), -7 * _r / 12 - _Q(25, 12), 5 - 2 * _r, _Q(5, 2) + _r / 2),
    ),
    b=(_Q(1, 12), 0, 0, 0, _Q(5, 12), _Q(5, 12), _Q(1, 12)),
    c=(0, *(_half - _r / 10, _half + _r / 10) * 2, _half - _r / 10, 1),
    reference="Butcher, J. Aust. Math. Soc. 4 (1964) 179-194, a process of order 6 in 7 stages",
    published=Published("Butcher (1964)", 6, oo),
)

ALL = (bogacki_shampine, dormand_prince, butcher6)
