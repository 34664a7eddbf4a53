"""Symmetric compositions of central differences (velocity Verlet), symplectic where there is no damping."""

from sympy import Interval, Rational, Symbol, root

from ...algebra.constant import Constant
from ..composition import composition
from ..parameter import Parameter, Root
from ..published import Published
from ..tableau import nystrom
from .newmark import central_difference

_Q = Rational
weight = Symbol("weight")
half = _Q(1, 2)

forest_ruth = composition(
    "forest_ruth",
    central_difference,
    (weight, 1 - 2 * weight, weight),
    # 2 w^3 + (1 - 2 w)^3 = 0, so that w = 1/(2 - 2^(1/3))
    parameters=(Parameter(weight, Interval(1, _Q(3, 2)), Root(6 * weight**3 - 12 * weight**2 + 6 * weight - 1)),),
    reference="Forest & Ruth, Physica D 43 (1990) 105-117; Yoshida, Phys. Lett. A 150 (1990) 262-268",
    published=Published("Yoshida (1990)", 4),
).known_as("yoshida4", "yoshida_4")

_verlet = nystrom("verlet", A_bar=((), (half,)), b_bar=(half, 0), b=(half, half), c=(0, 1))

suzuki = composition(
    "suzuki",
    _verlet,
    (weight, weight, 1 - 4 * weight, weight, weight),
    # 4 w^3 + (1 - 4 w)^3 = 0, so that w = 1/(4 - 4^(1/3))
    parameters=(Parameter(weight, Interval(_Q(1, 4), half), Root(60 * weight**3 - 48 * weight**2 + 12 * weight - 1)),),
    reference="Suzuki, Phys. Lett. A 146 (1990) 319-323",
    published=Published("Suzuki (1990)", 4),
)

_theta = Constant("theta", root(2, 15))
_inner, _outer = 1 / (2 - _theta**5), 1 / (2 - _theta**3)  # 1/(2 - 2^(1/3)) and 1/(2 - 2^(1/5))

yoshida6 = composition(
    "yoshida6",
    _verlet,
    [outer * inner for outer in (_outer, 1 - 2 * _outer, _outer) for inner in (_inner, 1 - 2 * _inner, _inner)],
    reference="Yoshida, Phys. Lett. A 150 (1990) 262-268, the triple jump of the triple jump",
    published=Published("Yoshida (1990)", 6),
).known_as("yoshida")

ALL = (forest_ruth, suzuki, yoshida6)
