"""Scheme -> bifurcation: the Omega at which, undamped, a pair of complex eigenvalues becomes real."""

from itertools import pairwise
from typing import Any

from sympy import QQ, Expr, Poly, oo

from ..algebra.algebraic import Field, RealRoot, closed_form
from ..algebra.points import count_real_roots, positive_roots, ring_over, simplest_between
from ..declare.symbols import Omega, lam
from .evaluation import Evaluation
from .spectrum import live_at


def bifurcation(evaluation: Evaluation) -> Expr:
    """The smallest Omega at which, undamped, a complex pair of eigenvalues becomes real; oo if none does.

    Exact (an algebraic number). Raises ValueError for parameters left free.
    """
    field = evaluation.field
    if not isinstance(field, Field):
        raise ValueError(f"expected values for {', '.join(map(str, evaluation.scheme.values))}; fix them before")
    ring = ring_over(field, lam, Omega)
    rows = live_at(evaluation, field.domain.zero)
    in_square = all(power % 2 == 0 for row in rows for power in row)
    if in_square:
        rows = [{power // 2: c for power, c in row.items()} for row in rows]
    p = ring.from_dict({(j, power): c for j, row in enumerate(rows) for power, c in row.items()})
    if p.degree(0) < 2:
        return oo
    discriminant = p.discriminant()
    if not discriminant:  # an eigenvalue is double at every Omega: take the distinct ones
        p = p.exquo(p.gcd(p.diff(ring.gens[0])))
        if p.degree(0) < 2:
            return oo
        discriminant = p.discriminant()
    over_Omega = ring_over(field, Omega)
    whole = over_Omega.from_dict({(m[-1],): c for m, c in discriminant.terms()})
    parts = []
    for end in (1, -1):  # where eigenvalues meet most often
        there = p.evaluate(0, field.domain.convert(end))
        own = over_Omega.from_dict({(m[-1],): c for m, c in there.terms()})
        if own and not own.is_ground and not whole.rem(own):
            whole = whole.exquo(own)
            parts.append(own)
    places = positive_roots(field, [*parts, whole], over_Omega)
    counts = []
    for low, high in zip([None, *places], [*places, None], strict=True):
        start = QQ(0) if low is None else low.high
        sample = simplest_between(start, start + 2 if high is None else high.low)
        at = p.evaluate(1, field.domain.convert(sample))
        counts.append(count_real_roots(field, [at.coeff(m) for m in _powers(at)]))
    for place, (before, after) in zip(places, pairwise(counts), strict=True):
        if after > before:
            return closed_form(place, Omega, in_square=True) if in_square else _exact(place)
    return oo


def _powers(polynomial: Any) -> list[Any]:
    """The monomials of a polynomial in one variable, from its highest power down to 1."""
    x = polynomial.ring.gens[0]
    return [x**k if k else 1 for k in range(polynomial.degree(), -1, -1)]


def _exact(root: RealRoot) -> Expr:
    """The root in closed form, as a square root where its polynomial holds only even powers."""
    coefficients = root.polynomial.all_coeffs()
    if len(coefficients) % 2 and not any(coefficients[1::2]):
        square = Poly(coefficients[::2], root.polynomial.gen)
        low, high = root.low * root.low, root.high * root.high
        return closed_form(RealRoot(square, low, high), Omega, in_square=True)
    return closed_form(root, Omega)
