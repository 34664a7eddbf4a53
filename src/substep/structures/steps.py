"""Steps of a scheme on a structure: its plan with numbers, its start, and the loads at its instants."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..core.arrays import Array
from ..core.loads import values_at
from ..core.schemes import Scheme
from .linear import Factors, LinearSystem
from .newton import Iteration, NonlinearSystem
from .plan import Steps, System, start_of, step_of
from .structure import Structure

BLOCK = 256  # steps for which the loads are sampled at once


@dataclass(frozen=True)
class StructureSteps:
    """All systems of a plan on a structure, ready to be solved step by step."""

    run: "Run"
    steps: Steps
    systems: tuple[LinearSystem | NonlinearSystem, ...]

    def loads(self, first: int, count: int) -> list[Array]:
        """For each system the sum of w g(t_n + tau h), (count, J), for the J loads and the steps n from `first` on."""
        n = np.arange(first, first + count, dtype=np.float64)
        functions = [g for _, g in self.run.structure.loads]
        found = []
        for system in self.steps.systems:
            total = np.zeros((count, len(functions)))
            for w, tau in system.loads:
                for j, g in enumerate(functions):
                    total[:, j] += w * values_at(g, (n + tau) * self.run.h)
            found.append(total)
        return found

    def complete(self, X: Array, loads: Sequence[Array], i: int, n: int) -> None:
        """Compute the unknowns of step n in X (V, n), with row i of the loads. Raises NewtonFailed."""
        shapes = self.run.shapes
        for system, solver, factors in zip(self.steps.systems, self.systems, loads, strict=True):
            load = shapes @ factors[i] if shapes.shape[1] and system.loads else None
            X[system.place] = solver.solved(X, load, (n + system.instant) * self.run.h)

    @property
    def counts(self) -> list[int]:
        """The iterations of each balance in the last step."""
        return [solver.count for system, solver in zip(self.steps.systems, self.systems, strict=True) if system.balance]


@dataclass(frozen=True)
class Run:
    """A march of a structure with a scheme in steps of h. factors: of its linear effective matrices, as far as made."""

    structure: Structure
    scheme: Scheme
    h: float
    iteration: Iteration = field(default_factory=Iteration)
    factors: Factors = field(default_factory=Factors)

    @property
    def shapes(self) -> Array:
        """The vectors of the loads (n, J)."""
        return np.array([shape for shape, _ in self.structure.loads]).reshape(-1, self.structure.size).T

    def prepared(self, steps: Steps) -> StructureSteps:
        """The plan on the structure. Raises ValueError for a singular effective matrix."""
        return StructureSteps(self, steps, tuple(self._system(system) for system in steps.systems))

    def _system(self, system: System) -> LinearSystem | NonlinearSystem:
        if self.structure.internal is not None and system.displacements:
            return NonlinearSystem(self.structure, system, self.structure.internal, self.iteration)
        return LinearSystem.of(self.structure, system, self.factors, f"a step of {self.scheme.name}")

    def marched(self, n: int, state: Array | None = None, done: int = 0) -> Iterator[tuple[Array, StructureSteps]]:
        """X (V, n), complete, of each step after the first `done` of n, and of what: steps.report @ X are u, v, a.

        X is written anew in every step. state: that after `done` steps, by default the start. Where another scheme
        marches the first steps, those are its own. Raises NewtonFailed.
        """
        if state is None and self.scheme.starter is not None:
            history = [self._given]
            lag = max(steps for _, steps in self.scheme.history)
            starter = Run(self.structure, self.scheme.starter, self.h, self.iteration, self.factors)
            for X, march in starter.marched(min(lag, n)):
                history.append(self._with_acceleration(march.steps.report @ X, len(history) * self.h))
                yield X, march
            if (done := len(history) - 1) == n:
                return
            state = np.array([history[lag - steps][kind] for kind, steps in self.scheme.history])
        march = self.prepared(step_of(self.scheme, self.h))
        X = np.empty((march.steps.vectors, self.structure.size))
        given = march.steps.given
        X[:given] = self._started() if state is None else state
        for first in range(done, n, BLOCK):
            count = min(BLOCK, n - first)
            loads = march.loads(first, count)
            for i in range(count):
                march.complete(X, loads, i, first + i)
                yield X, march
                X[:given] = march.steps.out @ X

    @property
    def _given(self) -> Array:
        return np.array([self.structure.u0, self.structure.v0, self.structure.a0])

    def _started(self) -> Array:
        """The state at t = 0 of a scheme that starts by itself."""
        start = self.prepared(start_of(self.scheme, self.h))
        X = np.empty((start.steps.vectors, self.structure.size))
        X[:3] = self._given
        start.complete(X, start.loads(0, 1), 0, 0)
        return start.steps.out @ X

    def _with_acceleration(self, row: Array, t: float) -> Array:
        """u, v, a (3, n) of a row that may lack a."""
        return row if len(row) == 3 else np.array([*row, self.structure.acceleration(t, *row)])
