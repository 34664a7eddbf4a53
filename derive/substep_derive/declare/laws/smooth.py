"""Laws given by their slope along a direction, integrated exactly along the path."""

from sympy import Interval, Rational, Symbol, oo

from ..law import Law, before, e
from ..scene import optional, required
from .functions import bouc_wen, bouc_wen_work

k, q_y, alpha, z, e_0 = (Symbol(name) for name in ("k", "q_y", "alpha", "z", "e_0"))
A, beta, gamma, n = (Symbol(name) for name in ("A", "beta_bw", "gamma_bw", "n"))
e_y = q_y / k
soft = (1 - alpha) * k
shape = A, beta, gamma, n

bouc_wen_law = Law(
    "bouc_wen",
    parameters=(
        required(k),
        required(q_y),
        optional(alpha, 0, Interval.Ropen(0, 1)),
        optional(A, 1),
        optional(beta, Rational(1, 2)),
        optional(gamma, Rational(1, 2), Interval(-oo, oo)),
        optional(n, 1, Interval(1, oo)),
    ),
    memory={z: 0, e_0: 0},
    update={z: e_y * bouc_wen((e - e_0) / e_y, z / e_y, *shape), e_0: e},
    force=alpha * k * e + soft * z,
    stored=alpha * k * e**2 / 2 + soft * z**2 / (2 * A),
    dissipated=soft * e_y**2 * bouc_wen_work((e - before(e_0)) / e_y, before(z) / e_y, *shape)
    - soft * (z**2 - before(z) ** 2) / (2 * A),
    reference="Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249-263: de_y z'/de = A - (beta sign(z e') + gamma) |z/e_y|^n",
)

ALL = (bouc_wen_law,)
