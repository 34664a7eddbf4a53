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

from collections.abc import Mapping
from dataclasses import dataclass, replace

from sympy import Abs, Dummy, Expr, Integer, Matrix, Symbol, factor, sympify, zeros

from ..declare.errors import DeclarationError
from ..declare.law import slope
from ..declare.scheme import Scheme
from ..declare.symbols import K0, C, K_t, M, N, N_discrete, h, knot, knot_of
from ..motion.components import Assignments, Writer, assign, drawn_out
from ..motion.equations import EquationsOfMotion, solved
from ..step.step import Stage, Step
from ..step.times import moved
from .balance_step import BalanceStep, predicted, written
from .reactions import by_velocity, joined, of_balance, pushed


@dataclass(frozen=True)
class Place:
    """Where a balance takes the equation of motion, with that weight: its force, displacement and velocity."""

    weight: Expr
    force: Expr
    u: Expr
    v: Expr


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
    """One balance; it is iterated if its force depends on the unknown, or if it has reactions."""
    w.unknown = w.acting = of_balance(w.motion.scene, k)
    at = _At(w, k, stage)
    z, before, reached, reach = at.z, Assignments(), Assignments(), dict[Symbol, Expr]()
    for number, s in enumerate(sorted(stage.moved, key=str)):
        whole, predictor = at.in_z(s), w.components(predicted(number))
        reach[s] = whole[0].diff(z[0])
        before += assign(predictor, at.at_rest(whole))
        reached += assign(w.components(s), predictor + reach[s] * z)
    after = reached + written(w, {s: e for s, e in stage.in_z.items() if s in wanted and s not in reach})
    inertia, places = at.in_z(stage.balance.inertia), _places(stage, w)
    moving = [place for place in places if at.moves(place)] or (places[-1:] if w.unknown else [])
    load = w.vector(stage.balance.load) / sum((place.weight for place in places), Integer(0))
    for place in places:
        if place not in moving:
            inertia += at.acceleration(place, at.in_z(place.u), at.in_z(place.v), load)
    if len(moving) > 1:
        raise DeclarationError(
            f"{w.scheme.name}: expected balances that take the force at one knot that depends on the new acceleration, "
            f"got {len(moving)} such on {w.motion.scene.name}, where the equation of motion is taken at each; take "
            "another scheme"
        )
    if moving:
        found = _iterated(at, last, moving[0], inertia, load, reach)
        return replace(found, before=before + found.before, moving=reached + found.moving, after=after + found.after)
    nothing = zeros(w.size)
    explicit = assign(z, w.hoisted(-at.at_rest(inertia) / inertia[0].diff(z[0])))
    return BalanceStep(
        k, z, before, [], zeros(w.size, 1), nothing, nothing, None, Integer(0), after, nothing, solved=explicit
    )


def _iterated(
    at: "_At", last: Symbol, place: Place, inertia: Matrix, load: Matrix, reach: Mapping[Symbol, Expr]
) -> BalanceStep:
    """The balance that is iterated, without what is computed of displacements; inertia: with the known accelerations.

    last: the displacement last solved for. reach: of each displacement that moves with z, its derivative by it.
    """
    w, z = at.w, at.z
    before, within = Assignments(), Assignments()
    vectors = [(w.components(s), c) for s, c in reach.items()]  # that move with z, and their derivatives by it

    def named(kind: str, whole: Matrix, where: str = "at") -> Matrix:
        """Names of a vector that moves with z, assigned in every iteration from its value at z = 0."""
        name, star = (w.components(Symbol(f"{kind}_*{label}")) for label in (where, f"{where}star"))
        before.extend(assign(star, w.hoisted(at.at_rest(whole))))
        within.extend(assign(name, star + whole[0].diff(z[0]) * z))
        return name

    u, v = at.in_z(place.u), at.in_z(place.v)
    if isinstance(place.u, Symbol) and u.has(*z):
        u = w.components(place.u)
    elif u.has(*z):
        vectors.append((w.components(Symbol("u_*at")), u[0].diff(z[0])))
        u = vectors[-1][0]
        within += assign(u, w.hoisted(w.vector(place.u)))
    if w.motion.of_rates and v.has(*z):
        vectors.append((named("v", v), v[0].diff(z[0])))
        v = vectors[-1][0]
    c_a, rest = inertia[0].diff(z[0]), w.hoisted(at.at_rest(inertia))
    a = z if rest.is_zero_matrix and c_a == 1 else named("a", inertia)
    if w.strengths:
        w.acting = w.unknown * w.constant(c_a / place.weight)
    mass, force = at.equation(place, u, v)
    residual, jacobian = mass * a + place.weight * (force - load), c_a * mass
    for names, rate in vectors:
        jacobian += Matrix([[slope(e, s) for s in names] for e in residual]) * rate
    after = Assignments()
    if w.unknown:
        s, velocity = moved(Step.of(w.scheme), at.stage)
        c_u, where = reach.get(s, Integer(0)), w.components(s)
        speed = at.in_z(velocity) if by_velocity(w.motion) else zeros(w.size, 1)
        c_v: Expr = Integer(0) + speed[0].diff(z[0])
        if c_v != 0:
            speed = named("v", speed, "held")
            vectors.append((speed, c_v))
        residual, jacobian = joined(w, at.k, at.stage, (residual, jacobian), (where, c_u), (speed, c_v))
        w.reactions[s] = zeros(len(w.unknown), 1) if w.strengths else w.unknown
        if w.strengths:
            after += pushed(w, at.k, where, w.when(s))
    steady = _Steady(at.k, {s for m in (z, a, w.unknown, *(names for names, _ in vectors)) for s in m.free_symbols})
    residual, jacobian = (w.hoisted(m).applyfunc(steady.without) for m in (residual, jacobian))
    c_u, first = next(iter(reach.values()), Integer(0)), zeros(w.size, 1)
    if w.motion.bends_at_rest:  # as if there were no force of the rates, whose slope may have no bound at the last z
        still = at.acceleration(place, at.at_rest(at.in_z(place.u)), zeros(w.size, 1), load)
        first = w.hoisted(-(rest + still) / c_a).subs(dict(zip(w.unknown, w.latest, strict=True)))
    elif c_u != 0:
        first = (w.components(last) - w.components(predicted(0))) * w.reciprocal(c_u, c_u)
    far = Abs(c_u) + Abs(h * at.stage.c_v) if w.motion.of_rates or by_velocity(w.motion) else c_u
    before += steady.assignments
    first, w.latest, scene = Matrix([*first, *w.latest]), w.unknown, w.motion.scene
    return BalanceStep(
        at.k, Matrix([*z, *w.unknown]), before, within, residual, jacobian, Matrix(), first, far, after, c_a * mass,
        multipliers=len(w.unknown), bounded=len(scene.contacts) + len(scene.frictions),
    )  # fmt: skip


