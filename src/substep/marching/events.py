"""Where a run with reactions stands, the steps it may make, and what of its reactions acts.

Of each contact it is known whether it is closed, of each friction whether something slides, and which way: the mode. A
short step ahead says it, by the scheme's own balances, and leaves the run where it stands.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Array
from ..core.outcome import Happening
from ..core.schemes import Scheme

STICKS = 1e-9  # of velocities: what slides no faster at the end of a step does not slide
BEGINS = 1e-13  # the same of the short step ahead, in which what begins to slide is not fast
HELD = 1e-13  # of the scene's length: how far inside a stop a closed gap is held, so that no rounding opens it
INSIDE = 0.1  # of the accuracy asked for: how far inside a stop a motion may be at the end of a step
SHORT = 0.01  # of the accuracy asked for: what the motion does in a step that passes over an event
SHORTEST = 1e-11, 1e-8  # the same at least; with constraints, whose rounding over the step is in the velocity
LATE = 1e-14  # of the time: a step that does not get lost in its rounding

HIT = 2
Mode = tuple[int, ...]  # 0, 1 or, where it is about to be hit, HIT of each contact, and -1, 0 or 1 of each friction


class Stand(NamedTuple):
    """Where a run is: u, v (d,), a (d,) if the scheme has one, what is carried (m, d), None at a start of a scene.

    memory: of a scene (k,) what laws and reactions remember; of a structure `structures.march.structure_events.Kept`.
    """

    t: float
    u: Array
    v: Array
    a: Array | None
    rows: Array | None
    memory: Any


class Steps(NamedTuple):
    """A few steps of one length: a stand after each, and Newton's iterations (n, balances)."""

    stands: tuple[Stand, ...]
    iterations: NDArray[np.int64]


