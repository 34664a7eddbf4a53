"""Truncated power series over any ring, and the numbers alpha + beta*zeta of an oscillator's mode.

A series knows how many of its coefficients are right: sums and products are as long as the shorter of the two, and a
quotient loses as many as its divisor starts late.
"""

from collections.abc import Iterable, Sequence
from typing import Any

from sympy import QQ


class Modal:
    """alpha + beta*zeta over any ring, where zeta^2 = -2*xi*zeta - 1.

    zeta is the exact eigenvalue over omega, s = Omega*zeta its product with the step; the other one is -2*xi - zeta.
    """

    __slots__ = ("alpha", "beta", "xi")

    def __init__(self, alpha: Any, beta: Any, xi: Any) -> None:
        self.alpha, self.beta, self.xi = alpha, beta, xi

    def __add__(self, other: "Modal") -> "Modal":
        return Modal(self.alpha + other.alpha, self.beta + other.beta, self.xi)

    def __sub__(self, other: "Modal") -> "Modal":
        return Modal(self.alpha - other.alpha, self.beta - other.beta, self.xi)

    def __neg__(self) -> "Modal":
        return Modal(-self.alpha, -self.beta, self.xi)

    def __mul__(self, other: Any) -> "Modal":
        """Times another one, or times an element of the ring."""
        if not isinstance(other, Modal):
            return Modal(self.alpha * other, self.beta * other, self.xi)
        a, b, c, d = self.alpha, self.beta, other.alpha, other.beta
        last = b * d
        return Modal(a * c - last, a * d + b * c - 2 * self.xi * last, self.xi)

    def __bool__(self) -> bool:
        return bool(self.alpha) or bool(self.beta)

    @property
    def conjugate(self) -> "Modal":
        """The same number of the other eigenvalue."""
        return Modal(self.alpha - 2 * self.xi * self.beta, -self.beta, self.xi)

    def inverse(self, one: Any) -> "Modal":
        """1 over a number that is not 0, over a field whose 1 is given."""
        other = self.conjugate
        return other * (one / (self * other).alpha)


class PowerSeries:
    """c[0] + c[1] x + ... + O(x^len(c))."""

    __slots__ = ("c",)

    def __init__(self, coefficients: Iterable[Any]) -> None:
        self.c = list(coefficients)

    def __len__(self) -> int:
        return len(self.c)

    def __add__(self, other: "PowerSeries") -> "PowerSeries":
        return PowerSeries(a + b for a, b in zip(self.c, other.c, strict=False))

    def __sub__(self, other: "PowerSeries") -> "PowerSeries":
        return PowerSeries(a - b for a, b in zip(self.c, other.c, strict=False))

    def __mul__(self, other: "PowerSeries") -> "PowerSeries":
        n = min(len(self), len(other))
        product: list[Any] = [None] * n
        for i, left in enumerate(self.c[:n]):
            if left:
                for j, right in enumerate(other.c[: n - i]):
                    term = left * right
                    product[i + j] = term if product[i + j] is None else product[i + j] + term
        zero = self.c[0] - self.c[0] if n else None
        return PowerSeries(zero if c is None else c for c in product)

    def scaled(self, factor: Any) -> "PowerSeries":
        """The series times a constant."""
        return PowerSeries(c * factor for c in self.c)

    @property
    def valuation(self) -> int:
        """The first power whose coefficient is not 0; the number of coefficients if there is none."""
        return next((k for k, c in enumerate(self.c) if c), len(self))

    @property
    def alternated(self) -> "PowerSeries":
        """The series at -x."""
        return PowerSeries(-c if k % 2 else c for k, c in enumerate(self.c))

    def shifted(self, power: int) -> "PowerSeries":
        """Times x^power, of the same length: the highest coefficients are dropped."""
        return PowerSeries([self.c[0] - self.c[0]] * power + self.c[: len(self) - power])

    def over(self, other: "PowerSeries", inverse: Any) -> "PowerSeries":
        """self/other, where `inverse` inverts the first coefficient of other that is not 0.

        Raises ValueError if the quotient has negative powers.
        """
        k = other.valuation
        if self.valuation < k:
            raise ValueError(f"expected a series that starts with the power {k} at least, got {self.valuation}")
        n = min(len(self), len(other)) - k
        rest, quotient = self.c[k : k + n], []
        for i in range(n):
            q = rest[i] * inverse
            quotient.append(q)
            if q:
                for j in range(i + 1, n):
                    rest[j] = rest[j] - q * other.c[j - i + k]
        return PowerSeries(quotient)

    def to_the(self, power: Any) -> "PowerSeries":
        """A power, whole or not, of a series that starts with 1: by the recurrence of f*x' = power*f'*x."""
        result = self.c[:1]
        for n in range(1, len(self)):
            total = self.c[0] - self.c[0]
            for k in range(1, n + 1):
                total = total + self.c[k] * result[n - k] * (power * k - (n - k))
            result.append(total * QQ(1, n))
        return PowerSeries(result)

    def at(self, argument: "PowerSeries") -> "PowerSeries":
        """The series of a series that starts with its first power."""
        total = PowerSeries([c - c for c in argument.c])
        for c in reversed(self.c):
            total = total * argument
            total.c[0] = total.c[0] + c
        return total


def total(series: Sequence[PowerSeries]) -> PowerSeries:
    """The sum of one series or more."""
    first, *others = series
    for other in others:
        first = first + other
    return first


def powers_of_zeta(n: int, damping: Any) -> list[tuple[Any, Any]]:
    """zeta^0 ... zeta^(n-1) as pairs (alpha, beta)."""
    zero = 0 * damping
    powers: list[tuple[Any, Any]] = [(zero + 1, zero)]
    for _ in range(n - 1):
        a, b = powers[-1]
        powers.append((-b, a - 2 * damping * b))
    return powers