class _At:
    """Evaluates what a balance takes at a knot."""

    def __init__(self, w: Writer, k: int, stage: Stage) -> None:
        self.w, self.k, self.stage, self.z = w, k, stage, w.components(stage.z)

    def at_rest(self, vector: Matrix) -> Matrix:
        """The vector at z = 0."""
        return vector.subs(dict.fromkeys(self.z, Integer(0)))

    def acceleration(self, place: Place, u: Matrix, v: Matrix, load: Matrix) -> Matrix:
        """Minus the acceleration there under the load, times the weight."""
        mass, force = self.equation(place, u, v)
        return place.weight * solved(mass, force - load)

    def in_z(self, e: Expr) -> Matrix:
        """Components of a vector in those of the unknown and of what is known."""
        return self.w.hoisted(self.w.vector(sympify(e).subs(self.stage.in_z, simultaneous=True)))

    def moves(self, place: Place) -> bool:
        """Whether the equation of motion there depends on the unknown."""
        v = self.in_z(place.v) if self.w.motion.of_rates else Matrix()
        return any(e.has(*self.z) for e in (*self.in_z(place.u), *v))

    def equation(self, place: Place, u: Matrix, v: Matrix) -> tuple[Matrix, Matrix]:
        """Mass and forces there, at these components of displacement and velocity."""
        w = self.w
        instant = w.instant(factor(place.u.subs({**w.instants, h: 1}, simultaneous=True)))
        if isinstance(place.force, N_discrete):
            old, new = (list(w.vector(argument)) for argument in place.force.args)
            mass, force = w.motion.discrete_equation(old, new, list(v), instant)
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


def _places(stage: Stage, w: Writer) -> list[Place]:
    """Where the balance takes the equation of motion.

    Raises DeclarationError where it takes it at several knots, and what C multiplies is not the same mixture of theirs.
    """
    balance = stage.balance
    marks: dict[Expr, Dummy] = {atom: Dummy() for atom in sorted(balance.force.atoms(N, N_discrete), key=str)}
    force = balance.force.subs(marks)
    weights = {atom: factor(force.diff(mark)) for atom, mark in marks.items()}
    found = [
        Place(weight, atom, sum(atom.args, Integer(0)) / len(atom.args), balance.damping / weight)
        for atom, weight in weights.items()
    ]
    if len(found) == 1 or not w.motion.of_rates:
        return found
    found = [replace(place, v=_velocity(place.u)) for place in found]
    if (sum((place.weight * place.v for place in found), Integer(0)) - balance.damping).expand() != 0:
        raise DeclarationError(
            f"{w.scheme.name}: expected a balance whose damping mixes the velocities of the knots of its force, with "
            f"the same weights, got {balance.damping} beside {balance.force}, on {w.motion.scene.name}, whose forces "
            "depend on rates; take another scheme"
        )
    return found


def _velocity(u: Expr) -> Expr:
    """The velocity of the knots of a displacement."""
    at = {s: knot_of(s) for s in u.free_symbols}
    return u.subs({s: knot(found[1]).v for s, found in at.items() if found and found[0] == "u"}, simultaneous=True)
