"""What a march of a structure keeps: rows of u, v, a, energies and iterations, in memory or on disk."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...core.arrays import Array, dot
from ...core.errors import warn
from ...core.response import Status
from ...core.schemes import Scheme
from ..model.model import Model
from ..model.rayleigh import Rayleigh
from ..solvers.combine import combined, inner_products, products
from ..solvers.matrices import is_identity
from .newton import Tangent
from .quadrature import middle, of_damped, of_work
from .response import Account
from .saved import Saved, described
from .scheme_plan import step_of
from .steps import BLOCK, Run, StructureSteps

WARN = 0.05  # share of the energy beyond which what the scheme dissipates or gains is worth a warning
ROUNDING = 1e-10  # of the energy at the start: what steps at rest may seem to dissipate


class Energies(NamedTuple):
    """Where the account of energy stands: the last u and v, `both` (2, n), what follows from them, and the sums so far.

    held: K u (n,), or the part of an internal force that `worked_at` returns, if any. resisted: C times the change of u
    in the last step, and C v, (2, n); None without damping. loads (J,): the values of the loads' functions. moved
    (J, 2): inner products of the load vectors with u, v.
    quadrature: as in `Account`.
    """

    both: Array
    held: Array | None
    resisted: Array | None
    loads: Array
    moved: Array
    kinetic: float
    strain: float
    work: float = 0.0
    damped: float = 0.0
    quadrature: float = 0.0

    @classmethod
    def of(cls, s: Model, both: Array, t: float, loads: Array, before: "Energies | None" = None) -> "Energies":
        """At u, v, `both` (2, n), under loads (J,), after a step from `before`, if there was one.

        A strain energy without a potential is its work, so far 0. What M, C or K multiplies goes through it together.
        """
        u, v = both
        moving, resisted = np.array([u if before is None else u - before.both[0], v]), None
        if s.internal is None and isinstance(s.C, Rayleigh):
            by_mass, by_stiffness = products(s.M, moving), products(s.K, both)
            held, inertia = by_stiffness[0].copy(), by_mass[1]
            if before is not None and before.held is not None:
                by_stiffness[0] -= before.held
            resisted = s.C.alpha * by_mass + s.C.beta * by_stiffness
        else:
            held, inertia = worked_at(s, t, u, v), products(s.M, moving[1:])[0]
            if s.C is not None:
                resisted = products(s.damping, moving)
        strain = 0.0
        if s.internal is None:
            assert held is not None
            strain = 0.5 * dot(u, held)
        elif s.internal.potential is not None:
            strain = s.internal.energy(u)
        moved = inner_products(s.load_vectors.T, both)
        return cls(both, held, resisted, loads, moved, 0.5 * dot(v, inertia), strain)

    @classmethod
    def at_start(cls, s: Model, both: Array, t: float) -> "Energies":
        """At u, v, `both` (2, n), where a march begins at the time t."""
        return cls.of(s, both, t, s.load_values(np.array([t]))[0])

    def after(self, s: Model, both: Array, t: float, h: float, loads: Array, half: Array) -> "Energies":
        """After a step of length h to u, v, `both` (2, n), at the time t, under these loads (J,), `half` at its middle.

        The rules of the work take products of forces and motions. Here these are rows: motions over the change of u and
        v at both ends, forces over the loads and what there is of an internal force to add up, at the start, the middle
        and the end; `known` are the inner products of what they are rows over.
        """
        between = None
        if s.internal is not None:  # before the force at the end, which the next step takes again
            between = worked_at(s, t - 0.5 * h, *middle(self.both[0], both[0], self.both[1], both[1], h))
        new = Energies.of(s, both, t, loads, self)
        motions = np.array([both[0] - self.both[0], self.both[1], both[1]])
        change, *ends = np.eye(3)
        forces = [self.loads, half, loads]
        known = np.column_stack([new.moved[:, 0] - self.moved[:, 0], self.moved[:, 1], new.moved[:, 1]])
        work, damped = 0.5 * float((self.loads + loads) @ known[:, 0]), 0.0
        if s.internal is not None and self.held is not None and between is not None and new.held is not None:
            of_force = inner_products(np.array([self.held, between, new.held]), motions)
            own = 0.5 * float(of_force[0, 0] + of_force[2, 0])
            if s.internal.potential is None:
                new = new._replace(strain=self.strain + own)
            else:
                damped += own
            known = np.concatenate([known, of_force])
            forces = [np.append(values, -row) for values, row in zip(forces, np.eye(3), strict=True)]
        finer = float(of_work(forces, change, ends, h, lambda force, motion: force @ known @ motion))
        if new.resisted is not None and self.resisted is not None:
            by_damping = inner_products(motions, np.array([new.resisted[0], self.resisted[1], new.resisted[1]]))
            damped += float(by_damping[0, 0]) / h
            finer -= float(of_damped((change, change), ends, ends, h, lambda x, y: x @ by_damping @ y))
        return new._replace(work=self.work + work, damped=self.damped + damped, quadrature=self.quadrature + finer)

    @property
    def sums(self) -> dict[str, float]:
        """What is added up from step to step."""
        names = ("strain", "work", "damped", "quadrature")
        return {name: getattr(self, name) for name in names}

    @property
    def row(self) -> tuple[float, float, float, float, float]:
        """Kinetic and strain energy, work, damped energy and quadrature."""
        return self.kinetic, self.strain, self.work, self.damped, self.quadrature


def worked_at(s: Model, t: float, u: Array, v: Array) -> Array | None:
    """What the account of energy takes the work of: K u (n,), or that part of an internal force which no potential has.

    That part is all of a force without a potential, whose work is its strain energy, and else what velocities add to
    it, whose work is damped energy; None for a force of u alone with a potential.
    """
    force = s.internal
    if force is None or force.potential is None:
        return s.restoring(t, u, v)
    return force.damping(t, u, v) if force.reads > 1 else None


class Histories:
    """What a march has so far: rows of u, v, a at the degrees of freedom asked for, energies, and iterations.

    done, state and energies belong together and are set at once, last in a step: what a step that was interrupted has
    put elsewhere lies beyond `done` and does not count.
    """

    def __init__(
        self, run: Run, n: int, places: list[int], stride: int, account: bool, save: str | Path | None
    ) -> None:
        s = run.structure
        self.run, self.stride, self.done = run, stride, 0
        self.kinds = 3 if len(step_of(run.scheme, run.h).report) == 3 else 2
        self.select = selection(s, places)
        self.n, self.sampled = n, (0, np.empty((0, 2, 0)))
        given = run.given
        self.energies = Energies.at_start(s, given[:2], run.time(0)) if account else None
        self.accounts = [] if self.energies is None else [self.energies.row]
        self.iterations = np.zeros((n, run.scheme.balances), np.int64)
        self.state: Array | None = None
        self.tangents: list[Tangent | None] = []
        shape = (n // stride + 1, self.kinds, len(places))
        self.saved = None
        if save is None:
            self.rows = np.empty(shape)
        else:
            choices = {"dofs": places, "stride": stride, "account": account}
            self.saved = Saved(save, shape, n, run.h, lambda end: described(run, end, **choices))
            if self.saved.last is not None:
                self._resume(self.saved.last)
        if not self.done:
            self._put(0, self.select(given[: self.kinds]))

    def add(self, X: Array, march: StructureSteps) -> None:
        """A step, with all that is kept of it."""
        s, h, done, energies = self.run.structure, self.run.h, self.done + 1, self.energies
        counts, own = march.counts, march.run is self.run  # else another scheme marches the first steps
        self.iterations[done - 1] = counts if own else [sum(counts), *[0] * (self.run.scheme.balances - 1)]
        kept = done % self.stride == 0
        if energies is not None:
            both = combined(march.steps.report[:2], X)
            energies = energies.after(s, both, self.run.time(done), h, *self._loads(done))
            if kept:
                self.accounts.append(energies.row)
        if kept:
            self._put(done // self.stride, self.select(march.steps.report[: self.kinds], X))
        state = combined(march.steps.out, X) if self.saved is not None and own else None
        self.done, self.state, self.energies, self.tangents = done, state, energies, march.tangents
        if self.saved is not None and self.saved.full:
            self.checkpoint()

    def checkpoint(self) -> None:
        """Write what is in memory to the store, if there is one; rows only while another scheme marches the first."""
        if self.saved is None:
            return
        self.saved.write()
        if self.state is None:
            return
        arrays: dict[str, Any] = {"state": self.state, "iterations": self.iterations[: self.done]}
        parts = [None if x is None else [x.t, x.largest] for x in self.tangents]
        numbers: dict[str, Any] = {"done": self.done, "tangents": parts, "sums": []}
        if self.energies is not None:
            arrays |= {"accounts": np.array(self.accounts[: self.kept]), "energies": self.energies.both}
            numbers["sums"] = self.energies.sums
        arrays |= {f"tangent_{k}": x.at for k, x in enumerate(self.tangents) if x is not None}
        self.saved.checkpoint(arrays, **numbers)

    @property
    def kept(self) -> int:
        """How many rows there are."""
        return self.done // self.stride + 1

    def read(self) -> list[Any]:
        """u, v and, where the scheme has its own, a."""
        if self.saved is None:
            return [self.rows[: self.kept, kind] for kind in range(self.kinds)]
        return self.saved.read(self.kept)

    def _loads(self, done: int) -> tuple[Array, Array]:
        """The values (J,) of the loads' functions at the end of step number `done`, and at its middle."""
        first, values = self.sampled
        if not first < done <= first + len(values):
            first = done - 1
            steps = np.arange(done, min(first + BLOCK, self.n) + 1, dtype=np.float64)
            at = self.run.structure.load_values
            first_step, origin = self.run.begin.first, self.run.begin.origin
            ends, halves = (origin + (first_step + n) * self.run.h for n in (steps, steps - 0.5))
            values = np.stack([at(ends), at(halves)], axis=1)
            self.sampled = first, values
        end, half = values[done - first - 1]
        return end, half

    def _put(self, place: int, row: Array) -> None:
        if self.saved is None:
            self.rows[place] = row
        else:
            self.saved.put(place, row)

    def _resume(self, last: dict[str, Any]) -> None:
        self.done, self.state = last["done"], last["state"]
        self.iterations[: self.done] = last["iterations"]
        self.tangents = [
            None if x is None else Tangent(x[0], last[f"tangent_{k}"], x[1]) for k, x in enumerate(last["tangents"])
        ]
        if self.energies is not None:
            self.accounts = [tuple(row) for row in last["accounts"].tolist()]
            t = self.run.time(self.done)
            loads = self.run.structure.load_values(np.array([t]))[0]
            self.energies = Energies.of(self.run.structure, last["energies"], t, loads)._replace(**last["sums"])


