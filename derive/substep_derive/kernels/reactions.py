"""Reactions of a scene in a balance: the rows by which they are solved for, and what is not remembered of them.

Every balance has an unknown for each reaction beside its new acceleration z. A constraint holds its expression at the
first displacement that moves with z, of explicit schemes a later one than that of the force, or at the velocity that
moves with z; of a contact the smaller of gap and pressure is 0, or of a velocity and the pressure; and friction is at
its limit, or nothing slides. Newton's iteration finds the branch of each.

Reactions that are not remembered accelerate z by M^-1 G^T times the unknown, whatever weight a balance gives to forces:
only their impulse counts. See `step.times.impulses` for what it is of a constant force.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from sympy import Expr, Integer, Matrix, Rational, Symbol, zeros

from ..constrained.prescribed import Prescribed, prescribed
from ..declare.errors import DeclarationError
from ..declare.law import larger, slope, smaller, where_at_least
from ..declare.scene import Scene
from ..declare.scheme import Scheme
from ..declare.symbols import C, N, f, h, kind_of, knot, knot_of, successor
from ..motion.components import Assignments, Writer, assign
from ..motion.equations import EquationsOfMotion, solved
from ..step.step import Stage, Step
from ..step.times import impulses, impulses_last, instants_of, moved


@dataclass(frozen=True)
class Moving:
    """A displacement or a velocity that may move with z: its components, their derivative by z, and their time."""

    names: Matrix
    by_z: Expr
    when: Expr


def begin(w: Writer, scheme: Scheme, step: Step) -> None:
    """Prepares the writing of a step: what reactions were at t_n, and how they act.

    Raises DeclarationError for a scheme whose balances do not move what the scene's reactions hold.
    """
    scene = w.motion.scene
    if scene.multipliers and (found := _require_holding(scheme, Asked.by(w.motion))):
        w.holding = tuple(u for u, _ in found.held)
    w.latest = at_start(scene)
    u0 = knot(0).u
    if any(b.force.has(N(successor(u0))) for b in step.scheme.balances):  # else what is taken at u_0 is unknown
        w.reactions[u0] = remembered(scene)
    w.strengths = impulses(step).strengths if scene.impulsive else ()


def remembered(scene: Scene) -> Matrix:
    """The reactions at t_n that a balance holds which takes the force there too."""
    return at_start(scene) * int(not scene.impulsive)


def at_start(scene: Scene) -> Matrix:
    """The reactions at t_n, of the last balance before."""
    return Matrix([Symbol(f"multiplier_{s}") for s in scene.multipliers])


def of_balance(scene: Scene, k: int) -> Matrix:
    """Those that the k-th balance is solved for."""
    return Matrix([Symbol(f"multiplier{k + 1}_{s}") for s in scene.multipliers])


def by_velocity(motion: EquationsOfMotion) -> bool:
    """Whether any of them is decided by a velocity."""
    bounces = any(contact.restitution is not None for contact in motion.scene.contacts.values())
    return bool(motion.scene.frictions) or bounces or any(motion.held.at_velocities)


def held_next(step: Step, u: Symbol) -> Expr:
    """A displacement at which reactions hold: of the step, or of the next one, where it follows from the state."""
    return step.prior[u].xreplace({s: successor(s) for s in step.state}) if u in step.prior else u


def held_first(w: Writer, step: Step) -> tuple[tuple[Expr, Expr, Expr], Expr] | None:
    """The displacement of the first step that the reaction at its start holds: factors of u, v, a there; its instant.

    None where there is none: reactions hold displacements of their own step, or one that the start alone moves.
    """
    found = ((u, _first_factors(step, u)) for u in w.holding if u in step.prior)
    return next(((factors, w.instants[u]) for u, factors in found if factors and factors[2] != 0), None)


def _first_factors(step: Step, u: Symbol) -> tuple[Expr, Expr, Expr] | None:
    """Factors of u, v, a at the start in a displacement that follows from the state; None where others enter."""
    start = None if step.start is None else dict(zip(step.state, step.start, strict=True))
    first = step.prior[u].subs(start or {}, simultaneous=True)
    u0, v0, a0 = knot(0)
    return None if start is None or first.has(N, f, C) else (first.diff(u0), first.diff(v0), first.diff(a0))


@dataclass(frozen=True)
class Asked:
    """What reactions ask of a scheme.

    positions, rates: whether some hold a displacement, or are decided by a velocity. contacts: whether some only push,
    or are friction; restitution: whether some contact has one. impulsive: whether they are not remembered.
    """

    positions: bool
    rates: bool
    contacts: bool
    restitution: bool
    impulsive: bool

    @classmethod
    def by(cls, motion: EquationsOfMotion) -> "Asked":
        """Those of a scene."""
        scene, restitutions = motion.scene, [x.restitution is not None for x in motion.scene.contacts.values()]
        at_positions = len(scene.constraints) - sum(motion.held.at_velocities) + restitutions.count(False)
        either = bool(scene.contacts or scene.frictions)
        return cls(at_positions > 0, by_velocity(motion), either, any(restitutions), scene.impulsive)


def why_no_contact(scheme: Scheme, *, restitution: bool = False, friction: bool = False) -> str:
    """Why the scheme takes no contacts of a structure, with restitution, or no frictions; empty where it takes them."""
    rates = restitution or friction
    try:
        _require_holding(scheme, Asked(not rates, rates, True, restitution, True))
    except DeclarationError as error:
        return str(error)
    return ""


def _require_holding(scheme: Scheme, asked: Asked) -> Prescribed | None:
    """What the scheme makes of constraints at displacements; None where there are none.

    Raises DeclarationError for a scheme whose balances do not move what reactions hold.
    """
    step = Step.of(scheme)
    if not all(stage.alone for stage in step.stages):
        raise DeclarationError(
            f"{scheme.name} solves balances together: expected balances that are solved one after the other on a scene "
            "with constraints, contacts or friction; take another scheme, or a scene without"
        )
    explicit = not all(stage.moved for stage in step.stages)
    if asked.positions and asked.contacts and explicit:
        raise DeclarationError(
            f"{scheme.name} is explicit: expected each balance to move the displacement that it takes the force at, so "
            "that a pressure holds a gap there; take an implicit scheme, give contacts a restitution, or leave them out"
        )
    if asked.impulsive or asked.rates:
        impulses(step)
    missing = [s for s in knot(0)[:2] if s not in step.state]
    if asked.restitution and (missing or not impulses_last(step)):
        raise DeclarationError(
            f"{scheme.name} does not keep the velocity that an impact leaves: expected one that is the same a step "
            "later, of which restitution is a share; take a scheme of one balance, such as average_acceleration"
        )
    found = prescribed(scheme) if asked.positions else None
    if found and explicit:
        _require_next(step, found)
    last, _ = moved(step, step.stages[-1])
    if last in step.state and (asked.rates or not found):
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
        factors = _first_factors(step, u)
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


def joined(
    w: Writer, k: int, stage: Stage, balance: tuple[Matrix, Matrix], held: Moving, u: Moving, v: Moving
) -> tuple[Matrix, Matrix]:
    """Residual and its derivative by z of a balance, with rows of its reactions, and columns of their unknowns.

    held: the displacement at which constraints hold; u and v are at the knot where the balance takes the force, of
    implicit schemes the same.
    """
    residual, jacobian = balance
    more = _rows(w, k, stage, held, u, v)
    below = zeros(len(more), jacobian.cols)
    for moving in (held, v):
        below += Matrix([[slope(e, s) for s in moving.names] for e in more]) * moving.by_z
    whole = Matrix([*residual, *more])
    by_reactions = Matrix([[slope(e, s) for s in w.unknown] for e in whole])
    return whole, Matrix.hstack(Matrix([*jacobian.tolist(), *below.tolist()]), by_reactions)


def _rows(w: Writer, k: int, stage: Stage, to: Moving, u: Moving, v: Moving) -> Matrix:
    """What is 0 where the k-th balance's reactions are right, divided so that it does not depend on the step."""
    scene, held, unknown = w.motion.scene, w.motion.held, w.unknown
    place, speed, c_u, c_v, when = u.names, v.names, to.by_z, v.by_z, u.when
    at, _ = moved(Step.of(w.scheme), stage)
    values = held.at(held.expressions, list(to.names), list(speed), to.when)
    rates = held.at(held.drift[0], list(place), list(speed), when)
    c, d = len(scene.constraints), len(scene.contacts)
    moves = _mobilities(w)
    found = [rates[j] / c_v if held.at_velocities[j] else values[j] / c_u for j in range(c)]
    for j, contact in enumerate(scene.contacts.values(), start=c):
        if contact.restitution is None:
            found.append(smaller(-values[j] / c_u, moves[j] * unknown[j]))
            continue
        u0, v0 = (list(w.components(s)) for s in knot(0)[:2])
        gaps, before = (held.at(e, u0, v0, w.instant(Integer(0)))[j] for e in (held.expressions, held.drift[0]))
        ahead = gaps + h * w.instants[at] * before
        opens = smaller(-(rates[j] + contact.restitution * before) / c_v, moves[j] * unknown[j])
        found.append(where_at_least(ahead, Integer(0), opens, moves[j] * unknown[j]))
    pressures = dict(zip(map(Symbol, scene.contacts), unknown[c : c + d, :], strict=True))
    for j, friction in enumerate(scene.frictions.values(), start=c + d):
        limit = friction.limit.subs(scene.invariants)
        without = limit.subs(dict.fromkeys(pressures, 0))
        most = (limit - without).expand().subs(pressures) + w.strengths[k] * without
        most = held.at(Matrix([most]), list(place), list(speed), when)[0]
        low, high = (moves[j] * (unknown[j] + sign * most) for sign in (-1, 1))
        found.append(larger(low, smaller(-rates[j] / c_v, high)))
    return Matrix(found)


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


