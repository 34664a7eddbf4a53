"""Explicit Runge-Kutta pairs."""

from sympy import Rational, oo

from ..published import Published
from ..tableau import tableau

_Q = Rational

_b = (_Q(2, 9), _Q(1, 3), _Q(4, 9), 0)

bogacki_shampine = tableau(
    "bogacki_shampine",
    A=((), (_Q(1, 2),), (0, _Q(3, 4)), _b),
    b=_b,
    c=(0, _Q(1, 2), _Q(3, 4), 1),
    b_hat=(_Q(7, 24), _Q(1, 4), _Q(1, 3), _Q(1, 8)),
    reference="Bogacki & Shampine, Appl. Math. Lett. 2 (1989) 321-325",
    published=Published("Bogacki & Shampine (1989)", 3, oo),
)

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
)

ALL = (bogacki_shampine, dormand_prince)
