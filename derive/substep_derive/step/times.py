"""Step -> the instants of its knots, and those at which a step has reached the motion and goes on from it.

A knot is a label, never a time. Its instant is where a motion of constant velocity passes through it, since every
consistent scheme follows that motion exactly.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

from sympy import Abs, Expr, Integer, Matrix, Symbol, cancel, diff, factor, linsolve, ordered, sympify

from ..algebra.constant import reduced
from ..declare.errors import DeclarationError
from ..declare.parameter import positive
from ..declare.symbols import K0, C, K_t, N, N_discrete, f, h, kind_of, knot, knot_of, steps_back, successor
from .step import Stage, Step


@dataclass(frozen=True)
class SubStepEnd:
    """A displacement at which a step commits what a scene remembers, and its instant in steps after t_n.

    always: whether the instant lies inside the step and after the commit before it whatever the parameters are.
    """

    u: Symbol
    instant: Expr
    always: bool


@cache
def passed(step: Step) -> Mapping[Symbol, Expr]:
    """Each symbol of a step in a motion of velocity 1 that is 0 at t_n, for h = 1: of a displacement its instant."""
    return _followed(step, 1)


def sub_step_ends(step: Step) -> Sequence[SubStepEnd]:
    """The knots inside the step that end a sub-step, in the order in which they are solved.

    A knot does where a balance takes the internal force at it, or at a mixture with it, and it follows the motion as
    the end of the step does: a uniformly accelerated motion passes through it, and t^3, t^4, ... do as far as they pass
    through the end whatever the parameters are. Stages of Runge-Kutta are no such ends, since they are less exact than
    the step: where a load bends they go to and fro while the motion does not. Nor are knots whose balances are solved
    together with others. Where the balances do not go forward in time, as in compositions with negative sub-steps and
    in extrapolation, there is none.

    Raises DeclarationError for a scheme that takes the force as a discrete gradient, which needs a potential, or at a
    displacement before t_n, where what was remembered then is no longer known.
    """
    everything = [*step.equations, *step.reported, *(step.start or ())]
    atoms = {a for e in everything for a in e.atoms(N, N_discrete, K_t)}
    name = step.scheme.name
    if any(isinstance(a, N_discrete) for a in atoms):
        raise DeclarationError(
            f"{name} takes the internal force as a discrete gradient of a potential: expected no law or "
            "material with a memory, which has no potential; take another scheme"
        )
    if back := [s for a in ordered(atoms) for s in ordered(a.free_symbols) if s in step.state and steps_back(s) > 0]:
        raise DeclarationError(
            f"{name} takes the internal force at {back[0]}: expected no law or material with a "
            "memory, since what was remembered before t_n is not kept; take another scheme"
        )
    instants = {s: e for s, e in passed(step).items() if kind_of(s) == 0 and s not in step.state}
    at_typical = {s: e.subs(step.scheme.typical) for s, e in instants.items()}
    alone = [x.balances[0] for x in step.stages if x.alone]
    moved = [{s for a in b.force.atoms(N) for s in a.free_symbols if s in instants} for b in alone]
    reached = [(s, at_typical[s]) for symbols in moved for s in sorted(ordered(symbols), key=at_typical.__getitem__)]
    if any(later < at for (_, at), (_, later) in pairwise(reached)):
        return []
    followed = _followed_as_the_end(step, [s for s, _ in reached])
    found, last = list[SubStepEnd](), Integer(0)
    for s, at in reached:
        inside = at < 1 or (at == 1 and cancel(instants[s] - 1) != 0)  # other parameters may have it earlier
        if last < at and inside and s in followed:
            previous = found[-1].instant if found else Integer(0)
            gaps = instants[s] - previous, 1 - instants[s]
            found.append(SubStepEnd(s, instants[s], all(positive(gap, step.scheme.parameters) for gap in gaps)))
            last = at
    return found


@cache
def instants_of(step: Step) -> Mapping[Symbol, Expr]:
    """Of each displacement of a step its instant, in steps after t_n."""
    return {s: sympify(e) for s, e in passed(step).items() if kind_of(s) == 0}


def instant_of(displacement: Expr, instants: Mapping[Symbol, Expr]) -> Expr:
    """When a motion of constant velocity passes a displacement, or a mixture of some, in steps after t_n.

    instants: those of the displacements that it is made of, as `instants_of` gives them.
    """
    return factor(displacement.subs({**instants, h: Integer(1)}, simultaneous=True))


@dataclass(frozen=True)
class Impulses:
    """How reactions act that a scheme does not remember: the acceleration that it keeps is without theirs.

    A reaction that is constant accelerates by 1 where it acts alone. strengths: for each balance the acceleration that
    is then its reaction's, so that its velocity is exact; 2 for the trapezoidal rule, which gives a new acceleration
    half of the step. Velocities and displacements before are exact, and what is kept of accelerations is 0. weights:
    what accelerations of the reactions of a step, each times its own, are as one that is constant.
    """

    strengths: tuple[Expr, ...]
    weights: tuple[Expr, ...]


@cache
def impulses(step: Step) -> Impulses:
    """Those of a step.

    Raises DeclarationError for a balance that does not move the velocity where it takes the force.
    """
    back = {s: sympify(steps_back(s)) for s in step.state}
    values = {s: [tau**2 / 2, -tau, Integer(0)][kind_of(s)] for s, tau in back.items()} | {h: Integer(1)}
    at, found = instants_of(step), list[Expr]()
    known = {s: e.subs(values, simultaneous=True) for s, e in step.solved.items()}
    for stage in step.stages:
        ends = [moved(step, step.accelerations.index(z)) for z in stage.z]
        left = [known.get(v, Integer(0)) - at[u] for u, v in ends]
        acting = Matrix(left).jacobian(stage.z).applyfunc(lambda e: reduced(cancel(e)))
        if cancel(acting.det()) == 0:
            raise DeclarationError(
                f"{step.scheme.name}: expected each balance to move the velocity of the displacement that it takes the "
                f"force at, {', '.join(str(v) for _, v in ends)}, so that an impulse acts in it; take another scheme"
            )
        (values,) = linsolve(left, *stage.z)
        found += [reduced(cancel(e)) for e in values]
        known = {s: e.subs(dict(zip(stage.z, found[-len(stage.z) :], strict=True))) for s, e in known.items()}
    reported = step.reported[1].subs({s: e.subs(h, 1) for s, e in step.solved.items()}, simultaneous=True)
    slopes = [reported.diff(z) for z in step.accelerations]
    whole = sum((a * s for a, s in zip(slopes, found, strict=True)), Integer(0))
    return Impulses(tuple(found), tuple(reduced(cancel(a / whole)) for a in slopes))


def impulses_last(step: Step) -> bool:
    """Whether a velocity that a balance's reaction gives stays as it is, without forces, to the end of steps after it.

    It does not where a velocity is extrapolated from several, as by three-point backward Euler, or where later balances
    count an acceleration once more.
    """
    _, v0, _ = knot(0)
    reported = step.reported[1].subs(step.solved, simultaneous=True)
    others = [s for s in step.state if kind_of(s) < 2 and s != v0]
    if reported.diff(v0) != 1 or any(reduced(cancel(reported.diff(s))) != 0 for s in others):
        return False
    given = [step.solved.get(moved(step, k)[1], Integer(0)).diff(z) for k, z in enumerate(step.accelerations)]
    changes = [reduced(cancel(reported.diff(z) - g)) for z, g in zip(step.accelerations, given, strict=True)]
    return all(change == 0 for change in changes)


def drift_at_rest(step: Step) -> Expr:
    """The displacement of a step in which a reaction that is not remembered holds the velocity at 0.

    In units of h^2 times the constant acceleration of a force against the stop: (2 beta - gamma)/(2 gamma) in Newmark's
    family. What rests on a stop sinks into it where this is negative, and is lifted, to fall again, where positive. Of
    a step with one balance.
    """
    kept = {s: [Integer(0), Integer(0), Integer(-1)][kind_of(s)] for s in step.state}
    (z,) = step.accelerations
    at = {**kept, h: Integer(1), C: Integer(0)}
    u, v = (e.subs(step.solved, simultaneous=True).subs(at, simultaneous=True) for e in step.reported[:2])
    return reduced(cancel(u.subs(z, -v.subs(z, 0) / v.diff(z))))


def growth_where_held(step: Step) -> float:
    """The largest factor of velocities in a step whose reactions hold displacements at 0 and are not remembered.

    At typical parameters; of a step with balances that each move a displacement. It is |1 - gamma/beta| in Newmark's
    family: velocities of 0 are not what displacements of 0 give, and what is left of them grows beyond 1.
    """
    velocities = [s for s in step.state if kind_of(s) == 1]
    if not velocities:
        return 0.0
    at = {s: s if s in velocities else Integer(0) for s in step.state} | {h: Integer(1), C: Integer(0), K0: Integer(0)}
    known = {s: e.subs(step.scheme.typical).subs(at, simultaneous=True) for s, e in step.solved.items()}
    (z,) = linsolve([known[moved(step, k)[0]] for k in range(len(step.accelerations))], *step.accelerations)
    known |= at | dict(zip(step.accelerations, z, strict=True))
    after = Matrix([known[successor(s)] for s in velocities]).subs(known, simultaneous=True)
    return max(float(Abs(e).n()) for e in after.jacobian(velocities).eigenvals())


def moved(step: Step, k: int) -> tuple[Symbol, Symbol]:
    """The newest displacement that the k-th balance takes the force at, of those that move in its stage; and its v."""
    stage, j = step.placed[k]
    forces = stage.balances[j].force.atoms(N, N_discrete)
    at = instants_of(step)
    among = stage.moved_by(j) or {s for a in forces for s in a.free_symbols if s in at}
    u = max(among, key=lambda s: (at[s].subs(step.scheme.typical), str(s)))
    return u, Symbol(f"v_{(knot_of(u) or ('', '0'))[1]}")


def newest(step: Step, stage: Stage) -> int:
    """The place, among all balances, of that of a stage which takes the force at the latest displacement."""
    at = {k: instants_of(step)[moved(step, k)[0]] for k in map(step.accelerations.index, stage.z)}
    return max(at, key=lambda k: (at[k].subs(step.scheme.typical), k))


def _followed_as_the_end(step: Step, among: Collection[Symbol]) -> Collection[Symbol]:
    """Those of some displacements on which t^2 is, and t^3, t^4, ... as far as the end of the step is on these."""
    at, degree = instants_of(step), 2
    while among:
        motion = _followed(step, degree)
        end = step.reported[0].subs({**motion, h: Integer(1)}, simultaneous=True)
        if degree > 2 and reduced(cancel(end - 1)) != 0:
            break
        among = [s for s in among if reduced(cancel(motion[s] - at[s] ** degree)) == 0]
        degree += 1
    return among


def _followed(step: Step, degree: int) -> Mapping[Symbol, Expr]:
    """The symbols of a step of length 1 of a free mass, from the motion t^degree at t_n on, under the load it needs."""
    t = Symbol("t")
    motion = [diff(t**degree, t, k) for k in range(3)]
    state = {s: motion[kind_of(s)].subs(t, -steps_back(s)) for s in step.state}
    still = {**state, h: Integer(1), C: Integer(0), K0: Integer(0)}

    def on_it(e: Expr) -> Expr:
        return e.xreplace({**step.solved}).xreplace(still)

    if degree > 2:
        loads = [b.load.replace(f, lambda tau: motion[2].subs(t, tau)) for b in step.scheme.balances]
        balances = [on_it(b.inertia) - load for b, load in zip(step.scheme.balances, loads, strict=True)]
        (z,) = linsolve(balances, *step.accelerations)
    else:
        z = [motion[2]] * len(step.accelerations)
    accelerations = dict(zip(step.accelerations, z, strict=True))
    return {**state, **accelerations, **{s: reduced(on_it(s).subs(accelerations)) for s in step.solved}}
