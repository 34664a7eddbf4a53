"""Reactions of a scene in a balance: the rows by which they are solved for, and what is not remembered of them.

Every balance has an unknown for each reaction beside its new acceleration z. A constraint holds its expression at the
first displacement that moves with z, of explicit schemes a later one than that of the force, or at the velocity that
moves with z; of a contact the smaller of gap and pressure is 0, or of a velocity and the pressure; and friction is at
its limit, or nothing slides. Newton's iteration finds the branch of each.

In implicit schemes these are the velocity at the knot where the balance takes the force, and reactions that are not
remembered accelerate z by M^-1 G^T times the unknown, whatever weight a balance gives to forces: only their impulse
counts. See `step.times.impulses` for what it is of a constant force. Explicit balances take reactions as they take
forces, and hold the mean velocity with which the next displacement is reached, since no other one moves anything.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from sympy import Abs, Expr, Integer, Matrix, Rational, Symbol, cancel, zeros

from ..algebra.constant import reduced
from ..constrained.explicit import explicit, first_factors, require_held
from ..constrained.prescribed import Prescribed, prescribed
from ..declare.branches import larger, slope, smaller, where_at_least
from ..declare.errors import DeclarationError
from ..declare.parameter import signed
from ..declare.scheme import Scheme
from ..declare.symbols import C, N, h, knot, successor
from ..motion.components import Writer
from ..motion.equations import EquationsOfMotion
from ..step.step import Stage, Step
from ..step.times import drift_at_rest, growth_where_held, impulses, impulses_last, instants_of, moved, newest
from .remembering import at_start, remembered

ROUNDING = Rational(1, 10**12)  # of a scene's length: a smaller gap is closed, so that what rests on a stop stays there


@dataclass(frozen=True)
class Moving:
    """A displacement or a velocity that may move with the accelerations z of a stage.

    names: its components; each: their derivative by each z; k: the place of the balance's own; when: its time.
    """

    names: Matrix
    each: Sequence[Expr]
    k: int
    when: Expr

    @property
    def by_z(self) -> Expr:
        """The derivative by the balance's own z; where that does not move it, by the first one that does."""
        return next((e for e in (self.each[self.k], *self.each) if e != 0), Integer(0))


def begin(w: Writer, scheme: Scheme, step: Step) -> None:
    """Prepares the writing of a step: what reactions were at t_n, and how they act.

    Raises DeclarationError for a scheme whose balances do not move what the scene's reactions hold.
    """
    scene = w.motion.scene
    if scene.multipliers and (found := _require_holding(scheme, Asked.by(w.motion))):
        w.holding = tuple(u for u, _ in found.held)
    impulsive = scene.impulsive and not explicit(step)
    w.latest = at_start(scene)
    u0 = knot(0).u
    if any(b.force.has(N(successor(u0))) for b in step.scheme.balances):  # else what is taken at u_0 is unknown
        w.reactions[u0] = remembered(scene)
    w.strengths = impulses(step).strengths if impulsive else ()


def by_velocity(motion: EquationsOfMotion) -> bool:
    """Whether any of them is decided by a velocity."""
    bounces = any(contact.restitution is not None for contact in motion.scene.contacts.values())
    return bool(motion.scene.frictions or motion.held.at_both) or bounces or any(motion.held.at_velocities)


def held_first(w: Writer, step: Step) -> tuple[tuple[Expr, Expr, Expr], Expr] | None:
    """The displacement of the first step that the reaction at its start holds: factors of u, v, a there; its instant.

    None where there is none: reactions hold displacements of their own step, or one that the start alone moves.
    """
    found = ((u, first_factors(step, u)) for u in w.holding if u in step.prior)
    return next(((factors, w.instants[u]) for u, factors in found if factors and factors[2] != 0), None)


@dataclass(frozen=True)
class Asked:
    """What reactions ask of a scheme.

    positions, rates: whether some hold a displacement, or are decided by a velocity; velocities: whether constraints
    are; both: whether some hold both. contacts: whether some only push, or are friction; gaps: whether some only push;
    restitution: whether some contact has one. impulsive: whether they are not remembered. lasting: whether constraints
    hold a displacement.
    """

    positions: bool
    rates: bool
    velocities: bool
    contacts: bool
    gaps: bool
    restitution: bool
    impulsive: bool
    both: bool = False
    lasting: bool = False

    @classmethod
    def by(cls, motion: EquationsOfMotion) -> "Asked":
        """Those of a scene."""
        scene, restitutions = motion.scene, [x.restitution is not None for x in motion.scene.contacts.values()]
        velocities = sum(motion.held.at_velocities)
        at_positions = len(scene.constraints) - velocities + restitutions.count(False)
        either = bool(scene.contacts or scene.frictions)
        return cls(
            at_positions > 0, by_velocity(motion), velocities > 0, either, bool(restitutions), any(restitutions),
            scene.impulsive, bool(motion.held.at_both), len(scene.constraints) > velocities,
        )  # fmt: skip


