"""Step -> EffectiveSystem: effective stiffness, residual and recovery of v and a of each balance, as in papers."""

from dataclasses import dataclass
from functools import cache

from sympy import Expr, Symbol, factor

from ..declare.scheme import Scheme
from ..declare.symbols import C, M
from ..step.step import Stage, Step, affine


@dataclass(frozen=True)
class EffectiveSystem:
    """One balance in its own unknown: R(unknown) = 0, solved by effective_stiffness * d = -R.

    unknown: the new displacement, or, for an explicit balance, the new acceleration.
    residual: M*a + C*v + N - F, with v and a expressed in the unknown and in what is known.
    tangent: derivative of the internal force, K_t at the displacement where the force is taken.
    effective_stiffness: derivative of the residual (an effective mass for an explicit balance).
    recover_v, recover_a: velocity and acceleration at the balance from the solved unknown.
    effective_mass: derivative of the residual by the new acceleration z, c_a M + c_v C + c_u K_t;
    c_u, c_v, c_a: derivatives of displacement, velocity and inertia by z.
    """

    unknown: Symbol
    residual: Expr
    tangent: Expr
    effective_stiffness: Expr
    recover_v: Expr
    recover_a: Expr
    effective_mass: Expr
    c_u: Expr
    c_v: Expr
    c_a: Expr

    @property
    def explicit(self) -> bool:
        """Whether the internal force does not depend on the unknown acceleration."""
        return self.c_u == 0


@cache
def effective_systems(scheme: Scheme) -> tuple[EffectiveSystem, ...]:
    """The effective system of each balance. Raises DeclarationError as `Step.stages` does."""
    return tuple(_effective(stage, scheme.name) for stage in Step.of(scheme).stages)


def _effective(stage: Stage, scheme: str) -> EffectiveSystem:
    balance, z, in_z = stage.balance, stage.z, stage.in_z
    residual = M * balance.inertia + C * balance.damping + balance.force - balance.load
    if len(stage.moved) == 1 and stage.c_u != 0:
        (unknown,) = stage.moved
        free = [s for s in (*in_z, z) if s != unknown]
        by_unknown = affine(stage.relations, free, scheme)
    else:
        unknown, by_unknown = z, in_z
    residual = residual.subs(by_unknown)
    inertia, damping = balance.inertia.subs(by_unknown), balance.damping.subs(by_unknown)
    tangent = balance.force.subs(by_unknown).diff(unknown)
    c_v, c_a = stage.c_v, stage.c_a
    return EffectiveSystem(
        unknown=unknown,
        residual=residual,
        tangent=tangent,
        effective_stiffness=M * factor(inertia.diff(unknown)) + C * factor(damping.diff(unknown)) + tangent,
        recover_v=damping,
        recover_a=inertia,
        effective_mass=c_a * M + c_v * C + stage.c_u * tangent,
        c_u=stage.c_u,
        c_v=c_v,
        c_a=c_a,
    )
