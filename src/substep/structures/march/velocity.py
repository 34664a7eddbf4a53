"""Internal forces N(u, v) under schemes that do not give them the velocity, or know their damping at the start only."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.errors import warn
from ...core.schemes import Scheme
from ..model.internal_force import ROUNDING, InternalForce
from ..model.model import Model
from .scheme_plan import Steps, System

CHANGED = 1e-2  # of the damping in the force, by which it may differ from what coefficients know of it
OF_DISPLACEMENTS = "an internal force that does not depend on velocities, got one that does"


def needs_no_damping(who: str, expected: str) -> ValueError:
    """The error of a scheme, who, that takes no damping; expected, and got: in words."""
    return ValueError(
        f"{who} is a scheme for u'' = g(t, u): expected {expected}; take a scheme that takes damping, such as "
        "dormand_prince"
    )


def takes_damping_at_start(system: System) -> bool:
    """Whether it gives coefficients of a scheme, as those of KR-alpha, from C: it has damping but no internal force."""
    return not system.displacements and bool(system.damping.any())


def damped_at_start(structure: Model) -> bool:
    """Whether the internal force at u0 depends on velocities, of either sign."""
    s, force = structure, structure.internal
    if force is None or force.reads < 2:
        return False
    v = max(1.0, float(np.abs(s.v0).max())) * np.cos(np.arange(s.size))  # which moves every degree of freedom
    with np.errstate(all="ignore"):
        return any(force.damps(0.0, s.u0, x) for x in (v, -v))


def require_tangent_by_velocity(structure: Model, who: str) -> None:
    """Raises ValueError for such a force whose tangent is no pair; who takes that at the start."""
    if structure.force_damping is None and damped_at_start(structure):
        raise ValueError(
            f"{who} takes the damping at the start: expected tangent= to return a pair, the derivatives of the "
            "internal force by u and by v, for a force that depends on v, got one matrix; return both, or take another "
            "scheme, such as dormand_prince"
        )


@dataclass(eq=False)
class Watch:
    """Looks, step by step, whether velocities add to the internal force what a scheme knows of, and no more.

    known: the derivative of the force by v (n, n) that the scheme's coefficients take, None for a scheme of
    u'' = g(t, u). That costs one evaluation of the force a step, of a scheme with such coefficients two.
    """

    force: InternalForce
    known: Any
    who: str
    warned: bool = False

    @classmethod
    def of(cls, structure: Model, scheme: Scheme, steps: Steps) -> "Watch | None":
        """None where there is nothing to look at: a force of u alone, or a scheme that gives it the velocity."""
        force = structure.internal
        if force is None or force.remembers or force.reads < 2:
            return None
        if not scheme.info.damping:
            return cls(force, None, scheme.name)
        if not any(takes_damping_at_start(x) for x in steps.systems):
            return None
        none = 0.0 * structure.M
        return cls(force, none if structure.force_damping is None else structure.force_damping, scheme.name)

    def look(self, t: float, u: Array, v: Array) -> None:
        """At a state of the last step. Raises ValueError, or warns once, for damping that the scheme does not know."""
        if self.known is None:
            if self.force.damps(t, u, v):
                raise needs_no_damping(self.who, f"{OF_DISPLACEMENTS} at t = {t:.6g}")
        elif not self.warned:
            found, known = self.force.damping(t, u, v), self.known @ v
            size, wrong = (float(np.abs(x).max()) for x in (found, found - known))
            if wrong > CHANGED * size + ROUNDING * float(np.abs(self.force(t, u, v)).max()):
                self.warned = True
                warn(
                    f"{self.who} takes the damping at the start, from which that of the internal force differs by "
                    f"{wrong:.3g} of {size:.3g} at t = {t:.6g}: it is of first order then; take another scheme, such "
                    "as dormand_prince, where that matters"
                )
