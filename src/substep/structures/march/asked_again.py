"""Whether an internal force answers the same question twice alike: one that keeps a memory of its own does not.

Between two marches it may, since what a function of the user's reads may have changed.
"""

from dataclasses import replace
from typing import NamedTuple, TypeVar

import numpy as np

from ...core.arrays import Array
from ...core.loads import is_known
from ..model.held import Held
from ..model.internal_force import InternalForce
from ..model.memory import Memory, Recalled, RememberingForce
from ..model.model import Model
from ..solvers.combine import combined
from ..solvers.matrices import arrays_of, is_operator
from .steps import Run
from .time_loop import Trial

EVERY = 64  # steps; before that after 1, 2, 4, 8, ..
SAME = 1e-9  # of the largest force so far


M = TypeVar("M", bound=Model)


def asked_anew(structure: M, *, at_start: bool = True) -> M:
    """The structure without what functions of the user's answered at the start: what they read may have changed since.

    Another one, with the tangent at the start as K, where that has. at_start: whether a run begins there; raises
    ValueError where that was an equilibrium with another tangent.
    """
    force = structure.internal
    own = force is not None and (not isinstance(force, RememberingForce) or force.material is not None)
    if not own and not isinstance(structure.contacts, Held) and all(is_known(g) for _, g in structure.loads):
        return structure
    for name in ("force_damping", "memory0", "at_start", "a0"):
        structure.__dict__.pop(name, None)
    if not own or force is None:
        return structure
    force.kept.clear()
    if force.tangent is None:
        return structure
    tangent = force.at_start(structure.u0, structure.v0)[0]
    pairs = zip(arrays_of(tangent), arrays_of(structure.K), strict=False)
    same = is_operator(tangent) or all(x.shape == y.shape and np.allclose(x, y, 1e-9, 0.0) for x, y in pairs)
    if structure.static and at_start and not same:
        raise ValueError(
            "expected u0='static' in equilibrium with internal_force as it is, got a tangent there that is another "
            "than when the structure was made; make it anew, or give u0 as numbers"
        )
    return structure if same else replace(structure, K=tangent)


class Question(NamedTuple):
    """A time, u, v (n,) and what was remembered there, and the force (n,) that was the answer."""

    t: float
    u: Array
    v: Array
    memory: Memory | None
    answer: Array


class AskedAgain:
    """Asks a force of the user's again what it was asked at the start and at the last look, at a few steps of a march.

    What it has answered in between is a long way from there, so that a function moved by its calls is found.
    """

    def __init__(self, run: Run) -> None:
        force = run.structure.internal
        own = isinstance(force, InternalForce) or (isinstance(force, RememberingForce) and force.material is not None)
        self.run, self.force, self.steps = run, force if own else None, 0
        self.questions, self.largest, self.last = list[Question](), 0.0, None
        if self.force is not None:
            u, v, _ = run.given
            self._ask(run.time(0), u, v, run.memory)
            self._repeat()

    def after(self, step: object) -> None:
        """After a step that counts. Raises ValueError for a force that has answered otherwise."""
        if self.force is None or not isinstance(step, Trial):
            return
        self.steps += 1
        self.last: Trial | None = step
        if self.steps % EVERY == 0 or (self.steps < EVERY and self.steps & (self.steps - 1) == 0):
            self.look()

    def look(self) -> None:
        """After the last step so far; see `after`."""
        step, self.last = self.last, None
        if step is not None:
            self._repeat()
            self.questions[1:] = []
            self._ask(step.t, *combined(step.march.steps.report[:2], step.X), step.march.memory)

    def _ask(self, t: float, u: Array, v: Array, memory: Memory | None) -> None:
        self.questions.append(Question(t, u.copy(), v.copy(), memory, self._answer(t, u, v, memory)))

    def _repeat(self) -> None:
        for t, u, v, memory, before in self.questions:
            now = self._answer(t, u, v, memory)
            wrong = np.abs(now - before)
            if not (wrong <= SAME * self.largest).all() and not np.array_equal(now, before, equal_nan=True):
                place = int(np.argmax(np.nan_to_num(wrong, nan=np.inf)))
                raise ValueError(
                    f"expected internal_force to give the same force each time it is asked the same, got "
                    f"{before[place]:.6g} and then {now[place]:.6g} at degree of freedom "
                    f"{self.run.structure.named(place)} for t = {t:.6g}: it keeps a memory of its own, which "
                    "iterations and stages of a step would move as they come; give what it remembers as state=, and "
                    "let it return force, tangent and new state"
                )

    def _answer(self, t: float, u: Array, v: Array, memory: Memory | None) -> Array:
        assert self.force is not None
        self.force.kept.clear()
        found = self.force(t, u, v, None if memory is None else Recalled(memory))
        self.largest = max(self.largest, float(np.abs(found).max(initial=0.0)))
        return found
