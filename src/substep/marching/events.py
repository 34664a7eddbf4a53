"""Where a run of a scene with reactions stands, the steps it may make, and what of its reactions acts.

Of each contact it is known whether it is closed, of each friction whether something slides, and which way: the mode. A
short step ahead says it, by the scheme's own balances, and leaves the run where it stands.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Array
from ..core.loads import is_known, one_sided
from ..core.response import Happening
from ..core.scenes import Scene
from ..core.schemes import Scheme
from ..run.clock import Begin
from .scene_lanes import march_lanes

STICKS = 1e-9  # of velocities: what slides no faster at the end of a step does not slide
BEGINS = 1e-13  # the same of the short step ahead, in which what begins to slide is not fast
HELD = 1e-13  # of the scene's length: how far inside a stop a closed gap is held, so that no rounding opens it
INSIDE = 0.1  # of the accuracy asked for: how far inside a stop a motion may be at the end of a step
SHORT = 0.01  # of the accuracy asked for: what the motion does in a step that passes over an event
SHORTEST = 1e-11, 1e-8  # the same at least; with constraints, whose rounding over the step is in the velocity
LATE = 1e-14  # of the time: a step that does not get lost in its rounding

ONE = np.array([1])
HIT = 2
Mode = tuple[int, ...]  # 0, 1 or, where it is about to be hit, HIT of each contact, and -1, 0 or 1 of each friction


class Stand(NamedTuple):
    """Where a run is: u, v (d,), a (d,) if the scheme has one, what is carried (m, d), None at a start; memory (k,)."""

    t: float
    u: Array
    v: Array
    a: Array | None
    rows: Array | None
    memory: Array


class Steps(NamedTuple):
    """A few steps of one length: a stand after each, and Newton's iterations (n, balances)."""

    stands: tuple[Stand, ...]
    iterations: NDArray[np.int64]


