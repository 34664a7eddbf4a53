"""Expressions of a declaration as linear forms in knots' symbols, forces and loads, with numbers as coefficients.

A coefficient that holds M, C, K0 or a tangent K_t(u) is the operator den^-1 num, num and den linear in them, as on
scenes (`motion.components`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sympy import Dummy, Expr, Integer, cancel, fraction, sympify

from ..declare.errors import DeclarationError
from ..declare.symbols import K0, C, K_t, M, N, N_discrete, f, h, knot_of

UNIT = {h: Integer(1), M: Integer(1)}  # in u, h v, h^2 a, per unit mass, h drops out


@dataclass(frozen=True)
class Operator:
    """One of C, K0, K_t(argument) in a coefficient (plain + sum of num_i X_i)/(1 + sum of den_i X_i)."""

    kind: str
    num: Any
    den: Any
    argument: "Form | None" = None


@dataclass(frozen=True)
class Term:
    """plain times a symbol or the value of an atom N, N_discrete, f; or an operator that starts with `plain`."""

    of: Expr
    plain: Any
    operators: tuple[Operator, ...]
    arguments: "tuple[Form, ...]"
    instant: Any = None


@dataclass(frozen=True)
class Form:
    """The sum of its terms."""

    terms: tuple[Term, ...]

    def plain(self) -> dict[Expr, Any]:
        """The coefficient of each symbol and atom as h -> 0, where operators vanish."""
        return {term.of: term.plain for term in self.terms}


Number = Callable[[Expr], Any]


def form(scheme: str, expression: Expr, number: Number) -> Form:
    """The linear form. Raises DeclarationError for an expression that is none."""
    e = sympify(expression).subs(UNIT)
    tangents = {atom: Dummy() for atom in sorted(e.atoms(K_t), key=str)}
    e = e.subs(tangents)
    atoms = {atom: Dummy() for atom in sorted(e.atoms(N, N_discrete, f), key=str)}
    e = e.subs(atoms)
    symbols = {s: s for s in sorted(e.free_symbols, key=str) if knot_of(s)}
    marks = {**symbols, **atoms}
    found = []
    rest = e.subs(dict.fromkeys(marks.values(), 0))
    for atom, mark in marks.items():
        coefficient = e.diff(mark)
        if coefficient.free_symbols & set(marks.values()):
            raise DeclarationError(f"{scheme}: expected an expression linear in the knots' u, v, a, got {expression}")
        if coefficient != 0:
            found.append(_term(scheme, atom, coefficient, tangents, number))
    if cancel(rest) != 0:
        raise DeclarationError(f"{scheme}: expected no term without a knot's u, v, a, a force or a load, got {rest}")
    return Form(tuple(found))


def _term(scheme: str, atom: Expr, coefficient: Expr, tangents: Mapping[Expr, Expr], number: Number) -> Term:
    arguments: Sequence[Any] = atom.args if isinstance(atom, N | N_discrete) else ()
    instant = number(atom.args[0]) if isinstance(atom, f) else None
    kinds = {C: "C", K0: "K", **{mark: "tangent" for mark in tangents.values()}}
    at = {mark: atom.args[0] for atom, mark in tangents.items()}
    operators: list[Operator] = []
    plain = coefficient
    present = coefficient.free_symbols & set(kinds)
    if present:
        num, den = fraction(cancel(coefficient))
        zero = dict.fromkeys(kinds, 0)
        first = number(den.subs(zero))
        if not first:
            raise DeclarationError(f"{scheme}: expected a coefficient that stays finite as h -> 0, got {coefficient}")
        plain = num.subs(zero) / den.subs(zero)
        for symbol, kind in kinds.items():
            parts = [part.diff(symbol).expand() for part in (num, den)]
            if any(part.free_symbols & set(kinds) for part in parts):
                raise DeclarationError(
                    f"{scheme}: expected coefficients num/den, each linear in M, C, K0, got {coefficient}"
                )
            if symbol in present:
                where = form(scheme, at[symbol], number) if symbol in at else None
                operators.append(Operator(kind, *(number(part) / first for part in parts), where))
    forms = tuple(form(scheme, argument, number) for argument in arguments)
    return Term(atom, number(plain), tuple(operators), forms, instant)
