"""Composite schemes of higher order with one effective stiffness, found by `substep_derive.study.design`.

Every sub-step adds gamma*h times the rate at its own end, so that all effective stiffnesses are the same and a linear
structure needs one factorization. u and v follow the same rule. The first sub-step is trapezoidal and ends at
2*gamma*h; the others satisfy the condition of stage order 2. docs/design.md has the proofs.

gamma alone decides rho_inf here: rho_inf only gives its default, and follows where gamma is given.
"""

from typing import Any

from sympy import Integer, Interval, Rational

from ..parameter import Parameter, Root
from ..symbols import gamma, rho_inf
from ..tableau import tableau

_half = Rational(1, 2)


def _controlled(low: Rational, high: Rational, equation: Any) -> tuple[Parameter, Parameter]:
    """rho_inf, and gamma as the root of the equation between two numbers."""
    return Parameter(rho_inf, Interval(0, 1), _half), Parameter(gamma, Interval(low, high), Root(equation))


_32 = 3 * (3 - 10 * gamma) / (100 * gamma)
_3 = 25 * (1 - 6 * gamma + 6 * gamma**2) / (9 * (3 - 10 * gamma))
_2 = (_half - gamma - Rational(3, 5) * _3) / (2 * gamma)
_weights = (1 - _2 - _3 - gamma, _2, _3, gamma)

three_substep_third_order = tableau(
    "three_substep_third_order",
    A=((0,), (gamma, gamma), (Rational(3, 5) - _32 - gamma, _32, gamma), _weights),
    b=_weights,
    c=(0, 2 * gamma, Rational(3, 5), 1),
    # order 3 gives rho_inf = (6 gamma^3 - 18 gamma^2 + 9 gamma - 1)/(6 gamma^3), which falls from 1 to 0 in here
    parameters=_controlled(
        Rational(33, 100), Rational(44, 100), 6 * (1 - rho_inf) * gamma**3 - 18 * gamma**2 + 9 * gamma - 1
    ),
    reference="substep design --sub-steps 3 --order 3 --rho-inf free --one-stiffness",
)


_c = (Integer(0), 2 * gamma, Rational(3, 4), Rational(2, 3), Integer(1))
_a32 = 3 * (3 - 8 * gamma) / (64 * gamma)
_a43 = 8 * (1 - 12 * gamma + 36 * gamma**2 - 24 * gamma**3) / (81 * gamma * (3 - 8 * gamma))
_a42 = (Rational(2, 9) - 2 * gamma / 3 - 3 * _a43 / 4) / (2 * gamma)
_b2, _b3, _b4 = (
    1 / (12 * gamma * (3 - 8 * gamma)),
    16 * (1 - 12 * gamma + 24 * gamma**2) / (9 * (3 - 8 * gamma)),
    9 * gamma / 2,
)
_weights = (1 - _b2 - _b3 - _b4 - gamma, _b2, _b3, _b4, gamma)
# 1/96 of the divided difference of the rates at 0, 3/4, 2/3 and 1, which vanishes for quadratic ones
_difference = (-Rational(1, 48), 0, -Rational(2, 3), Rational(9, 16), Rational(1, 8))

four_substep = tableau(
    "four_substep",
    A=(
        (0,),
        (gamma, gamma),
        (_c[2] - _a32 - gamma, _a32, gamma),
        (_c[3] - _a42 - _a43 - gamma, _a42, _a43, gamma),
        _weights,
    ),
    b=_weights,
    c=_c,
    b_hat=[w + d for w, d in zip(_weights, _difference, strict=True)],
    # order 4 gives 24 gamma^4 rho_inf = 24 gamma^4 - 96 gamma^3 + 72 gamma^2 - 16 gamma + 1; rho_inf falls from 1 to 0
    parameters=_controlled(
        Rational(39, 100),
        Rational(58, 100),
        24 * (1 - rho_inf) * gamma**4 - 96 * gamma**3 + 72 * gamma**2 - 16 * gamma + 1,
    ),
    reference="substep design --sub-steps 4 --order 4 --rho-inf free --one-stiffness",
)

# rho_inf = 1/3 is the least at which no sub-step reaches beyond the step's end: there gamma = 1/2. At this gamma the
# times 3/5 and 4/5 have the least principal error, 0.0181 where 3/4 and 2/3 have 0.0209
_last = (Rational(3, 16), -Rational(5, 24), Rational(25, 24), -Rational(25, 48), _half)

four_substep_fourth_order = tableau(
    "four_substep_fourth_order",
    A=(
        (0,),
        (_half, _half),
        (Rational(11, 50), -Rational(3, 25), _half),
        (Rational(17, 150), -Rational(12, 25), Rational(2, 3), _half),
        _last,
    ),
    b=_last,
    c=(0, 1, Rational(3, 5), Rational(4, 5), 1),
    reference="substep design --sub-steps 4 --order 4 --rho-inf 1/3 --one-stiffness",
)

ALL = (three_substep_third_order, four_substep, four_substep_fourth_order)
