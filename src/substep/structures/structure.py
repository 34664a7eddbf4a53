"""A structure and its modes, as users have them: made from matrices, checked, marched."""

from __future__ import annotations

# pyright: reportUnnecessaryIsInstance=false
# what users give is checked when it comes, whatever its annotation says
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from numpy.typing import ArrayLike

from ..core.errors import called_as
from ..core.laws import Law
from ..core.loads import Load, Record
from .march.asked_again import asked_anew
from .march.critical import CriticalStep, critical_step
from .march.march_structure import march_structure
from .march.refusals import require_no_contacts
from .march.response import StructureResponse
from .model.constraints import independent, transformation
from .model.contacts import contacts_of
from .model.equilibrium import equilibrium
from .model.given import Dof, LoadPair, loads_of, names_of, numbered, place_of
from .model.given_force import internal_of
from .model.held import Held, held_of
from .model.model import Model
from .model.rayleigh import Rayleigh
from .model.supports import accelerated, displaced, require_still_supports
from .modes.eigen import eigenmodes
from .modes.modal_damping import ModalDamping
from .modes.modes import ModalBasis, modal_damping_matrix
from .modes.superposition import superpose
from .solvers.factorization import Solver
from .solvers.matrices import checked, is_operator, kept, reduced


@dataclass(frozen=True, eq=False, repr=False)
class Modes(ModalBasis):
    """The m lowest modes of a structure, which `substep.march` superposes; made by `Structure.modes`."""

    def march(
        self, scheme: Any, *, dt: float | None, t_end: float, dofs: Iterable[Dof] | None = None, **options: Any
    ) -> StructureResponse:
        """Mode superposition: see `superpose`, and `substep.march`, which calls it."""
        return superpose(self, scheme, dt, t_end, dofs=dofs, **options)


@dataclass(frozen=True, eq=False, repr=False)
class Structure(Model):
    """A structure in its free degrees of freedom; make one with `substep.structure`."""

    def modes(self, n: int) -> Modes:
        """The n lowest natural modes, undamped, with the damping of each; see `Modes`.

        Raises ValueError for more modes than degrees of freedom with mass, for M or K that is not symmetric or not
        positive semidefinite, and for nonlinear constraints.
        """
        if isinstance(self.contacts, Held):
            require_no_contacts(self, "modes", "hold degrees of freedom by fixed= or constraints=T")
        here = asked_anew(self)
        omega, shapes, statics = eigenmodes(here, n)
        return Modes(here, omega, shapes, modal_damping_matrix(here, omega, shapes), statics)

    def support_motion(
        self,
        dofs: Iterable[Dof],
        *,
        acceleration: Record | None = None,
        displacement: Load | None = None,
        velocity: Load | None = None,
    ) -> Structure:
        """The same structure, of which these supports, fixed degrees of freedom, move together; others stay.

        acceleration, m/s^2: the response is then that beyond the static displacements under the supports' own, and
        damping between supports and structure is left out, as is usual; displacement, with the velocity where damping,
        by a matrix C (N, N) or Rayleigh's, acts between supports and structure: the response is the motion itself; a
        Record is 0 after its end. Call it again for supports that move otherwise. By a displacement, damping
        proportional to the mass acts on the motion itself, as dashpots to a place at rest do; by an acceleration it
        acts on the motion beyond the static one. Where u0 is "static", it is so with the supports where the
        displacement puts them at t = 0.

        Raises ValueError for degrees of freedom that are free, for both or neither of acceleration and displacement,
        for an internal force, for a displacement under damping by ratios of modes, and for an acceleration where there
        are contacts. Chopra, Dynamics of Structures, 9.7.

        >>> bridge = ss.structure(np.eye(3), [[2.0, -1, -1], [-1, 1, 0], [-1, 0, 1]], fixed=[1, 2])
        >>> shaken = bridge.support_motion([1], displacement=ss.Step(0.1))
        >>> shaken = shaken.support_motion([2], displacement=ss.Step(0.1, start=0.2))
        >>> print(f"{ss.march(shaken, 'bathe', dt=0.01, t_end=1.0).u[-1, 0]:.4f}")
        0.0711
        """
        if isinstance(self.contacts, Held):
            require_no_contacts(self, "supports that move", "declare the supports as masses that a load moves")
        if (acceleration is None) == (displacement is None):
            raise ValueError("expected acceleration or displacement of the supports, one of the two; give one")
        if acceleration is not None and velocity is not None:
            raise ValueError(
                "expected velocity with displacement only, got it with acceleration, where damping between supports "
                "and structure is left out; leave it out, or give displacement="
            )
        if acceleration is not None:
            require_no_contacts(
                self, "supports that move by an acceleration", "give displacement=, of the motion itself"
            )
            return accelerated(self, acceleration, dofs)  # type: ignore[return-value]
        return displaced(self, displacement, velocity, dofs)  # type: ignore[arg-type, return-value]

    def critical_step(self, scheme: Any, *, bound: bool = False) -> CriticalStep:
        """The largest step with which a scheme is stable on it: see `substep.structures.march.critical`."""
        return critical_step(self, scheme, bound=bound)

    def march(self, scheme: Any, *, dt: float | None, t_end: float, **options: Any) -> Any:
        """See `substep.march`, which calls it."""
        return march_structure(self, scheme, dt, t_end, **options)


