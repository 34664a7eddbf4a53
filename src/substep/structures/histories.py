"""What a march of a structure keeps: rows of u, v, a, energies and iterations, in memory or on disk."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..core.arrays import Array, dot
from ..core.errors import warn
from ..core.response import Status
from ..core.schemes import Scheme
from .combine import combined
from .damping import Rayleigh
from .matrices import is_identity
from .newton import Tangent
from .plan import step_of
from .quadrature import middle, of_damped, of_work
from .response import Account
from .saved import Saved, described
from .steps import Run, StructureSteps
from .structure import Structure

WARN = 0.05  # share of the energy beyond which what the scheme dissipates or gains is worth a warning
VECTORS = 5  # of `Energies`, before its sums


class Energies(NamedTuple):
    """Where the account of energy stands: the last u, v, load, internal force and C v, and the sums so far.

    quadrature: as in `Account`.
    """

    u: Array
    v: Array
    load: Array
    held: Array
    resisted: Array
    strain: float
    work: float = 0.0
    damped: float = 0.0
    quadrature: float = 0.0

    @classmethod
    def of(cls, s: Structure, u: Array, v: Array, t: float, load: Array) -> "Energies":
        """At this state under this load (n,); a strain energy without a potential is its work, so far 0."""
        held, strain = s.restoring(t, u, v), 0.0
        rayleigh = isinstance(s.C, Rayleigh) and s.internal is None
        resisted = np.zeros_like(v) if s.C is None else cls._resisted(s, v, s.K @ v if rayleigh else v)
        if s.internal is None:
            strain = 0.5 * dot(u, held)
        elif s.internal.potential is not None:
            strain = s.internal.energy(u)
        return cls(u, v, load, held, resisted, strain)

    def after(self, s: Structure, u: Array, v: Array, t: float, h: float, load: Array, half: Array) -> "Energies":
        """After a step of length h to u, v at the time t, with this load at its end and `half` at its middle."""
        ends, change, forces = (self.v, v), u - self.u, [self.load, half, load]
        by_work = s.internal is not None and s.internal.potential is None
        if by_work:  # before the force at the end, which the next step takes again
            forces[1] = half - s.restoring(t - 0.5 * h, *middle(self.u, u, *ends, h))
        new = Energies.of(s, u, v, t, load)
        if by_work:
            forces[0], forces[2] = self.load - self.held, load - new.held
            new = new._replace(strain=self.strain + 0.5 * dot(self.held + new.held, change))
        finer, damped = of_work(forces, change, ends, h, dot), 0.0
        if s.C is not None:
            by_change = self._resisted(s, change, new.held - self.held)
            damped = dot(change, by_change) / h
            finer -= of_damped((change, by_change), ends, (self.resisted, new.resisted), h, dot)
        return new._replace(
            work=self.work + 0.5 * dot(self.load + load, change),
            damped=self.damped + damped,
            quadrature=self.quadrature + finer,
        )

    @staticmethod
    def _resisted(s: Structure, change: Array, held: Array) -> Array:
        """C times a change of displacement or a velocity, which K makes `held` of where the structure is linear."""
        if isinstance(s.C, Rayleigh) and s.internal is None:  # held is K times the change
            return s.C.alpha * (s.M @ change) + s.C.beta * held
        return s.damping @ change

    def row(self, s: Structure) -> tuple[float, float, float, float, float]:
        """Kinetic and strain energy, work, damped energy and quadrature."""
        return 0.5 * dot(self.v, s.M @ self.v), self.strain, self.work, self.damped, self.quadrature


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
        self.energies = Energies.of(s, s.u0, s.v0, 0.0, s.force(0.0)) if account else None
        self.accounts = [] if self.energies is None else [self.energies.row(s)]
        self.iterations: list[list[int]] = []
        self.state: Array | None = None
        self.tangents: list[Tangent | None] = []
        shape = (n // stride + 1, self.kinds, len(places))
        self.saved = None
        if save is None:
            self.rows = np.empty(shape)
        else:
            choices = {"dofs": places, "stride": stride, "account": account}
            self.saved = Saved(save, shape, n, run.h, lambda end: described(s, run.scheme, run.h, end, **choices))
            if self.saved.last is not None:
                self._resume(self.saved.last)
        if not self.done:
            self._put(0, self.select(np.array([s.u0, s.v0, s.a0][: self.kinds])))

    def add(self, X: Array, march: StructureSteps) -> None:
        """A step, with all that is kept of it."""
        s, h, done, energies = self.run.structure, self.run.h, self.done + 1, self.energies
        counts, own = march.counts, march.run is self.run  # else another scheme marches the first steps
        self.iterations.append(counts if own else [sum(counts), *[0] * (self.run.scheme.balances - 1)])
        kept = done % self.stride == 0
        if energies is not None:
            u, v = combined(march.steps.report[:2], X)
            energies = energies.after(s, u, v, done * h, h, s.force(done * h), s.force((done - 0.5) * h))
            if kept:
                self.accounts.append(energies.row(s))
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
        arrays: dict[str, Any] = {"state": self.state, "iterations": np.array(self.iterations[: self.done])}
        parts = [None if x is None else [x.t, x.largest] for x in self.tangents]
        numbers: dict[str, Any] = {"done": self.done, "tangents": parts, "sums": []}
        if self.energies is not None:
            arrays |= {"accounts": np.array(self.accounts[: self.kept]), "energies": np.array(self.energies[:VECTORS])}
            numbers["sums"] = list(self.energies[VECTORS:])
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

    def _put(self, place: int, row: Array) -> None:
        if self.saved is None:
            self.rows[place] = row
        else:
            self.saved.put(place, row)

    def _resume(self, last: dict[str, Any]) -> None:
        self.done, self.state, self.iterations = last["done"], last["state"], last["iterations"].tolist()
        self.tangents = [
            None if x is None else Tangent(x[0], last[f"tangent_{k}"], x[1]) for k, x in enumerate(last["tangents"])
        ]
        if self.energies is not None:
            self.accounts = [tuple(row) for row in last["accounts"].tolist()]
            self.energies = Energies(*last["energies"], *last["sums"])


def selection(structure: Structure, places: list[int]) -> Any:
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


def accounted(scheme: Scheme, rows: Sequence[Any], status: Status, step: str) -> Account | None:
    """The account of a run from its rows, if there are any; warns where the scheme has dissipated, or gained, much."""
    account = Account(*np.array(rows).T) if len(rows) else None
    if account is not None and abs(account.share) > WARN and status == "completed":
        lost = account.share > 0.0
        did, other = ("dissipated", "less numerical damping") if lost else ("gained", "a longer stable step")
        warn(
            f"{scheme.name} has {did} {abs(account.share):.0%} of the energy in play at {step}: see Response.account; "
            f"take a smaller step, or a scheme with {other}, where that energy matters"
        )
    return account
