"""Expressions of a declaration as linear forms in knots' symbols, forces and loads, with numbers as coefficients.

A coefficient that holds M, C, K0 or a tangent K_t(u) is the operator den^-1 num, num and den linear in them, as on
scenes (`motion.components`).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from sympy import Dummy, Expr, Integer, cancel, fraction, sympify

from ..declare.errors import DeclarationError
from ..declare.symbols import K0, C, K_t, M, N, N_discrete, N_of_rates, f, h, knot_of

UNIT = {h: Integer(1), M: Integer(1)}  # in u, h v, h^2 a, per unit mass, h drops out


@dataclass(frozen=True)
class Term:
    """plain times a symbol or an atom N, N_discrete, N_of_rates, f; with `over`, den^-1 of that, den = 1 + sum of c X.

    arguments: of a force. instant: of f. over: (X, c) for each of C and K0 in the denominator, which a numerator
    1 + sum of c X in `under` may accompany.
    """

    of: Expr
    plain: Any
    arguments: "tuple[Form, ...]" = ()
    instant: Any = None
    under: tuple[tuple[str, Any], ...] = ()
    over: tuple[tuple[str, Any], ...] = ()


@dataclass(frozen=True)
class Applied:
    """C, K0, the tangent K_t(argument) or M(u_n)^-1 (M(argument) - M(u_n)) times a form."""

    kind: str
    to: "Form"
    argument: "Form | None"


@dataclass(frozen=True)
class Form:
    """The sum of its terms and of what operators make of other forms."""

    terms: tuple[Term, ...]
    applied: tuple[Applied, ...] = ()

    def plain(self) -> dict[Expr, Any]:
        """The coefficient of each symbol and atom as h -> 0, where operators vanish."""
        return {term.of: term.plain for term in self.terms}


Number = Callable[[Expr], Any]


def form(scheme: str, expression: Expr, number: Number) -> Form:
    """The linear form. Raises DeclarationError for an expression that is none."""
    e = sympify(expression).subs(UNIT)
    tangents = {atom: Dummy() for atom in sorted(e.atoms(K_t), key=str)}
    e = e.subs(tangents)
    atoms = {atom: Dummy() for atom in sorted(e.atoms(N, N_discrete, N_of_rates, f), key=str)}
    e = e.subs(atoms)
    marks: dict[Expr, Expr] = {s: s for s in sorted(e.free_symbols, key=str) if knot_of(s)}
    marks |= atoms
    kinds = {C: "C", K0: "K", **dict.fromkeys(tangents.values(), "tangent")}
    terms: list[Term] = []
    applied: dict[Expr, list[Term]] = {}
    rest = cancel(e.subs(dict.fromkeys(marks.values(), 0)))
    if rest != 0:
        raise DeclarationError(f"{scheme}: expected no term without a knot's u, v, a, a force or a load, got {rest}")
    for atom, mark in marks.items():
        coefficient = e.diff(mark)
        if coefficient.free_symbols & set(marks.values()):
            raise DeclarationError(f"{scheme}: expected an expression linear in the knots' u, v, a, got {expression}")
        over, parts = _split(scheme, coefficient, kinds, number)
        at: dict[str, Any] = {}
        if isinstance(atom, N | N_discrete | N_of_rates):
            at["arguments"] = tuple(form(scheme, argument, number) for argument in atom.args)
        elif isinstance(atom, f):
            at["instant"] = number(atom.args[0])
        if over:
            under = tuple((kinds[x], c) for x, c in parts.items() if x is not None and c)
            terms.append(Term(atom, parts[None], **at, under=under, over=over))
            continue
        if parts[None]:
            terms.append(Term(atom, parts[None], **at))
        for x, c in parts.items():
            if x is not None and c:
                applied.setdefault(x, []).append(Term(atom, c, **at))
    where = {mark: form(scheme, atom.args[0], number) for atom, mark in tangents.items()}
    return Form(tuple(terms), tuple(Applied(kinds[x], Form(tuple(t)), where.get(x)) for x, t in applied.items()))


def _split(
    scheme: str, coefficient: Expr, kinds: Mapping[Expr, str], number: Number
) -> tuple[tuple[tuple[str, Any], ...], dict[Expr | None, Any]]:
    """The operators over which a coefficient stands, and its numerator's part without (None) and with each operator."""
    if not coefficient.free_symbols & set(kinds):
        return (), {None: number(coefficient)}
    zero = dict.fromkeys(kinds, 0)
    parts: list[dict[Expr | None, Any]] = []
    for part in fraction(cancel(coefficient)):
        slopes: dict[Expr | None, Any] = {x: part.diff(x).expand() for x in kinds if part.has(x)}
        if any(slope.free_symbols & set(kinds) for slope in slopes.values()):
            raise DeclarationError(
                f"{scheme}: expected coefficients num/den, each linear in M, C, K0, got {coefficient}"
            )
        parts.append({None: part.subs(zero), **slopes})
    num, den = ({x: number(c) for x, c in part.items()} for part in parts)
    first = den.pop(None)
    if not first:
        raise DeclarationError(f"{scheme}: expected a coefficient that stays finite as h -> 0, got {coefficient}")
    if any(kinds[x] == "tangent" for x in den if x is not None):
        raise DeclarationError(f"{scheme}: expected K_t in no denominator, got {coefficient}")
    return (
        tuple((kinds[x], c / first) for x, c in den.items() if x is not None and c),
        {x: c / first for x, c in num.items()},
    )
