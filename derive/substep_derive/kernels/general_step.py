"""Balance x Scene -> BalanceStep where the mass moves, or forces of rates and time are more than a damping matrix.

A balance mixes accelerations, forces and loads at knots, which says what a scheme does where the mass is constant. The
one reading here that keeps a scheme's order where it is not: a scheme is one for a = G(u, v, t), with G the
acceleration that the equation of motion gives at a knot. So M*inertia + C*damping + sum of w N(u) = load means

    inertia + sum of w M(u)^-1 (F(u, v, t) - load) = 0,

as in Arnold & Bruels, Multibody Syst. Dyn. 18 (2007) 185-202, for the alpha schemes; where mass and damping are
constant both are the same. The velocity is what C multiplies or, where a balance takes the force at several knots, that
of each of them, of which C then multiplies the same mixture. The time is that at which a motion of constant velocity
passes the displacement. The row is multiplied by the mass at the one knot that depends on the unknown.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from sympy import Abs, Expr, Integer, Matrix, Symbol, diag, zeros

from ..declare.branches import slope
from ..declare.errors import DeclarationError
from ..declare.names import entry_name
from ..declare.scheme import Balance, Scheme
from ..declare.symbols import K0, C, K_t, M, N_discrete, h, kind_of, knot
from ..motion.components import Assignments, Writer, assign, drawn_out
from ..motion.equations import EquationsOfMotion
from ..step.step import Stage, Step
from ..step.times import newest
from .at_knots import AtKnots, places_of
from .balance_step import BalanceStep, Part, written
from .held_block import accelerated
from .held_rows import HeldRows, Taken
from .reactions import by_velocity
from .remembering import of_balance
from .together import Reach, begun_together, combined, predicted, reached, split


def refuse(scheme: Scheme, motion: EquationsOfMotion) -> None:
    """Raises DeclarationError for a scheme that has no reading on such a scene."""
    start = scheme.start.values() if not isinstance(scheme.start, Scheme) else ()
    held = [*scheme.relations.values(), *scheme.report.values(), *start]
    held += [e for b in scheme.balances for e in (b.inertia, b.damping, b.force, b.load)]
    if any(e.has(M, C, K0, K_t) for e in held):
        raise DeclarationError(
            f"{scheme.name} has coefficients from matrices of mass, damping or stiffness: expected a scene in which "
            f"these are constant, apart from a force of the coordinates, got {motion.scene.name}; take another scheme"
        )
    if motion.mass_moves and any(b.force.has(N_discrete) for b in scheme.balances):
        raise DeclarationError(
            f"{scheme.name} takes the force as a discrete gradient of the potential, and of a kinetic energy that "
            f"depends on coordinates or time it has none: expected a constant mass, got that of {motion.scene.name}; "
            "take another scheme, or coordinates in which the mass is constant"
        )


def general_step(w: Writer, k: int, stage: Stage, last: Symbol, wanted: set[Symbol]) -> BalanceStep:
    """The balances of one stage; they are iterated if a force depends on the unknown, or if they have reactions."""
    at = AtKnots(w, k, stage)
    w.unknown = Matrix([e for number in at.balances for e in of_balance(w.motion.scene, number)])
    reach, before, moves = reached(w, stage, at.z, at.in_z)
    shift = _Shift.of(w, at.balances[0])
    moves = shift.applied(moves, {s: by_z[0] for s, by_z in reach.items()}, w)
    rest = {s: e for s, e in stage.in_z.items() if s in wanted and s not in reach}
    moved_too = {s: at.in_z(s)[0].diff(at.z[0]) for s in rest if shift.names and kind_of(s) == 0}
    after = moves + shift.applied(written(w, rest), moved_too, w)
    rows = [_row(at, balance) for balance in stage.balances]
    if any(place is None for _, place, _ in rows):
        if not stage.alone:
            raise DeclarationError(
                f"{w.scheme.name} solves balances together: expected each of them to take the force at a displacement "
                f"that moves, on {w.motion.scene.name}, whose equation of motion is taken there; take another scheme"
            )
        nothing, ((inertia, *_),) = zeros(w.size), rows
        explicit = assign(at.z, w.hoisted(-at.at_rest(inertia) / inertia[0].diff(at.z[0])))
        return BalanceStep(
            k, at.z, before, [], zeros(w.size, 1), nothing, nothing, None, Integer(0), after, nothing, solved=explicit,
            prepared=tuple(at.prepared),
        )  # fmt: skip
    found = _iterated(at, last, rows, reach, shift)
    prepared = (*shift.prepared, *at.prepared)
    return replace(found, before=before + found.before, moving=moves + found.moving, after=after, prepared=prepared)


def _row(at: AtKnots, balance: Balance) -> Taken:
    """What a balance takes of the equation of motion."""
    w, inertia, places = at.w, at.in_z(balance.inertia), places_of(balance, at)
    moving = [place for place in places if at.moves(place)] or (places[-1:] if w.unknown else [])
    load = w.vector(balance.load) / sum((place.weight for place in places), Integer(0))
    for place in places:
        if place not in moving:
            inertia += at.acceleration(place, at.in_z(place.u), at.in_z(place.v), load)
    if len(moving) > 1:
        raise DeclarationError(
            f"{w.scheme.name}: expected balances that take the force at one knot that depends on the new acceleration, "
            f"got {len(moving)} such on {w.motion.scene.name}, where the equation of motion is taken at each; take "
            "another scheme"
        )
    return inertia, moving[0] if moving else None, load


def _iterated(at: AtKnots, last: Symbol, rows: Sequence[Taken], reach: Reach, shift: "_Shift") -> BalanceStep:
    """The balances that are iterated, without what is computed of displacements.

    last: the displacement last solved for.
    """
    w, z = at.w, at.z
    parts = split(w, z)
    before, within = list(shift.before), Assignments()
    vectors = [(w.components(s), by_z) for s, by_z in reach.items()]  # that move with z, and their derivatives by it

    def named(kind: str, whole: Matrix, number: int, where: str = "at") -> Matrix:
        """Names of a vector that moves with z, assigned in every iteration from its value at z = 0."""
        name, star = (w.components(Symbol(f"{kind}_*{label}{number or ''}")) for label in (where, f"{where}star"))
        before.extend(assign(star, w.hoisted(at.at_rest(whole))))
        within.extend(assign(name, combined(star, at.by_z(whole), parts)))
        return name

    displaced = list(vectors)
    residuals, jacobians, accelerations, free = list[Matrix](), list[Matrix](), list[Matrix](), list[Matrix]()
    for number, (inertia, place, load) in enumerate(rows):
        assert place is not None
        u, v = at.in_z(place.u), at.in_z(place.v)
        if isinstance(place.u, Symbol) and u.has(*z):
            u = w.components(place.u)
        elif u.has(*z):
            vectors.append((w.components(Symbol(f"u_*at{number or ''}")), at.by_z(u)))
            displaced.append(vectors[-1])
            u = vectors[-1][0]
            within += assign(u, w.hoisted(w.vector(place.u)))
        if w.motion.damped and v.has(*z):
            vectors.append((named("v", v, number), at.by_z(v)))
            v = vectors[-1][0]
        c_a, rest = at.by_z(inertia), w.hoisted(at.at_rest(inertia))
        plain = rest.is_zero_matrix and c_a == [Integer(j == number) for j in range(len(parts))]
        a = parts[number] if plain else named("a", inertia, number)
        at.press(number, c_a[number] / place.weight)
        mass, force = at.equation(place, u, v)
        residuals.append(mass * a + place.weight * (force - load))
        jacobian = Matrix.hstack(*(c * mass for c in c_a))
        for names, rates in vectors:
            slopes = Matrix([[slope(e, s) for s in names] for e in residuals[-1]])
            jacobian += Matrix.hstack(*(slopes * rate for rate in rates))
        jacobians.append(jacobian)
        accelerations.append(a)
        free.append(c_a[number] * mass)
    residual, jacobian = Matrix.vstack(*residuals), Matrix.vstack(*jacobians)
    held, unknown = HeldRows.of(at, reach, rows, named), Matrix()
    if w.unknown:
        vectors += [(one.names, []) for one in held.moving]
        residual, jacobian, unknown = held.joined(at, residual, jacobian)
    jacobian = Matrix.hstack(jacobian, shift.columns(displaced, residual))
    moving = (z, *accelerations, unknown, shift.names, *(names for names, _ in vectors))
    steady = _Steady(at.k, {s for m in moving for s in m.free_symbols})
    residual, jacobian = (w.hoisted(m).applyfunc(steady.without) for m in (residual, jacobian))
    scene, latest = w.motion.scene, dict(zip(w.unknown, [*w.latest] * len(rows), strict=True))
    first, far = _begun(at, last, rows, reach, held.held[0].by_z if w.unknown else Integer(0))
    first = Matrix([*first.subs(latest), *(latest[s] for s in unknown), *(0 * shift.names)])
    if w.unknown:
        w.latest = of_balance(scene, newest(Step.of(w.scheme), at.stage))
    return BalanceStep(
        at.k, Matrix([*z, *unknown, *shift.names]), [*before, *steady.assignments], within, residual, jacobian,
        Matrix(), first, far, [], diag(*free), multipliers=len(unknown) + len(shift.names), settled=held.settled,
        bounded=len(rows) * (len(scene.contacts) + len(scene.frictions)),
    )  # fmt: skip


def _begun(at: AtKnots, last: Symbol, rows: Sequence[Taken], reach: Reach, held: Expr) -> tuple[Matrix, Expr]:
    """Where the iteration starts, and how far an acceleration moves a displacement; held: one that constraints hold.

    With constraints alone from the last acceleration, and of balances that are solved together from 0, which is as near
    in order. Where contacts or frictions act, the branch that it finds is that nearest to the last displacement.
    """
    w, stage, scene = at.w, at.stage, at.w.motion.scene
    constraints_alone = bool(scene.constraints) and not (scene.contacts or scene.frictions)
    if not stage.alone:
        first, far = begun_together(w, stage, reach, last, at.in_z)
        first = 0 * first if constraints_alone else first
        return (_without_rates(at, rows) if w.motion.bends_at_rest else first), far
    (c_u,) = next(iter(reach.values()), [Integer(0)])
    first = zeros(w.size, 1)
    if w.motion.bends_at_rest:
        first = _without_rates(at, rows)
    elif constraints_alone and (known := _last_acceleration(at)) is not None:
        first = w.components(known)
    elif c_u != 0:
        first = (w.components(last) - w.components(predicted(0))) * w.reciprocal(c_u, c_u)
    by_rates, moves = w.motion.damped or by_velocity(w.motion), held if c_u == 0 else c_u
    return first, Abs(moves) + Abs(h * stage.c_v()) if by_rates else moves


def _last_acceleration(at: AtKnots) -> Symbol | None:
    """The newest acceleration that is known; None where a step begins without one."""
    step, first = Step.of(at.w.scheme), at.balances[0]
    known = step.accelerations[first - 1] if first else knot(0).a
    return known if first or known in step.state else None


def _without_rates(at: AtKnots, rows: Sequence[Taken]) -> Matrix:
    """The accelerations as if there were no force of the rates, whose slope may have no bound at the last ones."""
    w, found = at.w, list[Matrix]()
    for number, ((inertia, place, load), z) in enumerate(zip(rows, split(w, at.z), strict=True)):
        assert place is not None
        at.press(number, inertia[0].diff(z[0]) / place.weight)
        still = at.acceleration(place, at.at_rest(at.in_z(place.u)), zeros(w.size, 1), load)
        found.append(w.hoisted(-(w.hoisted(at.at_rest(inertia)) + still) / inertia[0].diff(z[0])))
    return Matrix.vstack(*found)


@dataclass(frozen=True)
class _Shift:
    """What moves the displacements of a balance beside z, so that constraints may hold them and velocities alike.

    names: a multiplier (c, 1) for each such constraint. along: the names of M^-1 G^T (d, c) at t_n, which `before`
    assigns of what is prepared. Where z moves a displacement by c_u z, these move it by c_u along*names.
    """

    names: Matrix
    along: Matrix
    before: Assignments
    prepared: tuple[Part, ...] = ()

    @classmethod
    def of(cls, w: Writer, k: int) -> "_Shift":
        """That of the k-th balance, with names alone if there is one."""
        held, places = w.motion.held, list(w.motion.held.at_both)
        names = Matrix([Symbol(f"shift{k + 1}_{list(w.motion.scene.constraints)[j]}") for j in places])
        if not places:
            return cls(names, names, [])
        u0, when = list(w.components(knot(0).u)), w.instant(Integer(0))
        mass, _ = w.motion.equation(u0, u0, when)
        directions = held.directions_at(u0, when)
        found = [accelerated(w, mass, directions[j, :].T, f"along{k}_{j}") for j in places]
        value = w.hoisted(Matrix.hstack(*(column for column, _ in found)))
        along = Matrix(*value.shape, lambda i, j: Symbol(entry_name(f"along{k}_", i, j)))
        return cls(names, along, assign(along, value), tuple(part for _, parts in found for part in parts))

    def applied(self, moves: Assignments, by_z: Mapping[Symbol, Expr], w: Writer) -> Assignments:
        """Assignments of displacements, with their derivatives by z, that these move as well."""
        whole = self.along * self.names if self.names else Matrix()
        more = {name: c * e for s, c in by_z.items() for name, e in zip(w.components(s), whole, strict=False)}
        return [(s, e + more.get(s, Integer(0))) for s, e in moves]

    def columns(self, moved: Iterable[tuple[Matrix, list[Expr]]], residual: Matrix) -> Matrix:
        """The residual's derivative by these; moved: displacements, and their derivatives by z."""
        total = zeros(len(residual), len(self.names))
        for names, (by_z, *_) in moved if self.names else ():
            total += Matrix([[slope(e, s) for s in names] for e in residual]) * by_z * self.along
        return total


class _Steady:
    """Names for the parts of an iteration's expressions that do not move in it, and are computed before."""

    def __init__(self, k: int, moving: set[Symbol]) -> None:
        self.k, self.moving = k, moving
        self.named = dict[Expr, Symbol]()

    def without(self, e: Expr) -> Expr:
        """The expression with these names."""
        return drawn_out(e, lambda part: not part.free_symbols & self.moving, self._name)

    def _name(self, e: Expr) -> Expr:
        if e.is_number or e.is_Symbol:
            return e
        if e.could_extract_minus_sign():
            return -self._name(-e)
        return self.named.setdefault(e, Symbol(f"once{self.k}_{len(self.named)}"))

    @property
    def assignments(self) -> Assignments:
        """Of the names."""
        return [(name, e) for e, name in self.named.items()]