def why_no_contact(scheme: Scheme, *, restitution: bool = False, friction: bool = False) -> str:
    """Why the scheme takes no contacts of a structure, with restitution, or no frictions; empty where it takes them."""
    if not all(stage.alone for stage in Step.of(scheme).stages):
        return (
            f"{scheme.name} solves balances together: expected balances that are solved one after the other on a "
            "structure with contacts or friction; take another scheme"
        )
    rates = restitution or friction
    try:
        _require_holding(scheme, Asked(not rates, rates, False, True, not friction, restitution, True))
    except DeclarationError as error:
        return str(error)
    return ""


def holds(scheme: Scheme) -> bool:
    """Whether reactions of its balances can hold displacements, as those of constraints do."""
    try:
        _require_holding(scheme, Asked(True, False, False, False, False, False, False))
    except DeclarationError:
        return False
    return True


def _require_holding(scheme: Scheme, asked: Asked) -> Prescribed | None:
    """What the scheme makes of constraints at displacements; None where there are none.

    Raises DeclarationError for a scheme whose balances do not move what reactions hold.
    """
    step = Step.of(scheme)
    later = explicit(step)
    together = not all(stage.alone for stage in step.stages)
    if asked.gaps and asked.positions and together and (still := _still(step)):
        raise DeclarationError(
            f"{scheme.name} solves balances together, of which one does not move the displacement {still} that it "
            "takes the force at by its own acceleration: expected a pressure that opens the gap at which it acts; take "
            "a scheme that solves its balances one after the other"
        )
    if asked.both and (later or asked.contacts or together):
        cure = 'level="velocity"' if asked.contacts else 'level="position" with projected=True, or another scheme'
        raise DeclarationError(
            f"{scheme.name}: expected implicit balances that are solved one after the other, and no contacts or "
            f"frictions, where a constraint holds displacements and velocities; take {cure}"
        )
    if asked.rates or (asked.impulsive and not later):
        impulses(step)
    found = prescribed(scheme) if asked.positions or (later and asked.contacts) else None
    if found and later:
        require_held(step, found, bounded=asked.contacts, gaps=asked.gaps)
    grows = growth_where_held(step) if asked.impulsive and asked.lasting and not later else 0.0
    if grows > 1 + 1e-9:
        raise DeclarationError(
            f"{scheme.name}: expected velocities that follow a displacement which is held, where reactions are not "
            f"remembered, beside contacts or frictions, got some that are multiplied by {grows:.3g} in each step; take "
            "another scheme, such as average_acceleration"
        )
    missing = [s for s in knot(0)[:2] if s not in step.state]
    if asked.restitution and not later and (missing or not impulses_last(step)):
        raise DeclarationError(
            f"{scheme.name} does not keep the velocity that an impact leaves: expected one that is the same a step "
            "later, of which restitution is a share; take a scheme of one balance, such as average_acceleration"
        )
    one = asked.restitution and not later and len(step.accelerations) == 1
    if one and (drift := float(drift_at_rest(step).subs(scheme.typical))) < 0:
        raise DeclarationError(
            f"{scheme.name} lets what rests on a stop with restitution sink into it, by {-drift:.3g} dt^2 times the "
            "acceleration that is held in each step: expected one that stays, as those with gamma = 2 beta; take "
            "average_acceleration"
        )
    at_last = newest(step, step.stages[-1])
    if asked.contacts and asked.impulsive and not later and impulses(step).strengths[at_last].subs(scheme.typical) <= 0:
        raise DeclarationError(
            f"{scheme.name} takes nothing of a constant force at the end of its steps where the acceleration at their "
            "start is not remembered: expected a friction that holds the velocity there; take another scheme, such as "
            "radau_iia2"
        )
    last, _ = moved(step, at_last)
    if last in step.state and (asked.velocities or not found):
        raise DeclarationError(
            f"{scheme.name} takes the force at the start of its steps: expected a reaction at a displacement that is "
            "new; take another scheme"
        )
    at_end = found.at_end if found else instants_of(step)[last].subs(scheme.typical) == 1
    if not at_end:
        raise DeclarationError(
            f"{scheme.name} takes no force at the end of its steps: expected a reaction that holds the displacement "
            "there, which would drift from the constraint; take another scheme"
        )
    return found


def _still(step: Step) -> Symbol | None:
    """A displacement that a balance takes the force at and does not move by its own z in the direction of that."""
    typical = {**step.scheme.typical, h: Integer(1), C: Integer(0)}
    for k, z in enumerate(step.accelerations):
        u, _ = moved(step, k)
        by_z = step.solved.get(u, Integer(0)).diff(z)
        if not reduced(cancel(by_z)).subs(typical).is_positive:
            return u
    return None


Held = tuple[Moving, Moving, Moving, Moving]


