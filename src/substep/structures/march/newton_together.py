"""Balances of a nonlinear structure that are solved together: Newton's iteration with the tangents of all of them.

The derivative of the residuals by the unknowns is a matrix of s x s blocks, one for each balance and each unknown. It
is not taken apart as that of a linear structure, since the tangents of the balances differ.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...core.arrays import Array
from ..model.memory import Memory
from ..model.model import Model
from ..solvers.combine import combined
from ..solvers.matrices import Matrix, combination
from .newton import Iteration, NonlinearSystem
from .pressing import Pressing
from .scheme_plan import System


@dataclass(eq=False)
class NonlinearTogether(NonlinearSystem):
    """All systems that are solved together, `system` being the last one; z: their unknowns (s n,), one after another.

    offsets: of the times at which they take the force, from that of the last one, s.
    """

    group: Sequence[System] = ()
    offsets: Sequence[float] = ()

    @classmethod
    def of(
        cls, structure: Model, group: Sequence[System], h: float, iteration: Iteration, memories: list[Memory]
    ) -> "NonlinearTogether":
        """From systems of a plan, with a step of h, s. Raises ValueError for a discrete gradient."""
        assert structure.internal is not None
        if any(system.differences for system in group):
            raise ValueError(
                "expected no discrete gradient in balances that are solved together, got one; write each of them as a "
                "balance of its own, or march a scene"
            )
        offsets = [h * (system.instant - group[-1].instant) for system in group]
        return cls(structure, group[-1], structure.internal, iteration, memories, group=group, offsets=offsets)

    @property
    def unknowns(self) -> slice:
        """The places of the unknowns."""
        return self.system.unknowns

    def begin(self, X: Array) -> None:
        """Put into the unknowns' places of X (V, n) what matrices give of the vectors before them, with the sign of a
        load."""
        first = self.unknowns.start
        for system in self.group:
            X[system.place] = 0.0
            for name, matrix in self.products.items():
                if (row := getattr(system, name)[:first]).any():
                    X[system.place] -= matrix @ combined(row[None], X[:first])[0]

    def put(self, X: Array, load: Array | None, t: float, ahead: int = 0, pressing: Pressing | None = None) -> None:
        """Put the unknowns in place of what `begin` and loads have put there. Raises NewtonFailed."""
        if load is not None:
            X[self.place] += load
        if pressing is not None:
            pressing.begin()
        self.before.clear()
        known = -X[self.unknowns].ravel()
        X[self.unknowns] = self._iterated(X, known, t, pressing).reshape(len(self.group), -1)

    def taken_at(self, X: Array) -> tuple[Array, Array | None]:
        """As of a single system, at the last one."""
        u, v = combined(np.array([self.system.displacements[-1], self.system.velocity]), X)
        return u, v if self.system.velocity.any() else None

    def _displaced(self) -> Array:
        rows = [row for system in self.group for row in system.displacements]
        return max(rows, key=lambda row: float(np.abs(row[self.unknowns]).sum()))

    @property
    def _reach(self) -> float:
        return float(np.abs(self._displaced()[self.unknowns]).sum())

    def _begun(self, X: Array) -> Array:
        """With all displacements that move at the last position, where there are as many as unknowns."""
        first, rows = self.unknowns.start, np.array([row for s in self.group for row in s.displacements])
        rows = np.unique(rows[rows[:, self.unknowns].any(axis=1)], axis=0)
        by_z = rows[:, self.unknowns]
        if len(rows) != len(self.group) or np.linalg.matrix_rank(by_z) < len(rows):
            return np.zeros(len(self.group) * X.shape[1])
        away = X[0] - combined(rows[:, :first], X[:first])
        return combined(np.linalg.inv(by_z), away).ravel()

    def _where(self, X: Array, z: Array) -> list[Array]:
        return [self._at(row, X, z) for s in self.group for row in (s.velocity, *(force.u for force in s.forces))]

    def _at(self, row: Array, X: Array, z: Array | None) -> Array:
        first = self.unknowns.start
        if (found := self.before.get(id(row))) is None:
            found = self.before[id(row)] = combined(row[None, :first], X[:first])[0]
        assert z is not None
        return found + combined(row[None, self.unknowns], z.reshape(len(self.group), -1))[0]

    def _residual(self, X: Array, z: Array, known: Array, t: float) -> Array:
        total = (known + self._by_matrices(z)).reshape(len(self.group), -1)
        for k, (system, offset) in enumerate(zip(self.group, self.offsets, strict=True)):
            v = self._at(system.velocity, X, z)
            for force in system.forces:
                u = self._at(force.u, X, z)
                total[k] += force.w * self.internal(t + offset, u, v, self._recalled(force))
        return total.ravel()

    def _by_matrices(self, z: Array) -> Array:
        """What matrices give of the unknowns."""
        Z = z.reshape(len(self.group), -1)
        total = np.zeros_like(Z)
        for k, system in enumerate(self.group):
            for name, matrix in self.products.items():
                if (factors := getattr(system, name)[self.unknowns]).any():
                    total[k] += matrix @ combined(factors[None], Z)[0]
        return total.ravel()

    def _unbalanced(self, residual: Array, known: Array, z: Array) -> bool:
        return (
            self.internal.remembers and self.internal.reads > 1 and self._left(residual, [known, self._by_matrices(z)])
        )

    def _factorized(self, t: float = 0.0, at: Array | None = None) -> Callable[[Array], Array]:
        """The factors of the residuals' derivative by all unknowns; at: v and displacements of each system."""
        assert at is not None
        where, blocks = iter(at), list[list[Matrix]]()
        for system, offset in zip(self.group, self.offsets, strict=True):
            terms = [(getattr(system, name), matrix) for name, matrix in self.products.items()]
            v = next(where)
            for force in system.forces:
                K, C = self.internal.stiffness(t + offset, next(where), v, self._recalled(force))
                terms.append((force.w * force.u, K))
                if C is not None and not self.released:
                    terms.append((force.w * system.velocity, C))
            places = range(self.unknowns.start, self.unknowns.stop)
            blocks.append([combination([(float(row[j]), matrix) for row, matrix in terms]) for j in places])
        n = self.structure.size
        places = np.tile(np.arange(n), len(self.group))
        return self.structure.factorized(_whole(blocks, n), "a Newton iteration", places)


def _whole(blocks: list[list[Matrix]], n: int) -> Matrix:
    """The matrix of blocks (n, n), None for zeros. Raises ValueError for one that is neither dense nor sparse."""
    from scipy import sparse  # noqa: PLC0415 (slow to import)

    every = [block for row in blocks for block in row if block is not None]
    if other := [block for block in every if not (isinstance(block, np.ndarray) or sparse.issparse(block))]:
        raise ValueError(
            "expected damping and tangents as dense or sparse matrices where balances of a nonlinear structure are "
            f"solved together, got {type(other[0]).__name__}, of modal damping or known by its products; give C and "
            "the tangent as matrices, or take another scheme, such as sdirk4"
        )
    if any(sparse.issparse(block) for block in every):
        return sparse.block_array(blocks, format="csr")
    return np.block([[np.zeros((n, n)) if block is None else block for block in row] for row in blocks])