def pushed(w: Writer, k: int, u: Matrix, at: Expr) -> Assignments:
    """The acceleration that the reactions of the k-th balance have given to its z, by name."""
    mass, _ = w.motion.equation(list(u), list(u), at)
    force = w.motion.held.directions_at(list(u), at).T * w.unknown
    return assign(w.components(_push(k)), w.hoisted(solved(mass, force)))


def _push(k: int) -> Symbol:
    return Symbol(f"a_*push{k}")


def kept(w: Writer, step: Step) -> tuple[Mapping[Symbol, Symbol], Assignments, Matrix]:
    """What a step keeps of its reactions.

    New accelerations that the next step or the report reads -> names of them without reactions that are not remembered;
    assignments of these and of the reactions at the end of the step, or of their means; and the names of the latter.
    """
    scene, found = w.motion.scene, Assignments()
    if not w.strengths:
        return {}, found, w.latest
    own = {s for e in step.outputs[2:] if e.is_Symbol for s in e.free_symbols}
    wanted = {successor(s) for s in step.state} | own
    names = {
        s: Symbol(f"a_*free{(knot_of(s) or ('', ''))[1]}")
        for s in sorted(wanted, key=str)
        if kind_of(s) == 2 and s in step.unknowns
    }
    for s, name in names.items():
        whole = w.components(s)
        for k, z in enumerate(step.accelerations):
            whole += (Integer(1) if s == z else step.solved.get(s, Integer(0)).diff(z)) * w.components(_push(k))
        found += assign(w.components(name), w.hoisted(whole))
    total = zeros(len(scene.multipliers), 1)
    for k, weight in enumerate(impulses(step).weights):
        total += weight * of_balance(scene, k)
    means = Matrix([Symbol(f"mean_{s}") for s in scene.multipliers])
    return names, found + assign(means, w.hoisted(total)), means
