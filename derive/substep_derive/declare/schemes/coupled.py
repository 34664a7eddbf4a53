"""Schemes whose stages are solved together: Gauss, Radau and Lobatto methods, weighted residuals."""

from sympy import Interval, Rational, oo, sqrt

from ...algebra.constant import Constant
from ..parameter import Parameter
from ..published import Published
from ..scheme import Balance, Scheme
from ..symbols import N, f, h, knot, rho_inf
from ..tableau import tableau

_Q = Rational
half = _Q(1, 2)
_book = "Hairer & Wanner, Solving Ordinary Differential Equations II (1996), IV.5"

_r = Constant("theta", sqrt(3))

gauss2 = tableau(
    "gauss2",
    A=((_Q(1, 4), _Q(1, 4) - _r / 6), (_Q(1, 4) + _r / 6, _Q(1, 4))),
    b=(half, half),
    c=(half - _r / 6, half + _r / 6),
    reference="Butcher, Math. Comp. 18 (1964) 50-64, Gauss's quadrature of two points",
    published=Published(_book, 4, 1),
).known_as("gauss_legendre4", "hammer_hollingsworth")

_r = Constant("theta", sqrt(15))

gauss3 = tableau(
    "gauss3",
    A=(
        (_Q(5, 36), _Q(2, 9) - _r / 15, _Q(5, 36) - _r / 30),
        (_Q(5, 36) + _r / 24, _Q(2, 9), _Q(5, 36) - _r / 24),
        (_Q(5, 36) + _r / 30, _Q(2, 9) + _r / 15, _Q(5, 36)),
    ),
    b=(_Q(5, 18), _Q(4, 9), _Q(5, 18)),
    c=(half - _r / 10, half, half + _r / 10),
    reference="Butcher, Math. Comp. 18 (1964) 50-64, Gauss's quadrature of three points",
    published=Published(_book, 6, 1),
).known_as("gauss_legendre6", "kuntzmann_butcher")

_b = (_Q(3, 4), _Q(1, 4))

radau_iia2 = tableau(
    "radau_iia2",
    A=((_Q(5, 12), _Q(-1, 12)), _b),
    b=_b,
    c=(_Q(1, 3), 1),
    reference="Ehle, SIAM J. Math. Anal. 4 (1973) 671-680; Axelsson, BIT 9 (1969) 185-199, two stages",
    published=Published(_book, 3, 0, oo),
).known_as("radau3")

_r = Constant("theta", sqrt(6))
_b = ((16 - _r) / 36, (16 + _r) / 36, _Q(1, 9))

radau_iia3 = tableau(
    "radau_iia3",
    A=(
        ((88 - 7 * _r) / 360, (296 - 169 * _r) / 1800, (3 * _r - 2) / 225),
        ((296 + 169 * _r) / 1800, (88 + 7 * _r) / 360, (-3 * _r - 2) / 225),
        _b,
    ),
    b=_b,
    c=((4 - _r) / 10, (4 + _r) / 10, 1),
    reference="Ehle, SIAM J. Math. Anal. 4 (1973) 671-680; Axelsson, BIT 9 (1969) 185-199, three stages",
    published=Published(_book, 5, 0, oo),
).known_as("radau", "radau5")

_b = (_Q(1, 6), _Q(2, 3), _Q(1, 6))

lobatto_iiia3 = tableau(
    "lobatto_iiia3",
    A=((), (_Q(5, 24), _Q(1, 3), _Q(-1, 24)), _b),
    b=_b,
    c=(0, half, 1),
    reference="Ehle, Univ. Waterloo CSRR 2010 (1969); Axelsson, BIT 12 (1972) 69-85, Lobatto IIIA, three stages",
    published=Published(_book, 4, 1),
).known_as("hermite_simpson")

_end = (3 - rho_inf) / (24 * (1 + rho_inf))  # the weight of t_n + h in the middle, with its sign changed

weighted_residual_p2 = tableau(
    "weighted_residual_p2",
    parameters=(Parameter(rho_inf, Interval(0, 1), half),),
    A=((), (_Q(1, 4) - _end, _Q(1, 4) + 2 * _end, -_end), _b),
    b=_b,
    c=(0, half, 1),
    reference="Song and others, Comput. Struct. 285 (2023) 107071, PTIM of order 22, on linear structures; by weighted "
    "residuals of quadratic u, v and a, as Kim & Reddy, J. Appl. Mech. 84 (2017) 071009, take them",
    published=Published("Song and others, Comput. Struct. 285 (2023) 107071", 3, rho_inf, oo),
).known_as("weighted_residual", "kim_reddy", "ptim", "mixed_pade")

lobatto_iiic2 = tableau(
    "lobatto_iiic2",
    A=((half, -half), (half, half)),
    b=(half, half),
    c=(0, 1),
    reference="Chipman, BIT 11 (1971) 384-393, Lobatto IIIC, two stages",
    published=Published(_book, 2, 0, oo),
)

lobatto_iiic3 = tableau(
    "lobatto_iiic3",
    A=((_Q(1, 6), _Q(-1, 3), _Q(1, 6)), (_Q(1, 6), _Q(5, 12), _Q(-1, 12)), _b),
    b=_b,
    c=(0, half, 1),
    reference="Chipman, BIT 11 (1971) 384-393, Lobatto IIIC, three stages",
    published=Published(_book, 4, 0, oo),
)

u0, v0, _ = knot(0)
u1, v1, _ = knot(1)
_up, _vp, _ = knot("p")  # u and v after their jump at t_n

discontinuous_galerkin_p1 = Scheme(
    "discontinuous_galerkin_p1",
    relations={_up: u0 + h * (_vp - v1) / 6, u1: u0 + h * (_vp + v1) / 2},
    balances=(
        # against 2 (1 - s) and 2 s; forces are interpolated, loads are integrated by Radau's quadrature of two points
        Balance((v1 + _vp - 2 * v0) / h, (2 * _vp + v1) / 3, (2 * N(_up) + N(u1)) / 3, f(_Q(1, 3))),
        Balance((v1 - _vp) / h, (_vp + 2 * v1) / 3, (N(_up) + 2 * N(u1)) / 3, (f(_Q(1, 3)) + f(1)) / 2),
    ),
    reference="Hughes & Hulbert, Comput. Methods Appl. Mech. Eng. 66 (1988) 339-363; Hulbert, IJNME 33 (1992) 307-331",
    published=Published("Hulbert, Int. J. Numer. Methods Eng. 33 (1992) 307-331, P1-P1", 3, 0, oo),
).known_as("time_discontinuous_galerkin", "tdg_p1")

ALL = (
    *(gauss2, gauss3, radau_iia2, radau_iia3, lobatto_iiia3, weighted_residual_p2),
    *(lobatto_iiic2, lobatto_iiic3),
    discontinuous_galerkin_p1,
)
