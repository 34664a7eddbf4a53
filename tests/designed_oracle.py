"""Designed composite schemes for the oracle, from the conditions that define them and not from the declared table.

gamma is found by Newton's iteration, weights and inner coefficients by small linear equations, in the type of rho.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

Number = Any  # float or mpmath.mpf


def root_near(start: Number, coefficients: Sequence[Number]) -> Number:
    """The root of a polynomial (highest power first) by Newton's iteration, until corrections no longer shrink."""
    x, change, last = start, 1, 2
    while change < last:
        value = slope = 0 * start
        for c in coefficients:
            slope = slope * x + value
            value = value * x + c
        x, change, last = x - value / slope, abs(value / slope), change
    return x


def third_order(rho: Number) -> tuple[list[list[Number]], list[Number]]:
    """sum b c = 1/2, sum b c^2 = 1/3, sum a_3j c_j = c_3^2/2 with c = (0, 2 gamma, 3/5, 1), gamma on the diagonal."""
    g = root_near((0 * rho + 38) / 100, [6 - 6 * rho, -18, 9, -1])
    second, third = 2 * g, (0 * rho + 3) / 5
    first_sum, second_sum = (1 - 2 * g) / 2, (1 - 3 * g) / 3
    determinant = second * third**2 - third * second**2
    b2 = (first_sum * third**2 - second_sum * third) / determinant
    b3 = (second * second_sum - second**2 * first_sum) / determinant
    a32 = (third**2 / 2 - g * third) / second
    return [[g, g], [third - a32 - g, a32, g], [1 - b2 - b3 - g, b2, b3, g]], [second, third, 0 * rho + 1]


def free_fourth_order(rho: Number) -> tuple[list[list[Number]], list[Number]]:
    """With c = (0, 2 gamma, 3/4, 2/3, 1): stages integrate linear rates, the third times b_4 the rest of order 4."""
    one = 0 * rho + 1
    g = root_near(one / 2, [24 - 24 * rho, -96, 72, -16, 1])
    c2, c3, c4 = 2 * g, one * 3 / 4, one * 2 / 3
    # sum b c^k = 1/(k + 1), k = 1, 2, 3, by Lagrange's weights for the moments left when gamma stands at 1
    m1, m2, m3 = (one / (k + 1) - g for k in (1, 2, 3))

    def weight(c: Number, d: Number, e: Number) -> Number:
        return (m3 - (d + e) * m2 + d * e * m1) / (c * (c - d) * (c - e))

    b2, b3, b4 = weight(c2, c3, c4), weight(c3, c2, c4), weight(c4, c2, c3)
    a32 = c3 * (c3 / 2 - g) / c2
    # sum b_i a_ij c_j^2 = 1/12 gives a_42 c_2^2 + a_43 c_3^2, sum a_4j c_j = c_4^2/2 the other equation
    right = one / 12 - g / 3 - b2 * (g * c2**2) - b3 * (a32 * c2**2 + g * c3**2) - b4 * g * c4**2
    second, linear = (right + g * (one / 3 - (m2 + g))) / b4, c4 * (c4 / 2 - g)
    a43 = (second - c2 * linear) / (c3 * (c3 - c2))
    a42 = (linear - a43 * c3) / c2
    rows = [[g, g], [c3 - a32 - g, a32, g], [c4 - a42 - a43 - g, a42, a43, g], [1 - b2 - b3 - b4 - g, b2, b3, b4, g]]
    return rows, [c2, c3, c4, one]


def fourth_order(one: Number) -> tuple[list[list[Number]], list[Number]]:
    """Hand-typed: gamma = 1/2, ends at 1, 3/5, 4/5, 1."""
    rows = [[50, 50], [22, -12, 50], [one * 34 / 3, -48, one * 200 / 3, 50]]
    last = [one * 75 / 4, -one * 125 / 6, one * 625 / 6, -one * 625 / 12, 50]
    return [[one * x / 100 for x in row] for row in [*rows, last]], [one, one * 3 / 5, one * 4 / 5, one]
