"""The account of energy of a march of a structure: kinetic and strain energy, work of the loads, damped energy."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...core.arrays import Array, dot
from ...core.errors import warn
from ...core.outcome import Status
from ...core.schemes import Scheme
from ..model.contacts import Contacts
from ..model.memory import Memory, Recalled, RememberingForce
from ..model.model import Model
from ..model.rayleigh import Rayleigh
from ..solvers.combine import inner_products, products
from .quadrature import middle, of_damped, of_work
from .response import Account
from .steps import Run

WARN = 0.05  # share of the energy beyond which what the scheme dissipates or gains is worth a warning
ROUNDING = 1e-10  # of the energy at the start: what steps at rest may seem to dissipate


class Energies(NamedTuple):
    """Where the account of energy stands: the last u and v, `both` (2, n), what follows from them, and the sums so far.

    held: K u (n,), or the part of an internal force that `worked_at` returns, if any. resisted: C times the change of u
    in the last step, and C v, (2, n); None without damping. loads (J,): the values of the loads' functions. moved
    (J, 2): inner products of the load vectors with u, v. memory: what an internal force remembers, None without.
    reactions (d,): of contacts, None where they are not known.
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
    memory: Memory | None = None
    reactions: Array | None = None

    @classmethod
    def of(
        cls,
        s: Model,
        both: Array,
        t: float,
        loads: Array,
        memory: Memory | None = None,
        before: "Energies | None" = None,
    ) -> "Energies":
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
            recalled = None if memory is None else Recalled(memory)
            held, inertia = worked_at(s, t, u, v, recalled), products(s.M, moving[1:])[0]
            if s.C is not None:
                resisted = products(s.damping, moving)
        strain = 0.0
        if s.internal is None:
            assert held is not None
            strain = 0.5 * dot(u, held)
        elif s.internal.potential is not None:
            strain = s.internal.energy(u)
        elif memory is not None:
            strain = stored(s, u, memory) or 0.0
        moved = inner_products(s.load_vectors.T, both)
        return cls(both, held, resisted, loads, moved, 0.5 * dot(v, inertia), strain, memory=memory)

    @classmethod
    def at_start(cls, s: Model, both: Array, t: float, memory: Memory | None) -> "Energies":
        """At u, v, `both` (2, n), where a march begins at the time t."""
        return cls.of(s, both, t, s.load_values(np.array([t]))[0], memory)

    def after(
        self, s: Model, both: Array, t: float, h: float, loads: Array, half: Array, memory: Memory | None,
        reactions: Array | None = None,
    ) -> "Energies":  # fmt: skip
        """After a step of length h to u, v, `both` (2, n), at the time t, under these loads (J,), `half` at its middle.

        memory: what an internal force remembers then. What it does not give back is damped energy, as is what
        frictions among the contacts take, under the mean reactions (d,) of the step.

        The rules of the work take products of forces and motions. Here these are rows: motions over the change of u and
        v at both ends, forces over the loads and what there is of an internal force to add up, at the start, the middle
        and the end; `known` are the inner products of what they are rows over.
        """
        between = None
        if s.internal is not None:  # before the force at the end, which the next step takes again
            recalled = None if self.memory is None else Recalled(self.memory, 0.5 * h)
            between = worked_at(s, t - 0.5 * h, *middle(self.both[0], both[0], self.both[1], both[1], h), recalled)
        new = Energies.of(s, both, t, loads, memory, self)
        motions = np.array([both[0] - self.both[0], self.both[1], both[1]])
        change, *ends = np.eye(3)
        forces = [self.loads, half, loads]
        known = np.column_stack([new.moved[:, 0] - self.moved[:, 0], self.moved[:, 1], new.moved[:, 1]])
        work = 0.5 * float((self.loads + loads) @ known[:, 0])
        damped, contacts = 0.0, s.contacts
        if isinstance(contacts, Contacts) and reactions is not None:
            damped = contacts.rubbed(reactions, motions[0])  # those of an explicit scheme act at instants
            if contacts.remembered and self.reactions is not None:
                damped = 0.5 * (damped + contacts.rubbed(self.reactions, motions[0]))
        if s.internal is not None and self.held is not None and between is not None and new.held is not None:
            of_force = inner_products(np.array([self.held, between, new.held]), motions)
            own = 0.5 * float(of_force[0, 0] + of_force[2, 0])
            if memory is not None and stored(s, both[0], memory) is not None:
                damped += own - (new.strain - self.strain)
            elif s.internal.potential is None:
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
        sums = {"work": self.work + work, "damped": self.damped + damped, "quadrature": self.quadrature + finer}
        return new._replace(**sums, reactions=reactions)

    def along(
        self, s: Model, motion: Array, t: float, h: float, loads: Array, half: Array, memories: Memory, held: Array,
        stored: Array,
    ) -> "tuple[Array, Energies]":  # fmt: skip
        """The rows (m, 5) after steps of length h to u and v, motion (m, 2, n), the last at t, and the last account.

        loads, half (m, J): of their functions at the ends and the middles; memories (m, ..), the internal force, held
        (m, n), and what it could give back, stored (m,), after each. The same rules as in `after`.
        """
        force = s.internal
        assert isinstance(force, RememberingForce)
        assert self.held is not None
        assert self.memory is not None
        (u_0, v_0), (u_1, v_1) = (np.moveaxis(x, 1, 0) for x in (_before(self.both, motion), motion))
        change, v = u_1 - u_0, (v_0, v_1)
        recalled = Memory.joined([self.memory.at(None), memories.at(slice(-1))])
        between, _ = force.along(*middle(u_0, u_1, v_0, v_1, h), recalled, 0.5 * h)
        by_loads = [x @ s.load_vectors.T for x in (_before(self.loads, loads), half, loads)]
        by_force = [_before(self.held, held), between, held]
        strain, kinetic = np.append(self.strain, stored), 0.5 * _products(v_1, (s.M @ v_1.T).T)
        work = 0.5 * _products(by_loads[0] + by_loads[2], change)
        damped = 0.5 * _products(by_force[0] + by_force[2], change) - np.diff(strain)
        left = [x - y for x, y in zip(by_loads, by_force, strict=True)]
        finer = of_work(left, change, v, h, _products)
        if s.C is not None:
            resisted = [(s.damping @ x.T).T for x in (change, v_0, v_1)]
            damped += _products(change, resisted[0]) / h
            finer -= of_damped((change, resisted[0]), v, resisted[1:], h, _products)
        sums = np.cumsum([[self.work, self.damped, self.quadrature], *np.transpose([work, damped, finer])], axis=0)[1:]
        last = Energies.of(s, motion[-1].copy(), t, loads[-1], memories.at([-1]).at(0))
        work, damped, finer = sums[-1].tolist()
        last = last._replace(work=work, damped=damped, quadrature=finer)
        return np.column_stack([kinetic, stored, sums]), last

    @property
    def sums(self) -> dict[str, float]:
        """What is added up from step to step."""
        names = ("strain", "work", "damped", "quadrature")
        return {name: getattr(self, name) for name in names}

    @property
    def row(self) -> tuple[float, float, float, float, float]:
        """Kinetic and strain energy, work, damped energy and quadrature."""
        return self.kinetic, self.strain, self.work, self.damped, self.quadrature


