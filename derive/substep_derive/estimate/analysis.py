"""What a scheme holds, in sets of growing expense, and its local errors: what estimators are chosen from."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from sympy import QQ, Symbol

from ..declare.errors import DeclarationError
from ..declare.symbols import kind_of, knot
from ..oscillator.evaluation import Evaluation
from .expansion import Expansion
from .held import END, START
from .motion import SmoothMotion
from .stiff import Growth

HIGHEST = (4, 6, 8, 11)  # weights up to which a local error is looked for, one after the other


class NoEstimator(DeclarationError):
    """A scheme, or a set of parameters, for which there is no estimate of the kind asked for; the message says why."""


@dataclass(frozen=True, eq=False)
class Analysis:
    """Expansions of what a step holds, and of its local errors, with numbers of one field for the parameters."""

    evaluation: Evaluation
    motion: SmoothMotion
    values: Mapping[Symbol, Expansion]
    errors: tuple[Expansion, Expansion]

    @cached_property
    def growths(self) -> tuple[Growth, ...]:
        """Undamped, and at an unremarkable damping ratio; for numbers only."""
        domain = self.evaluation.field.domain
        dampings = (QQ(0), QQ(1, 4)) if self.motion.damped else (QQ(0),)
        return tuple(Growth(self.evaluation, domain.convert(damping)) for damping in dampings)

    @property
    def held(self) -> dict[Symbol, Expansion]:
        """Symbols of the step, and u_*end, v_*end where the scheme reports something of its own."""
        scheme = self.motion.step.scheme
        reports = [end for end, own in zip(END[:2], knot(1)[:2], strict=True) if scheme.report.get(own, own) != own]
        return {s: self.values[s] for s in (*scheme.unknowns, *scheme.state, *reports)}

    @property
    def lag(self) -> int | None:
        """The power of h with which the state's acceleration differs from the motion's own; None where it does not."""
        a = knot(0).a
        if a not in self.motion.step.state:
            return None
        valuation = (self.values[a] - self.values[START.a]).valuation
        return None if valuation is None else valuation - 2

    @property
    def uneven(self) -> bool:
        """Whether the smooth motion does not depend on the step: the step before may have been of another length."""
        exact = {s: Expansion({(0, 0, kind_of(s)): self.motion.one}).terms for s in self.motion.step.state}
        return set(exact) <= set(knot(0)) and all(self.values[s].terms == terms for s, terms in exact.items())


def analysis_of(evaluation: Evaluation, damped: bool, top: int | None = None) -> Analysis:
    """Expansions up to a weight, by default up to that of the local errors. damped: whether c is not 0."""
    for highest in HIGHEST if top is None else (top,):
        motion = SmoothMotion(evaluation, highest, damped)
        values = motion.held()
        errors = motion.errors(values)
        if top is not None or all(e.undamped_valuation is not None for e in errors):
            return Analysis(evaluation, motion, values, errors)
    raise NoEstimator(
        f"{evaluation.scheme.name}: expected local errors of order {HIGHEST[-1] - 2} at most, got none up to there in "
        "u or in v; a scheme that is exact needs no estimate"
    )


ACCELERATION = "the acceleration at t_n + h from the equation of motion, at the u and v reported there"
BEFORE = "the same at t_n, kept from the step before"


LEVELS = range(5)
WITHOUT_BEFORE = (0, 1, 4)  # of them those that need nothing of the step before but the acceleration at its end


def pool(analysis: Analysis, level: int, ratio: Any) -> tuple[dict[Symbol, Expansion], dict[Symbol, str]]:
    """Values by symbol, and what of them is needed besides the step, at a level of expense.

    0: what the step holds. 1: and the acceleration at its end. 2: and what the step before held, which was ratio*h
    long. 3: both. 4: what the step holds, and u, v after two half steps.
    """
    motion, values, held = analysis.motion, analysis.values, analysis.held
    found, needed = dict(held), {}
    if level in (1, 3):
        found |= {s: values[s] for s in (END.a, START.a)}
        needed |= {END.a: ACCELERATION, START.a: BEFORE}
    if level in (2, 3):
        before = {s: x for s, x in motion.before(values, held, ratio).items() if s not in values}
        length = ", which was kappa*h long" if analysis.uneven else ", of the same length"
        found |= before
        needed |= {s: f"of the step before{length}; kept" for s in before}
    if level == LEVELS[-1]:
        halved = motion.halved()
        found |= halved
        needed |= {s: f"{'uv'[kind_of(s)]} at t_n + h after two steps of h/2 from the same state" for s in halved}
    return found, needed
