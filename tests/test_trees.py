"""Trees: none twice and none missing; their derivative by time is that of the elementary differentials."""

import pytest
from substep_derive.nonlinear.trees import Trees, U, V, flow
from sympy import Function, Integer, Rational, Symbol, diff, expand

u, v, t, c, k = (Symbol(name) for name in ("u", "v", "t", "c", "k"))
g, load = Function("g"), Function("f")


def multisets(counts: list[int], top: int) -> list[int]:
    """Numbers of multisets of each total weight from counts[w] kinds of weight w: prod (1 - x^w)^-counts[w]."""
    found = [1] + [0] * top
    for w, kinds in enumerate(counts[: top + 1]):
        for _ in range(kinds if w else 0):
            for total in range(w, top + 1):
                found[total] += found[total - w]
    return found


@pytest.mark.parametrize("damping", [False, True])
@pytest.mark.parametrize("with_load", [False, True])
@pytest.mark.parametrize("tangent", [False, True])
def test_every_tree_is_there_once(damping: bool, with_load: bool, tangent: bool) -> None:
    """Their numbers from a generating function, and from another way of listing those of low weight."""
    of, top = Trees(damping, with_load, tangent), 8
    of.grow(top)
    counts = [0, 1]
    for w in range(2, top + 1):
        own = multisets(counts, w - 2)[w - 2] + with_load
        own += damping * counts[w - 1]
        own += tangent * (counts[w - 2] if w > 2 else 0)
        counts.append(own)
    assert [len(level) for level in of.levels][1:] == counts[1:]
    assert len(set(of.keys)) == len(of.keys)
    assert all(list(branches) == sorted(branches) for kind, branches in of.keys if kind == "N")


def test_nystrom_trees_are_as_many_as_published() -> None:
    """Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, table II.14.3: special Nystrom trees."""
    of = Trees(False, False, False)
    of.grow(11)
    assert [len(level) for level in of.levels[2:]] == [1, 1, 2, 3, 6, 10, 20, 36, 72, 137]


def test_the_derivative_by_time() -> None:
    """On one coordinate with any N = g, C = c and K0 = k, whose derivatives SymPy takes."""
    of = Trees(True, True, True)
    of.grow(5)

    def value(tree: int):
        kind, branches = of.keys[tree]
        if kind in "uv":
            return u if kind == "u" else v
        if kind == "f":
            return diff(load(t), t, branches[0]) if branches[0] else load(t)
        found = {"C": c, "K": k, "N": diff(g(u), u, len(branches)) if branches else g(u)}[kind]
        for branch in branches:
            found = found * value(branch)
        return found

    def rate(e):
        return diff(e, t) + diff(e, u) * v + diff(e, v) * (load(t) - c * v - g(u))

    for tree in range(len(of.keys)):
        if of.weights[tree] < 5:
            found = sum((n * value(x) for x, n in of.rate(tree).items()), Integer(0))
            assert expand(found - rate(value(tree))).doit() == 0, of.text(tree)


def test_forth_and_back_is_nothing() -> None:
    of, one = Trees(True, True, False), Rational(1)
    of.grow(7)
    series = [{U: one}, {V: one}, *({} for _ in range(6))]
    there = flow(of, series, 1, one)
    assert there != series
    assert flow(of, there, -1, one) == series
    assert there[3][of.number("N", V)] == -(Rational(1, 6) + Rational(1, 2))  # of u and of h v
    assert of.text(of.number("N", V, of.number("C", of.number("f", 0)))) == "N[v, C[f_0]]"
