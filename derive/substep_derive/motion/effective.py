"""Scheme -> EffectiveSystem: effective stiffness, residual and recovery of v and a per balance.

All relations together make every new symbol affine in the balances' new accelerations z. A symbol
belongs to the first balance that determines it; a balance may only read what earlier balances
determined and its own z.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

from sympy import Expr, Matrix, Symbol, cancel, factor

from ..algebra import rational
from ..algebra.constant import constant_of
from ..declare.errors import DeclarationError
from ..declare.scheme import Balance, Scheme
from ..declare.symbols import C, M, N, N_discrete, knot_of


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


def affine(relations: Mapping[Symbol, Expr], unknowns: Sequence[Symbol], scheme: str) -> Mapping[Symbol, Expr]:
    """The relations solved for the unknowns, each in terms of every other symbol."""
    return _affine(tuple(relations.items()), tuple(unknowns), scheme)


@cache  # a scheme's relations are the same on every scene
def _affine(
    relations: tuple[tuple[Symbol, Expr], ...], unknowns: tuple[Symbol, ...], scheme: str
) -> Mapping[Symbol, Expr]:
    if not unknowns:
        return {}
    equations = Matrix([symbol - expression for symbol, expression in relations])
    matrix = equations.jacobian(Matrix(unknowns))
    others = sorted((s for s in equations.free_symbols - set(unknowns) if knot_of(s)), key=str)
    known = equations.jacobian(Matrix(others))
    try:
        numerators, den = rational.solve(matrix, -known)
    except rational.SingularMatrix as error:
        raise DeclarationError(
            f"{scheme}: the relations for {', '.join(map(str, unknowns))} do not determine them; "
            "one of them repeats another"
        ) from error
    numbers = constant_of(equations) is not None  # of its field, which have one form

    def coefficient(i: int, j: int) -> Expr:
        return numerators[i, j] / den if numbers else factor(cancel(numerators[i, j] / den))

    solved = {
        symbol: sum((coefficient(i, j) * other for j, other in enumerate(others)), 0 * den)
        for i, symbol in enumerate(unknowns)
    }
    return MappingProxyType(solved)


def new_accelerations(scheme: Scheme) -> list[Symbol]:
    """For each balance the new acceleration z it is solved for: the one in its inertia.

    A balance whose inertia is a difference of velocities gets a symbol of its own for it.
    """
    new = set(scheme.unknowns)
    found: list[Symbol] = []
    for balance in scheme.balances:
        candidates = [s for s in scheme.unknowns if s in balance.inertia.free_symbols & new and s.name[0] == "a"]
        candidates = [s for s in candidates if s not in found]
        found.append(candidates[0] if candidates else Symbol(f"a_*{len(found) + 1}"))
    return found


@dataclass(frozen=True)
class Stage:
    """One balance, its new acceleration z, and what becomes known with it.

    relations: those of the declared ones that belong to this stage. in_z: every other symbol of the stage, affine
    in z and in the symbols of earlier stages. moved: those of them at which the balance takes the internal force.
    """

    balance: Balance
    z: Symbol
    relations: dict[Symbol, Expr]
    in_z: Mapping[Symbol, Expr]
    moved: frozenset[Symbol]

    @property
    def c_u(self) -> Expr:
        """The derivative by z of the displacement at which the internal force is taken; 0 for an explicit balance."""
        return factor(sum((self.in_z[s].diff(self.z) for s in self.moved if s in self.in_z), 0 * self.z))


@cache
def stages(scheme: Scheme) -> tuple[Mapping[Symbol, Expr], tuple[Stage, ...]]:
    """(the new symbols that follow from the state alone, one stage for each balance).

    Raises DeclarationError when a balance reads an acceleration that a later balance defines.
    """
    z = new_accelerations(scheme)
    relations = dict(scheme.relations)
    for balance, symbol in zip(scheme.balances, z, strict=True):
        if symbol not in scheme.unknowns:
            relations[symbol] = balance.inertia
    unknowns = [s for s in scheme.unknowns if s not in z]
    solved = affine(relations, unknowns, scheme.name)
    level = {s: max((k + 1 for k, zk in enumerate(z) if e.has(zk)), default=0) for s, e in solved.items()}
    level |= {zk: k + 1 for k, zk in enumerate(z)}
    prior = {s: e for s, e in solved.items() if level[s] == 0}
    found: list[Stage] = []
    for k, balance in enumerate(scheme.balances, start=1):
        if late := [s for s in sorted(balance.symbols, key=str) if level.get(s, 0) > k]:
            raise DeclarationError(
                f"{scheme.name}: balance {k} reads {late[0]}, which depends on the acceleration of a later "
                "balance; write the balances in the order in which they are solved, each for its own acceleration"
            )
        own = {
            s: e for s, e in relations.items() if max((level.get(x, 0) for x in (e - s).free_symbols), default=0) == k
        }
        in_z = affine(own, [s for s in level if level[s] == k and s != z[k - 1]], scheme.name)
        where = {arg for atom in balance.force.atoms(N, N_discrete) for arg in atom.args}
        moved = frozenset(s for arg in where for s in arg.free_symbols if level.get(s) == k)
        found.append(Stage(balance, z[k - 1], own, in_z, moved))
    return MappingProxyType(prior), tuple(found)


@cache
def effective_systems(scheme: Scheme) -> tuple[EffectiveSystem, ...]:
    """The effective system of each balance. Raises DeclarationError as `stages` does."""
    return tuple(_effective(stage, scheme.name) for stage in stages(scheme)[1])


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
    c_v = factor(balance.damping.subs(in_z).diff(z))
    c_a = factor(balance.inertia.subs(in_z).diff(z))
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
