"""Body x estimator -> EstimatedBody: a step whose length the march chooses, with its estimated local error."""

from collections.abc import Mapping
from dataclasses import dataclass

from sympy import Expr, Integer, Matrix, Symbol

from ..declare.errors import DeclarationError
from ..declare.law import elapsed
from ..declare.scheme import Scheme
from ..declare.symbols import h, knot, knot_of, sampled, t
from ..estimate.estimator import acceleration_lag, kappa
from ..estimate.held import END, HALVED, START, earlier
from ..motion.components import Assignments, Writer, assign, component_names
from ..motion.equations import EquationsOfMotion, inverted
from ..step.step import Step
from .balance_step import Part
from .body import Body
from .held_block import accelerated
from .interpolant import Interpolant
from .local_error import Terms, factored, weight_names


@dataclass(frozen=True)
class EstimatedBody:
    """body: as of a constant step, with h a variable and the time t_n = t.

    once: constants that do not depend on h; changing: those that do, and are computed again where h changes; uneven:
    those that depend on kappa, the length of the step before divided by h. error_u, error_v: names and expressions of
    the estimated errors' components; error_end: those of the check of the end, none where the others see it; always:
    whether each step needs it, or only one that has none before it. kept: what is carried from an accepted step to the
    next for the estimate -> what it is in that step, a symbol of the step or a_*end. by_before: whether the errors of
    u, of v need the step before. lag: the power of h with which a_0 differs from the motion's own acceleration; None
    where it does not. halved: the same step, of which two of half the length are made; None where no estimate needs
    them. acceleration: from the equation of motion, in components of u, v named without a knot, t and the load, and in
    what `accelerating` computes before.
    between: the interpolant, for one coordinate of a step. remembered: what laws remember in the step, in components of
    u named without a knot and `elapsed`; elongations: those of the laws and their rates, named so too.
    """

    body: Body
    terms: Terms
    once: Assignments
    changing: Assignments
    uneven: Assignments
    error_u: Assignments
    error_v: Assignments
    error_end: Assignments
    always: bool
    kept: Mapping[Symbol, Symbol]
    by_before: tuple[bool, bool]
    lag: int | None
    halved: Body | None
    acceleration: Matrix
    accelerating: tuple[Part, ...]
    between: Interpolant
    remembered: tuple[Expr, ...]
    elongations: tuple[tuple[Expr, Expr], ...]

    @classmethod
    def of(
        cls, scheme: Scheme, motion: EquationsOfMotion, terms: Terms, order: int, always: bool = True
    ) -> "EstimatedBody":
        """terms, order, always: of the local error's estimate (see `LocalError`).

        Raises DeclarationError as `Body.of`, and for a scheme whose state holds values before t_n or does not
        begin with u_0, v_0, a_0: its step cannot change.
        """
        if held := motion.scene.multipliers:
            raise DeclarationError(
                f"{motion.scene.name}: expected a scene without reactions where lanes choose their steps, since the "
                f"estimated error would not say theirs, got {', '.join(map(str, held))}; give dt, or march one by one"
            )
        if earlier_ones := [s for s in scheme.state if s not in knot(0)]:
            raise DeclarationError(
                f"{scheme.name}: expected a state at t_n alone where steps change, got {earlier_ones[0]}, which stands "
                "at another time; give dt, or take a one-step or composite scheme"
            )
        if scheme.start_scheme is not None or scheme.start:
            raise DeclarationError(
                f"{scheme.name}: expected a state that begins with u_0, v_0, a_0 where steps change, got a start of "
                "its own, which depends on the step; give dt, or take another scheme"
            )
        factors, errors = factored(terms)
        before = _before(scheme, {s for e in errors for s in e.free_symbols})
        by_before = tuple(bool(e.free_symbols & before.keys()) for e in errors)
        names = {s: Symbol(f"{s.name[0]}_*before{k}") for k, s in enumerate(before)}
        at_end = dict(zip(END[:2], Step.of(scheme.in_doubles).reported[:2], strict=True))
        errors = [e.subs({**at_end, **names}, simultaneous=True) for e in errors]
        kept = {names[s]: source for s, source in before.items()}
        lag = acceleration_lag(scheme)
        if lag is not None or any(e.has(START.a) for e in errors):
            kept[START.a] = END.a
        body = Body.of(
            scheme, motion, now=t, errors=errors, weights=[*weight_names(terms), *(name for name, _ in factors)],
            read=before.values(),
        )  # fmt: skip
        once, changing, uneven = _by_change(factors, body.constants)
        found = [
            assign(Matrix([Symbol(name) for name in component_names(Symbol(kind), motion)]), e)
            for kind, e in zip(("u_*error", "v_*error", "v_*lateerror"), body.errors, strict=False)
        ]
        u, v = ([Symbol(name) for name in component_names(Symbol(f"{k}_*now"), motion)] for k in "uv")
        place = dict(zip((*motion.coordinates, *motion.scene.rates), (*u, *v), strict=True))
        place |= {
            sampled: Symbol("load"),
            elapsed: Integer(0),
            **{s: old for s, (old, _) in zip(motion.memory, body.memory, strict=True)},
        }
        acceleration, accelerating = _acceleration(scheme, motion, place)
        halved = Body.of(scheme, motion, now=t) if any(e.has(*HALVED[:2]) for e in errors) else None
        return cls(
            body, terms, once, [*changing, *body.near], uneven, found[0], found[1], found[2] if found[2:] else [],
            always, kept, (by_before[0], by_before[1]), lag, halved, acceleration, accelerating,
            Interpolant.of(knot(0), knot(1), order),
            tuple(e.xreplace({**place, elapsed: elapsed}) for e in motion.commit.values()),
            tuple((x.xreplace(place), r.xreplace(place)) for x, r in motion.elongations),
        )  # fmt: skip

    @property
    def own_acceleration(self) -> bool:
        """Whether the scheme reports an acceleration of its own."""
        return len(self.body.report) > 2

    @property
    def end_is_estimated(self) -> bool:
        """Whether each step's estimate takes the acceleration at its end from the equation of motion."""
        return self.takes_end([*self.error_u, *self.error_v, *(self.error_end if self.always else [])])

    def takes_end(self, errors: Assignments) -> bool:
        """Whether they contain the acceleration at the end of the step from the equation of motion."""
        names = set(self.body.components(END.a))
        return any(s.name in names for _, e in errors for s in e.free_symbols)

    @property
    def refactored(self) -> bool:
        """Whether the scene is linear and an effective mass depends on h, so that its inverse changes with the step."""
        depends = {name for name, _ in self.changing}
        return self.body.motion.linear and any(depends & step.inverse.free_symbols for step in self.body.steps)

    @property
    def expressions(self) -> list[Expr]:
        """Every expression that a run computes."""
        return [*self.body.expressions, *self.of_acceleration]

    @property
    def of_acceleration(self) -> list[Expr]:
        """Every expression that the acceleration from the equation of motion is computed by."""
        return [*(e for part in self.accelerating for _, e in part.assignments), *self.acceleration]


