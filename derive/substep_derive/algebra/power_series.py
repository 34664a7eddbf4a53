"""Truncated power series over any ring, and the numbers alpha + beta*zeta of an oscillator's mode.

A series holds only coefficients that are exact: a sum or product is as long as the shorter of the two series, and a
quotient is shorter by the number of zeros with which its divisor starts.
"""

from collections.abc import Iterable, Sequence
from typing import Any

from sympy import QQ


class Modal:
    """The number alpha + beta*zeta with alpha and beta from any ring, where zeta^2 = -2*xi*zeta - 1.

    zeta is the oscillator's exact eigenvalue divided by omega, and s = Omega*zeta the eigenvalue times the time step;
    the conjugate eigenvalue is -2*xi - zeta.
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
        """The product with another Modal or with an element of the ring."""
        if not isinstance(other, Modal):
            return Modal(self.alpha * other, self.beta * other, self.xi)
        a, b, c, d = self.alpha, self.beta, other.alpha, other.beta
        if not b:  # as it is in all series that come from polynomials, so that most products are short
            return Modal(a * c, a * d, self.xi)
        if not d:
            return Modal(a * c, b * c, self.xi)
        last = b * d
        return Modal(a * c - last, a * d + b * c - 2 * self.xi * last, self.xi)

    def __bool__(self) -> bool:
        return bool(self.alpha) or bool(self.beta)

    @property
    def conjugate(self) -> "Modal":
        """The number with the conjugate eigenvalue in place of zeta."""
        return Modal(self.alpha - 2 * self.xi * self.beta, -self.beta, self.xi)

    def inverse(self, one: Any) -> "Modal":
        """The reciprocal of a number that is not 0; one: the 1 of the field that alpha and beta are from."""
        other = self.conjugate
        return other * (one / (self * other).alpha)


class PowerSeries:
    """The truncated power series c[0] + c[1] x + ... + O(x^len(c))."""

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
                    if not right:
                        continue
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
        """The series times x^power, cut to the same length."""
        return PowerSeries([self.c[0] - self.c[0]] * power + self.c[: len(self) - power])

    def over(self, other: "PowerSeries", inverse: Any) -> "PowerSeries":
        """The quotient self/other; inverse: the reciprocal of other's first coefficient that is not 0.

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
        """An integer or fractional power of this series f, which starts with 1.

        The result x satisfies f*x' = power*f'*x, which gives its coefficients one after another.
        """
        result = self.c[:1]
        for n in range(1, len(self)):
            total = self.c[0] - self.c[0]
            for k in range(1, n + 1):
                total = total + self.c[k] * result[n - k] * (power * k - (n - k))
            result.append(total * QQ(1, n))
        return PowerSeries(result)

    def at(self, argument: "PowerSeries") -> "PowerSeries":
        """The series with another one for its variable; the argument must have no constant term."""
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
