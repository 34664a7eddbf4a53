"""Step -> the instants of its knots, and those at which a step has reached the motion and goes on from it.

A knot is a label, never a time. Its instant is where a motion of constant velocity passes through it, since every
consistent scheme follows that motion exactly.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from sympy import Expr, Integer, Symbol, cancel, ordered

from ..algebra.constant import reduced
from ..declare.errors import DeclarationError
from ..declare.parameter import positive
from ..declare.symbols import K0, C, K_t, N, N_discrete, h, kind_of, steps_back
from .step import Step


@dataclass(frozen=True)
class SubStepEnd:
    """A displacement at which a step commits what a scene remembers, and its instant in steps after t_n.

    always: whether the instant lies inside the step and after the commit before it whatever the parameters are.
    """

    u: Symbol
    instant: Expr
    always: bool


def passed(step: Step) -> Mapping[Symbol, Expr]:
    """Each symbol of a step in a motion of velocity 1 that is 0 at t_n, for h = 1: of a displacement its instant."""
    state = {s: [-steps_back(s), Integer(1), Integer(0)][kind_of(s)] for s in step.state}
    return {**state, **_followed(step, state, Integer(0))}


def sub_step_ends(step: Step) -> Sequence[SubStepEnd]:
    """The knots inside the step that end a sub-step, in the order in which they are solved.

    A knot does where a balance takes the internal force at it, or at a mixture with it, and it follows the motion to
    second order, as the end of a step does: a uniformly accelerated motion passes through it. Stages of Runge-Kutta
    that do not are no such ends, nor are knots whose balances are solved together with others. Where the balances do
    not go forward in time, as in compositions with negative sub-steps and in extrapolation, there is none.

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
    accelerated = {s: [steps_back(s) ** 2, -2 * steps_back(s), Integer(2)][kind_of(s)] for s in step.state}
    followed = _followed(step, accelerated, Integer(2))
    found, last = list[SubStepEnd](), Integer(0)
    for s, at in reached:
        if last < at < 1 and reduced(cancel(followed[s] - instants[s] ** 2)) == 0:
            previous = found[-1].instant if found else Integer(0)
            gaps = instants[s] - previous, 1 - instants[s]
            found.append(SubStepEnd(s, instants[s], all(positive(gap, step.scheme.parameters) for gap in gaps)))
            last = at
    return found


def _followed(step: Step, state: Mapping[Symbol, Expr], acceleration: Expr) -> Mapping[Symbol, Expr]:
    """The new symbols of a step of length 1 from a state, with this acceleration in each balance, of a free mass."""
    values = {**state, **dict.fromkeys(step.accelerations, acceleration), h: Integer(1), C: Integer(0), K0: Integer(0)}
    return {s: reduced(e.subs(values, simultaneous=True)) for s, e in step.solved.items()}
