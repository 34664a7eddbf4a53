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

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from sympy import Abs, Expr, Integer, Matrix, Symbol, diag, sympify, zeros

from ..constrained.explicit import held_next, mean_velocity
from ..declare.branches import slope
from ..declare.errors import DeclarationError
from ..declare.names import entry_name
from ..declare.scheme import Balance, Scheme
from ..declare.symbols import K0, C, K_t, M, N_discrete, h, kind_of, knot
from ..motion.components import Assignments, Writer, assign, drawn_out
from ..motion.discrete import discrete_equation
from ..motion.equations import EquationsOfMotion, solved
from ..step.places import Place, places
from ..step.step import Stage, Step
from ..step.times import instant_of, moved
from .balance_step import BalanceStep, Part, written
from .reactions import Moving, by_velocity, joined
from .remembering import lasting, lasting_at, of_balance, pushed
from .together import Reach, begun_together, combined, predicted, reached, split, unknowns


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
    w.unknown = w.acting = of_balance(w.motion.scene, k)
    at = _At(w, k, stage)
    reach, before, moves = reached(w, stage, at.z, at.in_z)
    shift = _Shift.of(w, k)
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
            k, at.z, before, [], zeros(w.size, 1), nothing, nothing, None, Integer(0), after, nothing, solved=explicit
        )
    found = _iterated(at, last, rows, reach, shift)
    return replace(found, before=before + found.before, moving=moves + found.moving, after=after)


Taken = tuple[Matrix, "Place | None", Matrix]  # inertia with the known accelerations, the place that moves, the load


def _row(at: "_At", balance: Balance) -> Taken:
    """What a balance takes of the equation of motion."""
    w, inertia, places = at.w, at.in_z(balance.inertia), _places(balance, at)
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


def _iterated(at: "_At", last: Symbol, rows: Sequence[Taken], reach: Reach, shift: "_Shift") -> BalanceStep:
    """The balances that are iterated, without what is computed of displacements.

    last: the displacement last solved for.
    """
    w, z = at.w, at.z
    parts = split(w, z)
    before, within = list(shift.before), Assignments()
    vectors = [(w.components(s), by_z) for s, by_z in reach.items()]  # that move with z, and their derivatives by it

    def by_z(whole: Matrix) -> list[Expr]:
        return [whole[0].diff(part[0]) for part in parts]

    def named(kind: str, whole: Matrix, number: int, where: str = "at") -> Matrix:
        """Names of a vector that moves with z, assigned in every iteration from its value at z = 0."""
        name, star = (w.components(Symbol(f"{kind}_*{label}{number or ''}")) for label in (where, f"{where}star"))
        before.extend(assign(star, w.hoisted(at.at_rest(whole))))
        within.extend(assign(name, combined(star, by_z(whole), parts)))
        return name

    displaced = list(vectors)
    residuals, jacobians, accelerations, free = list[Matrix](), list[Matrix](), list[Matrix](), list[Matrix]()
    for number, (inertia, place, load) in enumerate(rows):
        assert place is not None
        u, v = at.in_z(place.u), at.in_z(place.v)
        if isinstance(place.u, Symbol) and u.has(*z):
            u = w.components(place.u)
        elif u.has(*z):
            vectors.append((w.components(Symbol(f"u_*at{number or ''}")), by_z(u)))
            displaced.append(vectors[-1])
            u = vectors[-1][0]
            within += assign(u, w.hoisted(w.vector(place.u)))
        if w.motion.damped and v.has(*z):
            vectors.append((named("v", v, number), by_z(v)))
            v = vectors[-1][0]
        c_a, rest = by_z(inertia), w.hoisted(at.at_rest(inertia))
        plain = rest.is_zero_matrix and c_a == [Integer(j == number) for j in range(len(parts))]
        a = parts[number] if plain else named("a", inertia, number)
        if w.strengths:
            w.acting = w.unknown * w.constant(c_a[number] / place.weight)
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
    settled, far_held = tuple[Part, ...](), Integer(0)
    if w.unknown:
        moved_by_z, (residual, jacobian), settled = _with_reactions(at, reach, rows[0], (residual, jacobian), named)
        vectors += [(one.names, []) for one in moved_by_z]
        far_held = moved_by_z[0].by_z
    jacobian = Matrix.hstack(jacobian, shift.columns(displaced, residual))
    moving = (z, *accelerations, w.unknown, shift.names, *(names for names, _ in vectors))
    steady = _Steady(at.k, {s for m in moving for s in m.free_symbols})
    residual, jacobian = (w.hoisted(m).applyfunc(steady.without) for m in (residual, jacobian))
    first, far = _begun(at, last, rows, reach, far_held)
    first, w.latest, scene = Matrix([*first, *w.latest, *(0 * shift.names)]), w.unknown, w.motion.scene
    return BalanceStep(
        at.k, Matrix([*z, *w.unknown, *shift.names]), [*before, *steady.assignments], within, residual, jacobian,
        Matrix(), first, far, [], diag(*free), multipliers=len(w.unknown) + len(shift.names), settled=settled,
        bounded=len(scene.contacts) + len(scene.frictions),
    )  # fmt: skip


