"""Explicit balances: what a reaction in them holds, a later displacement, and the mean velocity that leads there.

Such a balance takes the force where its own acceleration moves nothing, so that neither the displacement nor the
velocity there is what its reaction decides. See `prescribed` for the displacement that it does.
"""

from sympy import Expr, Integer, Rational, Symbol, cancel

from ..algebra.constant import reduced
from ..declare.errors import DeclarationError
from ..declare.symbols import C, N, f, h, knot, successor
from ..step.step import Step
from ..step.times import instants_of, moved
from .prescribed import Prescribed


def explicit(step: Step) -> bool:
    """Whether some balance takes the force at a displacement that it does not move."""
    return not all(stage.moved for stage in step.stages)


def held_next(step: Step, u: Symbol) -> Expr:
    """A displacement at which reactions hold: of the step, or of the next one, where it follows from the state."""
    return step.prior[u].xreplace({s: successor(s) for s in step.state}) if u in step.prior else u


def first_factors(step: Step, u: Symbol) -> tuple[Expr, Expr, Expr] | None:
    """Factors of u, v, a at the start in a displacement that follows from the state; None where others enter."""
    start = None if step.start is None else dict(zip(step.state, step.start, strict=True))
    first = step.prior[u].subs(start or {}, simultaneous=True)
    u0, v0, a0 = knot(0)
    return None if start is None or first.has(N, f, C) else (first.diff(u0), first.diff(v0), first.diff(a0))


def require_held(step: Step, found: Prescribed, *, bounded: bool, gaps: bool) -> None:
    """Raises DeclarationError for an explicit scheme that takes no such reactions.

    bounded: whether some only push, or have a limit; gaps: whether some are of contacts, on which impacts act.
    """
    _require_next(step, found)
    if bounded:
        _require_forward(step, found)
    if gaps:
        _require_moving_on(step, found)


def _require_next(step: Step, found: Prescribed) -> None:
    """Raises DeclarationError for an explicit scheme whose balances do not hold later displacements one by one."""
    name, z = step.scheme.name, step.accelerations
    forces = {a for b in step.scheme.balances for a in b.force.atoms(N)}
    if beyond := sorted({a for e in step.outputs for a in e.atoms(N)} - forces, key=str):
        raise DeclarationError(
            f"{name} reports a velocity with the force {beyond[0]}, whose reaction only the next step determines: "
            "expected one by accelerations of its balances; take another scheme, such as central_difference"
        )
    late = ((u, zj) for k, (u, _) in enumerate(found.held) for zj in z[k + 1 :])
    if any(zj in held_next(step, u).subs(step.solved).free_symbols for u, zj in late):
        raise DeclarationError(
            f"{name}: expected each balance to hold a displacement that no later one moves, so that they are solved "
            "one after the other; take another scheme for constraints"
        )
    for u in (u for u, _ in found.held if u in step.prior):
        factors = first_factors(step, u)
        if u in step.reported and (factors is None or factors[2] == 0):
            raise DeclarationError(
                f"{name} moves its first displacement by the velocity of the start alone: expected one that the "
                "reaction there moves, so that it holds the constraint; take another scheme"
            )
    if found.decay is not None and found.decay.n(20) > 1 + Rational(1, 10**9):
        raise DeclarationError(
            f"{name} multiplies errors along constraints by {float(found.decay):.4g} in each step: expected a factor "
            "of at most 1; take another scheme"
        )


def _require_forward(step: Step, found: Prescribed) -> None:
    """Raises DeclarationError for explicit balances against whose mean velocities reactions do not act."""
    near = Step.of(step.scheme.in_doubles)
    typical = {**near.scheme.typical, C: Integer(0), h: Integer(1)}
    for k, (u, _) in enumerate(found.held):
        by_z = mean_velocity(near, k, u).subs(near.solved, simultaneous=True).diff(near.accelerations[k])
        if not by_z.subs(typical).is_positive:  # nor is it where both are at one instant
            raise DeclarationError(
                f"{step.scheme.name} has a sub-step that does not go forward in time, in which a reaction that only "
                "pushes would pull: expected such balances where there are contacts or friction; take another scheme, "
                "such as central_difference"
            )


def _require_moving_on(step: Step, found: Prescribed) -> None:
    """Raises DeclarationError for an explicit scheme whose steps do not go on with the velocity that an impact leaves.

    That is the mean velocity with which the displacement is reached that the reaction of a balance holds, from where
    it acts. It stays as it is, without forces, in later balances, and is what the next steps report, unlike Beeman's.
    """
    means = [mean_velocity(step, k, u) for k, (u, _) in enumerate(found.held)]
    plain, lasts = {C: Integer(0), h: Integer(1)}, not {*knot(0)[:2]} - {*step.state}
    for k, z in enumerate(step.accelerations):
        state, given, velocities = dict.fromkeys(step.state, Integer(0)), {z: Integer(1)}, list[Expr]()
        for number in range(len(step.state) + 1):
            here = {**plain, **state, **dict.fromkeys(step.accelerations, Integer(0)), **given}
            here |= {s: e.subs(here, simultaneous=True) for s, e in step.solved.items()}
            seen = [*means, step.reported[1]] if number > 0 else means
            velocities += [e.subs(here, simultaneous=True) for e in seen]
            state, given = {s: here[successor(s)] for s in step.state}, {}
        lasts = lasts and all(reduced(cancel(x - velocities[k])) == 0 for x in velocities[k + 1 :])
    if not lasts:
        raise DeclarationError(
            f"{step.scheme.name} is explicit and does not move on with the velocity that an impact leaves: expected "
            "one whose steps do so from the first one on; take central_difference, or an implicit scheme"
        )


def mean_velocity(step: Step, k: int, held: Symbol) -> Expr:
    """The mean velocity from where the k-th balance takes the force to the displacement that its reaction holds."""
    u, _ = moved(step, k)
    times = instants_of(step)
    ahead = times[held] + int(held in step.prior) - times[u]
    return (held_next(step, held) - u) / (h * ahead)