def rows_of(w: Writer, k: int, stage: Stage, unknown: Matrix, at: Held) -> tuple[Matrix, Matrix]:
    """What is 0 where the k-th balance's reactions are right, and its derivative by the accelerations of the stage.

    unknown: the reactions. at: the displacement at which constraints hold; u and v at the knot where the balance takes
    the force, of implicit schemes the same; and the velocity that contacts and frictions hold, v or a `mean_velocity`.
    """
    (held, _, v, mean), more = at, _rows(w, k, stage, unknown, *at)
    below = zeros(len(more), w.size * len(stage.z))
    for moving in (held, v) if mean is v else (held, v, mean):
        by_it = Matrix([[slope(e, s) for s in moving.names] for e in more])
        below += Matrix.hstack(*(by_it * e for e in moving.each))
    return more, below


def _rows(w: Writer, k: int, stage: Stage, unknown: Matrix, to: Moving, u: Moving, v: Moving, mean: Moving) -> Matrix:
    """The rows, divided so that they do not depend on the step."""
    scene, held = w.motion.scene, w.motion.held
    place, speed, c_u, c_v, when = u.names, v.names, to.by_z, v.by_z, u.when
    values = held.at(held.expressions, list(to.names), list(speed), to.when)
    rates = held.at(held.drift[0], list(place), list(speed), when)
    c, d = len(scene.constraints), len(scene.contacts)
    moves = _mobilities(w)
    found = [rates[j] / c_v if held.at_velocities[j] else values[j] / c_u for j in range(c)]
    rates, c_v = held.at(held.drift[0], list(place), list(mean.names), when), mean.by_z
    strength = w.strengths[k] if w.strengths else Integer(1)
    for j, contact in enumerate(scene.contacts.values(), start=c):
        if contact.restitution is None:
            found.append(smaller(-values[j] / c_u, moves[j] * unknown[j]))
            continue
        at, speed_there, then, span = _before(w, k, stage, u)
        gaps, before = (held.at(e, at, speed_there, then)[j] for e in (held.expressions, held.drift[0]))
        ahead = gaps + span * before
        across = sum((Abs(e) for e in held.directions_at(at, then)[j, :].tolist()[0]), Integer(0))
        allowed = w.hoisted(Matrix([ROUNDING * scene.length * across]))[0]
        opens = smaller(-(rates[j] + contact.restitution * before) / c_v, moves[j] * unknown[j])
        found.append(where_at_least(ahead, -allowed, opens, moves[j] * unknown[j]))
    pressures = dict(zip(map(Symbol, scene.contacts), unknown[c : c + d, :], strict=True))
    for j, friction in enumerate(scene.frictions.values(), start=c + d):
        limit = friction.limit.subs(scene.invariants)
        without = limit.subs(dict.fromkeys(pressures, 0))
        most = (limit - without).expand().subs(pressures) + strength * without
        most = held.at(Matrix([most]), list(place), list(speed), when)[0]
        if most.has(*unknown) or not signed(most, scene.parameters).is_nonnegative:
            most = larger(most, Integer(0))  # a pressure that is to become 0 may be below it
        low, high = (moves[j] * (unknown[j] + sign * most) for sign in (-1, 1))
        found.append(larger(smaller(-rates[j] / c_v, high), low))  # where nothing presses, the rate says which
    found += [held.at(held.drift[0], list(place), list(speed), when)[j] / v.by_z for j in held.at_both]
    return Matrix(found)


def _before(w: Writer, k: int, stage: Stage, u: Moving) -> tuple[list[Expr], list[Expr], Expr, Expr]:
    """A displacement and a velocity before the k-th balance, their time, and how long that velocity goes on.

    They are those at t_n, and of explicit balances the mean velocity that has led to where the force is taken.
    """
    step, (u0, v0) = Step.of(w.scheme), (w.components(s) for s in knot(0)[:2])
    at, _ = moved(step, k)
    if stage.moved:
        return list(u0), list(v0), w.instant(Integer(0)), h * w.instants[at]
    ahead = w.instants[w.holding[k]] + int(w.holding[k] in step.prior) - w.instants[at]
    return list(u.names), list(w.hoisted((u.names - u0) / (h * w.instants[at]))), u.when, h * ahead


def _mobilities(w: Writer) -> list[Expr]:
    """What makes accelerations comparable with reactions in the choice of a branch: G M^-1 G^T, of diagonals alone.

    With another factor the iteration may take the two ends of a friction in turn. It is taken at t_n.
    """
    u0 = list(w.components(knot(0).u))
    at = w.instant(Integer(0))
    mass, _ = w.motion.equation(u0, u0, at)
    G = w.motion.held.directions_at(u0, at)
    movable = [i for i in range(mass.rows) if mass[i, i] != 0]
    return [sum((G[j, i] ** 2 / mass[i, i] for i in movable), Integer(0)) for j in range(G.rows)]
