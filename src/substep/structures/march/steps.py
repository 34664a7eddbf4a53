"""Steps of a scheme on a structure: its plan with numbers, its start, and the loads at its instants."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.loads import Load, values_at
from ...core.schemes import Scheme
from ...run.clock import AT_ZERO, Begin
from ..model.contacts import Contacts
from ..model.memory import Memory, Recalled, RememberingForce
from ..model.model import Model
from ..solvers.combine import combined
from .linear import Factors, LinearSystem
from .newton import Iteration, NonlinearSystem, Tangent
from .newton_together import NonlinearTogether
from .pressing import Pressing
from .reacting import pressed
from .scheme_plan import Steps, System, start_of
from .together import Joined, Together
from .velocity import Watch

Solver = LinearSystem | NonlinearSystem | Joined | Together


@dataclass(frozen=True)
class StructureSteps:
    """All systems of a plan on a structure, ready to be solved step by step; repeated: see `Steps`.

    watch: what looks at the internal force after a step, if need be. memories: what the internal force remembers at the
    start of the step and after each of its commits so far; empty where it remembers nothing. pressings: the contacts in
    each system, None where there are none.
    """

    run: "Run"
    steps: Steps
    systems: tuple[Solver, ...]
    repeated: int | None
    watch: Watch | None
    memories: list[Memory]
    pressings: tuple[Pressing | None, ...] = ()

    def loads(self, first: int, count: int) -> list[Array]:
        """For each system the sum of w g(t_n + tau h), (count, J), for the J loads and the steps n from `first` on."""
        run, n = self.run, np.arange(first, first + count)
        functions = [g for _, g in run.loads]
        found = []
        for system in self.steps.systems:
            total = np.zeros((count, len(functions)))
            for w, tau in system.loads:
                for j, g in enumerate(functions):
                    total[:, j] += w * values_at(g, run.begin.time(run.h, n, tau))
            found.append(total)
        return found

    @cached_property
    def ahead(self) -> Array:
        """Rows (S, given) of what the first system takes of the state, if no more than there are unknowns."""
        for first in self.systems[:1] if self.repeated is None else ():
            if isinstance(first, LinearSystem) and len(first.rows) <= len(self.systems):
                return first.rows
        return np.empty((0, self.steps.given))

    def begin(
        self, X: Array, state: Array, memory: Memory | None = None, reactions: Array | None = None,
        stands: Sequence[Array] = (),
    ) -> None:  # fmt: skip
        """Put the state into X (V, n), and behind it, in the unknowns' places, what the first system takes.

        memory: what the internal force remembers there; reactions: those there, or stands, as another march has them.
        By default what the run begins with.
        """
        if self.run.memory is not None:
            self.memories[:] = [self.run.memory if memory is None else memory]
        reactions = self.run.reactions if reactions is None else reactions
        if reactions is not None and (last := self.last_pressing) is not None:
            last.resume(reactions, self.steps.rows["u_0"][: len(state)] @ state)
            if len(stands):
                last.go_on(*stands)
        given = self.steps.given
        X[:given] = state
        combined(self.ahead, X[:given], X[given : given + len(self.ahead)])

    def advance(self, X: Array, after: Array) -> None:
        """Begin the next step in `after` from a complete X; block by block, so that the new state is read from caches.

        The same to the bit as `begin` with that state; a repeated unknown is there already.
        """
        self.memories[:-1] = []
        combined(self.steps.out, X, after[: self.steps.given + len(self.ahead)], then=self.ahead)
        if self.repeated is not None:
            after[self.steps.given] = X[self.repeated]

    def complete(self, X: Array, loads: Sequence[Array], times: Sequence[float], *, advanced: bool = False) -> None:
        """Compute the unknowns of a step that has begun, with the loads (J,) and the mean instant of each system.

        advanced: whether it began by `advance`. Raises NewtonFailed.
        """
        shapes, cases, ahead = self.run.shapes, self.run.by_case, len(self.ahead)
        known = self.steps.given if advanced and self.repeated is not None else None
        solvers = zip(self.steps.systems, self.systems, self.pressings, loads, times, strict=True)
        for system, solver, pressing, values, t in solvers:
            if system.place == known:
                continue
            load = None
            if shapes.shape[1] and system.loads:
                factors = values / solver.scale
                load = combined(factors[None], shapes.T)[0] if cases is None else shapes @ (factors[:, None] * cases)
            if pressing is not None:
                load = pressing.loaded(load, solver.scale)
            solver.put(X, load, t, ahead, pressing)
            ahead = 0
            for u, v, since in system.commits if self.memories else ():
                self._commit(*combined(np.array([u, v]), X), since, t)

    @property
    def last_pressing(self) -> Pressing | None:
        """The contacts or constraints of the last balance that has any."""
        return next((x for x in reversed(self.pressings) if x is not None), None)

    def touched(self, X: Array) -> Array:
        """Of contacts the mean reactions of a complete step, or the last that are remembered, and the gaps, (2, d).

        Of constraints the last multipliers, and what is left of g.
        """
        contacts = self.run.structure.contacts
        assert contacts is not None
        each = [(x.touch.share, x.p) for x in self.pressings if x is not None]
        shared = each[-1][1] if contacts.remembered else sum((w * p for w, p in each), np.zeros(contacts.size))
        if isinstance(contacts, Contacts):
            shared = contacts.reported(shared)
        return np.array([shared, contacts.gaps(combined(self.steps.report[:1], X)[0])])

    def commit(self, X: Array, t: float) -> None:
        """Commit what the internal force remembers at the end of a complete step, at the time t, s."""
        if self.memories:
            self._commit(*combined(self.steps.report[:2], X), self.steps.since, t)

    def _commit(self, u: Array, v: Array, since: float, t: float) -> None:
        force = self.run.structure.internal
        assert isinstance(force, RememberingForce)
        self.memories.append(force.committed(t, u, v, Recalled(self.memories[-1], since)))

    def look(self, X: Array, times: Sequence[float]) -> None:
        """Look at the internal force where the last system of a step, with X complete, has taken it; see `Watch`."""
        for t, solver in list(zip(times, self.systems, strict=True))[::-1] if self.watch is not None else ():
            if isinstance(solver, NonlinearSystem) and self.watch is not None:
                u, v = solver.taken_at(X)
                self.watch.look(t, u, combined(self.steps.report[1:2], X)[0] if v is None else v)
                return

    def times(self, first: int, count: int) -> list[list[float]]:
        """For each of the steps from `first` on, all of one length, the mean instant of the loads of each system."""
        run, n = self.run, np.arange(first, first + count)
        found = [run.begin.time(run.h, n, system.instant) for system in self.steps.systems]
        return np.reshape(found, (-1, count)).T.tolist()

    @property
    def memory(self) -> Memory | None:
        """What the internal force remembers, as it was last committed; None where it remembers nothing."""
        return self.memories[-1] if self.memories else None

    @property
    def shortened(self) -> int:
        """How many corrections of Newton's iteration had gone too far in all steps so far, and were shortened."""
        return sum(solver.shortened for solver in self.systems if isinstance(solver, NonlinearSystem))

    @property
    def tangents(self) -> list[Tangent | None]:
        """The tangents that the systems keep, as far as they do."""
        return [solver.tangent for solver in self.systems]

    @property
    def counts(self) -> list[int]:
        """The iterations of each balance in the last step; of those that are solved together, at the first one."""
        pairs = zip(self.steps.systems, self.systems, strict=True)
        return [solver.count if x.place == x.unknowns.start else 0 for x, solver in pairs if x.balance]