def _acceleration(
    scheme: Scheme, motion: EquationsOfMotion, place: Mapping[Symbol, Expr]
) -> tuple[Matrix, tuple[Part, ...]]:
    """The acceleration from the equation of motion at a place, and what is computed for it before."""
    if inverted(motion.mass):
        return motion.consistent_acceleration.xreplace(place), ()
    w, (mass, force) = Writer(scheme.in_doubles, motion, ()), motion.constrained
    found, parts = accelerated(w, mass.xreplace(place), force.xreplace(place), "given")
    return found, (Part(w.constants), *parts)


def _before(scheme: Scheme, used: set[Symbol]) -> dict[Symbol, Symbol]:
    """Values of the step before that an estimate uses -> what they were called in that step."""
    own = {*scheme.unknowns, *scheme.state, *END, *START, *HALVED}
    names = {earlier(s): s for s in (*scheme.unknowns, *scheme.state)}
    wanted = sorted((s for s in used if knot_of(s) and s not in own), key=str)
    if unknown := [s for s in wanted if s not in names]:
        raise DeclarationError(
            f"{scheme.name}: expected an estimate from what a step holds, the ends' accelerations, the step before and "
            f"two half steps, got {unknown[0]}; march it with dt"
        )
    return {s: names[s] for s in wanted}


def _by_change(factors: Assignments, constants: Assignments) -> tuple[Assignments, Assignments, Assignments]:
    """Assignments that depend neither on h nor on kappa, that depend on h alone, and those that depend on kappa."""
    found: tuple[Assignments, Assignments, Assignments] = ([], [], [])
    depends = {h: 1, kappa: 2}
    for name, e in (*factors, *constants):
        place = max((depends.get(s, 0) for s in e.free_symbols), default=0)
        depends[name] = place
        found[place].append((name, e))
    return found
