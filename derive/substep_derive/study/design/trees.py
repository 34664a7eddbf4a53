"""Order conditions of Runge-Kutta tables on any nonlinear problem, exactly, by rooted trees (Butcher)."""

from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import combinations_with_replacement
from math import factorial, prod
from typing import Any

from sympy import QQ

Tree = tuple[Any, ...]  # its subtrees, in a fixed order


@cache
def trees(order: int) -> tuple[Tree, ...]:
    """All rooted trees with that many nodes, each once: 1, 1, 2, 4, 9, 20, ..."""
    return tuple(sorted(_forests(order - 1, order - 1))) if order > 1 else ((),)


def _forests(nodes: int, largest: int) -> Iterator[Tree]:
    """Multisets of trees with that many nodes in all, none with more than `largest`."""
    if nodes == 0:
        yield ()
        return
    for size in range(min(nodes, largest), 0, -1):
        for count in range(1, nodes // size + 1):
            for chosen in combinations_with_replacement(trees(size), count):
                for rest in _forests(nodes - size * count, size - 1):
                    yield tuple(sorted((*chosen, *rest)))


def nodes(tree: Tree) -> int:
    """The number of nodes."""
    return 1 + sum(map(nodes, tree))


def density(tree: Tree) -> int:
    """gamma(tree): the condition is b . weight = 1/gamma."""
    return nodes(tree) * prod(map(density, tree))


def symmetry(tree: Tree) -> int:
    """The order of the tree's group of symmetries."""
    return prod(factorial(count) * symmetry(child) ** count for child, count in Counter(tree).items())


def residuals(A: Sequence[Sequence[Any]], b: Sequence[Any], order: int) -> list[Any]:
    """For every tree of that order, (b . weight - 1/density)/symmetry: its coefficient in the error of one step.

    A (s, s) and b (s,) are of one field that contains the rationals.
    """
    zero = b[0] - b[0]
    size = range(len(b))

    def weight(tree: Tree) -> list[Any]:
        product = [zero + 1 for _ in size]
        for child in tree:
            inner = weight(child)
            sums = [sum((A[i][j] * inner[j] for j in size if A[i][j]), zero) for i in size]
            product = [a * c for a, c in zip(product, sums, strict=True)]
        return product

    found = []
    for tree in trees(order):
        left = sum((x * w for x, w in zip(b, weight(tree), strict=True)), zero)
        found.append((left - QQ(1, density(tree))) * QQ(1, symmetry(tree)))
    return found
