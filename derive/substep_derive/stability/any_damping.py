"""For which parameters a scheme is stable for every Omega > 0 and every damping ratio: what suffices, exactly.

Damping enters through d = 2*xi*Omega, which may be any number from 0 on whatever Omega > 0 is. The polynomials in
Omega^2 that `conditions` wants not to be negative are then polynomials in d as well, and are nowhere negative if the
coefficient of every power of d is not, for every Omega > 0. The coefficients without d are the undamped conditions,
which are necessary. Two polynomials of which none is negative do not vanish together if they do not at d = 0, where
all else that is added is not negative. The leading coefficient, a sum of all that is wanted, is positive then.
"""

from typing import Any

from sympy import Expr, Poly, Symbol, expand
from sympy.logic.boolalg import And, Boolean

from ..declare.scheme import Scheme
from ..declare.symbols import Omega, lam, xi
from ..oscillator.amplification import Amplification
from ..oscillator.spectrum import live
from .box import Box
from .conditions import W, for_all, leading_sign, not_both_zero, together
from .hurwitz import bilinear

D = Symbol("D", real=True)  # 2*xi*Omega; unlike a parameter of that name
HIGHEST = 3  # eigenvalues that are not 0


def stable_at_any_damping(scheme: Scheme) -> Boolean | None:
    """A condition on the free parameters that suffices for stability at every Omega > 0 and every xi >= 0.

    None where there is none of this kind: for a scheme without damping, with a constant or with more than three
    eigenvalues that are not 0, and where Omega could not be eliminated.
    """
    if scheme.constant is not None or not scheme.takes_damping:
        return None
    box: Box = {p.symbol: p.domain for p in scheme.parameters}
    p = Poly(live(Amplification.of(scheme).charpoly).as_expr(), lam).terms_gcd()[1]
    c = [_in_square(e) for e in p.all_coeffs()[::-1]]
    n = len(c) - 1
    if n > HIGHEST or None in c:
        return None
    try:
        sign = leading_sign(scheme, c[-1].subs(D, 0), box)
    except NotImplementedError:
        return None
    h = [expand(sign * e) for e in bilinear(c)]
    wanted = [*h, *([expand(h[1] * h[2] - h[0] * h[3])] if n == HIGHEST else [])]
    found = [for_all(part, False, box) for e in wanted for part in Poly(e, D).all_coeffs()]
    known = And(*(e for e in found if e is not None))
    undamped = [e.subs(D, 0) for e in h]
    found += [not_both_zero(*pair, known, box) for pair in (undamped[:2], undamped[:-3:-1])]
    return None if None in found else And(*together([e for e in found if e is not None], box))


def _in_square(coefficient: Expr) -> Any:
    """A polynomial in Omega and xi as one in W = Omega^2 and D = 2*xi*Omega; None if it is none."""
    found = 0
    for (i, j), value in Poly(coefficient, Omega, xi).terms():
        if i < j or (i - j) % 2:
            return None
        found += value * (D / 2) ** j * W ** ((i - j) // 2)
    return expand(found)
