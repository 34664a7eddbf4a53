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
    *short, wanted = _in_fewest_coordinates([*columns, right], p)
    for size in range(1, len(columns) + 1):
        visited = [0]
        found = list(_supports(short, wanted, size, 0, p, visited))
        if found:
            return found
        if visited[0] > MOST_VISITED:
            return []
    return []


def _in_fewest_coordinates(vectors: Sequence[Sequence[int]], p: int) -> list[list[int]]:
    """The vectors in as many coordinates as their rank: row operations keep all linear relations among them."""
    kept: list[tuple[int, list[int]]] = []
    for given in zip(*vectors, strict=True):
        row = list(given)
        for place, known in kept:
            row = _eliminated(row, known, row[place], p)
        place = next((i for i, x in enumerate(row) if x), None)
        if place is not None:
            inverse = pow(row[place], -1, p)
            kept.append((place, [x * inverse % p for x in row]))
    return [list(vector) for vector in zip(*(row for _, row in kept), strict=True)]


def _eliminated(vector: list[int], other: list[int], factor: int, p: int) -> list[int]:
    """vector - factor*other."""
    return [(x - factor * y) % p for x, y in zip(vector, other, strict=True)] if factor else vector


def _supports(
    columns: list[list[int]], right: list[int], size: int, first: int, p: int, visited: list[int]
) -> Iterator[tuple[int, ...]]:
    """Sets of `size` columns from `first` on whose span holds the right side, which is not 0.

    No smaller set is one, so that all of them are needed.
    """
    visited[0] += 1
    if visited[0] > MOST_VISITED:
        return
    if size < 3:
        yield from _last(columns, right, size, first, p, visited)
        return
    for k in range(first, len(columns) - size + 1):
        column = columns[k]
        pivot = next((i for i, x in enumerate(column) if x), None)
        if pivot is None:
            continue
        inverse = pow(column[pivot], -1, p)
        rest, *later = (
            _eliminated(other, column, other[pivot] * inverse % p, p) for other in (right, *columns[k + 1 :])
        )
        for tail in _supports([*columns[: k + 1], *later], rest, size - 1, k + 1, p, visited):
            yield (k, *tail)


def _last(
    columns: list[list[int]], right: list[int], size: int, first: int, p: int, visited: list[int]
) -> Iterator[tuple[int, ...]]:
    """The same for one column or two. Each column is a multiple of the right side plus a vector beside it.

    That vector has to be 0 for one column; for two, both have the same but for a number, and not the same share of the
    right side with it.
    """
    pivot = next(i for i, x in enumerate(right) if x)
    inverse = pow(right[pivot], -1, p)
    alike: dict[tuple[int, ...], list[tuple[int, int]]] = {}  # vector with a first number 1 -> columns, their shares
    found: list[tuple[tuple[int, ...], int] | None] = []
    for k, column in enumerate(columns[first:], first):
        share = column[pivot] * inverse % p
        beside = _eliminated(column, right, share, p)
        lead = next((x for x in beside if x), None)
        if lead is None:
            found.append(None)
            if size == 1 and share:
                yield (k,)
            continue
        scale = pow(lead, -1, p)
        line, share = tuple(x * scale % p for x in beside), share * scale % p
        found.append((line, share))
        alike.setdefault(line, []).append((k, share))
    if size == 1:
        return
    for k, own in enumerate(found[:-1], first):
        if own is None:
            continue
        visited[0] += 1
        if visited[0] > MOST_VISITED:
            return
        line, share = own
        yield from ((k, j) for j, other in alike[line] if j > k and other != share)
