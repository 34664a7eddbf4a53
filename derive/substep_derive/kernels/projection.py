"""Projection of what a step gives onto the constraints of a scene, at displacements and at velocities.

It moves u as a reaction at u does, which is as little as possible, measured by the mass, and then v (Hairer & Wanner,
Solving Ordinary Differential Equations II, VII.2). What is off after a step is of the order of its error, h^3, so that
two corrections of u leave h^9, below rounding unless steps are coarse; that of v is exact.
"""

from collections.abc import Mapping, Sequence

from sympy import Expr, Integer, Matrix, Symbol

from ..declare.errors import DeclarationError
from ..declare.symbols import knot
from ..motion.components import Assignments, Writer, assign
from ..step.step import Step
from .held_block import held_block, held_solution

U, V = Symbol("u_*kept"), Symbol("v_*kept")  # those at t_n + h once they are projected


def projected(w: Writer, step: Step) -> tuple[Mapping[Symbol, Symbol], Mapping[Symbol, Symbol], Assignments]:
    """New displacement and velocity -> their names once they are projected, in the state and in what is reported.

    And assignments of these. Where a balance holds a displacement of the next step, which the velocity moves, only what
    is reported is projected: of central differences that is RATTLE.

    Raises DeclarationError for a scheme of which u and v at t_n + h are not its own, and for what cannot be projected.
    """
    scene, held = w.motion.scene, w.motion.held
    given = list(scene.constraints.values())
    if not any(constraint.projected for constraint in given):
        return {}, {}, Assignments()
    (u1, v1, _), (u0, v0, _) = knot(1), knot(0)
    ahead = any(u in step.prior for u in w.holding)
    in_position = [k for k, x in enumerate(given) if not held.of_rates[k] and (x.projected or x.level == "position")]
    in_velocity = [k for k, x in enumerate(given) if held.at_velocities[k] or x.projected]
    moves = any(held.at_velocities[k] for k in in_position)
    if step.outputs[:2] != (u1, v1) or not {u0, v0} <= {*step.state} or (ahead and moves):
        raise DeclarationError(
            f"{step.scheme.name}: expected steps that begin with the displacement and the velocity that they report, "
            f"so that both may be projected, on {scene.name}; take another scheme, or leave out projected=True"
        )
    if scene.contacts or any(m == 0 for m in w.motion.mass.diagonal()):
        raise DeclarationError(
            f"{scene.name}: expected a mass of each coordinate and no contacts where constraints are projected, since "
            "that is measured by the mass and opens or closes gaps; leave out projected=True"
        )
    u, v, found, when = w.components(u1), w.components(v1), Assignments(), w.instant(Integer(1))
    if moves:
        matrix, found = _matrix(w, in_position, u, when, "in_u")
        for mark in ("in_u", "in_u_once_more"):
            off = held.at(held.expressions, list(u), list(v), when)
            change, more = _change(w, matrix, [off[j] for j in in_position], mark)
            found += more
            u -= change
        found += assign(w.components(U), u)
        u = w.components(U)
    matrix, more = _matrix(w, in_velocity, u, when, "in_v")
    off = held.at(held.drift[0], list(u), list(v), when)
    change, solve = _change(w, matrix, [off[j] for j in in_velocity], "in_v")
    found += [*more, *solve, *assign(w.components(V), v - change)]
    names = {v1: V} | ({u1: U} if moves else {})
    return {} if ahead else names, names, found


def _matrix(w: Writer, places: Sequence[int], u: Matrix, when: Expr, mark: str) -> tuple[Matrix, Assignments]:
    """The system of some constraints at u."""
    mass, _ = w.motion.equation(list(u), list(u), when)
    return held_block(w, places, mass, w.motion.held.directions_at(list(u), when), mark)


def _change(w: Writer, block: Matrix, off: Sequence[Expr], mark: str) -> tuple[Matrix, Assignments]:
    """By how much a vector is to be less, so that what is off becomes 0, and what is computed for it."""
    found, given, solve = held_solution(w, block, Matrix([*[Integer(0)] * w.size, *off]), mark)
    return found[: w.size, :], given + solve
