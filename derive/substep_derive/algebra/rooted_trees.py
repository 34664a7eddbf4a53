"""Order conditions of Runge-Kutta and Nystrom tables, exactly: one equation for each rooted tree.

A tree is the sorted tuple of its root's subtrees. Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I
(1993): II.2 for Runge-Kutta, II.14 for Nystrom, whose trees have two kinds of vertices. There a "fat" vertex stands for
the acceleration and a "meagre" one for a velocity; below a meagre vertex hangs nothing or one fat vertex, and below a
fat one hang meagre ones and, where the acceleration depends on the velocity, fat ones too.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from itertools import combinations_with_replacement
from math import factorial, prod
from typing import Any

from sympy import QQ

Tree = tuple[Any, ...]
Vector = Sequence[Any]
MOST = 10  # orders above are not looked for


def _forests(n: int, trees: Callable[[int], tuple[Any, ...]], largest: int) -> Iterator[Tree]:
    """Every multiset of trees with n vertices together, none of which has more than `largest`."""
    if n == 0:
        yield ()
        return
    for size in range(min(n, largest), 0, -1):
        for count in range(1, n // size + 1):
            for chosen in combinations_with_replacement(trees(size), count):
                for rest in _forests(n - size * count, trees, size - 1):
                    yield (*chosen, *rest)


@cache
def rooted_trees(n: int) -> tuple[Tree, ...]:
    """The rooted trees with n vertices: 1, 1, 2, 4, 9, 20, 48, 115, ... of them."""
    return tuple(_forests(n - 1, rooted_trees, n - 1))


def size(tree: Tree) -> int:
    """The number of vertices."""
    return 1 + sum(map(size, tree))


def density(tree: Tree) -> int:
    """The product of the sizes of all subtrees: b satisfies the tree's condition if sum_i b_i weights_i = 1/density."""
    return size(tree) * prod(map(density, tree))


def symmetry(tree: Tree) -> int:
    """The order of the tree's group of symmetries."""
    return prod(factorial(count) * symmetry(child) ** count for child, count in Counter(tree).items())


@cache
def nystrom_trees(n: int, damped: bool) -> tuple[Tree, ...]:
    """The Nystrom trees with n vertices and a fat root; damped: the acceleration depends on the velocity.

    The children of a fat vertex are pairs ("v", a fat vertex's tree or None), which is a meagre vertex, and
    ("a", a fat vertex's tree).
    """

    def children(size: int) -> tuple[Any, ...]:
        below = [None] if size == 1 else nystrom_trees(size - 1, damped)
        fat = [("a", tree) for tree in nystrom_trees(size, damped)] if damped else []
        return (*(("v", tree) for tree in below), *fat)

    return tuple(_forests(n - 1, children, n - 1))


def _weights(A: Sequence[Vector], one: Any) -> Callable[[Tree], tuple[Any, ...]]:
    """A function that gives a tree's weight at each stage of the table A (s, s), each tree's computed once."""

    @cache
    def weights(tree: Tree) -> tuple[Any, ...]:
        inner = [_product(A, weights(child)) for child in tree]
        return tuple(prod((w[i] for w in inner), start=one) for i in range(len(A)))

    return weights


def runge_kutta_order(A: Sequence[Vector], b: Vector, one: Any) -> int:
    """The largest p <= 10 for which b satisfies every condition with p vertices or fewer.

    A (s, s) and b (s,) hold numbers of one field, `one` is its 1.
    """
    weights = _weights(A, one)
    for p in range(1, MOST + 1):
        if any(_dot(b, weights(tree)) * density(tree) != one for tree in rooted_trees(p)):
            return p - 1
    return MOST


def residuals(A: Sequence[Vector], b: Vector, order: int, one: Any) -> list[Any]:
    """For every tree of that order, (b . weights - 1/density)/symmetry: its coefficient in the error of one step.

    A (s, s) and b (s,) hold numbers of one field, `one` is its 1.
    """
    weights = _weights(A, one)
    return [
        (_dot(b, weights(tree)) - one * QQ(1, density(tree))) * QQ(1, symmetry(tree)) for tree in rooted_trees(order)
    ]


def nystrom_order(
    A_bar: Sequence[Vector], b_bar: Vector, b: Vector, c: Vector, one: Any, A: Sequence[Vector] | None = None
) -> tuple[int, int]:
    """The orders <= 10 of u and of v for u'' = g(t, u), or, where A is given, for u'' = g(t, u, v).

    The new values are u_0 + h v_0 + h^2 sum b_bar_i a_i and v_0 + h sum b_i a_i; numbers are of one field, `one` is
    its 1.
    """

    @cache
    def weights(tree: Tree) -> tuple[Any, ...]:
        found = [one] * len(b)
        for kind, below in tree:
            if kind == "a":
                assert A is not None
                inner = _product(A, weights(below))
            else:
                inner = c if below is None else _product(A_bar, weights(below))
            found = [x * y for x, y in zip(found, inner, strict=True)]
        return tuple(found)

    orders = [MOST, MOST]
    for p in range(1, MOST + 1):
        for tree in nystrom_trees(p, A is not None):
            product = _nystrom_density(tree)[1]
            if _dot(b, weights(tree)) * product != one:
                orders[1] = min(orders[1], p - 1)
            if _dot(b_bar, weights(tree)) * (product * (p + 1)) != one:
                orders[0] = min(orders[0], p)
        if max(orders) < p:
            break
    return orders[0], orders[1]


def _product(matrix: Sequence[Vector], vector: Vector) -> list[Any]:
    return [_dot(row, vector) for row in matrix]


def _dot(left: Vector, right: Vector) -> Any:
    return sum((x * y for x, y in zip(left[1:], right[1:], strict=True)), left[0] * right[0])


def _nystrom_density(tree: Tree) -> tuple[int, int]:
    parts = []
    for kind, below in tree:
        n, product = (0, 1) if below is None else _nystrom_density(below)
        parts.append((n, product) if kind == "a" else (n + 1, (n + 1) * product))
    whole = 1 + sum(n for n, _ in parts)
    return whole, whole * prod(d for _, d in parts)