def _before(first: Array, rows: Array) -> Array:
    """The rows before these, of which the first is given."""
    return np.concatenate([first[None], rows[:-1]])


def _products(x: Array, y: Array) -> Array:
    """Inner products (m,) of rows (m, n)."""
    return np.einsum("mn,mn->m", x, y)


def stored(s: Model, u: Array, memory: Memory) -> float | None:
    """What an internal force with a memory could give back; None where it does not say."""
    assert isinstance(s.internal, RememberingForce)
    return s.internal.stored(u, memory)


def worked_at(s: Model, t: float, u: Array, v: Array, recalled: Recalled | None = None) -> Array | None:
    """What the account of energy takes the work of: K u (n,), or that part of an internal force which no potential has.

    That part is all of a force without a potential, whose work is its strain energy, and else what velocities add to
    it, whose work is damped energy; None for a force of u alone with a potential.
    """
    force = s.internal
    if force is None or force.potential is None:
        return s.restoring(t, u, v, recalled)
    return force.damping(t, u, v) if force.reads > 1 else None


def accounted(
    scheme: Scheme, rows: Sequence[Any], status: Status, step: str, at_start: float = 0.0, *, impacts: bool = False
) -> Account | None:
    """The account of a run from its rows, if there are any; warns where the scheme has dissipated, or gained, much.

    at_start: an energy that the structure holds at the start, whose rounding is no dissipation. impacts: of contacts,
    which dissipate too; then only a gain is worth a warning.
    """
    account = Account(*np.array(rows).T) if len(rows) else None
    seen = account is not None and np.abs(account.numerical).max() > ROUNDING * at_start
    seen = seen and not (impacts and account is not None and account.share > 0.0)
    if account is not None and seen and abs(account.share) > WARN and status == "completed":
        lost = account.share > 0.0
        did, other = ("dissipated", "less numerical damping") if lost else ("gained", "a longer stable step")
        if impacts:
            other = "one balance, as average_acceleration, which gains nothing at impacts"
        warn(
            f"{scheme.name} has {did} {abs(account.share):.0%} of the energy in play at {step}: see Response.account; "
            f"take a smaller step, or a scheme with {other}, where that energy matters"
        )
    return account


def held_at_start(run: Run) -> float:
    """About the energy that loads and an internal force have at the start, which the account counts from 0."""
    s, (u, v, _) = run.structure, run.given
    recalled, here = None if run.memory is None else Recalled(run.memory), run.time(0)
    by_loads = np.abs(s.load_values(np.array([here]))[0]) @ np.abs(s.load_vectors.T) @ np.abs(u)
    held = 0.0 if s.internal is None else np.abs(u) @ np.abs(s.restoring(here, u, v, recalled))
    return float(by_loads + held)
