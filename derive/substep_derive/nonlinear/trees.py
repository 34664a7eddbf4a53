"""Elementary differentials of M u'' + C u' + N(u) = f(t), as trees.

Exact motions and numerical ones are sums of products of derivatives of N, of C, of the velocity and of derivatives of
the load, all at one instant. Each such product is a tree (Hairer, Norsett & Wanner, Solving Ordinary Differential
Equations I, II.14: Nystrom trees for u'' = g(u), here with a node for each other part of the equation). Per unit mass,
with h the time step, the trees and their weights (the power of h) are

    u                 the displacement, 0           v                 h u', 1
    f_k               h^(k+2) f^(k)(t), k + 2       C[x]              h C x, 1 + that of x
    K[x]              h^2 K0 x, 2 + that of x       N[x, y, ...]      h^2 N^(m)(u)(x, y, ...), 2 + those of x, y, ...

K0, the tangent stiffness at the start of a run, is a constant that has nothing to do with N at a later displacement.

Where forces depend on rates in any way, as they do where the mass moves with the position, u'' = -N(u, u') + f(t), and
N[x, ...; y, ...] is h^2 times the derivative of N by u along x, ... and by u' along y/h, ...: y weighs one less there.
It stands in place of C. A branch y of that kind is written as ~y, a negative number. Where forces of inertia at other
displacements are asked for, M[x; y, ...] is M(u)^-1 times the derivative of M along y, ..., times x.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

U, V = 0, 1  # numbers of the trees u and v
Key = tuple[str, tuple[int, ...]]


@dataclass(frozen=True)
class Grown:
    """A tree N[..., last] that is another, `shorter`, with one more branch; `count`: how often it has that branch."""

    tree: int
    shorter: int
    last: int
    count: int


class Trees:
    """All trees of an equation with or without damping C, load f and start tangent K0, numbered by ascending weight.

    rates: whether N depends on rates. mass: whether there are derivatives of M.
    """

    def __init__(self, damping: bool, load: bool, tangent: bool, rates: bool = False, mass: bool = False) -> None:
        self.damping, self.load, self.tangent, self.rates, self.mass = damping, load, tangent, rates, mass
        self.keys: list[Key] = []
        self.weights: list[int] = []
        self.levels: list[list[int]] = []
        self.forces: list[list[Grown]] = []  # of each weight, the trees N[...] with at least one branch
        self._numbers: dict[Key, int] = {}
        self._rates: dict[int, dict[int, int]] = {}

    def grow(self, weight: int) -> None:
        """Number all trees up to this weight."""
        for w in range(len(self.levels), weight + 1):
            self.levels.append([])
            self.forces.append([])
            if w < 2:
                self._new(("u" if w == 0 else "v", ()), w)
                continue
            if self.load:
                self._new(("f", (w - 2,)), w)
            if self.damping:
                for x in self.levels[w - 1]:
                    self._new(("C", (x,)), w)
            if self.tangent and w > 2:
                for x in self.levels[w - 2]:
                    self._new(("K", (x,)), w)
            if w == 2:
                self._new(("N", ()), w)
            for branch in range(1, w - 1):
                self._grow_forces(w, branch)
                if self.mass:
                    self._grow_mass(w, branch)

    def _grow_forces(self, w: int, branch: int) -> None:
        """Number N[..., last] of weight w for all `last` that add that weight."""
        shorter = [n for n in self.levels[w - branch] if self.keys[n][0] == "N"]
        by_rate = sorted(~y for y in self.levels[branch + 1]) if self.rates else []
        for last in (*by_rate, *self.levels[branch]):
            for n in shorter:
                branches = self.keys[n][1]
                if not branches or branches[-1] <= last:
                    tree = self._new(("N", (*branches, last)), w)
                    self.forces[w].append(Grown(tree, n, last, branches.count(last) + 1))

    def _grow_mass(self, w: int, branch: int) -> None:
        """Number M[x; ..., last] of weight w for all `last` of that weight."""
        for last in self.levels[branch]:
            for n in list(self.levels[w - branch]):
                kind, branches = self.keys[n]
                self._new(("M", (n, last)), w)
                if kind == "M" and branches[-1] <= last:
                    self._new(("M", (*branches, last)), w)

    def _new(self, key: Key, weight: int) -> int:
        number = len(self.keys)
        self.keys.append(key)
        self.weights.append(weight)
        self.levels[weight].append(number)
        self._numbers[key] = number
        return number

    def number(self, kind: str, *branches: int) -> int:
        """The number of the tree of that kind ("u", "v", "f", "C", "K", "N") with these branches, in any order.

        Of "M" it is what M multiplies that comes first.
        """
        first = int(kind == "M")
        return self._numbers[kind, (*branches[:first], *sorted(branches[first:]))]

    def rate(self, tree: int) -> dict[int, int]:
        """h times the derivative of a tree by time along the exact motion: tree -> whole number."""
        if tree not in self._rates:
            self.grow(self.weights[tree] + 1)
            self._rates[tree] = self._rate(*self.keys[tree])
        return self._rates[tree]

    def _rate(self, kind: str, branches: tuple[int, ...]) -> dict[int, int]:
        if kind == "u":
            return {V: 1}
        if kind == "v":
            found = {self.number("N"): -1}
            found |= {self.number("C", V): -1} if self.damping else {}
            return found | ({self.number("f", 0): 1} if self.load else {})
        if kind == "f":
            return {self.number("f", branches[0] + 1): 1}
        found = {self.number(kind, *branches, V): 1} if kind in "NM" else {}
        found |= {self.number("M", self.number(kind, *branches), V): -1} if kind == "M" else {}
        if kind == "N" and self.rates:
            found |= {self.number("N", *branches, ~x): c for x, c in self.rate(V).items()}
        for k, branch in enumerate(branches):
            for x, c in self.rate(tree_of(branch)).items():
                after = self.number(kind, *branches[:k], like(branch, x), *branches[k + 1 :])
                found[after] = found.get(after, 0) + c
        return found

    def text(self, tree: int) -> str:
        """The tree as text, such as N[v, N[]]."""
        kind, branches = self.keys[tree]
        if kind in "uv":
            return kind
        if kind == "f":
            return f"f_{branches[0]}"
        if kind == "M":
            along, by_rate = [self.text(branches[0])], [self.text(x) for x in branches[1:]]
        else:
            along, by_rate = ([self.text(tree_of(x)) for x in branches if (x < 0) == rate] for rate in (False, True))
        return f"{kind}[{'; '.join(', '.join(part) for part in (along, by_rate) if part or part is along)}]"


def tree_of(branch: int) -> int:
    """The tree of a branch, along which a force is derived by u or by u'."""
    return max(branch, ~branch)


