"""Text of the module of the motion between two steps, for runs whose steps are stored."""

from itertools import count

from ..declare.symbols import knot
from ..kernels.interpolant import Interpolant
from .printing import block, fill

HEADER = '''"""The motion between two steps: Hermite's polynomial in u, v and a at both ends.

Functions of share = (t - t_n)/h, of h and of the values at both ends, which broadcast; they return u, v, a. Hairer,
Norsett & Wanner, Solving Ordinary Differential Equations I (1993), II.6.
"""

# powers of t that u reproduces, with and without the accelerations at the ends
DEGREE, DEGREE_OF_VELOCITIES = {degree}, {degree_of_velocities}
# order of a scheme from which on the acceleration is that of u, and not of the polynomial in v and a alone
HIGH = {high}
'''

FUNCTION = '''

def {name}({arguments}):
    """{meaning}"""
{lines}
    return u, v, a
'''


def interpolant_module() -> str:
    """Text of interpolant.py, without its banner."""
    whole = {order: Interpolant.of(knot(0), knot(1), order) for order in range(1, 8)}
    high = next(order for order in count(1) if whole[order].a != whole[1].a)
    begin, end = knot(0)[:2], knot(1)[:2]
    of_velocities = Interpolant.of(begin, end, 2)
    found = {
        "low": (whole[1], "For a scheme of an order below HIGH."),
        "high": (whole[high], "For a scheme of order HIGH or more."),
        "of_velocities": (of_velocities, "For values without accelerations."),
    }
    text = fill(HEADER, degree=whole[1].degree, degree_of_velocities=of_velocities.degree, high=high)
    for name, (interpolant, meaning) in found.items():
        knots = (begin, end) if name == "of_velocities" else (knot(0), knot(1))
        arguments = ["share", "h", *(symbol.name for ends in knots for symbol in ends)]
        outputs = [(kind, getattr(interpolant, kind)) for kind in "uva"]
        lines, _ = block(outputs)
        text += fill(FUNCTION, name=name, arguments=", ".join(arguments), meaning=meaning, lines=lines)
    return text
