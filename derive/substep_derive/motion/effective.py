"""Step -> EffectiveSystem: effective stiffness, residual and recovery of v and a of each balance, as in papers."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache

from sympy import Expr, Matrix, Symbol, cancel, factor

from ..algebra.constant import reduced
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
    beside: of a balance that is solved with others, the derivatives of its residual by their unknowns: with these, its
    row in the effective stiffness of all of them.
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
    beside: Mapping[Symbol, Expr] = field(default_factory=dict[Symbol, Expr])

    @property
    def explicit(self) -> bool:
        """Whether no internal force depends on the unknown acceleration."""
        return self.c_u == 0 and not self.beside


@cache
def effective_systems(scheme: Scheme) -> tuple[EffectiveSystem, ...]:
    """The effective system of each balance. Raises DeclarationError as `Step.stages` does."""
    step = Step.of(scheme)
    found = {
        j: _effective(stage, k, scheme.name)
        for places, stage in zip(step.together, step.stages, strict=True)
        for k, j in enumerate(places)
    }
    return tuple(found[j] for j in sorted(found))


def _effective(stage: Stage, k: int, scheme: str) -> EffectiveSystem:
    balance, unknowns, by_unknown = stage.balances[k], stage.z, stage.in_z
    residual = M * balance.inertia + C * balance.damping + balance.force - balance.load
    moved = [stage.moved_by(j) for j, _ in enumerate(stage.z)]
    own = tuple(dict.fromkeys(s for symbols in moved for s in symbols))
    if all(len(symbols) == 1 for symbols in moved) and len(own) == len(moved):
        by_z = Matrix([[stage.in_z[s].diff(z) for z in stage.z] for s in own])
        if reduced(cancel(by_z.det())) != 0:
            unknowns = own
            by_unknown = affine(stage.relations, [s for s in (*stage.in_z, *stage.z) if s not in unknowns], scheme)
    unknown = unknowns[k]
    residual = residual.subs(by_unknown)
    inertia, damping, force = (e.subs(by_unknown) for e in (balance.inertia, balance.damping, balance.force))

    def stiffness(s: Symbol) -> Expr:
        return M * factor(inertia.diff(s)) + C * factor(damping.diff(s)) + force.diff(s)

    c_u, c_v, c_a = stage.c_u(k), stage.c_v(k), stage.c_a(k)
    tangent = force.diff(unknown)
    return EffectiveSystem(
        unknown=unknown,
        residual=residual,
        tangent=tangent,
        effective_stiffness=stiffness(unknown),
        recover_v=damping,
        recover_a=inertia,
        effective_mass=stiffness(unknown) if unknown in stage.z else c_a * M + c_v * C + c_u * tangent,
        c_u=c_u,
        c_v=c_v,
        c_a=c_a,
        beside={s: stiffness(s) for s in unknowns if s != unknown},
    )
