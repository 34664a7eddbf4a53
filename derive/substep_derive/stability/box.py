"""The sign of a polynomial where every symbol lies in its interval, shown by coefficients."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from sympy import (
    Dummy,
    Expr,
    Integer,
    Interval,
    Mul,
    Poly,
    Symbol,
)

Box = Mapping[Symbol, Interval]


@dataclass(frozen=True)
class Sign:
    """The sign of a polynomial on a box: 1 or -1, strict if it has no zero there; 0 if it is not known."""

    value: int
    strict: bool


def sign_on(expression: Expr, box: Box) -> Sign:
    """The sign that coefficients show once every symbol is written in ones that are not negative.

    A symbol in [a, b] is a*s + b*t with s + t = 1, one in [a, oo) is a + t, one in (-oo, b] is b - t. What is not
    shown by that, also after multiplication by powers of s + t (Polya), is not known, nor is what depends on a symbol
    without bounds.
    """
    if not (symbols := sorted(expression.free_symbols, key=str)):
        return Sign(int(bool(expression > 0)) - int(bool(expression < 0)), True)
    if any(box[x].start.is_infinite and box[x].end.is_infinite for x in symbols):
        return Sign(0, False)
    parts = [(Dummy("s"), Dummy("t"), box[x]) for x in symbols]
    generators = [v for s, t, i in parts for v in ((s, t) if _bounded(i) else (t,))]
    raising = Poly(Mul(*(s + t for s, t, i in parts if _bounded(i))), *generators)
    p = Poly(expression, *symbols)
    q = Poly(0, *generators)
    for monomial, c in p.terms():
        term = Poly(c, *generators)
        for power, degree, (s, t, i) in zip(monomial, p.degree_list(), parts, strict=True):
            one = s + t if _bounded(i) else Integer(1)
            x = i.start * s + i.end * t if _bounded(i) else i.start + t if i.start.is_finite else i.end - t
            term *= Poly(x, *generators) ** power * Poly(one, *generators) ** (degree - power)
        q += term
    for _ in range(4):
        signs = {c > 0 for c in q.coeffs()}
        if len(signs) == 1:
            return Sign(1 if signs.pop() else -1, not _vanishes(q, generators, parts))
        if raising.is_one:
            break
        q *= raising
    return Sign(0, False)


def _bounded(interval: Interval) -> bool:
    return interval.start.is_finite and interval.end.is_finite


def _vanishes(q: Poly, generators: Sequence[Symbol], parts: Sequence[tuple[Symbol, Symbol, Interval]]) -> bool:
    """Whether the polynomial vanishes on an edge of the box that belongs to it."""
    edges: list[list[int]] = []
    for s, t, interval in parts:
        low = [] if interval.left_open or interval.start.is_infinite else [generators.index(t)]
        at_high = s if _bounded(interval) else t
        high = [] if interval.right_open or interval.end.is_infinite else [generators.index(at_high)]
        edges.append([-1, *low, *high])
    gone = ([i for i in edge if i >= 0] for edge in product(*edges))
    return any(all(any(monomial[i] for i in edge) for monomial in q.monoms()) for edge in gone)
