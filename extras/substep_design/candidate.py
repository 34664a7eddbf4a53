"""A stability function that meets a wish, where it does so, and how numbers gamma are written."""

from dataclasses import dataclass
from typing import Any

from substep_derive.algebra.algebraic import Algebraic
from substep_derive.declare.symbols import gamma, rho_inf
from sympy import Expr, Poly, Symbol, fraction, together

from .stability_function import StabilityFunction, approximate


@dataclass(frozen=True)
class Candidate:
    """A stability function and where it meets the wish: at one gamma, or on a branch with every rho_inf in [0, 1].

    equation: vanishes at gamma, a polynomial in gamma and, on a branch, rho_inf. ends: gamma at rho_inf = 1 and 0, or
    gamma itself twice.
    """

    function: StabilityFunction
    equation: Expr
    ends: tuple[Algebraic, Algebraic]

    @property
    def is_branch(self) -> bool:
        """Whether rho_inf is left free."""
        return self.ends[0] is not self.ends[1]


def caret(text: Any) -> str:
    """Text with ^ for powers."""
    return str(text).replace("**", "^")


def shown(number: Algebraic, name: Symbol = gamma) -> str:
    """A number in words: a fraction, or twelve digits for the eye and the equation of what has this name."""
    if len(number.coefficients) == 2:
        return str(approximate(number))
    polynomial = number.polynomial
    root = (
        caret(polynomial.as_expr(name)) if polynomial.degree() < 9 else f"a polynomial of degree {polynomial.degree()}"
    )
    return f"{float(approximate(number)):.12g}... (root of {root})"


def numerator_of(e: Expr) -> Expr:
    """The numerator of a rational function of gamma, and perhaps rho_inf, as a primitive polynomial."""
    numerator = Poly(fraction(together(e))[0], gamma, *({rho_inf} & e.free_symbols))
    return numerator.clear_denoms(convert=True)[1].primitive()[1].as_expr()
