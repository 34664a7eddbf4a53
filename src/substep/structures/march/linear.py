"""Steps of a linear structure: each system of a plan as products with M and C, one solve, and combinations.

With K y in a system whose effective matrix is m M + c C + k K, k not 0, no product with K is needed: its solution is
(m M + c C + k K)^-1 [f + M (x - (m/k) y) + C (w - (c/k) y)] + y/k. Rayleigh damping adds alpha and beta times what C
multiplies to what M and K do, so that one product with M is left. In the last system of a step y/k is not even
computed: what combines the unknown with other vectors has it among its coefficients. Through several systems these
would grow, and the digits of large parts be lost (of esdirk43 one and a half).

In a step that is short for the stiffest degree of freedom, both parts of that solution are y/k with opposite signs: it
loses the digits by which m/k is greater than the squares of the frequencies. There the product with K is kept,
(m M + c C + k K)^-1 [f + M x + C w - K y], whose rounding is that of K y.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...core.arrays import Array
from ..model.model import Model
from ..model.rayleigh import Rayleigh
from ..solvers.combine import add_product, combined
from ..solvers.matrices import Matrix, combination
from .pressing import Pressing
from .scheme_plan import System

SHORT = 100.0  # (m/k) / max(K_ii / M_ii) beyond which the product with K is kept, so that two digits are lost at most
SAME = 8 * np.finfo(np.float64).eps  # two ratios that differ by less belong to one effective matrix


@dataclass
class Factors:
    """Factorizations of a structure's effective matrices, one for each ratio of their parts."""

    known: list[tuple[Array, Callable[[Array], Array]]] = field(default_factory=list)

    def scaled(
        self, structure: Model, m: complex, c: complex, k: complex, what: str
    ) -> tuple[Any, Callable[[Array], Array]]:
        """A scale, and the function b -> (m M + c C + k K)^-1 scale b; complex where one of the numbers is."""
        parts, scale = np.array([m, c, k]), k or m
        ratios = parts / scale
        for other, solve in self.known:
            if np.all(np.abs(ratios - other) <= SAME * np.abs(ratios)):
                return scale, solve
        terms = [(ratios[0], structure.M), (ratios[2], structure.K)]
        if c != 0.0 and structure.C is not None:
            terms.append((ratios[1], structure.damping))
        solve = structure.factorized(combination(terms), what)
        self.known.append((ratios, solve))
        return scale, solve


@dataclass(frozen=True)
class LinearSystem:
    """matrices: multiplied with the first rows @ X; the last row, if there is one more, is added to the solution.

    place: of the solution in X. rest (place,): by what of the vectors before it the solution is less than the unknown.
    scale: what the matrices' rows are divided by, and the load has to be.
    """

    place: int
    rows: Array
    matrices: tuple[Matrix, ...]
    rest: Array
    factors: Callable[[Array], Array]
    scale: float
    count = 0  # iterations
    tangent = None  # that is kept

    @classmethod
    def of(cls, s: Model, system: System, last: bool, factors: Factors, what: str) -> "LinearSystem":
        """From a system of the plan, the last one or not. Raises ValueError for a singular effective matrix."""
        j, by = system.place, rows_by_matrix(s, system)
        m, c, k = (float(row[j]) for row in by.values())
        known = {name: -row[:j] for name, row in by.items()}
        rest = np.zeros(j)
        if k != 0.0 and abs(m) <= SHORT * abs(k) * s.stiffest:
            y = known.pop("K")
            known["M"] -= m / k * y
            known["C"] -= c / k * y
            rest = y / k
        matrices = {"M": s.M, "C": s.damping, "K": s.K}
        used = [name for name, row in known.items() if row.any()]
        scale, solve = factors.scaled(s, m, c, k, what)
        rows = [known[name] / scale for name in used]
        if rest.any() and not last:
            rows, rest = [*rows, rest], np.zeros(j)
        return cls(j, np.reshape(rows, (-1, j)), tuple(matrices[name] for name in used), rest, solve, scale)

    def solve(self, b: Array) -> Array:
        """The effective matrix's inverse times b."""
        return self.factors(b / self.scale)

    def put(self, X: Array, load: Array | None, t: float, ahead: int = 0, pressing: Pressing | None = None) -> None:
        """Put the solution in its place of X (V, n), from the vectors before it; of L cases (V, n, L).

        load (n,) or (n, L): the sum of its loads over the scale, which is overwritten. ahead: how many vectors from
        that place on are rows @ X already: all or none. pressing: contacts, which are then solved for.
        """
        j = self.place
        total = np.zeros(X.shape[1:]) if load is None else load
        Y = X[j : j + ahead] if ahead else combined(self.rows, X[:j])
        for matrix, y in zip(self.matrices, Y, strict=False):
            add_product(matrix, y, total)
        z = self.factors(total)
        if len(Y) > len(self.matrices):
            np.add(z, Y[-1], out=X[j])
        else:
            X[j] = z
        if pressing is not None:
            pressing.press(X, self.factors, self.scale)


def rows_by_matrix(s: Model, system: System) -> dict[str, Array]:
    """The rows (V,) of what M, C and K multiply, Rayleigh damping being part of those of M and K."""
    by = {"M": system.inertia.copy(), "C": system.damping.copy(), "K": system.linear_stiffness}
    if isinstance(s.C, Rayleigh):
        by["M"] += s.C.alpha * by["C"]
        by["K"] += s.C.beta * by["C"]
    if s.C is None or isinstance(s.C, Rayleigh):
        by["C"] = np.zeros_like(by["C"])
    return by