def _with_reactions(
    at: "_At",
    reach: Reach,
    row: Taken,
    balance: tuple[Matrix, Matrix],
    named: Callable[[str, Matrix, int, str], Matrix],
) -> tuple[tuple[Moving, ...], tuple[Matrix, Matrix], tuple[Part, ...]]:
    """Residual and its derivative with the rows of reactions, and what is computed of these once they are known.

    First the displacement that constraints hold, the velocity at the knot where the balance takes the force, and that
    which contacts and frictions hold, by the names that `named` has given them.
    """
    w, step, (inertia, place, _) = at.w, Step.of(at.w.scheme), row
    assert place is not None
    s, velocity = moved(step, at.stage)
    where = held = Moving(w.components(s), reach.get(s, [Integer(0)])[0], w.when(s))
    if w.holding and w.holding[at.k] not in reach:
        u = w.holding[at.k]
        whole, when = at.in_z(held_next(step, u)), w.instant(w.instants[u] + int(u in step.prior))
        held = Moving(named("u", whole, 0, "held"), whole[0].diff(at.z[0]), when)

    def of_velocity(e: Expr, label: str) -> Moving:
        whole = at.in_z(e)
        c_v: Expr = Integer(0) + whole[0].diff(at.z[0])
        return Moving(named("v", whole, 0, label) if c_v != 0 else whole, c_v, where.when)

    own = any(w.motion.held.at_velocities) or (at.stage.moved and by_velocity(w.motion))
    rate = of_velocity(velocity if own else Integer(0), "held")
    bounded = w.motion.scene.contacts or w.motion.scene.frictions
    later = bounded and not at.stage.moved
    mean = of_velocity(mean_velocity(step, at.k, w.holding[at.k]), "mean") if later else rate
    found = joined(w, at.k, at.stage, balance, held, where, rate, mean)
    if not w.strengths:
        w.reactions[s] = w.unknown
        return (held, rate, mean), found, ()
    v, share = velocity if place.u == s else place.v, place.weight / inertia[0].diff(at.z[0])
    kept = lasting(w, at.k, (place.u, instant_of(place.u, w.instants)), at.in_z(place.u), at.in_z(v))
    w.reactions[s] = lasting_at(w.motion.scene, at.k)
    return (held, rate, mean), found, (*kept, pushed(w, at.k, where.names, where.when, w.constant(share)))


def _begun(at: "_At", last: Symbol, rows: Sequence[Taken], reach: Reach, held: Expr) -> tuple[Matrix, Expr]:
    """Where the iteration starts, and how far an acceleration moves a displacement; held: one that constraints hold."""
    w, stage = at.w, at.stage
    if not stage.alone:
        first, far = begun_together(w, stage, reach, last, at.in_z)
        return (_without_rates(at, rows) if w.motion.bends_at_rest else first), far
    (c_u,) = next(iter(reach.values()), [Integer(0)])
    first = zeros(w.size, 1)
    if w.motion.bends_at_rest:
        first = _without_rates(at, rows).subs(dict(zip(w.unknown, w.latest, strict=True)))
    elif (known := _last_acceleration(at)) is not None:
        first = w.components(known)
    elif c_u != 0:
        first = (w.components(last) - w.components(predicted(0))) * w.reciprocal(c_u, c_u)
    by_rates, moves = w.motion.damped or by_velocity(w.motion), held if c_u == 0 else c_u
    return first, Abs(moves) + Abs(h * stage.c_v()) if by_rates else moves


def _last_acceleration(at: "_At") -> Symbol | None:
    """The newest acceleration that is known, of a scene with constraints alone; None of another, or without one.

    Where contacts or frictions act, the branch that the iteration finds is that nearest to the last displacement.
    """
    scene, step = at.w.motion.scene, Step.of(at.w.scheme)
    known = step.accelerations[at.k - 1] if at.k else knot(0).a
    alone = scene.constraints and not (scene.contacts or scene.frictions)
    return known if alone and (at.k or known in step.state) else None


