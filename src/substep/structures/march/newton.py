"""Systems of a plan on a nonlinear structure: Newton's iteration, which keeps a factorization while it contracts."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...core.arrays import Array, dot
from ..model.internal_force import InternalForce
from ..model.memory import Memory, Recalled, RememberingForce
from ..model.model import Model
from ..solvers.combine import combined
from ..solvers.complementarity import NotFound
from ..solvers.factorization import SingularMatrix
from ..solvers.matrices import Matrix, combination
from .branches import Branches
from .pressing import Pressing
from .scheme_plan import Force, System

TOLERANCE = 1e-12  # of the displacement, relative to its change in the step
EXACT = 4 * np.finfo(np.float64).eps  # of the largest displacement so far
ROUNDING = 1e-9  # corrections below this that no longer shrink are rounding
CONTRACTION = 0.2  # of the corrections, beyond which the tangent is taken anew
ITERATIONS = 60
TOO_FAR, SMALL = 0.8, 0.1  # of the residual's work along a change: from which it is shortened, and to what
BALANCED = 1e-9  # of the largest force: the residual where a force of rates with a memory is met
SEARCH = 30  # trials of a shorter change
LINE = 1e-12  # of the residual before: what is left of it where all springs have stayed on their lines


@dataclass(frozen=True)
class Iteration:
    """full: take the tangent in every iteration; line_search: halve a correction that increases the residual."""

    full: bool = False
    line_search: bool = False


class Tangent(NamedTuple):
    """Where a tangent was taken: at a time, for v and displacements (1 + P, n); largest: displacement until then."""

    t: float
    at: Array
    largest: float


class NewtonFailed(NotFound):
    """An iteration that did not converge."""


@dataclass(eq=False)
class NonlinearSystem:
    """R(z) = M a + C v + K0 x + sum of w N(u) - load = 0, with a, v, x and u affine in the unknown z.

    count: the iterations of the last solution, 0 for an explicit system. solve: the factorization in use; taken: the
    time, and v and displacements (1 + P, n), at which its tangent was taken, if it has one.

    memories: what the internal force remembers, after each commit of the step so far; empty where it remembers nothing.
    Where it does, each iteration takes its tangent, which is that of a branch: a march then goes on to the bit wherever
    it is broken. shortened: of all solutions, the corrections that had gone too far. branches: the factors there;
    released: without the slopes of springs by rates. before: of rows of the system, by their identity, what they have
    of the vectors before the unknown.
    """

    structure: Model
    system: System
    internal: InternalForce | RememberingForce
    iteration: Iteration
    memories: list[Memory]
    count: int = 0
    shortened: int = 0
    solve: Callable[[Array], Array] | None = None
    taken: tuple[float, Array] | None = None
    largest: float = 0.0
    products: dict[str, Matrix] = field(default_factory=dict)
    before: dict[int, Array] = field(default_factory=dict)
    branches: Branches | None = None
    released: bool = False
    scale = 1.0  # what its loads are divided by

    def __post_init__(self) -> None:
        self.products = {"inertia": self.structure.M, "damping": self.structure.damping, "stiffness": self.structure.K}

    @property
    def place(self) -> int:
        """The place of the unknown among the vectors."""
        return self.system.place

    @property
    def explicit(self) -> bool:
        """Whether the internal force does not depend on the unknown."""
        return not self.system.moves_force(self.internal.reads > 1)

    @property
    def tangent(self) -> Tangent | None:
        """The tangent in use, if there is one."""
        return None if self.taken is None or self.internal.remembers else Tangent(*self.taken, self.largest)

    def keep(self, tangent: Tangent) -> None:
        """Go on with a tangent that was in use before."""
        t, at, self.largest = tangent
        self.taken, self.solve = (t, at), self._factorized(t, at)

    def put(self, X: Array, load: Array | None, t: float, ahead: int = 0, pressing: Pressing | None = None) -> None:
        """Put the unknown in its place of X (V, n), under a load (n,); nothing of it is known ahead.

        pressing: contacts, which are solved for too. Raises NewtonFailed; t is the time at which the force is taken, if
        it depends on it.
        """
        if pressing is not None:
            pressing.begin()
        X[self.place] = self._solved(X, load, t, pressing)
        if pressing is not None:
            pressing.finish(X)

    def taken_at(self, X: Array) -> tuple[Array, Array | None]:
        """u and v, None where it takes none, at which a complete X (V, n) has the last of its forces."""
        self.before.clear()
        row, velocity = self.system.displacements[-1], self.system.velocity
        u, v = (self._at(x, X, X[self.place] if x[self.place] else None) for x in (row, velocity))
        return u, v if velocity.any() else None

    def _solved(self, X: Array, load: Array | None, t: float, pressing: Pressing | None) -> Array:
        self.before.clear()
        known = self._linear(X) - (0.0 if load is None else load)
        if self.explicit:
            self.count = 0
            if self.solve is None:
                self.solve = self._factorized()
            z = -self.solve(known + self._force(X, None, t))
            return z if pressing is None else pressing.settled(X, z, self.solve)
        return self._iterated(X, known, t, pressing)

    def _iterated(self, X: Array, known: Array, t: float, pressing: Pressing | None = None) -> Array:
        row, reach, z = self._displaced(), self._reach or 1.0, self._begun(X)
        residual = self._residual(X, z, known, t)
        self.released = False
        previous, fresh = 0.0, False  # the size of the correction before, 0 if it was another tangent's
        for self.count in range(1, ITERATIONS + 1):
            if self.solve is None or self.iteration.full or self.internal.remembers:
                self.taken = t, np.array(self._where(X, z))
                try:
                    self.solve, fresh = self._factorized(*self.taken), True
                except ValueError as error:
                    if self.count == 1 or not isinstance(error.__cause__, SingularMatrix):
                        raise  # at the last good state the structure itself is undetermined
                    break
            before, change = residual, -self.solve(residual)
            if pressing is not None and (more := pressing.more(X, z + change, self.solve)) is not None:
                change, residual, known = change + more[0], residual + more[1], known + more[1]
            z, residual, change = self._moved(X, z, change, residual, known, t)
            size = reach * float(np.abs(change).max())
            u = self._at(row, X, z)
            self.largest = max(self.largest, float(np.abs(u).max()))
            within = max(TOLERANCE * float(np.abs(u - X[0]).max()), EXACT * self.largest)
            if not np.isfinite(size + np.abs(residual).max()):
                break
            kept = pressing is None or pressing.kept(X, z)
            if kept and self._on_lines(X, z, t, residual, before):
                return z
            rate = size / previous if previous else 1.0
            left = size * min(1.0, rate / (1.0 - rate)) if rate < 1.0 else size  # of a series that shrinks so
            small = left <= within or (self.internal.remembers and np.array_equal(z, z - change))  # z's rounding
            slow = previous and rate >= 0.5 and size <= ROUNDING * self.largest
            if (small or slow) and kept and not self._unbalanced(residual, known, z):
                return z
            self.released = small
            if previous and rate > CONTRACTION and not fresh:
                self.solve, previous = None, 0.0
            else:
                previous, fresh = size, False
        self.solve = None
        raise NewtonFailed

    def _moved(
        self, X: Array, z: Array, change: Array, old: Array, known: Array, t: float
    ) -> tuple[Array, Array, Array]:
        """z + change, the residual there, and the change; halved while a line search finds the residual grown.

        With a memory the change is shortened where the residual's work along it says that it has gone too far.
        """
        residual = self._residual(X, z + change, known, t)
        if self.internal.remembers:
            size = self._reach * float(np.abs(change).max())
            if size > (EXACT if self.internal.reads > 1 else ROUNDING) * self.largest:
                change, residual = self._not_too_far(X, z, change, old, residual, known, t)
            return z + change, residual, change
        for _ in range(8 if self.iteration.line_search else 0):
            if dot(residual, residual) <= dot(old, old):  # not where it is NaN
                break
            change = 0.5 * change
            residual = self._residual(X, z + change, known, t)
        return z + change, residual, change

    def _not_too_far(
        self, X: Array, z: Array, change: Array, old: Array, residual: Array, known: Array, t: float
    ) -> tuple[Array, Array]:
        """The change, and the residual after it, or a part of it where full changes may cycle between two branches.

        Of a structure with positive slopes the residual is the slope of a convex function, and a change goes down it.
        It has gone too far where the residual's work along it has changed sign and is as large as before: then the
        part of it is sought for which that work is small, by false position (Illinois).
        """
        before, after = dot(change, old), dot(change, residual)
        if not (before < 0.0 and after > -TOO_FAR * before):
            return change, residual
        self.shortened += 1
        part, low, high, at_low, at_high = 1.0, 0.0, 1.0, before, after
        for _ in range(SEARCH):
            part = low - at_low * (high - low) / (at_high - at_low)
            residual = self._residual(X, z + part * change, known, t)
            here = dot(change, residual)
            if abs(here) <= SMALL * abs(before):
                break
            if here < 0.0:
                low, at_low, at_high = part, here, 0.5 * at_high
            else:
                high, at_high, at_low = part, here, 0.5 * at_low
        return part * change, residual

    def _displaced(self) -> Array:
        """The row of the displacement that moves most with the unknown."""
        return max(self.system.displacements, key=lambda row: abs(row[self.place]))

    @property
    def _reach(self) -> float:
        """How far the unknown moves that displacement."""
        return abs(float(self._displaced()[self.place]))

    def _begun(self, X: Array) -> Array:
        """Where the iteration starts: with that displacement, if it moves, at `System.begin` or the last position."""
        row, j = self._displaced(), self.place
        begin = combined(self.system.begin[None, :j], X[:j])[0] if self.internal.remembers else X[0]
        return (begin - combined(row[None, :j], X[:j])[0]) / row[j] if row[j] else np.zeros(X.shape[1])

    def _where(self, X: Array, z: Array) -> list[Array]:
        """Where tangents are taken: for v and displacements."""
        return [self._at(self.system.velocity, X, z), *self._displacements(X, z)]

    def _linear(self, X: Array) -> Array:
        """What matrices multiply of the vectors before the unknown."""
        total = np.zeros(X.shape[1])
        for name, matrix in self.products.items():
            if (row := getattr(self.system, name)[: self.place]).any():
                total += matrix @ combined(row[None], X[: self.place])[0]
        return total

    def _residual(self, X: Array, z: Array, known: Array, t: float) -> Array:
        for factor, matrix in self._by_unknown:
            known = known + matrix @ (factor * z)
        return known + self._force(X, z, t)

    @cached_property
    def _by_unknown(self) -> list[tuple[float, Matrix]]:
        """The matrices that multiply the unknown, with their factors."""
        factors = ((float(getattr(self.system, name)[self.place]), matrix) for name, matrix in self.products.items())
        return [(factor, matrix) for factor, matrix in factors if factor != 0.0]

    def _at(self, row: Array, X: Array, z: Array | None) -> Array:
        j = self.place
        if (found := self.before.get(id(row))) is None:
            found = self.before[id(row)] = combined(row[None, :j], X[:j])[0]
        return found if z is None else found + row[j] * z

    def _force(self, X: Array, z: Array | None, t: float) -> Array:
        s = self.system
        v = self._at(s.velocity, X, z)
        total = np.zeros(X.shape[1])
        for force in s.forces:
            total += force.w * self.internal(t, self._at(force.u, X, z), v, self._recalled(force))
        for w, old, new in s.differences:
            both = self._at(old, X, z), self._at(new, X, z)
            total += w * self.internal.discrete_gradient(t, *both, v, self.structure.M)
        return total

    def _displacements(self, X: Array, z: Array) -> list[Array]:
        """Where the tangents are taken of which the residual's derivative by z consists.

        Of a discrete gradient the tangent at the midpoint stands for its own.
        """
        s = self.system
        found = [self._at(force.u, X, z) for force in self._moving]
        found += [0.5 * (self._at(old, X, z) + self._at(new, X, z)) for _, old, new in s.differences]
        return found or [self._at(s.forces[0].u, X, z)]  # where z moves velocities alone

    @cached_property
    def _moving(self) -> list[Force]:
        """The forces that move with the unknown."""
        return [force for force in self.system.forces if force.u[self.place] != 0.0]

    def _recalled(self, force: Force) -> Recalled | None:
        """What it is taken from, if the internal force has a memory."""
        return Recalled(self.memories[force.place], force.since) if self.internal.remembers else None

    def _factorized(self, t: float = 0.0, at: Array | None = None) -> Callable[[Array], Array]:
        """The factors of the residual's derivative by z; at: v and `_displacements`, none for an explicit system."""
        if at is None or (slopes := self._of_springs(t, at)) is None:
            return self._of_derivative(t, at)
        if self.branches is None:
            force = self.internal
            assert isinstance(force, RememberingForce)
            assert force.springs is not None
            first = sum((self._slopes(one, force.springs.elastic, 0.0) for one in self._moving), 0.0 * slopes)
            self.branches = Branches(force.springs, hasattr(self.structure.M, "indptr"), self._with_springs, first)
        return self.branches.of(slopes)

    def _of_springs(self, t: float, at: Array) -> Array | None:
        """The derivative of the residual by z that springs give (s,); None where a material adds to it."""
        force = self.internal
        if not isinstance(force, RememberingForce) or force.springs is None or force.material is not None:
            return None
        total = np.zeros(force.springs.size)
        for one, u in zip(self._moving or self.system.forces[:1], at[1:], strict=True):
            found = force.answer(t, u, at[0], self._recalled(one)).of_springs
            assert found is not None
            total += self._slopes(one, found.tangent, 0.0 if self.released else found.damping)
        return total

    def _on_lines(self, X: Array, z: Array, t: float, residual: Array, before: Array) -> bool:
        """Whether the change was that of a linear system: no slope of a spring is another one, and nothing is left."""
        if self.branches is None or np.abs(residual).max() > LINE * np.abs(before).max():
            return False
        at = np.array(self._where(X, z))
        return self.branches.last is not None and np.array_equal(self._of_springs(t, at), self.branches.last)

    def _unbalanced(self, residual: Array, known: Array, z: Array) -> bool:
        """Whether the residual of a force of rates is more than rounding, however small the last correction was.

        So it is where a damper |v|^x, x < 1, is at rest, whose slope is infinite there: the next correction is without
        the slopes by rates, and it is shortened as it needs to be.
        """
        if self.branches is None or self.internal.reads < 2:
            return False
        return self._left(residual, [known, *(matrix @ (factor * z) for factor, matrix in self._by_unknown)])

    def _left(self, residual: Array, parts: Sequence[Array]) -> bool:
        """Whether the residual is more than rounding of these parts of it and of the internal force."""
        rounding = 16 * EXACT * self.largest * float(np.abs(self.structure.K.diagonal()).max())
        allowed = BALANCED * sum(float(np.abs(part).max()) for part in parts) + rounding
        return float(np.abs(residual).max()) > allowed

    def _slopes(self, force: Force, tangent: Array, damping: Any) -> Array:
        """The derivative of the residual by z that springs give by one force, for each of them (s,)."""
        j = self.place
        return force.w * force.u[j] * tangent + self.system.damping[j] * damping

    def _with_springs(self, d: Array) -> Callable[[Array], Array]:
        """The factors of the residual's derivative where that of springs is B^T diag(d) B."""
        force = self.internal
        assert isinstance(force, RememberingForce)
        assert force.springs is not None
        terms = [*self._by_unknown, (1.0, force.springs.matrix(d))]
        if force.K is not None:
            terms.append((sum(float(one.w * one.u[self.place]) for one in self._moving), force.K))
        return self.structure.factorized(combination(terms), "a Newton iteration")

    def _of_derivative(self, t: float, at: Array | None) -> Callable[[Array], Array]:
        """The same from the matrices that the internal force gives."""
        s, j = self.system, self.place
        terms = [(float(getattr(s, name)[j]), matrix) for name, matrix in self.products.items()]
        if at is not None:
            weights = [force.w * force.u[j] for force in self._moving]
            weights += [0.5 * w * new[j] for w, _, new in s.differences]
            recalled = [self._recalled(force) for force in self._moving] + [None] * len(s.differences)
            recalled = recalled or [self._recalled(s.forces[0])]
            for weight, u, memory in zip(weights or [0.0], at[1:], recalled, strict=True):
                K, C = self.internal.stiffness(t, u, at[0], memory)
                terms.append((weight, K))
                if C is not None:
                    terms.append((float(s.damping[j]), C))
        return self.structure.factorized(combination(terms), "a Newton iteration")