@called_as("structure(M, K, C=C, load=(P, Step(1.0)))")
def structure(
    M: Any,
    K: Any = None,
    *,
    springs: Iterable[tuple[Any, Law]] = (),
    internal_force: Callable[..., Any] | None = None,
    tangent: Callable[..., Any] | None = None,
    potential: Callable[..., Any] | None = None,
    state: Any = None,
    C: Any = None,
    load: LoadPair | Iterable[LoadPair] = (),
    u0: ArrayLike | Literal["static"] = 0.0,
    v0: ArrayLike = 0.0,
    a0: ArrayLike | Literal["consistent"] | None = None,
    fixed: Iterable[Dof] = (),
    constraints: Any = None,
    contacts: Any = None,
    restitution: Any = None,
    friction: Any = None,
    remembered: bool = False,
    names: Sequence[str] = (),
    solver: Solver = "auto",
) -> Structure:
    """A structure M a + C v + K u = load, or M a + C v + N(u) = load, from matrices (N, N) in consistent units.

    M, K: dense or sparse. internal_force: in place of K, the function N of u (N,), of u and v, or of t, u and v;
    tangent: with it, its derivative by u (N, N), or a pair with that by v, which explicit schemes do without;
    potential: the function of u of which N is the slope, for schemes that conserve it. C: as below; Rayleigh damping
    takes the tangent at u0 for K.

    springs: pairs of a row of B (N,), or a mapping from degrees of freedom to numbers, which gives an elongation e =
    B u, and a law (`substep.law`) of its force q; or of rows (s, N) and a law with parameters (s,). Their forces B^T q
    act beside K, which may be left out. state: what an internal force of one's own with a memory remembers at the
    start, an array or a dictionary of arrays. The force is then a function of t, u, v and state that returns the force,
    its tangent (a pair with that by v, if it depends on v), and the new state, and changes none of what it is given. It
    is called with the state that was last committed, as often as a step needs; the new state counts where a step or a
    sub-step ends: see docs/structures.md.

    C: a matrix, `substep.rayleigh(...)`, `substep.modal_damping(...)`, or None. load: pairs (P, g) of a vector (N,), or
    a mapping from degrees of freedom to numbers, and a function of time such as `substep.Record`; or one such pair.
    u0, v0, a0: (N,) or one number for all; a0 by default, and as "consistent", from the equation of motion.
    u0="static": the displacements in equilibrium with the loads at t = 0, of an internal force by Newton's iteration
    from zero with its tangent. fixed: degrees of freedom held at 0. constraints: T (N, n), the displacements of all as
    T q of those that are independent; or a mapping of names to functions of u (N,) that return g and its gradient G, a
    number and (N,) or (s,) and (s, N), where reactions -G^T lambda keep g at 0: see docs/constraints_and_contact.md.
    names: of all N, for `fixed`, `load` and `dofs`.
    contacts: a mapping of names to pairs of a row of B (N,), as of a spring, and a gap g0, in the units of u; or of
    rows (s, N) and gaps (s,). A reaction of that name keeps g0 + B u from becoming negative. restitution: for all of
    them, or by name, the share of the velocity that closed a gap with which it opens, from 0 to 1; friction: a mapping
    of names to pairs of a row of B and a limit, the force that acts along it against sliding at most, in the units of
    the load, or a mapping from contacts to coefficients of friction; remembered: whether
    the acceleration that a scheme keeps is with that of the reactions, as degrees of freedom without mass need it: see
    docs/constraints_and_contact.md and `substep.redistributed_mass`.
    solver: "auto", "dense", "superlu", "pardiso", "cholmod", or a function from a matrix to a function b -> x.

    Raises ValueError for both or neither of K and internal_force, for other shapes, complex or not finite entries,
    unknown names, names twice, a load on a fixed degree of freedom, constraints that are dependent or leave nothing
    free, a start that violates them, and contacts that are closed beyond 0 at the start or depend on each other.

    >>> frame = ss.structure(np.diag([2.0, 1.0]), [[6.0, -2.0], [-2.0, 4.0]], u0=[1.0, 0.0], names=["roof", "floor"])
    >>> u, v, a = ss.march(frame, "bathe", dt=0.1, t_end=1.0).at("roof")
    >>> u.shape
    (11,)
    """
    for name, matrix in (("M", M), ("K", K)):
        if is_operator(matrix):
            raise ValueError(
                f"expected {name} as a matrix, dense or sparse, got {type(matrix).__name__}; only a tangent and C "
                "may be known by their products"
            )
    mass = checked("M", M)
    N = mass.shape[0]
    known = names_of(names, N)
    if isinstance(fixed, str) or not isinstance(fixed, Iterable):
        raise ValueError(f"expected fixed as a list of names or numbers, got {fixed!r}; give [{fixed!r}]")
    numbers = numbered(known)
    held = sorted({place_of(dof, numbers, N) for dof in fixed})
    nonlinear = isinstance(constraints, Mapping)
    T = transformation(N, held, None if nonlinear else constraints)
    whole = None if K is None else checked("K", K, N)
    static = isinstance(u0, str)
    if static and u0 != "static":
        raise ValueError(f"expected u0 as displacements or 'static', got {u0!r}; give numbers")
    if isinstance(a0, str) and a0 != "consistent":
        raise ValueError(f"expected a0 as accelerations or 'consistent', got {a0!r}; give numbers")
    start = {"u0": 0.0 if static else u0, "v0": v0} | ({} if a0 is None or isinstance(a0, str) else {"a0": a0})
    free = {name: independent(name, x, T, known) for name, x in start.items()}
    linear = None if whole is None else reduced(whole, T)
    stiffness, free_mass = linear, reduced(mass, T)
    internal = internal_of(T, known, mass, linear, springs, internal_force, tangent, potential, state)
    if internal is not None:
        stiffness = None if internal.tangent is None else internal.at_start(free["u0"], free["v0"])[0]
    bare = Structure(
        M=free_mass,
        C=None,
        K=stiffness,
        T=T,
        loads=(),
        u0=free["u0"],
        v0=free["v0"],
        names=known,
        solver=solver,
        a0_given=free.get("a0"),
        full_mass=kept(mass, T, free_mass),
        full_stiffness=None if whole is None else kept(whole, T, linear),
        internal=internal,
    )
    loads = loads_of(T, known, load)
    loaded = replace(bare, loads=loads, given_loads=len(loads))
    if static:
        at_rest = equilibrium(loaded)
        tangent_there = stiffness if internal is None else internal.at_start(at_rest, free["v0"])[0]
        loaded = replace(loaded, u0=at_rest, K=tangent_there, static=True)
    if touching := contacts_of(contacts, restitution, friction, T, known, remembered=remembered):
        loaded = replace(loaded, contacts=touching)
        touching.require_open(loaded.u0)
        loaded.pushed  # noqa: B018 (raises for contacts without mass)
    if nonlinear and constraints:
        loaded = replace(loaded, contacts=_held(loaded, constraints))
    return damped_by(loaded, C)


