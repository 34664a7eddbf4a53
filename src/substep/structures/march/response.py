"""What a march of a structure returns: histories at the degrees of freedom asked for, and the account of energy."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.errors import unknown_name
from ...core.exports import Histories, History
from ...core.fighting import TOUCHES, Acting, reacts_until
from ...core.impacts import Touching
from ...core.loads import Load
from ...core.response import Response
from ...core.state import State
from ..model.contacts import Contacts
from ..model.given import Dof
from ..model.held import Held
from ..model.memory import WORK, Memory, RememberingForce
from ..model.model import Model
from ..model.state_vectors import vectors
from ..solvers.factorization import factorize
from ..solvers.matrices import is_identity
from .spring_histories import SpringHistories


@dataclass(frozen=True)
class Account:
    """Energies (n+1,) in the structure's units, in balance: work = kinetic + strain - those at the start + damped +
    numerical + residual.

    work: of the loads, and damped: by the damping matrix and, where the internal force has a potential, by what
    velocities add to it, from t = 0, by the trapezoidal rule over each step, in which the average acceleration scheme
    keeps the balance exactly. quadrature: what a finer rule would add to the work less
    the damped energy, and less a strain energy that is itself the work of an internal force; see
    `substep.structures.march.quadrature`. numerical: what the scheme itself has dissipated by both rules, 0 where one
    finds a loss and the other a gain. residual: what is left over, which is known no better than the work is. Of a
    linear structure whose damping leaves the modes apart `substep.own_energy` says exactly what the scheme dissipates.
    """

    kinetic: Array
    strain: Array
    work: Array
    damped: Array
    quadrature: Array

    @cached_property
    def numerical(self) -> Array:
        """Energy that the scheme has dissipated since t = 0, (n+1,): of what two rules find, what is nearer to 0."""
        missing = self._missing
        finer = missing + self.quadrature
        return np.clip(0.0, np.minimum(missing, finer), np.maximum(missing, finer))

    @property
    def residual(self) -> Array:
        """What the balance leaves open (n+1,), which is at most the difference between two rules for the work."""
        return self._missing - self.numerical

    @property
    def _missing(self) -> Array:
        mechanical = self.kinetic + self.strain
        return self.work - self.damped - (mechanical - mechanical[0])

    @property
    def share(self) -> float:
        """The largest numerical dissipation relative to the largest energy in play; negative for energy gained."""
        energies = self.kinetic, self.kinetic + self.strain, self.work, self.damped  # strain may be counted from 0
        scale = max(float(np.max(np.abs(x))) for x in energies)
        return float(self.numerical[np.argmax(np.abs(self.numerical))]) / scale if scale > 0.0 else 0.0


@dataclass(frozen=True, eq=False, repr=False)
class StructureResponse(Response):
    """Histories u, v, a (n+1, k) at k degrees of freedom, as `Response` has them of a scene's coordinates.

    dofs: names or numbers of the k columns. a: the scheme's own acceleration, else from the equation of motion, which
    needs all degrees of freedom. account: None where it was not asked for. On a moving base all is relative to it.
    springs: what those of the structure did, None without; remembered: what was committed at each row, if anything is.
    touched (n+1, 2, d): mean reactions of the steps that end with the rows, and gaps there; None without contacts.
    """

    dofs: "tuple[Dof, ...]" = ()
    account: Account | None = None
    springs: SpringHistories | None = None
    remembered: Memory | None = None
    touched: Array | None = None

    @cached_property
    def state(self) -> State:
        """Where the run stands, as `Response.state`; with the work of springs of which no law keeps account."""
        here, springs = super().state, self.springs
        if springs is None or springs.work is None:
            return here
        work = springs.work if self.last is not None else springs.dissipated[-1] + springs.stored[-1]
        return replace(here, memory={**here.memory, WORK: work})

    @property
    def structure(self) -> Model:
        """The structure that was marched."""
        return self.scene  # type: ignore[return-value]

    @cached_property
    def a(self) -> Array:
        """Acceleration (n+1, k). Raises ValueError where it cannot be computed from what was kept."""
        if self.own_a is not None:
            return self.own_a
        s = self.structure
        if not self.has_a:
            raise ValueError(
                "expected all degrees of freedom for the acceleration of a scheme that has none of its own, got "
                f"{self.u.shape[1]} of {s.T.shape[0]}; march without dofs and fixed, or take a scheme that carries a"
            )
        order = np.argsort(self._places)  # of the columns, as the structure has its degrees of freedom
        kept = self.remembered
        memories = [None if kept is None else kept.at(k) for k in range(1, len(self.t))]
        rows = zip(self.t[1:], np.asarray(self.u)[1:, order], np.asarray(self.v)[1:, order], memories, strict=True)
        first = s.a0 if self.started is None else vectors(s, self.started)[2]
        touching = [None] * len(self.t) if self.touched is None else self.touched[:, 0]
        found = np.array([first, *(s.pushed_acceleration(*row) for row in zip(rows, touching[1:], strict=True))])
        return found[:, self._places]

    @property
    def memory(self) -> Mapping[str, Array]:
        """What was remembered, by name: (n+1, s) of springs, NaN where a law has no such name; (n+1, ...) of states.

        Of each contact the constant reaction (n+1,) that has the impulse of the step, 0 at the start, or the last one
        where they are remembered; of each friction such a force, on the side of K u; of each constraint its multiplier;
        (n+1, s) of one of several rows.
        """
        force, kept = self.structure.internal, self.remembered
        found = {} if kept is None or not isinstance(force, RememberingForce) else force.named(kept)
        return {**found, **self._touching(0)}

    @property
    def multipliers(self) -> Mapping[str, Array]:
        """The multiplier (n+1,) of each nonlinear constraint, by name, from the equations of motion at u, v and t.

        (n+1, s) of one of several rows; NaN where gradients are dependent. It is as accurate as u and v, also where the
        scheme's own one, in `memory`, is of lower order. Empty where there are no constraints. Raises ValueError where
        not all degrees of freedom were kept.
        """
        held = self.structure.contacts
        if not isinstance(held, Held):
            return {}
        if not self._has_all:
            raise ValueError(
                f"expected all degrees of freedom for the multipliers of constraints, got {len(set(self.dofs))} of "
                f"{self.structure.T.shape[0]}; march without dofs, or take the scheme's own in r.memory"
            )
        return held.by_name(self._multipliers)

    @cached_property
    def _multipliers(self) -> Array:
        """Those (n+1, d) of all constraints, from the equations of motion."""
        held = self.structure.contacts
        assert isinstance(held, Held)
        found = np.full((len(self.t), held.size), np.nan)
        for k, (t, u, v) in enumerate(zip(self.t, self._free(self.u), self._free(self.v), strict=True)):
            with suppress(np.linalg.LinAlgError):
                memory = None if self.remembered is None else self.remembered.at(k)
                found[k] = self.structure.at_rest(t, u, v, memory)
        return found

    @property
    def gaps(self) -> Mapping[str, Array]:
        """The gap (n+1,) of each contact, by name, 0 where it is closed; (n+1, s) of one of several rows.

        Of each constraint what is left of g.
        """
        contacts, found = self.structure.contacts, self._touching(1)
        return found if contacts is None else {name: x for name, x in found.items() if name not in contacts.frictions}

    def _contacts_in_rows(self) -> Touching | None:
        """The contacts in the rows; rates are NaN where not all degrees of freedom were kept, energies without account.

        What is lost is what the account leaves beside loads and damping.
        """
        contacts, n = self.structure.contacts, len(self.t)
        if not isinstance(contacts, Contacts) or self.touched is None or contacts.sliding.all():
            return None
        gaps = ~contacts.sliding
        places = [(name, x) for name, x in contacts.names.items() if name not in contacts.frictions]
        of = [(name, k) for name, x in places for k in ([None] if isinstance(x, int) else range(x.stop - x.start))]
        u, v = (self._free(x) for x in (self.u, self.v))
        rows = contacts.rows[gaps].T
        of_u, of_v = (np.abs(x[:, contacts.columns]) @ np.abs(rows) for x in (u, v))
        lost = np.full(n, np.nan) if self.account is None else self.account.numerical + self.account.residual
        p, gap, gap0 = self.touched[:, 0, gaps], self.touched[:, 1, gaps], contacts.gaps0[gaps]
        of_u, rates = np.abs(gap0) + np.fmax(of_u, np.abs(gap - gap0)), v[:, contacts.columns] @ rows
        return Touching(tuple(of), p, gap, rates, of_u, of_v, lost, contacts.remembered)

    def acting(self, row: int, end: float) -> Acting | None:
        """The contacts and frictions in a step from a row to `end`, as far as the degrees of freedom were kept."""
        contacts, found = self.structure.contacts, self._contacts_in_rows()
        if not isinstance(contacts, Contacts) or found is None:
            return None
        if contacts.remembered and not contacts.sliding.any():  # gaps alone always have reactions
            return None
        d, named, begin = len(found.contacts), self.structure.named, float(self.t[row])
        h = reacts_until(self.scheme, begin, end) - begin
        ahead = np.fmin(found.gaps[row], found.gaps[row] + h * found.rates[row])
        touches = np.flatnonzero(ahead <= TOUCHES * found.u_parts.max(axis=0))
        v = self._free(self.v)[row][contacts.columns]
        rates = contacts.rows[d:] @ v
        slides = np.where(np.abs(rates) > TOUCHES * (np.abs(contacts.rows[d:]) @ np.abs(v)), rates, 0.0)
        at = [*touches.tolist(), *range(d, contacts.size)]
        mobility = contacts.rows @ self.structure.pushed[contacts.columns]
        return Acting(
            [contacts.name_of(k) for k in touches], [contacts.name_of(k) for k in range(d, contacts.size)],
            [", ".join(named(int(contacts.columns[j])) for j in np.flatnonzero(contacts.rows[k])) for k in touches],
            mobility[np.ix_(at, at)], contacts.shares[:, touches], slides,
        )  # fmt: skip

    def _unkept(self) -> str:
        return ""

    def _jumping(self) -> str:
        return ""

    def _ending(self) -> str:
        return ""

    def _free(self, x: Array) -> Array:
        """Rows (n+1, n) of the free degrees of freedom, of those (n+1, k) that were kept; NaN if these are not all."""
        T = self.structure.T
        if not self._has_all:
            return np.full((len(x), T.shape[1]), np.nan)
        every = np.asarray(x)[:, np.argsort(self._places)]
        return every if is_identity(T) else factorize(T.T @ T)(T.T @ every.T).T

    def _touching(self, which: int) -> dict[str, Array]:
        """Of contacts the reactions, or the gaps, by name."""
        contacts = self.structure.contacts
        return {} if contacts is None or self.touched is None else contacts.by_name(self.touched[:, which])

    @property
    def energy_dissipated(self) -> Array:
        """The energy (n+1,) that all springs have dissipated: see `SpringHistories`, which has it of each.

        Raises AttributeError for a structure without springs.
        """
        if self.springs is None:
            raise AttributeError("expected a structure with springs, which dissipate energy; this one has none")
        return self.springs.dissipated.sum(axis=1)

    @property
    def base_shear(self) -> Array:
        """The force (n+1,) of springs, and of K, on the base, in the direction in which it moves.

        That is iota^T (B^T q + K u), iota the displacements where the base of the structure moves by one, all of them
        by one where it does not move. Raises ValueError where it moves in several directions, or where K holds the
        structure and not all columns were kept, and AttributeError without springs.
        """
        s, force = self.structure, self.structure.internal
        if self.springs is None or not isinstance(force, RememberingForce) or force.springs is None:
            raise AttributeError("expected a structure with springs for the base shear; this one has none")
        iota, *others = [x for x, _ in s.motions] or [np.ones(s.T.shape[0])]
        if not all(np.array_equal(x, iota) for x in others):
            raise ValueError(
                f"expected a base that moves in one direction for the base shear, got {len(s.motions)} motions in "
                "several; add up r.springs.forces, and what K holds, along the direction that you want"
            )
        shear = self.springs.forces @ (force.springs.full @ iota)
        if s.full_stiffness is None:
            return shear
        held = s.full_stiffness.T @ iota
        if missing := set(np.flatnonzero(held).tolist()) - set(self._places):
            raise ValueError(
                f"expected all degrees of freedom that K holds for the base shear, got none of {min(missing)}; march "
                "without dofs"
            )
        return shear + np.asarray(self.u) @ held[self._places]

    def at_times(self, times: Array, u: Array) -> dict[str, Any]:
        """The account of energy, gaps and what springs do, linear between the rows.

        Reactions and what is remembered are those of the row before.
        """
        more = dict[str, Any]()
        before = np.clip(np.searchsorted(self.t, times, side="right") - 1, 0, len(self.t) - 1)
        if self.springs is not None:
            after = np.minimum(before + 1, len(self.t) - 1)
            share = (times - self.t[before]) / np.where(after > before, self.t[after] - self.t[before], 1.0)
            more["springs"] = self.springs.between(before, after, share)
        if self.remembered is not None:
            more["remembered"] = self.remembered.at(before)
        if self.touched is not None:
            between = [np.interp(times, self.t, gap) for gap in self.touched[:, 1].T]
            more["touched"] = np.stack([self.touched[before, 0], np.array(between).T], axis=1)
        if self.account is None:
            return more
        found = {f.name: np.interp(times, self.t, getattr(self.account, f.name)) for f in fields(self.account)}
        return {**more, "account": Account(**found)}

    @property
    def _last_row(self) -> tuple[Array, Array, Array | None]:
        """u, v, a (N,) in the last row, None for an a that is not known.

        Raises ValueError where not all degrees of freedom were kept.
        """
        order = np.argsort(self._places)
        if not self._has_all:
            raise ValueError(
                "expected all degrees of freedom for the state of a march that failed or ended at an event, got "
                f"{len(self.dofs)} of {self.structure.T.shape[0]}; march without dofs, or go on from an earlier state"
            )
        u, v, *a = (np.asarray(x)[-1][order] for x in (self.u, self.v, *([self.a] if self.has_a else [])))
        return u, v, a[0] if a else None

    def _histories(self) -> Histories:
        """What can be exported: a where it can be computed, energies where there is an account; consistent units."""
        found = {"u": History(np.asarray(self.u), "", "displacement"), "v": History(np.asarray(self.v), "", "velocity")}
        if self.has_a:
            found["a"] = History(np.asarray(self.a), "", "acceleration")
        if self.account is not None:
            energies = {"energy": self.energy, "work": self.account.work, "damped": self.account.damped}
            found |= {name: History(x, "", name) for name, x in energies.items()}
        if self.springs is not None:
            found["energy_dissipated"] = History(self.energy_dissipated, "", "energy dissipated by springs")
        several = [(kind, f"{kind} of a contact", self._touching(k)) for k, kind in enumerate(("reaction", "gap"))]
        if self._has_all:
            several.append(("multiplier", "multiplier of a constraint, from the equations of motion", self.multipliers))
        for kind, what, of in several:
            found |= {f"{name}_{kind}": History(x, "", what) for name, x in of.items() if x.ndim == 1}
        return Histories(self.t, found, self.dofs, "dof", self._attrs)

    @property
    def _subject(self) -> str:
        return f"a structure of {self.structure.size} degrees of freedom"

    @cached_property
    def jump(self) -> Array:
        """How far a (N,) at the start is from the one of the equation of motion: see `Response.jump`."""
        s, started = self.structure, self.started
        t = 0.0 if started is None else started.t
        u, v, a = (s.u0, s.v0, s.a0) if started is None else vectors(s, started)
        memory = None if self.remembered is None else self.remembered.at(0)
        touching = None if self.touched is None else self.touched[0, 0]
        return s.T @ (a - s.pushed_acceleration((t, u, v, memory), touching))

    @property
    def _jumped(self) -> str:
        started = self.started
        given = self.structure.a0_given is not None if started is None else started.a is not None and not started.of
        with suppress(ValueError):  # of a mass that is singular, or an a that cannot be computed
            return super()._jumped if given else ""  # else it would take a factorization of M
        return ""

    @property
    def loads(self) -> Sequence[Load]:
        """The loads' functions of time."""
        return [g for _, g in self.structure.loads]

    @property
    def has_a(self) -> bool:
        """Whether the scheme has an acceleration of its own, or all degrees of freedom are there to compute one."""
        s = self.structure
        return self.own_a is not None or (s.all_free and sorted(self._places) == list(range(s.size)))

    @property
    def _has_all(self) -> bool:
        """Whether all degrees of freedom were kept."""
        return len(set(self.dofs)) == self.structure.T.shape[0]

    @property
    def _places(self) -> list[int]:
        """The numbers of the columns' degrees of freedom."""
        return [self.structure.place(dof) for dof in self.dofs]

    @cached_property
    def energy(self) -> Array:
        """Kinetic and strain energy (n+1,). Raises ValueError without an account."""
        if self.account is None:
            raise ValueError(
                "expected an account of energy, got a march without one; march with account=True, which "
                "takes symmetric M and K"
            )
        return self.account.kinetic + self.account.strain

    @cached_property
    def momenta(self) -> Mapping[str, Array]:
        """Empty: a structure's degrees of freedom do not say along or about what they move."""
        return {}

    @property
    def angular_momentum(self) -> Array | None:
        """None, as there are no momenta."""
        return None

    @cached_property
    def outputs(self) -> Mapping[str, Array]:
        """Empty: a structure has no outputs besides u, v, a and the account of energy."""
        return {}

    def at(self, dof: Dof) -> tuple[Array, Array, Array | None]:
        """u, v, a (n+1,) of one degree of freedom, None for an a that `a` cannot compute from what was kept.

        Raises ValueError for a degree of freedom that was not kept.
        """
        if dof not in self.dofs:
            raise unknown_name("a degree of freedom that was kept", str(dof), map(str, self.dofs))
        place = self.dofs.index(dof)
        return self.u[:, place], self.v[:, place], self.a[:, place] if self.has_a else None

    @cached_property
    def absolute_a(self) -> Array:
        """Absolute acceleration (n+1, k) on a moving base: a + iota a_g of each motion. Raises ValueError for none."""
        s = self.structure
        if not s.motions:
            raise ValueError("expected a structure on a moving base, got none; see Structure.ground_motion")
        base = sum(record(self.t)[:, None] * iota[self._places] for iota, record in s.motions)
        return np.asarray(self.a) + base
