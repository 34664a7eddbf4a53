"""What is refused of a structure before anything is computed: schemes and questions that do not fit it."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.scheme_names import unknown_argument
from ...core.schemes import Scheme
from ...marching.decay import require_decay as require_error_decay
from ..model.consistency import require_finite_start, require_own_potential, require_own_tangent
from ..model.contacts import Contacts
from ..model.held import Held
from ..model.model import Model
from ..model.rayleigh import Rayleigh
from ..solvers.low_rank import LowRank
from ..solvers.matrices import asymmetry, indefinite, is_operator
from .scheme_plan import System, start_of, step_of, why_no_contact, why_no_memory
from .velocity import (
    OF_DISPLACEMENTS,
    damped_at_start,
    needs_no_damping,
    require_tangent_by_velocity,
    takes_damping_at_start,
)

OF_STRUCTURE = (
    "u0", "v0", "a0", "load", "C", "fixed", "constraints", "contacts", "restitution", "names", "solver", "tangent",
    "potential",
)  # fmt: skip


def unknown_in_march(what: str, name: str, known: Sequence[str], scheme: Any) -> ValueError:
    """The error for an argument that the march of a structure does not have; it says so of one of `ss.structure`."""
    begins = "; a run begins elsewhere by start={'u': ..., 'v': ...}" if name in ("u0", "v0") else ""
    error = unknown_argument(what, name, known, scheme, {"ss.structure(M, K, {}=...)": OF_STRUCTURE})
    return ValueError(f"{error}{begins}")


def require_suited(structure: Model, scheme: Scheme, h: float) -> None:
    """Raises ValueError for a scheme, or the one that starts it, that is not for this structure in steps of h.

    Damping, also that of an internal force at the start, is not for a scheme of u'' = g(t, u). Degrees of freedom
    without mass are not for a scheme none of whose balances has K on its unknown: what it computes of them is nothing
    the equation of motion says, or not defined. An internal force without a potential is not for a discrete gradient,
    one without a tangent only for a scheme that takes it where all is known, and one that depends on v only with its
    derivative by v for a scheme that takes the damping at the start. Contacts are for a scheme whose balances move what
    their reactions hold, and that damps errors there. An internal force has to be finite at the start,
    and what of its tangent and potential the result depends on has to belong to it.
    """
    require_finite_start(structure)
    one: Scheme | None = scheme
    while one is not None:
        who = one.name if one is scheme else f"{one.name}, which starts {scheme.name},"
        require_undamped(structure, one, who)
        systems = step_of(one, h).systems
        if (force := structure.internal) is not None:
            if force.remembers and (why := why_no_memory(one)):
                raise ValueError(why)
            if force.potential is None and any(x.differences for x in systems):
                raise ValueError(
                    f"{who} takes a discrete gradient: expected potential= for this structure, got none; give the "
                    "function whose slope the internal force is, or take another scheme, such as average_acceleration"
                )
            own_start = one.starter is None and one.info.start != "given"
            every = (*systems, *(start_of(one, h).systems if own_start else ()))
            if force.tangent is None and any(x.stiffness.any() or x.moves_force(force.reads > 1) for x in every):
                raise ValueError(
                    f"{who} takes the tangent of the internal force: expected tangent= for this structure, got none; "
                    "give it, or take an explicit scheme such as dormand_prince"
                )
            if any(takes_damping_at_start(x) for x in every) and not force.remembers:
                require_tangent_by_velocity(structure, who)
            by_stiffness = isinstance(structure.C, Rayleigh) and structure.C.beta != 0.0
            if by_stiffness or any(x.stiffness.any() for x in every):  # else the tangent is Newton's alone
                require_own_tangent(structure, who)
            if any(x.differences for x in systems):
                require_own_potential(structure, who)
        require_contacts(structure, one, who, systems)
        if len(structure.massless) and not any(x.implicit for x in systems):
            raise ValueError(
                f"{who} is explicit: expected mass at each degree of freedom, got none at "
                f"{structure.named(int(structure.massless[0]))}; condense such degrees of freedom, or take an implicit "
                "scheme, such as bathe"
            )
        one = one.starter


def require_contacts(structure: Model, scheme: Scheme, who: str, systems: Sequence[System]) -> None:
    """Raises ValueError for a structure with contacts and a scheme, who, that takes none of their kind.

    systems: of its step.
    """
    if structure.contacts is None:
        return
    later = any(x.touch is not None and x.touch.later for x in systems)
    explicit = not any(x.implicit for x in systems)
    held = isinstance(structure.contacts, Held)
    if held and explicit and (not later or _starts_otherwise(scheme)):
        raise ValueError(
            f"{who} is explicit: expected for nonlinear constraints of a structure one that starts from u, v and a "
            "and whose balances each hold the next displacement that they move; take central_difference, an implicit "
            "scheme, or declare the structure as a scene"
        )
    if held and any(x.together and x.touch is None for x in systems):
        raise ValueError(
            f"{who} solves balances together that do not hold the ends of steps, or not by their reactions: expected "
            "for nonlinear constraints of a structure such as radau_iia3; take that, or another scheme"
        )
    if held and any(_at_a_mean(x) for x in systems):
        raise ValueError(
            f"{who} takes forces at a mean of two displacements: expected a scheme that takes them at displacements of "
            "its own, where the reactions of nonlinear constraints of a structure act; take another scheme, or declare "
            "the structure as a scene"
        )
    holds = later or any(x.together and x.touch is not None for x in systems)
    kinds = structure.contacts.kinds if isinstance(structure.contacts, Contacts) else ["gap"][: not holds]
    for kind in kinds:
        if why := why_no_contact(scheme, kind):
            raise ValueError(why)
        if any(x.touch is not None and x.touch.rows[int(kind != "gap"), x.place] == 0.0 for x in systems):
            what = "displacement" if kind == "gap" else "velocity"
            raise ValueError(
                f"{who} does not move the {what} at which it takes the force: expected one that it moves, so that a "
                "reaction acts there; take another scheme"
            )
    if kinds != ["friction"]:
        require_error_decay(f"a structure with {structure.contacts.kind}", scheme)


def _starts_otherwise(scheme: Scheme) -> bool:
    """Whether another scheme starts it, or its start solves systems."""
    return scheme.starter is not None or (scheme.info.start != "given" and bool(start_of(scheme, 1.0).systems))


def _at_a_mean(system: System) -> bool:
    """Whether a balance takes a force that it moves elsewhere than where its reactions act."""
    if system.touch is None:
        return False
    if system.touch.later or system.together:
        return len(system.displacements) != 1
    moved = [force.u for force in system.forces if force.u[system.place] != 0.0]
    return bool(system.differences) or any(not np.array_equal(u, system.touch.rows[0]) for u in moved)


def require_undamped(structure: Model, scheme: Scheme, who: str) -> None:
    """Raises ValueError for damping, also in an internal force at the start, and a scheme that takes none.

    who: what the error calls the scheme.
    """
    if scheme.info.damping:
        return
    if structure.C is not None:
        raise needs_no_damping(who, "a structure without damping, got one with C")
    if damped_at_start(structure):
        raise needs_no_damping(who, f"{OF_DISPLACEMENTS} at the start")


def require_definite_mass(structure: Model) -> None:
    """Raises ValueError for a symmetric M with a negative eigenvalue, of which no motion of a structure is."""
    if (place := structure.indefinite) is not None:
        raise ValueError(
            "expected a mass matrix M without negative eigenvalues, got one that gives negative kinetic energy to a "
            f"motion that shows most in degree of freedom {structure.named(place)}; correct its entries there"
        )


def require_decay(structure: Model) -> None:
    """Raises ValueError for a K or a C with a negative eigenvalue: a motion then grows by itself, whatever the step.

    Of C its symmetric part counts, the rest does no work; one of low rank is positive, one known by products is
    believed.
    """
    if (place := indefinite(structure.K)) is not None:
        raise ValueError(
            "expected a stiffness matrix K without negative eigenvalues, got one under which a motion grows that shows "
            f"most in degree of freedom {structure.named(place)}, so that no step is stable; correct its entries "
            "there, or march in steps of an accuracy that you choose"
        )
    C = structure.C
    if C is None or isinstance(C, LowRank) or is_operator(C):
        return
    if isinstance(C, Rayleigh) and C.alpha >= 0.0 and C.beta >= 0.0:
        return
    if (place := indefinite(0.5 * (structure.damping + structure.damping.T))) is not None:
        raise ValueError(
            "expected damping without negative eigenvalues, got one that feeds energy into a motion that shows most in "
            f"degree of freedom {structure.named(place)}, so that no step is stable; correct the sign of C there, or "
            "march in steps of an accuracy that you choose"
        )


def require_no_contacts(structure: Model, what: str, cure: str) -> None:
    """Raises ValueError for a structure with contacts; what: asked for."""
    if structure.contacts is not None:
        raise ValueError(
            f"expected a structure without {structure.contacts.kind} for {what}, got {structure.contacts.kind} "
            f"{', '.join(structure.contacts.names)}; {cure}"
        )


def require_linear(structure: Model, what: str) -> None:
    """Raises ValueError for contacts, and for an internal force, of which the tangent at u0 alone would count."""
    require_no_contacts(structure, what, "march the structure itself, or make it without")
    if structure.internal is not None:
        raise ValueError(
            f"expected a linear structure for {what}, got one with internal_force or springs, of which it would know "
            "the tangent at u0 only; march the structure itself, or linearise it on purpose by "
            "structure(M, tangent(u0), ...)"
        )


def require_tangent(structure: Model, what: str) -> None:
    """Raises ValueError for a structure with an internal force that was given no tangent."""
    if structure.K is None:
        raise ValueError(f"expected the tangent at u0 for {what}, got a structure without; give it tangent=")


def unsymmetric(structure: Model) -> str | None:
    """M or K where it is not symmetric, so that no energy belongs to it: the work of a force is added up without K."""
    matrices = {"M": structure.M} | ({"K": structure.K} if structure.internal is None else {})
    return next((name for name, matrix in matrices.items() if asymmetry(matrix) > 1e-10), None)
