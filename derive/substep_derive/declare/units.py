"""That what a scheme declares is linear, and of one unit: lengths u, h v and h^2 a, and forces such as M a.

All that is derived on the linear oscillator is derived for h = 1 and M = 1, where a wrong power of either is not seen.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from sympy import Add, Expr, Integer, Mul, Symbol, cancel

from .errors import DeclarationError
from .symbols import K0, C, K_t, M, N, N_discrete, f, h, kind_of, knot_of


def check_units(scheme: Any) -> None:
    """Raises DeclarationError for a part of a declaration that is not linear in knots' symbols, or not of one unit."""
    for where, e, kind, mass in _parts(scheme):
        _check(f"{scheme.name}: expected {where}", e, kind, mass)
        for argument in (x for force in e.atoms(N, N_discrete) for x in force.args):
            _check(f"{scheme.name}: expected the displacement of N in {where}", argument, 0, 0)


def _parts(scheme: Any) -> Iterator[tuple[str, Expr, int, int]]:
    """Each part in words, its expression, and the powers of 1/h and of M in its unit, that of u left aside."""
    start: Any = scheme.start if scheme.start_scheme is None else {}
    given: Sequence[tuple[str, Mapping[Symbol, Expr]]]
    given = (("relation", scheme.relations), ("start", start), ("report", scheme.report), ("embedded", scheme.embedded))
    for what, mapping in given:
        for symbol, e in mapping.items():
            yield f"the {what} of {symbol}", e, kind_of(symbol), 0
    for k, b in enumerate(scheme.balances, start=1):
        for slot, kind, mass in (("inertia", 2, 0), ("damping", 1, 0), ("force", 2, 1), ("load", 2, 1)):
            yield f"the {slot} of balance {k}", getattr(b, slot), kind, mass


def _check(expected: str, e: Expr, kind: int, mass: int) -> None:
    for coefficient, part in _terms(e.xreplace(dict.fromkeys(e.atoms(K_t), K0)), Integer(1)):
        at = part if isinstance(part, Symbol) and knot_of(part) else None
        if at is None and not isinstance(part, N | N_discrete | f):
            raise DeclarationError(
                f"{expected} as a linear combination of knots' u, v, a, and of N and f where forces belong, got {part} "
                f"in {e}; write it without products of these and without terms that hold none"
            )
        own, own_mass = (2, 1) if at is None else (kind_of(at), 0)
        if not _scales(coefficient, own - kind, mass - own_mass):
            unit = Mul(h ** (own - kind), M ** (mass - own_mass))
            number = "a number" if unit == 1 else f"a number times {unit}"
            raise DeclarationError(
                f"{expected} to hold {part} with {number} before it, got {coefficient}: u, h*v and h^2*a are of one "
                "unit, and so are M, h*C and h^2*K0; correct the powers"
            )


def _terms(e: Expr, coefficient: Expr) -> Iterator[tuple[Expr, Expr]]:
    """The expression as coefficients times parts that are a knot's symbol, N or f, if it is linear in these."""
    if isinstance(e, Add):
        for part in e.args:
            yield from _terms(part, coefficient)
    elif isinstance(e, Mul):
        held = [part for part in e.args if any(map(knot_of, part.free_symbols)) or part.has(N, N_discrete, f)]
        if len(held) == 1:
            yield from _terms(held[0], coefficient * Mul(*(part for part in e.args if part is not held[0])))
        else:
            yield coefficient, e
    elif e != 0:
        yield coefficient, e


def _scales(coefficient: Expr, of_h: int, of_M: int) -> bool:
    """Whether a coefficient is a number times these powers of h and M, or behaves so where these are multiplied."""
    if (coefficient / (h**of_h * M**of_M)).free_symbols.isdisjoint((h, M, C, K0)):
        return True
    multiplied = {h: 2 * h, M: 3 * M, C: 3 * C / 2, K0: 3 * K0 / 4}
    scale = Integer(2) ** of_h * Integer(3) ** of_M
    return cancel(coefficient.subs(multiplied, simultaneous=True) - coefficient * scale) == 0