def _held(s: Structure, given: Any) -> Held:
    """Its nonlinear constraints, kept at the start. Raises ValueError for contacts, u0="static" or where no mass is."""
    touching = s.contacts.kind if s.contacts is not None else ""
    for what, there in ((touching, bool(touching)), ('u0="static"', s.static)):
        if there:
            raise ValueError(f"expected nonlinear constraints without {what}, got both; leave one out")
    found = held_of(given, s.T, s.u0)
    found.require_kept(s.u0, s.v0)
    if len(bare := s.massless[found.touched(s.u0)[s.massless]]):
        raise ValueError(
            f"expected mass at the degrees of freedom of nonlinear constraints, got none at {s.named(int(bare[0]))}; "
            "condense it"
        )
    return found


def damped_by(s: Structure, C: Any) -> Structure:
    """The structure with the damping that `structure` takes as C."""
    require_still_supports(s)
    if isinstance(C, Rayleigh) and C.beta != 0.0 and s.K is None:
        raise ValueError(
            "expected tangent= for Rayleigh damping with beta, which takes the tangent at u0, got none; give it, or "
            "set beta = 0"
        )
    if isinstance(C, ModalDamping):
        return replace(s, C=C.matrix(s), full_damping=None)
    if isinstance(C, int | float):
        raise ValueError(
            f"expected C as a matrix, got {C}; for a ratio of the modes give C=ss.modal_damping({C}, modes=10), "
            f"or of two frequencies C=ss.rayleigh({C}, {C}, at=(omega_1, omega_2))"
        )
    if C is None or isinstance(C, Rayleigh):
        return replace(s, C=C, full_damping=None)
    whole = checked("C", C, s.T.shape[0])
    free = reduced(whole, s.T)
    return replace(s, C=free, full_damping=kept(whole, s.T, free))
