"""What is known of a structure: M a + C v + N(u) = load, with its constraints, loads and start."""

# pyright: reportUnnecessaryIsInstance=false
# what users give is checked when it comes, whatever its annotation says

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.arrays import Array
from ...core.loads import Load, Record, is_known, values_at
from ..solvers.factorization import SingularMatrix, Solver, factorize
from ..solvers.matrices import (
    Matrix,
    added,
    arrays_of,
    asymmetry,
    combination,
    diagonal_of,
    indefinite,
    is_identity,
    is_operator,
    vector,
)  # fmt: skip
from .contacts import Contacts
from .given import Dof, numbered, place_of
from .held import Held
from .internal_force import InternalForce
from .memory import Memory, Recalled, RememberingForce
from .rayleigh import Rayleigh


@dataclass(frozen=True, eq=False, repr=False)
class Model:
    """A structure in its free degrees of freedom: what its march, its modes and its critical step are computed from.

    M, K (n, n), K the tangent at u0 of an internal force, None where that has none. C: a matrix, one of low rank where
    modes are damped, Rayleigh damping, or None. T (N, n): the displacements of all N degrees of freedom are T q.
    loads: pairs of a vector (n,) and a function of time; the first `given_loads` of them were given as loads, others
    are those of motions of the ground and of supports. u0, v0 (n,). names: of all N degrees of freedom, or empty.
    motions: of the ground, pairs of displacements (N,) for a unit motion of the base, and its acceleration.
    full_mass, full_stiffness, full_damping: M, K and C (N, N); K is None with an internal force, C where it was not
    given as a matrix. static: whether u0 was asked for as the equilibrium under the loads at t = 0. contacts: gaps that
    reactions keep from closing, or nonlinear constraints, if there are any.
    """

    M: Matrix
    C: Matrix | Rayleigh | None
    K: Matrix
    T: Matrix
    loads: tuple[tuple[Array, Load], ...]
    u0: Array
    v0: Array
    names: tuple[str, ...]
    solver: Solver
    a0_given: Array | None = None
    motions: tuple[tuple[Array, Record], ...] = ()
    full_mass: Matrix = None
    full_stiffness: Matrix = None
    full_damping: Matrix = None
    internal: InternalForce | RememberingForce | None = None
    given_loads: int = 0
    static: bool = False
    contacts: Contacts | Held | None = None

    def asked_anew(self, *, at_start: bool = True) -> "Model":
        """Itself, without what functions of the user's answered at the start: what they read may have changed since.

        Another one, with the tangent at the start as K, where that has. at_start: whether a run begins there; raises
        ValueError where that was an equilibrium with another tangent.
        """
        force = self.internal
        own = force is not None and (not isinstance(force, RememberingForce) or force.material is not None)
        if not own and not isinstance(self.contacts, Held) and all(is_known(g) for _, g in self.loads):
            return self
        for name in ("force_damping", "memory0", "at_start", "a0"):
            self.__dict__.pop(name, None)
        if not own or force is None:
            return self
        force.kept.clear()
        if force.tangent is None:
            return self
        tangent = force.at_start(self.u0, self.v0)[0]
        pairs = zip(arrays_of(tangent), arrays_of(self.K), strict=False)
        same = is_operator(tangent) or all(x.shape == y.shape and np.allclose(x, y, 1e-9, 0.0) for x, y in pairs)
        if self.static and at_start and not same:
            raise ValueError(
                "expected u0='static' in equilibrium with internal_force as it is, got a tangent there that is another "
                "than when the structure was made; make it anew, or give u0 as numbers"
            )
        return self if same else replace(self, K=tangent)

    @property
    def size(self) -> int:
        """Number of free degrees of freedom, n."""
        return self.M.shape[0]

    @cached_property
    def all_free(self) -> bool:
        """Whether the free degrees of freedom are all there are: T is the identity."""
        return is_identity(self.T)

    @cached_property
    def damping(self) -> Matrix:
        """The damping matrix (n, n), also where it is Rayleigh's or there is none."""
        if self.C is None:
            return 0.0 * self.M
        return self.C.matrix(self.M, self.K) if isinstance(self.C, Rayleigh) else self.C

    @cached_property
    def force_damping(self) -> Matrix | None:
        """The derivative of the internal force by v (n, n) at the start, where its tangent is a pair; else None."""
        force = self.internal
        if force is None or force.tangent is None:
            return None
        return force.at_start(self.u0, self.v0)[1]

    @cached_property
    def memory0(self) -> Memory | None:
        """What the internal force remembers at the start, committed at u0; None where it remembers nothing."""
        if not isinstance(self.internal, RememberingForce):
            return None
        return self.internal.committed(0.0, self.u0, self.v0, Recalled(self.internal.unstrained))

    @cached_property
    def at_start(self) -> "Model":
        """As coefficients of schemes and modes know it, which take K at u0: with `force_damping` as part of C."""
        more = self.force_damping
        return self if more is None else replace(self, C=more if self.C is None else added(self.damping, more))

    @cached_property
    def massless(self) -> NDArray[np.intp]:
        """The degrees of freedom without mass: rows of M that are zero."""
        return np.flatnonzero(np.asarray(abs(self.M).sum(axis=1)).ravel() == 0.0)

    @cached_property
    def stiffest(self) -> float:
        """The largest K_ii / M_ii of the degrees of freedom with mass, about the square of the highest frequency.

        Infinite for a tangent that is known by its products only.
        """
        if is_operator(self.K):
            return math.inf
        mass, stiffness = self.M.diagonal(), self.K.diagonal()
        return float(np.abs(stiffness[mass != 0.0] / mass[mass != 0.0]).max(initial=0.0))

    @cached_property
    def indefinite(self) -> int | None:
        """Where M, if it is symmetric, gives negative energy to a motion: the free degree of freedom that shows most.

        None where it does not, or M is not symmetric, as of a fluid beside a structure.
        """
        return None if diagonal_of(self.M) is None and asymmetry(self.M) > 0.0 else indefinite(self.M)

    @cached_property
    def load_vectors(self) -> Array:
        """The vectors of all loads (n, J)."""
        return np.array([shape for shape, _ in self.loads]).reshape(-1, self.size).T

    def force(self, t: float) -> Array:
        """The load (n,) at a time."""
        return self.loaded(self.load_values(np.array([t]))[0])

    def loaded(self, values: Array) -> Array:
        """The load (n,) where its functions of time have these values (J,)."""
        return sum((shape * value for (shape, _), value in zip(self.loads, values, strict=True)), np.zeros(self.size))

    def load_values(self, t: Array) -> Array:
        """The functions of time of the J loads at the times t (k,), (k, J)."""
        found = np.empty((len(t), len(self.loads)))
        for values, (_, load) in zip(found.T, self.loads, strict=True):
            values[:] = values_at(load, t)
        return found

    def restoring(self, t: float, u: Array, v: Array, recalled: Recalled | None = None) -> Array:
        """The internal force (n,); recalled: what it remembers, if it does, by default nothing was ever strained."""
        return self.K @ u if self.internal is None else self.internal(t, u, v, recalled)

    @cached_property
    def a0(self) -> Array:
        """Acceleration (n,) at t = 0: as given, else from the equation of motion, by static condensation without mass.

        Raises ValueError where massless degrees of freedom are not in equilibrium at the start.
        """
        if self.a0_given is not None:
            return self.a0_given
        a = self.acceleration(0.0, self.u0, self.v0, memory=self.memory0)
        if self.contacts is None:
            return a
        return a + self.pushed_by(self.at_rest(0.0, self.u0, self.v0, self.memory0), self.u0)

    def acceleration(
        self,
        t: float,
        u: Array,
        v: Array,
        force: Array | None = None,
        memory: Memory | None = None,
        held: Array | None = None,
    ) -> Array:
        """Acceleration (n,) from the equation of motion, under the loads or under another force (n,); see `a0`.

        memory: what the internal force remembers, committed there, if it does; held (n,): that force, where it is
        known.
        """
        right, largest = self._unbalanced(t, u, v, force, memory, held)
        s = self.massless
        if not len(s):
            return self.solve_mass(right)
        if self.K is None:
            raise ValueError(
                f"expected tangent= for the acceleration of the massless degree of freedom {self.named(int(s[0]))}, "
                "got an internal force without; give it, or a0="
            )
        self._require_balance(t, np.setdiff1d(s, self.bare), right, largest)
        m = np.setdiff1d(np.arange(self.size), s)
        M, K = self.M[m][:, m], self.K[s]
        a = np.zeros(self.size)
        a[m] = self.factorized(M, "M of the degrees of freedom with mass", m)(right[m])
        a[s] = -self.factorized(K[:, s], "K of degrees of freedom without mass", s)(K[:, m] @ a[m])
        return a

    def _unbalanced(
        self,
        t: float,
        u: Array,
        v: Array,
        force: Array | None = None,
        memory: Memory | None = None,
        held: Array | None = None,
    ) -> tuple[Array, float]:
        """What inertia is to balance (n,), see `acceleration`, and the largest of the forces that it is the sum of."""
        force = self.force(t) if force is None else force
        held = self.restoring(t, u, v, None if memory is None else Recalled(memory)) if held is None else held
        right = force - held - (self.damping @ v if self.C is not None else 0.0)
        return right, max(float(np.abs(part).max()) for part in (force, held))

    def _require_balance(self, t: float, places: NDArray[np.intp], right: Array, largest: float) -> None:
        """Raises ValueError where a force is left over at some of these massless degrees of freedom."""
        if not len(places):
            return
        worst = int(places[np.argmax(np.abs(right[places]))])
        if abs(right[worst]) > 1e-9 * largest:
            raise ValueError(
                f"expected equilibrium of the massless degree of freedom {self.named(worst)} at t = {t:g}, got a "
                f"force of {right[worst]:.3g} left over; give displacements (and velocities) for which it is 0"
            )

    @cached_property
    def solve_mass(self) -> Callable[[Array], Array]:
        """The factorization of M. Raises ValueError, with the degree of freedom, where it is singular."""
        return self.factorized(self.M, "M, the mass matrix")

    @cached_property
    def bare(self) -> NDArray[np.intp]:
        """The massless degrees of freedom that contacts touch, whose reactions stiffness balances."""
        if not isinstance(self.contacts, Contacts):
            return self.massless[:0]
        return self.massless[self.contacts.forces(self.size)[self.massless].any(axis=1)]

    @cached_property
    def pushed(self) -> Array:
        """The accelerations (n, d) that unit reactions of its d contacts give the masses, without other forces.

        Raises ValueError for a contact of a degree of freedom without mass, unless reactions are remembered.
        """
        assert isinstance(self.contacts, Contacts)
        forces = self.contacts.forces(self.size)
        if not len(self.massless):
            return self.solve_mass(forces)
        if len(self.bare) and not self.contacts.remembered:
            raise ValueError(
                f"expected mass at the degrees of freedom of contacts, got none at {self.named(int(self.bare[0]))}, "
                "where a reaction gives no acceleration to be left out; give remembered=True, without restitution"
            )
        forces[self.massless] = 0.0
        rest = np.zeros(self.size)
        plain = replace(self, internal=None)
        return np.array([plain.acceleration(0.0, rest, rest, force) for force in forces.T]).T

    def pushed_by(self, reactions: Array, u: Array) -> Array:
        """The acceleration (n,) that reactions (d,), or multipliers of constraints, give the masses at u (n,)."""
        if isinstance(self.contacts, Held):
            return self.solve_mass(self.contacts.forces(u, reactions))
        return self.pushed @ reactions

    def pushed_acceleration(self, at: tuple[float, Array, Array, Memory | None], reactions: Array | None) -> Array:
        """The acceleration (n,) with that of reactions (d,) that are remembered; at: t, u, v and a memory.

        Of constraints their multipliers follow from the equation of motion there, whatever those of a step are.
        """
        t, u, v, memory = at
        a, contacts = self.acceleration(t, u, v, memory=memory), self.contacts
        if isinstance(contacts, Held):
            return a + self.pushed_by(contacts.multipliers(u, v, a, self.solve_mass), u)
        return a if contacts is None or reactions is None or not contacts.remembered else a + self.pushed @ reactions

    def at_rest(self, t: float, u: Array, v: Array, memory: Memory | None = None) -> Array:
        """The reactions (d,) that are remembered of gaps that are closed and at rest at t, u, v (n,).

        Of constraints the multipliers there. memory: as in `acceleration`. Raises ValueError where none balance what
        massless degrees of freedom bear.
        """
        if isinstance(self.contacts, Held):
            return self.contacts.multipliers(u, v, self.acceleration(t, u, v, memory=memory), self.solve_mass)
        assert self.contacts is not None
        if not self.contacts.remembered:
            return np.zeros(self.contacts.size)
        closed, found = self.contacts.closed(u, v) & ~self.contacts.sliding, np.zeros(self.contacts.size)
        rows, columns = self.contacts.rows, self.contacts.columns
        if len(self.bare):
            right, largest = self._unbalanced(t, u, v, memory=memory)
            forces = self.contacts.forces(self.size)
            static = closed & forces[self.bare].any(axis=0)
            found[static] = np.linalg.lstsq(forces[self.bare][:, static], -right[self.bare], rcond=None)[0]
            found = np.maximum(found, 0.0)  # a reaction only pushes
            self._require_balance(t, self.bare, right + forces @ found, largest)
            closed &= ~static
        if not closed.any() and not self.contacts.sliding.any():
            return found
        a = self.acceleration(t, u, v, memory=memory) + self.pushed @ found
        opening = np.where(closed, rows @ a[columns], np.inf)
        if self.contacts.sliding.any():  # at rest it stays so, up to the limit, and what slides is far beyond
            rubs = rows @ a[columns] + self.contacts.slipping(v) * 1e12 * (1.0 + np.abs(rows @ a[columns]))
            opening = np.where(self.contacts.sliding, rubs, opening)
        return found + self.contacts.reactions(opening, rows @ self.pushed[columns], np.zeros(len(found)), 1.0)

    def factorized(self, matrix: Matrix, what: str, part: NDArray[np.intp] | None = None) -> Callable[[Array], Array]:
        """The factorization of a matrix (n, n), or of that of a part of the free degrees of freedom, by their numbers.

        Raises ValueError, with a degree of freedom, for a singular one.
        """
        try:
            return factorize(matrix, self.solver)
        except SingularMatrix as error:
            place = error.place if part is None else int(part[error.place])
            raise ValueError(
                f"expected a regular matrix of {what}, got one that leaves degree of freedom {self.named(place)} "
                "undetermined; support it, give it stiffness or mass; if only M is singular, take an implicit scheme "
                "and give the accelerations at the start as a0="
            ) from error

    def named(self, place: int) -> str:
        """Name or number, among all, of the degree of freedom in which a free one shows most."""
        column = self.T[:, [place]]
        whole = int(np.argmax(np.abs(column.toarray() if hasattr(column, "toarray") else column)))
        return f"'{self.names[whole]}'" if self.names else str(whole)

    def place(self, dof: Dof) -> int:
        """The number of a degree of freedom, by name or number. Raises ValueError for one that is not there."""
        return place_of(dof, self.numbers, self.T.shape[0])

    @cached_property
    def numbers(self) -> dict[str, int]:
        """The number of each degree of freedom, by name."""
        return numbered(self.names)

    def kept(self, dofs: Iterable[Dof] | None) -> list[Dof]:
        """Degrees of freedom that are asked for, by default all. Raises ValueError for what is no list of them."""
        if isinstance(dofs, str) or not isinstance(dofs, Iterable | None):
            raise ValueError(f"expected dofs as a list of names or numbers, got {dofs!r}; give [{dofs!r}]")
        found = list(self.names or range(self.T.shape[0])) if dofs is None else list(dofs)
        for dof in found:
            self.place(dof)
        return found

    def ground_motion(self, record: Record, direction: ArrayLike) -> "Model":
        """The same structure on a base that moves, also: the load -M iota a_g, displacements relative to the base.

        record: ground acceleration a_g. direction: iota (N,), the displacement of each degree of freedom where the base
        moves by one, or names or numbers of those that do; 1.0 for all. Raises ValueError for another shape, unknown
        names, a direction in which no free mass moves, integers of which it is not plain whether they are
        displacements or numbers of degrees of freedom, and a record without a unit that is likely not in m/s^2 and s.
        """
        record = of_ground(record)
        iota = self.influence_of(direction)
        shape = -self.inertia_of(iota)
        return replace(self, loads=(*self.loads, (shape, record)), motions=(*self.motions, (iota, record)))

    def influence_of(self, direction: ArrayLike) -> Array:
        """iota (N,) of a direction as `ground_motion` takes it, and raising what it does."""
        N = self.T.shape[0]
        given = np.asarray(direction)
        numbers = given.dtype.kind in "iu"
        if numbers and (given.ndim == 0 or (given.shape == (N,) and not np.isin(given, (0, 1)).all())):
            raise ValueError(
                f"expected a direction as displacements, such as 1.0 for all, or as a list of degrees of freedom, such "
                f"as [1], got {direction!r}, which may be either; write displacements with a decimal point"
            )
        if given.dtype.kind in "US" or (numbers and given.shape != (N,)):
            iota = np.zeros(N)
            iota[[self.place(x) for x in np.atleast_1d(given).tolist()]] = 1.0
        else:
            iota = vector("direction", direction, N)
        if not self.inertia_of(iota).any():
            raise ValueError(
                "expected a direction in which mass moves that is free, got one without; give the displacements of all "
                "degrees of freedom where the base moves by one"
            )
        return iota

    def inertia_of(self, iota: Array) -> Array:
        """M iota in the free degrees of freedom (n,), of a motion iota (N,) of all."""
        every = self.full_mass @ iota
        return every if self.all_free else self.T.T @ every

    def __getstate__(self) -> dict[str, Any]:
        return {f.name: getattr(self, f.name) for f in fields(self)}  # factors and the like are computed again

    def __repr__(self) -> str:
        return f"Structure({self.size} free of {self.T.shape[0]} degrees of freedom, {len(self.loads)} loads)"


def of_ground(record: Any) -> Record:
    """The record in m/s^2. Raises ValueError for anything else, and as `Record.of_ground`."""
    if not isinstance(record, Record):
        raise ValueError(f"expected the ground acceleration as ss.Record(dt, values), got {type(record).__name__}")
    return record.of_ground()


def sum_of_matrices(structure: Model, m: complex, c: complex, k: complex) -> Matrix:
    """m M + c C + k K."""
    terms = [(m, structure.M), (k, structure.K)]
    if c != 0.0 and structure.C is not None:
        terms.append((c, structure.damping))
    return combination(terms)
