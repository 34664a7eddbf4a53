"""Power series in several variables up to a degree, at many points at once, of which derivatives are read."""

from collections import Counter
from collections.abc import Sequence
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from .arrays import Array


class Space:
    """The monomials in n variables up to a degree, in ascending degree: 1, x_1, ..., x_n, x_1^2, x_1 x_2, ..."""

    def __init__(self, variables: int, degree: int) -> None:
        chosen = [c for total in range(degree + 1) for c in combinations_with_replacement(range(variables), total)]
        place = {c: k for k, c in enumerate(chosen)}
        self.variables, self.degree, self.size = variables, degree, len(chosen)
        fewer = [sum(len(c) <= total for c in chosen) for total in range(degree + 1)]
        self.products = [[place[tuple(sorted(a + b))] for b in chosen[: fewer[degree - len(a)]]] for a in chosen]
        lower = chosen[: fewer[degree - 1]] if degree else []
        self._lower = dict(zip(fewer[1:], fewer, strict=False))
        self._raised = [[place[tuple(sorted((*c, x)))] for c in lower] for x in range(variables)]
        self._factors = [np.array([Counter(c)[x] + 1.0 for c in lower])[:, None] for x in range(variables)]

    def variables_at(self, points: Array) -> list["Jet"]:
        """The variables (n, P) about these points."""
        found = np.zeros((self.variables, self.size, points.shape[1]))
        found[:, 0] = points
        if self.degree:
            found[range(self.variables), range(1, self.variables + 1)] = 1.0
        return [Jet(self, c) for c in found]

    def along(self, series: Array, x: Array, first: int = 0) -> Array:
        """The derivative of series (..., m, P) along x (k, P), of the variables from `first` on; a degree less."""
        m, k = self._lower[series.shape[-2]], len(x)
        raised, factors = self._raised[first : first + k], self._factors[first : first + k]
        parts = (f[:m] * series[..., r[:m], :] * part for r, f, part in zip(raised, factors, x, strict=True))
        return sum(parts, np.zeros(()))


class Jet:
    """A power series: coefficients (m, P) of the monomials of a space at P points."""

    def __init__(self, space: Space, coefficients: Array) -> None:
        self.space, self.coefficients = space, coefficients

    @property
    def value(self) -> Array:
        """At the points themselves (P,)."""
        return self.coefficients[0]

    def _made(self, other: Any) -> "Jet":
        if isinstance(other, Jet):
            return other
        found = np.zeros_like(self.coefficients)
        found[0] = other
        return Jet(self.space, found)

    def __add__(self, other: Any) -> "Jet":
        return Jet(self.space, self.coefficients + self._made(other).coefficients)

    def __neg__(self) -> "Jet":
        return Jet(self.space, -self.coefficients)

    def __sub__(self, other: Any) -> "Jet":
        return self + -self._made(other)

    def __rsub__(self, other: Any) -> "Jet":
        return self._made(other) - self

    def __mul__(self, other: Any) -> "Jet":
        if not isinstance(other, Jet):
            return Jet(self.space, self.coefficients * other)
        found = np.zeros_like(self.coefficients)
        for factor, places in zip(self.coefficients, self.space.products, strict=True):
            if factor.any():
                found[places] += factor * other.coefficients[: len(places)]
        return Jet(self.space, found)

    def __pow__(self, power: float) -> "Jet":
        if power == int(power) and 0 <= power <= self.space.degree:
            found = self._made(1.0)
            for _ in range(int(power)):
                found = found * self
            return found
        value, terms = self.value, [np.ones_like(self.value)]
        for k in range(self.space.degree):
            terms.append(terms[-1] * (power - k) / (k + 1))
        return self.composed([c * value ** (power - k) for k, c in enumerate(terms)])

    def __truediv__(self, other: Any) -> "Jet":
        return self * other**-1.0

    def __rtruediv__(self, other: Any) -> "Jet":
        return self**-1.0 * other

    __radd__, __rmul__ = __add__, __mul__

    def composed(self, terms: Sequence[Any]) -> "Jet":
        """A function of it, with its Taylor coefficients (degree + 1, P) at the series' values."""
        rest = self.coefficients.copy()
        rest[0] = 0.0
        small, found = Jet(self.space, rest), self._made(terms[-1])
        for term in terms[-2::-1]:
            found = found * small + term
        return found


def solved(matrix: Sequence[Sequence[Any]], right: Sequence[Any], space: Space, points: int) -> Array:
    """The solution (d, m, P) of a linear system of series and numbers."""
    nothing = Jet(space, np.zeros((space.size, points)))
    A = np.array([[(nothing + x).coefficients for x in row] for row in matrix])
    b = np.array([(nothing + x).coefficients for x in right])
    at, rest = A[:, :, 0].transpose(2, 0, 1), A.copy()  # (P, d, d)
    rest[:, :, 0] = 0.0
    found = np.zeros_like(b)
    for _ in range(space.degree + 1 if rest.any() else 1):  # one more degree is right each time
        known = [
            [(Jet(space, r) * Jet(space, x)).coefficients for r, x in zip(row, found, strict=True)] for row in rest
        ]
        left: Array = b - np.array(known).sum(axis=1)
        found = np.moveaxis(np.linalg.solve(at, np.moveaxis(left, 2, 0)), 0, 2)
    return np.asarray(found, dtype=np.float64)
