"""Floats as the simple fractions that they stand for."""

from fractions import Fraction


def simple_fraction(value: float) -> Fraction | None:
    """The fraction of small denominator that differs from a float by rounding only; None if there is none."""
    near = Fraction(value).limit_denominator(10**6)
    return near if abs(near - Fraction(value)) <= 4e-16 * max(1.0, abs(value)) else None


def printed_fraction(value: float) -> Fraction:
    """The simplest fraction that prints as this number: a third where one was meant, else the decimal number."""
    near = Fraction(value).limit_denominator(1000)
    return near if float(near) == value else Fraction(repr(value))
