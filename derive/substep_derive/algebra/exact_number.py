"""Numbers as a user writes them, as exact rationals."""

from fractions import Fraction
from math import isfinite
from typing import Any

from sympy import Rational


def exact_number(value: Any) -> Rational:
    """An int, Fraction, SymPy Rational or text such as '1/5' as an exact rational.

    Text is parsed by `Fraction`, never evaluated. Raises TypeError for a float, ValueError for text
    that is no rational number, and for nan and infinity.
    """
    if isinstance(value, float) and isfinite(value):
        raise TypeError(f"expected an exact number, got the float {value!r}; write it as text, '{value}'")
    if isinstance(value, Rational):
        return value
    try:
        exact = Fraction(value)
    except (ValueError, TypeError, ArithmeticError) as error:
        raise ValueError(f"expected a rational number such as '1/5' or '0.2', got {value!r}") from error
    return Rational(exact.numerator, exact.denominator)
