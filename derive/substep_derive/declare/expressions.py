"""What a user has given as an expression, one that has a finite value everywhere, and as a mapping: or refused."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, cast

import sympy
from sympy import Expr, Max, Min, Piecewise, S, Symbol, SympifyError, preorder_traversal, sympify, true

from .errors import DeclarationError

FUNCTIONS = ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "asin", "acos", "atan")
SYMPY: Any = sympy
IN_KERNELS: tuple[Any, ...] = (
    SYMPY.Add, SYMPY.Mul, SYMPY.Pow, Symbol, SYMPY.Number, SYMPY.NumberSymbol, SYMPY.Abs, SYMPY.sign, Max, Min,
    Piecewise, SYMPY.functions.elementary.piecewise.ExprCondPair, SYMPY.logic.boolalg.Boolean,
    *(getattr(SYMPY, name) for name in FUNCTIONS),
)  # fmt: skip
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


def alike(one: Any, other: Any) -> bool:
    """Whether two declarations are the same: all fields are equal, and what their mappings name stands in one order.

    The order of coordinates, of constraints and of what a law remembers is that of the numbers that a run returns.
    """
    if type(one) is not type(other):
        return False
    pairs = [(getattr(one, field.name), getattr(other, field.name)) for field in fields(one)]
    return all(a == b and (not isinstance(a, Mapping) or [*a] == [*b]) for a, b in pairs)


def require_known(owner: str, what: str, expression: Expr, allowed: set[Symbol]) -> None:
    """Raises DeclarationError for an expression with other symbols, or with functions that kernels do not have."""
    if unknown := sorted(expression.free_symbols - allowed, key=str):
        raise DeclarationError(
            f"{owner}: the {what} holds '{unknown[0]}', expected only "
            f"{', '.join(sorted(map(str, allowed))) or 'numbers'}; declare it or correct the name"
        )
    parts = (e for e in preorder_traversal(expression) if "substep_derive" not in str(type(e).__module__))
    if (odd := next((e for e in parts if not isinstance(e, IN_KERNELS)), None)) is not None:
        raise DeclarationError(
            f"{owner}: expected in the {what} real functions that compiled kernels have, {', '.join(FUNCTIONS)}, "
            f"abs, sign, Max, Min and Piecewise, got {odd}; write it by these, as by an expansion"
        )