def like(branch: int, tree: int) -> int:
    """A tree as a branch of the same kind as another."""
    return tree if branch >= 0 else ~tree


@cache
def trees(damping: bool, load: bool, tangent: bool, rates: bool = False, mass: bool = False) -> Trees:
    """The trees of an equation, which every scheme shares."""
    return Trees(damping, load, tangent, rates, mass)


Level = dict[int, Any]  # tree -> number, of one weight
Series = list[Level]  # the levels of weights 0, 1, ...


def flow(of: Trees, series: Series, sign: int, one: Any) -> Series:
    """A series in the trees at t_n as one in those at t_n - sign*h: exp(sign*D), D the derivative along the motion."""
    total: Series = [dict(level) for level in series]
    moved, factorial = series, one
    for power in range(1, len(series)):
        factorial = factorial * power
        last, moved = moved, [{} for _ in series]
        for w, level in enumerate(last[: len(series) - 1]):
            target = moved[w + 1]
            for tree, c in level.items():
                for x, n in of.rate(tree).items():
                    target[x] = target[x] + c * n if x in target else c * n
        if not any(moved):
            break
        scale = one * (sign if power % 2 else 1) / factorial
        for level, more in zip(total, moved, strict=True):
            add(level, more, scale)
    return total


def add(level: dict[Any, Any], more: dict[Any, Any], factor: Any) -> None:
    """level += factor*more, in place; numbers that cancel are left out."""
    for key, c in more.items():
        value = level[key] + factor * c if key in level else factor * c
        if value:
            level[key] = value
        else:
            level.pop(key, None)