@dataclass(frozen=True)
class Run:
    """A march of a structure with a scheme in steps of h. factors: of its linear effective matrices, as far as made.

    cases: L structures that differ in their loads only, which are marched at once: vectors are then (n, L). begin:
    where the steps begin, with rows (S, n) of the state where the scheme does not start anew; start (3, n): u, v, a
    there, in place of the structure's; remembered: what its internal force remembers there, in its place too; reactions
    (d,): those of contacts there, None without contacts.
    """

    structure: Model
    scheme: Scheme
    h: float
    iteration: Iteration = field(default_factory=Iteration)
    factors: Factors = field(default_factory=Factors)
    cases: tuple[Model, ...] = ()
    begin: Begin = AT_ZERO
    start: Array | None = None
    remembered: Memory | None = None
    reactions: Array | None = None

    def time(self, steps: Any) -> Any:
        """The time after so many steps, s, a number or an array."""
        return self.begin.time(self.h, steps)

    @cached_property
    def loads(self) -> tuple[tuple[Array, Load], ...]:
        """The J loads of all cases, one after another."""
        return tuple(load for s in self.cases or (self.structure,) for load in s.loads)

    @cached_property
    def shapes(self) -> Array:
        """The vectors of the loads (n, J)."""
        return np.array([shape for shape, _ in self.loads]).reshape(-1, self.structure.size).T

    @cached_property
    def by_case(self) -> Array | None:
        """1 where a load (J,) belongs to a case (L,); None where there are no cases."""
        if not self.cases:
            return None
        whose = [case for case, s in enumerate(self.cases) for _ in s.loads]
        return np.equal.outer(whose, np.arange(len(self.cases))).astype(np.float64)

    @property
    def memory(self) -> Memory | None:
        """What the internal force remembers where the steps begin; None where it remembers nothing."""
        return self.structure.memory0 if self.remembered is None else self.remembered

    def prepared(self, steps: Steps) -> StructureSteps:
        """The plan on the structure. Raises ValueError for a singular effective matrix."""
        before, repeated, memories = steps, steps.repeated, list[Memory]()
        systems = tuple(
            solver
            for group in steps.groups
            for solver in self._solvers(group, group[-1] is steps.systems[-1] and group[0].place != repeated, memories)
        )
        for solver in systems[-1:]:
            if isinstance(solver, LinearSystem):
                steps = steps.less(solver.rest)
        watch = Watch.of(self.structure, self.scheme, steps)
        steps, pressings = pressed(self.structure, steps, before)
        return StructureSteps(self, steps, systems, repeated, watch, memories, pressings)

    def _solvers(self, group: Sequence[System], last: bool, memories: list[Memory]) -> Sequence[Solver]:
        """Of systems that are solved together, the last of the step or not."""
        if len(group) > 1:
            if self.structure.internal is not None:
                whole = NonlinearTogether.of(self.structure, group, self.h, self.iteration, memories)
            else:
                whole = Together.of(self.structure, group, self.factors, self.scheme.name)
            return [*(Joined(system.place, whole) for system in group[:-1]), whole]
        return [self._solver(group[0], last, memories)]

    def _solver(self, system: System, last: bool, memories: list[Memory]) -> LinearSystem | NonlinearSystem:
        if self.structure.internal is not None and system.displacements:
            return NonlinearSystem(self.structure, system, self.structure.internal, self.iteration, memories)
        return LinearSystem.of(self.structure.at_start, system, last, self.factors, f"a step of {self.scheme.name}")

    @property
    def given(self) -> Array:
        """u, v, a where the steps begin, (3, n) or (3, n, L)."""
        if self.start is not None:
            return self.start
        s = self.structure
        if not self.cases or s.a0_given is not None:
            start = np.array([s.u0, s.v0, s.a0])
            return np.repeat(start[..., None], len(self.cases), axis=-1) if self.cases else start
        return np.stack([self._moved(case, 0.0, s.u0, s.v0) for case in self.cases], axis=-1)

    @property
    def touched(self) -> Array:
        """Of contacts or constraints the reactions where the steps begin, and the gaps, as they are reported (2, d)."""
        contacts = self.structure.contacts
        assert contacts is not None
        assert self.reactions is not None
        first = contacts.reported(self.reactions) if isinstance(contacts, Contacts) else self.reactions
        return np.array([first, contacts.gaps(self.given[0])])

    def room(self, steps: Steps) -> Array:
        """Memory for the vectors of a step, (V, n) or (V, n, L)."""
        return np.empty((steps.vectors, self.structure.size, *([len(self.cases)] if self.cases else [])))

    def started(self) -> Array:
        """The state at the start of a scheme that starts by itself."""
        if self.scheme.info.start == "given":
            return self.given[[kind for kind, _ in self.scheme.history]]
        start = self.prepared(start_of(self.scheme, self.h))
        X = self.room(start.steps)
        start.begin(X, self.given)
        start.complete(X, [rows[0] for rows in start.loads(0, 1)], start.times(0, 1)[0])
        return combined(start.steps.out, X)

    def with_acceleration(self, row: Array, t: float, memory: Memory | None) -> Array:
        """u, v, a (3, n) of a row that may lack a; memory: what the internal force remembers there."""
        if len(row) == 3:
            return row
        if not self.cases:
            return self._moved(self.structure, t, *row, memory)
        columns = zip(self.cases, np.moveaxis(row, -1, 0), strict=True)
        return np.stack([self._moved(case, t, *x) for case, x in columns], axis=-1)

    def _moved(self, case: Model, t: float, u: Array, v: Array, memory: Memory | None = None) -> Array:
        """u, v, a (3, n) under the loads of a case, by the factors of the one structure that all cases are."""
        return np.array([u, v, self.structure.acceleration(t, u, v, case.force(t), memory)])
