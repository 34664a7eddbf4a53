"""Amplification -> what happens at large Omega: overshoot, and where the eigenvalues turn real.

Overshoot: Hilber & Hughes, Earthq. Eng. Struct. Dyn. 6 (1978) 99-117, in the notation U0-V1.
"""

from dataclasses import dataclass

from sympy import Expr, Matrix, Poly, fraction, together

from ..declare.scheme import Scheme
from ..declare.symbols import Omega, knot_of, lattice, xi
from .amplification import Amplification


@dataclass(frozen=True)
class Overshoot:
    """Powers of Omega with which u_1 and v_1/omega grow in the scheme's first step as Omega -> oo.

    For unit u_0 and unit v_0/omega with the consistent a_0, undamped; the larger of the two, negative as 0.
    """

    u: int
    v: int

    def __str__(self) -> str:
        return f"U{self.u}-V{self.v}"


def overshoot(amplification: Amplification) -> Overshoot:
    """Of a multi-step scheme, in the first step that is its own, after the start it declares."""
    found = [(_first_own_step(amplification, given)) for given in ((1, 0, -(Omega**2)), (0, Omega, 0))]
    u = max(_growth(step[0]) for step in found)
    v = max(_growth(step[1] / Omega) for step in found)
    return Overshoot(max(u, 0), max(v, 0))


def _growth(expression: Expr) -> int:
    """Degree in Omega of a rational function; that of 0 counts as 0."""
    numerator, denominator = fraction(together(expression))
    degrees = [Poly(part, Omega).degree() for part in (numerator, denominator)]
    return int(degrees[0] - degrees[1]) if numerator != 0 else 0


def _first_own_step(amplification: Amplification, given: tuple[Expr, Expr, Expr]) -> Matrix:
    """Reported u, h*v, h^2*a after it, undamped."""
    scheme = amplification.scheme
    start = Matrix(given)
    if isinstance(scheme.start, Scheme):
        first = Amplification.of(scheme.start).step
        history = [start]
        at = [knot_of(s) or ("u", "0") for s in scheme.state]
        for _ in range(int(max(-(lattice(label) or 0) for _, label in at))):
            history.append(first.N.subs(xi, 0) * history[-1] / first.den.subs(xi, 0))
        x = Matrix([history[-1 + int(lattice(label) or 0)]["uva".index(kind)] for kind, label in at])
    elif amplification.start is None:
        x = Matrix([start["uva".index(s.name[0])] for s in scheme.state])
    else:
        x = amplification.start.N.subs(xi, 0) * start / amplification.start.den.subs(xi, 0)
    after = amplification.step.N.subs(xi, 0) * x / amplification.step.den.subs(xi, 0)
    outputs = amplification.outputs
    told = outputs.N.subs(xi, 0) * x / outputs.den.subs(xi, 0)
    rest = iter(range(told.rows))
    return Matrix([after[place] if place >= 0 else told[next(rest)] for place in amplification.in_state])
