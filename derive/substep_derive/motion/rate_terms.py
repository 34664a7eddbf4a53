"""Terms of forces, taken apart by the rates that they hold."""

from collections.abc import Sequence

from sympy import Expr, Symbol

from ..declare.potentials import may_jump


def parts(term: Expr, rates: Sequence[Symbol]) -> list[Expr]:
    """What of a term each rate is a factor of, and the rest, where it is linear in the rates; else the term."""
    slopes = [term.diff(r) for r in rates]
    if not term.has(*rates) or may_jump(term, rates) or any(e.has(*rates) for e in slopes):
        return [term]
    found = [e * r for e, r in zip(slopes, rates, strict=True)] + [term.subs(dict.fromkeys(rates, 0))]
    return [e for e in found if e != 0]