def _without_rates(at: "_At", rows: Sequence[Taken]) -> Matrix:
    """The accelerations as if there were no force of the rates, whose slope may have no bound at the last ones."""
    w, found = at.w, list[Matrix]()
    for (inertia, place, load), z in zip(rows, split(w, at.z), strict=True):
        assert place is not None
        still = at.acceleration(place, at.at_rest(at.in_z(place.u)), zeros(w.size, 1), load)
        found.append(w.hoisted(-(w.hoisted(at.at_rest(inertia)) + still) / inertia[0].diff(z[0])))
    return Matrix.vstack(*found)


@dataclass(frozen=True)
class _Shift:
    """What moves the displacements of a balance beside z, so that constraints may hold them and velocities alike.

    names: a multiplier (c, 1) for each such constraint. along: the names of M^-1 G^T (d, c) at t_n, which `before`
    assigns. Where z moves a displacement by c_u z, these move it by c_u along*names.
    """

    names: Matrix
    along: Matrix
    before: Assignments

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
        value = w.hoisted(Matrix.hstack(*(solved(mass, directions[j, :].T) for j in places)))
        along = Matrix(*value.shape, lambda i, j: Symbol(entry_name(f"along{k}_", i, j)))
        return cls(names, along, assign(along, value))

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


class _At:
    """Evaluates what the balances of a stage take at a knot."""

    def __init__(self, w: Writer, k: int, stage: Stage) -> None:
        self.w, self.k, self.stage, self.z = w, k, stage, unknowns(w, stage)

    def at_rest(self, vector: Matrix) -> Matrix:
        """The vector at z = 0."""
        return vector.subs(dict.fromkeys(self.z, Integer(0)))

    def acceleration(self, place: Place, u: Matrix, v: Matrix, load: Matrix) -> Matrix:
        """Minus the acceleration there under the load, times the weight."""
        mass, force = self.equation(place, u, v)
        if mass.det() == 0:
            raise DeclarationError(
                f"{self.w.scheme.name}: expected a mass matrix of {self.w.motion.scene.name} that is regular, since a "
                f"balance takes accelerations at several instants, got {mass.tolist()}; take a scheme that takes them "
                "at one, such as bathe, or give each coordinate a mass"
            )
        return place.weight * solved(mass, force - load)

    def in_z(self, e: Expr) -> Matrix:
        """Components of a vector in those of the unknown and of what is known."""
        return self.w.hoisted(self.w.vector(sympify(e).subs(self.stage.in_z, simultaneous=True)))

    def moves(self, place: Place) -> bool:
        """Whether the equation of motion there depends on the unknown."""
        v = self.in_z(place.v) if self.w.motion.damped else Matrix()
        return any(e.has(*self.z) for e in (*self.in_z(place.u), *v))

    def equation(self, place: Place, u: Matrix, v: Matrix) -> tuple[Matrix, Matrix]:
        """Mass and forces there, at these components of displacement and velocity."""
        w = self.w
        instant = w.when(place.u)
        if isinstance(place.force, N_discrete):
            old, new = (list(w.vector(argument)) for argument in place.force.args)
            mass, force = discrete_equation(w.motion, old, new, list(v), instant)
            return mass, force + w.discrete_reaction(old, new)
        mass, force = w.motion.equation(list(u), list(v), instant)
        force += w.reaction(place.force, list(u), instant)
        return mass, force.subs(w.remembered(place.u), simultaneous=True)


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


def _places(balance: Balance, at: "_At") -> list[Place]:
    """Where the balance takes the equation of motion.

    Forces of rates are taken at each knot of its force, a constant damping, if that is another mixture, at one of them.
    Raises DeclarationError where it takes it at several knots, and what C multiplies is not the same mixture of theirs.
    """
    w = at.w
    found, same = places(balance.force, balance.damping)
    if same or not w.motion.damped:
        return found
    if w.motion.of_rates:
        raise DeclarationError(
            f"{w.scheme.name}: expected a balance whose damping mixes the velocities of the knots of its force, with "
            f"the same weights, got {balance.damping} beside {balance.force}, on {w.motion.scene.name}, whose forces "
            "depend on rates; take another scheme"
        )
    whole = next((place for place in found if at.in_z(place.u).has(*at.z)), found[-1])
    return [place if place is whole else replace(place, v=Integer(0)) for place in found]  # a constant damping, once
