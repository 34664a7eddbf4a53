"""Laws that yield: what remains of the elongation is the memory."""

from sympy import Interval, Symbol

from ..law import Law, before, clip, e
from ..scene import POSITIVE, optional, required

k, q_y, alpha, p = (Symbol(name) for name in ("k", "q_y", "alpha", "p"))

soft = (1 - alpha) * k  # the stiffness of the part that yields, at the force (1 - alpha)*q_y
yielding = clip(e - p, -q_y / k, q_y / k)

bilinear = Law(
    "bilinear",
    parameters=(required(k), required(q_y), optional(alpha, 0, Interval.Ropen(0, 1))),
    memory={p: 0},
    update={p: e - yielding},
    force=alpha * k * e + soft * (e - p),
    stored=alpha * k * e**2 / 2 + soft * (e - p) ** 2 / 2,
    dissipated=soft * (e - p) * (p - before(p)),
    reference="kinematic hardening; elastic-perfectly plastic where alpha = 0. Chopra, Dynamics of Structures, 7.1",
)

ALL = (bilinear,)