def selection(structure: Model, places: list[int]) -> Any:
    """A function of rows (r, n), or of rows and vectors that they combine, to values (r, k) at degrees of freedom.

    Rows (r, n, L) of L load cases become (r, k, L).
    """
    part = structure.T[places]
    columns = np.unique(part.indices)
    part = part[:, columns]
    plain = is_identity(part)

    def select(rows: Array, X: Array | None = None) -> Array:
        found = rows[:, columns] if X is None else combined(rows, X[:, columns])
        if plain:
            return found
        by_dof = np.moveaxis(found, 1, 0)
        rest = by_dof.shape[1:]
        return np.moveaxis((part @ by_dof.reshape(len(columns), math.prod(rest))).reshape(len(places), *rest), 0, 1)

    return select


def accounted(scheme: Scheme, rows: Sequence[Any], status: Status, step: str, at_start: float = 0.0) -> Account | None:
    """The account of a run from its rows, if there are any; warns where the scheme has dissipated, or gained, much.

    at_start: an energy that the structure holds at the start, whose rounding is no dissipation.
    """
    account = Account(*np.array(rows).T) if len(rows) else None
    seen = account is not None and np.abs(account.numerical).max() > ROUNDING * at_start
    if account is not None and seen and abs(account.share) > WARN and status == "completed":
        lost = account.share > 0.0
        did, other = ("dissipated", "less numerical damping") if lost else ("gained", "a longer stable step")
        warn(
            f"{scheme.name} has {did} {abs(account.share):.0%} of the energy in play at {step}: see Response.account; "
            f"take a smaller step, or a scheme with {other}, where that energy matters"
        )
    return account


def held_at_start(run: Run) -> float:
    """About the energy that an internal force holds at the start, which the account counts from 0."""
    s, (u, v, _) = run.structure, run.given
    return 0.0 if s.internal is None else float(np.abs(u) @ np.abs(s.restoring(run.time(0), u, v)))