@dataclass
class Reacting:
    """A scene with reactions and a scheme on it; accuracy: asked for, of the scene's length.

    middle: a time between the break points of the load between which the run is. speed, rate: the largest velocity so
    far, and the largest that something slides with.
    """

    scene: Scene
    scheme: Scheme
    accuracy: float
    speed: float
    middle: float = 0.0
    rate: float = 0.0

    def moment(self, t: float) -> float:
        """Length of the step that passes over an event at the time t, s."""
        least = SHORTEST[bool(self.scene.info.multipliers)]
        return max(max(SHORT * self.accuracy, least) * self.scene.length / self.speed, LATE * abs(t))

    @property
    def least(self) -> float:
        """Length of a step, s, below which velocities are rounding, where displacements are held; 0 where none are."""
        return SHORTEST[1] * self.scene.length / self.speed if self.scene.info.multipliers else 0.0

    @cached_property
    def reacts(self) -> slice:
        """The places of contacts and frictions among reactions."""
        info = self.scene.info
        return slice(len(info.multipliers), len(info.reactions))

    def steps(self, at: Stand, h: float, n: int, mode: Mode = ()) -> Steps | str:
        """n steps of h from a stand, each held to what is closed in a mode; or why one could not be made: a status."""
        stands, iterations, origin = list[Stand](), list[Any](), at.t
        for k in range(n):
            start = at.u, at.v, at.u if at.a is None else at.a
            lanes = march_lanes(
                self.loaded, self.scheme, np.array([h]), ONE, start=start, memory=at.memory,
                begin=Begin(0, at.t, None if at.rows is None else at.rows[None]), history=True, counts=True,
            )  # fmt: skip
            if lanes.status[0]:
                return "newton_failed" if lanes.status[0] == 1 else "non_finite"
            u, v, *a = lanes.out[0, -1]
            reached = Stand(origin + (k + 1) * h, u, v, a[0] if a else None, lanes.state[0], lanes.memory[0, -1])
            at = self.held(reached, mode)
            stands.append(at)
            iterations.append(lanes.iterations[0, 0])
        return Steps(tuple(stands), np.array(iterations))

    @property
    def loaded(self) -> Scene:
        """The scene, with its load as it is on this side of where it jumps."""
        load = self.scene.load
        return replace(self.scene, load=Sided(load, self.middle)) if load is not None and is_known(load) else self.scene

    def mode(self, at: Stand) -> Mode | None:
        """What acts ahead of a stand; None where a short step cannot be made."""
        if self.reacts.start == self.reacts.stop:
            return ()
        made = self.steps(at, self.moment(at.t), 1)
        if isinstance(made, str):
            return None
        found, d = self.modes(made, BEGINS)[0], len(self.scene.info.contacts)
        _, rates, across = self._drift((at,))
        hit = rates[0] > max(STICKS, SHORT * self.accuracy) * across[0] * self.speed
        return (*(x * (HIT if y else 1) for x, y in zip(found[:d], hit.tolist(), strict=False)), *found[d:])

    def modes(self, made: Steps, rounding: float = STICKS) -> list[Mode]:
        """What has acted in each of some steps; what slides without a force, as where it touches nothing, does not."""
        d, laws = len(self.scene.info.contacts), self.scene.info.laws
        forces = np.array([x.memory[laws:][self.reacts] for x in made.stands])
        closed = forces[:, :d] > 0.0
        _, rates, across = self._drift(made.stands)
        rates, across = rates[:, d:], across[:, d:]
        self.rate = max(self.rate, float(np.abs(rates).max(initial=0.0)))
        least = rounding * np.maximum(across * self.speed, self.rate)
        slides = np.sign(rates) * ((np.abs(rates) > least) & (forces[:, d:] != 0.0))
        return [(*x, *y) for x, y in zip(closed.astype(int).tolist(), slides.astype(int).tolist(), strict=True)]

    def keeps(self, made: Steps, mode: Mode) -> bool:
        """Whether nothing has changed in some steps: neither what acts, nor has a motion gone into a stop."""
        if self.reacts.start == self.reacts.stop:
            return True
        d = len(self.scene.info.contacts)
        inside, _, across = self._drift(made.stands)
        free = np.array(mode[:d]) == 0
        beyond = inside[:, :d] > INSIDE * self.accuracy * self.scene.length * across[:, :d]
        return not (beyond & free).any() and all(x == mode for x in self.modes(made))

    def changes(self, at: Stand, h: float, mode: Mode) -> bool:
        """Whether the mode is another one by the end of two steps that are h together."""
        made = self.steps(at, 0.5 * h, 2, mode)
        return isinstance(made, str) or not self.keeps(made, mode) or self.mode(made.stands[-1]) != mode

    def held(self, at: Stand, mode: Mode) -> Stand:
        """The stand with closed gaps, and their rates, moved to where they are held, by as little as possible.

        Steps hold the rates of gaps, which are then of the scheme's error, and what rounding opens would fall.
        """
        c, closed = self.reacts.start, np.flatnonzero(np.array(mode[: len(self.scene.info.contacts)]) == 1)
        if not closed.size:
            return at
        t, u, v = np.array([at.t]), at.u[None], at.v[None]
        inside, rates, _ = (x[0] for x in self.scene.drift(t, u, v))
        G, by = self.scene.directions(t, u)[0], c + closed
        wanted = np.zeros((c + len(by), 2))
        wanted[c:, 0] = HELD * self.scene.length * np.linalg.norm(G[by], axis=1) - inside[by]
        wanted[c:, 1] = -rates[by]
        changes = np.asarray(np.linalg.pinv(G[[*range(c), *by.tolist()]]) @ wanted, dtype=np.float64)
        assert at.rows is not None
        rows = at.rows.copy()
        for k, (kind, _) in enumerate(self.scheme.history):
            if kind < 2:
                rows[k] += changes[:, kind]
        return at._replace(u=at.u + changes[:, 0], v=at.v + changes[:, 1], rows=rows)

    def happened(self, t: float, before: Mode, within: Mode, after: Mode) -> Iterator[Happening]:
        """What an event at t was, by the modes before, in the step that passed over it, and after it."""
        info = self.scene.info
        for name, x, y, z in zip((*info.contacts, *info.frictions), before, within, after, strict=True):
            if name in info.contacts:
                said = {(0, 1): "closes", (1, 0): "opens"}.get((x % HIT, z % HIT), "hits" if y and x != 1 else "")
            else:
                said = "" if x == z else "sticks" if z == 0 else "slides" if x == 0 else "turns"
            if said:
                yield Happening(float(t), name, said)

    def _drift(self, stands: Sequence[Stand]) -> tuple[Array, Array, Array]:
        """Of each contact and friction at each stand: minus the gap, or what slides; its rate; how steep it is."""
        t, u, v = (np.array([x[k] for x in stands]) for k in range(3))
        x, rate, _ = self.scene.drift(t, u, v)
        across = np.linalg.norm(self.scene.directions(t, u), axis=-1)
        return x[:, self.reacts], rate[:, self.reacts], across[:, self.reacts]


@dataclass(frozen=True)
class Sided:
    """A load of substep's own as it is around a time `middle`, on both sides of which it may jump."""

    load: Any
    middle: float

    def __call__(self, t: Any) -> Array:
        """The load at times t."""
        load, times = one_sided(self.load), np.asarray(t, dtype=float)
        return np.array([load(x, self.middle) for x in times.ravel()]).reshape(times.shape)
