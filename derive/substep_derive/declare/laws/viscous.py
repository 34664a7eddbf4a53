"""Laws of dampers: of the rate of the elongation, or with a memory that fades in time."""

from sympy import Interval, Rational, Symbol, exp

from ..law import Law, before, e, e_dot, elapsed
from ..potentials import signed_power
from ..scene import optional, required
from .functions import phi_1, phi_2

c, exponent, stiffness, q, e_0 = (Symbol(name) for name in ("c", "exponent", "stiffness", "q", "e_0"))

power_damper = Law(
    "power_damper",
    parameters=(required(c), optional(exponent, 1, Interval(Rational(1, 10), 2))),
    force=c * signed_power(e_dot, exponent),
    reference="q = c |v|^exponent sign(v): a viscous damper of structures; linear where the exponent is 1",
)

# the rate is constant between two commits, as the path is straight
faded = elapsed * stiffness / c
change = e - before(e_0)

maxwell = Law(
    "maxwell",
    parameters=(required(stiffness), required(c)),
    memory={q: 0, e_0: 0},
    update={q: q * exp(-faded) + stiffness * (e - e_0) * phi_1(faded), e_0: e},
    force=q,
    stored=q**2 / (2 * stiffness),
    dissipated=before(q) * change * phi_1(faded)
    + stiffness * change**2 * phi_2(faded)
    - (q**2 - before(q) ** 2) / (2 * stiffness),
    reference="a spring and a linear damper in series: q' + q stiffness/c = stiffness e'",
)

ALL = (power_damper, maxwell)