@dataclass
class Reacting(ABC):
    """A scene or a structure with reactions, and a scheme on it; accuracy: asked for, of its length.

    middle: a time between the break points of the load between which the run is. speed, rate: the largest velocity so
    far, and the largest that something slides with. contacts, frictions: their names, of one of several rows for each
    row; constrained: whether there are constraints. length: what a motion is measured by.
    """

    scheme: Scheme
    accuracy: float
    speed: float
    contacts: Sequence[str]
    frictions: Sequence[str]
    constrained: bool
    length: float
    middle: float = 0.0
    rate: float = 0.0

    @abstractmethod
    def steps(self, at: Stand, h: float, n: int, mode: Mode = ()) -> Steps | str:
        """n steps of h from a stand, each held to what is closed in a mode; or why one could not be made: a status."""

    @abstractmethod
    def pressing(self, stands: Sequence[Stand]) -> Array:
        """The reactions (m, d) of contacts and frictions in the steps to m stands."""

    @abstractmethod
    def drift(self, stands: Sequence[Stand]) -> tuple[Array, Array, Array]:
        """Of each contact and friction at each stand: minus the gap, or what slides; its rate; how steep it is."""

    @abstractmethod
    def acceleration(self, at: Stand) -> Array:
        """The acceleration (d,) of the equation of motion at a stand, under the load as it is around `middle`."""

    @abstractmethod
    def pushed(self, at: Stand, reactions: Array) -> Array:
        """The acceleration (d,) that reactions (d,) of contacts and frictions give at a stand, or its opposite."""

    @abstractmethod
    def changes_to(self, at: Stand, closed: NDArray[np.intp], wanted: Array) -> Array:
        """The least changes (d, 2) of u and v that change what `drift` has of closed contacts by `wanted` (k, 2)."""

    def moment(self, t: float) -> float:
        """Length of the step that passes over an event at the time t, s."""
        least = SHORTEST[self.constrained]
        return max(max(SHORT * self.accuracy, least) * self.length / self.speed, LATE * abs(t))

    @property
    def least(self) -> float:
        """Length of a step, s, below which velocities are rounding, where displacements are held; 0 where none are."""
        return SHORTEST[1] * self.length / self.speed if self.constrained else 0.0

    def mode(self, at: Stand) -> Mode | None:
        """What acts ahead of a stand; None where a short step cannot be made."""
        if not (self.contacts or self.frictions):
            return ()
        made = self.steps(at, self.moment(at.t), 1)
        if isinstance(made, str):
            return None
        found, d = self.modes(made, BEGINS)[0], len(self.contacts)
        _, rates, across = self.drift((at,))
        hit = rates[0] > max(STICKS, SHORT * self.accuracy) * across[0] * self.speed
        return (*(x * (HIT if y else 1) for x, y in zip(found[:d], hit.tolist(), strict=False)), *found[d:])

    def modes(self, made: Steps, rounding: float = STICKS) -> list[Mode]:
        """What has acted in each of some steps; what slides without a force, as where it touches nothing, does not."""
        d, forces = len(self.contacts), self.pressing(made.stands)
        closed = forces[:, :d] > 0.0
        _, rates, across = self.drift(made.stands)
        rates, across = rates[:, d:], across[:, d:]
        self.rate = max(self.rate, float(np.abs(rates).max(initial=0.0)))
        least = rounding * np.maximum(across * self.speed, self.rate)
        slides = np.sign(rates) * ((np.abs(rates) > least) & (forces[:, d:] != 0.0))
        return [(*x, *y) for x, y in zip(closed.astype(int).tolist(), slides.astype(int).tolist(), strict=True)]

    def keeps(self, made: Steps, mode: Mode) -> bool:
        """Whether nothing has changed in some steps: neither what acts, nor has a motion gone into a stop."""
        if not (self.contacts or self.frictions):
            return True
        d = len(self.contacts)
        inside, _, across = self.drift(made.stands)
        free = np.array(mode[:d]) == 0
        beyond = inside[:, :d] > INSIDE * self.accuracy * self.length * across[:, :d]
        return not (beyond & free).any() and all(x == mode for x in self.modes(made))

    def changes(self, at: Stand, h: float, mode: Mode) -> bool:
        """Whether the mode is another one by the end of two steps that are h together."""
        made = self.steps(at, 0.5 * h, 2, mode)
        return isinstance(made, str) or not self.keeps(made, mode) or self.mode(made.stands[-1]) != mode

    @abstractmethod
    def onto_constraints(self, at: Stand) -> Array:
        """The least change (d,) of v, measured by the mass, with which it keeps constraints; where there are any."""

    def held(self, at: Stand, mode: Mode) -> Stand:
        """The stand with closed gaps, and their rates, moved to where they are held, by as little as possible.

        Steps hold the rates of gaps, which are then of the scheme's error, and what rounding opens would fall. So are
        the rates of constraints moved to 0: by the trapezoidal rule a rate, as an impact leaves one, changes its sign
        in each step, and no length of a step is short enough for it.
        """
        closed = np.flatnonzero(np.array(mode[: len(self.contacts)]) == 1)
        if closed.size:
            inside, rates, across = (x[0, closed] for x in self.drift((at,)))
            wanted = np.column_stack([HELD * self.length * across - inside, -rates])
            at = self._moved(at, *self.changes_to(at, closed, wanted).T)
        return self._moved(at, 0.0, self.onto_constraints(at)) if self.constrained else at

    def _moved(self, at: Stand, u: Array | float, v: Array) -> Stand:
        """The stand with these changes of displacements and velocities, in what is carried too."""
        assert at.rows is not None
        rows = at.rows.copy()
        for k, (kind, _) in enumerate(self.scheme.history):
            if kind < 2:
                rows[k] += (u, v)[kind]
        return at._replace(u=at.u + u, v=at.v + v, rows=rows)

    def happened(self, t: float, before: Mode, within: Mode, after: Mode) -> Iterator[Happening]:
        """What an event at t was, by the modes before, in the step that passed over it, and after it."""
        d = len(self.contacts)
        for k, (name, x, y, z) in enumerate(zip((*self.contacts, *self.frictions), before, within, after, strict=True)):
            if k < d:
                said = {(0, 1): "closes", (1, 0): "opens"}.get((x % HIT, z % HIT), "hits" if y and x != 1 else "")
            else:
                said = "" if x == z else "sticks" if z == 0 else "slides" if x == 0 else "turns"
            if said:
                yield Happening(float(t), name, said)
