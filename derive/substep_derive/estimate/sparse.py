"""The sparsest solutions of a linear system: which few unknowns suffice.

Supports are sought modulo a prime, at which a regular matrix is singular only by a chance of about one in 10^9; what is
found is solved again exactly by the caller.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from sympy import prevprime

from ..algebra.algebraic import Field
from ..algebra.rational import polynomial_roots_modulo

MOST_VISITED = 60000  # sets of unknowns that are looked at


def reduction(field: Field) -> tuple[int, Callable[[Any], int]]:
    """(a prime p, the map of the field's elements to remainders); r goes to a root of its polynomial modulo p."""
    p = 2**31 - 1
    if not field.algebraic:
        return p, lambda number: int(number.numerator) * pow(int(number.denominator), -1, p) % p
    assert field.root is not None
    while not (roots := polynomial_roots_modulo(field.root.polynomial, p)):
        p = int(prevprime(p))
    r = roots[0]

    def remainder(number: Any) -> int:
        value = 0
        for part in field.parts(number):
            value = (value * r + int(part.numerator) * pow(int(part.denominator), -1, p)) % p
        return value

    return p, remainder


def sparsest(columns: Sequence[Sequence[int]], right: Sequence[int], p: int) -> list[tuple[int, ...]]:
    """All smallest sets of columns that have a combination equal to the right side modulo p; none if it takes too long.

    The right side is known to be a combination of all columns.
    """
    if not any(right):
        return [()]
    for size in range(1, len(columns) + 1):
        visited = [0]
        found = list(_supports([list(c) for c in columns], list(right), size, 0, p, visited))
        if found:
            return found
        if visited[0] > MOST_VISITED:
            return []
    return []


def _supports(
    columns: list[list[int]], right: list[int], size: int, first: int, p: int, visited: list[int]
) -> Iterator[tuple[int, ...]]:
    """Sets of `size` columns from `first` on, all of them needed, whose span holds the right side."""
    visited[0] += 1
    if visited[0] > MOST_VISITED:
        return
    for k in range(first, len(columns) - size + 1):
        column = columns[k]
        pivot = next((i for i, x in enumerate(column) if x), None)
        if pivot is None:
            continue
        inverse = pow(column[pivot], -1, p)

        def eliminated(
            other: list[int], pivot: int = pivot, inverse: int = inverse, column: list[int] = column
        ) -> list[int]:
            factor = other[pivot] * inverse % p
            return [(x - factor * y) % p for x, y in zip(other, column, strict=True)] if factor else other

        rest = eliminated(right)
        if size == 1:
            if not any(rest):
                yield (k,)
            continue
        if not any(rest):
            continue
        later = [*columns[: k + 1], *(eliminated(c) for c in columns[k + 1 :])]
        for tail in _supports(later, rest, size - 1, k + 1, p, visited):
            yield (k, *tail)
