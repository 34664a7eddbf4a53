"""Amplification -> where, undamped, a pair of complex eigenvalues turns real."""

from itertools import pairwise

from sympy import Expr, Integer, Poly, oo

from ..declare.symbols import Omega, lam, xi
from .amplification import Amplification
from .spectrum import live


def bifurcation(amplification: Amplification) -> Expr:
    """The smallest Omega at which, undamped, a complex pair turns real; oo if none does.

    Exact (an algebraic number). All parameters of the scheme must have values; raises ValueError for
    free ones.
    """
    p = Poly(live(amplification.charpoly).as_expr().subs(xi, 0), lam)
    if free := p.as_expr().free_symbols - {lam, Omega}:
        raise ValueError(f"expected values for {', '.join(map(str, free))}; fix them before")
    discriminant = Poly(p.discriminant(), Omega)
    if discriminant.is_zero:  # a root that is double at every Omega: look at the others
        p = p.quo(p.gcd(p.diff(lam)))
        discriminant = Poly(p.discriminant(), Omega)
    places = [root for root in sorted(set(discriminant.real_roots())) if root > 0]
    cells = _samples(places)
    counts = [_real_eigenvalues(p, sample) for sample in cells]
    for place, (before, behind) in zip(places, pairwise(counts), strict=True):
        if behind > before:
            return place
    return oo


def _samples(places: list[Expr]) -> list[Expr]:
    """One rational in each cell that the places cut out of (0, oo)."""
    ends = [Integer(0), *places]
    inside = [_between(low, high) for low, high in pairwise(ends)]
    last = Integer(1) if not places else Integer(int(places[-1].n(20)) + 2)
    return [*inside, last]


def _between(low: Expr, high: Expr) -> Expr:
    digits = 20
    while True:
        middle = ((low + high) / 2).n(digits)
        exact = Integer(int(middle * 10**digits)) / 10**digits
        if low < exact < high:
            return exact
        digits *= 2


def _real_eigenvalues(p: Poly, at: Expr) -> int:
    """How many real roots p has at one rational Omega, with their multiplicities."""
    q = Poly(p.as_expr().subs(Omega, at), lam)
    return sum(factor.count_roots() * power for factor, power in q.sqf_list()[1])
