"""The step of a declaration on many linear structures at once, in NumPy: all its equations as one block system."""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from substep_derive import Scheme
from substep_derive.declare.symbols import K0, C, M, N, N_discrete, h, kind_of, knot_of, steps_back, successor
from sympy import Expr, Rational, Symbol, cancel, fraction

Array = np.ndarray[Any, Any]


class Blocks:
    """M, h C and h^2 K (P, n, n) of P structures, with h = 1; parameters: numbers for a scheme's symbols."""

    def __init__(
        self, scheme: Scheme, parameters: Mapping[Symbol, float], structures: tuple[Array, Array, Array]
    ) -> None:
        exact = {s: Rational(float(value)) for s, value in parameters.items()}  # so that equal factors cancel
        self.scheme, self.values, self.structures = scheme, {h: 1, **exact}, structures
        self.P, self.n = structures[0].shape[:2]

    def _linear(self, e: Expr) -> Array:
        parts = [float(e.coeff(x).subs(self.values)) for x in (M, C, K0)]
        return sum(
            (c * matrix for c, matrix in zip(parts, self.structures, strict=True)), np.zeros((self.P, self.n, self.n))
        )

    def coefficient(self, e: Expr) -> Array:
        """A coefficient (P, n, n): a number, or den^-1 num with both linear in the matrices."""
        if not e.has(M, C, K0):
            return np.broadcast_to(float(e.subs(self.values)) * np.eye(self.n), (self.P, self.n, self.n))
        num, den = (part.expand() for part in fraction(cancel(e.subs(self.values))))
        if not den.has(M, C, K0):
            return self._linear(num / den)
        return np.linalg.solve(self._linear(den), self._linear(num))

    def amplification(self) -> Array:
        """A (P, m n, m n) of x_1 = A x_0, x the old symbols that a step reads."""
        unknowns, state, n = self.scheme.unknowns, self.scheme.state, self.n
        place = {s: slice(i * n, (i + 1) * n) for i, s in enumerate([*unknowns, *state])}
        system = np.zeros((self.P, len(unknowns) * n, len(place) * n))
        equations: list[list[tuple[Array, Expr]]] = []
        one = self.coefficient(Symbol("one") / Symbol("one"))
        for symbol, e in self.scheme.relations.items():
            equations.append([(one, symbol - e)])
        for b in self.scheme.balances:
            force = b.force.replace(N, lambda u: u).replace(N_discrete, lambda u, w: (u + w) / 2)
            equations.append([*zip(self.structures, (b.inertia, b.damping, force), strict=True)])
        for i, terms in enumerate(equations):
            for factor, e in terms:
                for s in (s for s in e.free_symbols if knot_of(s)):
                    system[:, i * n : (i + 1) * n, place[s]] += factor @ self.coefficient(e.expand().coeff(s))
        split = len(unknowns) * n
        new = -np.linalg.solve(system[:, :, :split], system[:, :, split:])
        known = np.concatenate(
            [new, np.broadcast_to(np.eye(len(state) * n), (self.P, len(state) * n, len(state) * n))], 1
        )
        return np.concatenate([known[:, place[successor(s)]] for s in state], 1)

    def without_rigid(self, A: Array, rigid: int) -> Array:
        """A on differences of displacements in the last `rigid` coordinates, on which K is 0: they move freely."""
        n, state = self.n, self.scheme.state
        displacements = sorted((i for i, s in enumerate(state) if kind_of(s) == 0), key=lambda i: steps_back(state[i]))
        T = np.eye(len(state) * n)
        for newer, older in pairwise(displacements):
            T[older * n : (older + 1) * n, newer * n : (newer + 1) * n] = -np.eye(n)
        kept = np.delete(np.arange(len(T)), displacements[0] * n + np.arange(n - rigid, n))
        return (T @ A @ np.linalg.inv(T))[:, kept][:, :, kept]


def random_structures(rng: Any, count: int, n: int, rigid: int) -> tuple[Array, Array, Array]:
    """M > 0, C >= 0 of a random rank, not proportional, K >= 0 that is 0 on the last `rigid` coordinates."""

    def positive(rank: int, size: int, spread: float) -> Array:
        x = rng.normal(size=(count, size, rank)) * 10 ** (spread * rng.uniform(-1, 1, size=(count, 1, rank)))
        return x @ x.transpose(0, 2, 1)

    K = np.zeros((count, n, n))
    K[:, : n - rigid, : n - rigid] = positive(n - rigid, n - rigid, 1.0) + 0.01 * np.eye(n - rigid)
    return positive(n, n, 0.3) + 0.3 * np.eye(n), positive(int(rng.integers(1, n + 1)), n, 1.5), K
