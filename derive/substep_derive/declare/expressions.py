"""What a user has given as an expression, one that has a finite value everywhere, and as a mapping: or refused."""

from collections.abc import Mapping
from typing import Any, cast

from sympy import Expr, Piecewise, S, Symbol, SympifyError, sympify, true

from .errors import DeclarationError

NOT_FINITE = (S.NaN, S.Infinity, S.NegativeInfinity, S.ComplexInfinity)


def expression(owner: str, what: str, given: Any) -> Expr:
    """What is given as an expression of SymPy.

    Raises DeclarationError for what is none, as an equation, for one that holds what is not finite, and for a Piecewise
    without a last branch.
    """
    try:
        found = sympify(given)
    except (SympifyError, TypeError, AttributeError):
        found = None
    if not isinstance(found, Expr):
        raise DeclarationError(
            f"{owner}: expected {what} as an expression, got {given!r}; write a number or an expression of SymPy, what "
            "is to be 0 as the difference of both sides"
        )
    if found.has(*NOT_FINITE):
        raise DeclarationError(f"{owner}: expected {what} that is finite, got {found}; give finite numbers")
    if any(e.args[-1][1] != true for e in found.atoms(Piecewise)):
        raise DeclarationError(
            f"{owner}: expected {what} with a value everywhere, got {found}; end the Piecewise with (value, True)"
        )
    return found


def require_mapping(owner: str, what: str, given: Any, kind: type, of: str = "expressions") -> None:
    """Raises DeclarationError for what is no mapping from symbols, or names, to what is meant."""
    keys = cast(Mapping[Any, Any], given) if isinstance(given, Mapping) else [given]
    if wrong := [key for key in keys if keys is not given or not isinstance(key, kind)]:
        names, example = ("symbols", "{x: ...} of x = Symbol('x')") if kind is Symbol else ("names", "{'name': ...}")
        raise DeclarationError(
            f"{owner}: expected {what} as a mapping from {names} to {of}, got {wrong[0]!r}; write {example}"
        )
