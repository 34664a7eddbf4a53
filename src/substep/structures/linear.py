"""Steps of a linear structure: each system of a plan as products with M and C, one solve, and combinations.

With K y in a system whose effective matrix is m M + c C + k K, k not 0, no product with K is needed: its solution is
(m M + c C + k K)^-1 [f + M (x - (m/k) y) + C (w - (c/k) y)] + y/k. Rayleigh damping adds alpha and beta times what C
multiplies to what M and K do, so that one product with M is left.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..core.arrays import Array
from ..core.loads import values_at
from ..core.schemes import Scheme
from .combine import combined
from .damping import Rayleigh
from .matrices import Matrix
from .plan import Steps, System, start_of, step_of
from .structure import Structure, sum_of_matrices

BLOCK = 256  # steps for which the loads are sampled at once
SAME = 8 * np.finfo(np.float64).eps  # two ratios that differ by less belong to one effective matrix


@dataclass
class Factors:
    """Factorizations of a structure's effective matrices, one for each ratio of their parts."""

    structure: Structure
    known: list[tuple[Array, Callable[[Array], Array]]] = field(default_factory=list)

    def solve(self, m: float, c: float, k: float, what: str) -> Callable[[Array], Array]:
        """b -> (m M + c C + k K)^-1 b."""
        parts, scale = np.array([m, c, k]), k or m
        ratios = parts / scale
        for other, solve in self.known:
            if np.all(np.abs(ratios - other) <= SAME * np.abs(ratios)):
                return lambda b: solve(b) / scale
        solve = self.structure.factorized(sum_of_matrices(self.structure, *ratios), what)
        self.known.append((ratios, solve))
        return lambda b: solve(b) / scale


@dataclass(frozen=True)
class LinearSystem:
    """matrices: multiplied with the first rows @ X; the last row, if there is one more, is added to the solution.

    place: of the solution in X. loads: pairs (w, tau).
    """

    place: int
    rows: Array
    matrices: tuple[Matrix, ...]
    solve: Callable[[Array], Array]
    loads: tuple[tuple[float, float], ...]

    @classmethod
    def of(cls, system: System, factors: Factors, what: str) -> "LinearSystem":
        """From a system of the plan, for the structure of these factors."""
        s, j = factors.structure, system.place
        by = {"M": system.inertia.copy(), "C": system.damping.copy(), "K": system.linear_stiffness}
        if isinstance(s.C, Rayleigh):
            by["M"] += s.C.alpha * by["C"]
            by["K"] += s.C.beta * by["C"]
        if s.C is None or isinstance(s.C, Rayleigh):
            by["C"] = np.zeros_like(by["C"])
        m, c, k = (float(row[j]) for row in by.values())
        known = {name: -row[:j] for name, row in by.items()}
        rest = np.zeros((0, j))
        if k != 0.0:
            y = known.pop("K")
            known["M"] -= m / k * y
            known["C"] -= c / k * y
            rest = (y / k)[None]
        matrices = {"M": s.M, "C": s.damping, "K": s.K}
        used = [name for name, row in known.items() if row.any()]
        rows = np.concatenate([np.reshape([known[name] for name in used], (-1, j)), rest])
        return cls(j, rows, tuple(matrices[name] for name in used), factors.solve(m, c, k, what), system.loads)

    def solved(self, X: Array, load: Array | None) -> Array:
        """The solution (n,) from the vectors before it, X (V, n), and the sum of its loads (n,)."""
        Y = combined(self.rows, X[: self.place])
        total = load
        for matrix, y in zip(self.matrices, Y, strict=False):
            product = matrix @ y
            total = product if total is None else np.add(total, product, out=product)
        z = self.solve(np.zeros(X.shape[1]) if total is None else total)
        return z + Y[-1] if len(Y) > len(self.matrices) else z


@dataclass(frozen=True)
class LinearSteps:
    """All systems of a plan on a structure."""

    structure: Structure
    steps: Steps
    systems: tuple[LinearSystem, ...]
    h: float

    @classmethod
    def of(cls, steps: Steps, factors: Factors, h: float, what: str) -> "LinearSteps":
        """Factorizes what is not yet in `factors`. Raises ValueError for a singular effective matrix."""
        return cls(factors.structure, steps, tuple(LinearSystem.of(s, factors, what) for s in steps.systems), h)

    def loads(self, first: int, count: int) -> list[Array]:
        """For each system the sum of w g(t_n + tau h), (count, J), for the J loads and the steps n from `first` on."""
        n = np.arange(first, first + count, dtype=np.float64)
        found = []
        for system in self.systems:
            total = np.zeros((count, len(self.structure.loads)))
            for w, tau in system.loads:
                for j, (_, g) in enumerate(self.structure.loads):
                    total[:, j] += w * values_at(g, (n + tau) * self.h)
            found.append(total)
        return found

    def complete(self, X: Array, shapes: Array, loads: Sequence[Array], i: int) -> None:
        """Compute the unknowns in X (V, n). shapes (J, n): the loads' vectors; loads: those of a block; i: its step."""
        for system, factors in zip(self.systems, loads, strict=True):
            load = combined(factors[i : i + 1], shapes)[0] if len(shapes) and system.loads else None
            X[system.place] = system.solved(X, load)


def marched(structure: Structure, scheme: Scheme, h: float, n: int) -> Iterator[tuple[Array, Steps]]:
    """X (V, n), complete, of each of n steps, and the plan, of which report @ X are u, v, a after the step.

    X is written anew in every step. Where another scheme marches the first steps, those are its own.
    """
    factors = Factors(structure)
    yield from _marched(factors, scheme, h, n)


def _marched(factors: Factors, scheme: Scheme, h: float, n: int) -> Iterator[tuple[Array, Steps]]:
    s = factors.structure
    given = np.array([s.u0, s.v0, s.a0])
    what = f"{scheme.name}'s step,"
    shapes = np.array([shape for shape, _ in s.loads]).reshape(-1, s.size)
    done = 0
    if scheme.starter is None:
        start = LinearSteps.of(start_of(scheme, h), factors, h, what)
        X = np.empty((start.steps.vectors, s.size))
        X[:3] = given
        start.complete(X, shapes, start.loads(0, 1), 0)
        state = start.steps.out @ X
    else:
        history = [given]
        lag = max(steps for _, steps in scheme.history)
        for X, steps in _marched(factors, scheme.starter, h, min(lag, n)):
            history.append(_with_acceleration(s, steps.report @ X, len(history) * h))
            yield X, steps
        done = len(history) - 1
        if done == n:
            return
        state = np.array([history[lag - steps][kind] for kind, steps in scheme.history])
    march = LinearSteps.of(step_of(scheme, h), factors, h, what)
    X, after = np.empty((2, march.steps.vectors, s.size))
    X[: march.steps.given] = state
    for first in range(done, n, BLOCK):
        count = min(BLOCK, n - first)
        loads = march.loads(first, count)
        for i in range(count):
            march.complete(X, shapes, loads, i)
            yield X, march.steps
            combined(march.steps.out, X, after[: march.steps.given])
            X, after = after, X


def _with_acceleration(structure: Structure, row: Array, t: float) -> Array:
    """u, v, a (3, n) of a row that may lack a."""
    return row if len(row) == 3 else np.array([*row, structure.acceleration(t, *row)])
