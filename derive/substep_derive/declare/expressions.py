"""What a user has given as an expression: one that has a finite value everywhere, or refused."""

from typing import Any

from sympy import Expr, Piecewise, S, SympifyError, sympify, true

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
