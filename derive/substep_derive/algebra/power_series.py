"""Power series in Omega whose coefficients are pairs alpha + beta*zeta, zeta^2 = -2*xi*zeta - 1."""

from collections.abc import Sequence
from typing import Any

Pair = tuple[Any, Any]


class Series:
    """A power series in Omega, cut off after Omega^(n-1), whose coefficients are pairs."""

    def __init__(self, coefficients: Sequence[Pair], damping: Any) -> None:
        self.c, self.xi = list(coefficients), damping

    def __add__(self, other: "Series") -> "Series":
        return Series([(a + c, b + d) for (a, b), (c, d) in zip(self.c, other.c, strict=True)], self.xi)

    def __mul__(self, other: "Series") -> "Series":
        n = len(self.c)
        product = [(0 * self.xi, 0 * self.xi)] * n
        for i, left in enumerate(self.c):
            if left[0] == 0 and left[1] == 0:
                continue
            for j, right in enumerate(other.c[: n - i]):
                a, b = _times(left, right, self.xi)
                product[i + j] = (product[i + j][0] + a, product[i + j][1] + b)
        return Series(product, self.xi)

    def scaled(self, factor: Any) -> "Series":
        """The series times a constant."""
        return Series([(a * factor, b * factor) for a, b in self.c], self.xi)

    def over(self, other: "Series", k: int, inverse: Pair) -> "Series":
        """self/other, where other starts with Omega^k and `inverse` inverts its leading coefficient.

        The last k coefficients of the quotient are lost and returned as zeros.
        """
        n = len(self.c)
        zero = 0 * self.xi
        rest, quotient = self.c[k:] + [(zero, zero)] * k, []
        for i in range(n - k):
            q = _times(rest[i], inverse, self.xi)
            quotient.append(q)
            for j in range(i, n - k):
                p = _times(q, other.c[j - i + k], self.xi)
                rest[j] = (rest[j][0] - p[0], rest[j][1] - p[1])
        return Series(quotient + [(zero, zero)] * k, self.xi)


def _times(left: Pair, right: Pair, damping: Any) -> Pair:
    (a, b), (c, d) = left, right
    return (a * c - b * d, a * d + b * c - 2 * damping * b * d)


def powers_of_zeta(n: int, damping: Any) -> list[Pair]:
    """zeta^0 ... zeta^(n-1) as pairs."""
    zero = 0 * damping
    one = zero + 1
    powers: list[Pair] = [(one, zero)]
    for _ in range(n - 1):
        a, b = powers[-1]
        powers.append((-b, a - 2 * damping * b))
    return powers
