"""March a scene with constraints, contacts or friction in chosen steps, which end where what acts changes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Array
from ..core.constraints import corrections
from ..core.loads import break_points, is_known, one_sided
from ..core.response import Response
from ..core.scenes import Scene
from ..core.schemes import Scheme
from ..core.state import State
from ..run.clock import Begin, Control
from .events import Mode, Reacting, Stand, Steps
from .scene_lanes import march_lanes, memory_of, pair_kernels
from .to_events import ToEvents, needs_restitution, require_changing

ONE = np.array([1])


def march_to_events(
    scene: Scene, scheme: Scheme, asked: Control, start: tuple[Array, Array, Array], state: State | None, bound: float
) -> Response:
    """One run from u, v, a at the start; state: where it goes on from; bound: energy in J before which it stops.

    Raises ValueError as `require_events`.
    """
    require_events(scene, scheme, asked)
    at = Stand(asked.t_begin, *start, None, scene.memory0 if state is None else memory_of(scene, state))
    breaks = np.empty(0) if scene.load is None else break_points(scene.load, asked.t_end)
    run = _Run(OfScene.of(scene, scheme, asked, at), asked, at, frozenset(breaks.tolist()), bound=bound)
    for made in run.march():
        run.store(made.stands)
    return run.response(state)


def require_events(scene: Scene, scheme: Scheme, asked: Control) -> None:
    """Raises ValueError as `require_changing`, and for contacts without a restitution."""
    module = pair_kernels(scene, scheme)
    carries = any(lag for _, lag in module.STATE) or bool(module.START_ARGUMENTS)
    require_changing(scene.name, scheme, asked, carries=carries, later=hasattr(module, "held_first"))
    if held := scene.info.held_gaps:
        raise needs_restitution(scene.name, held[0], "declare Contact(gap, restitution=0)")


@dataclass(kw_only=True)
class OfScene(Reacting):
    """See `Reacting`."""

    scene: Scene

    @classmethod
    def of(cls, scene: Scene, scheme: Scheme, asked: Control, at: Stand) -> "OfScene":
        """Of a run that begins at a stand."""
        info, length, t_end = scene.info, scene.length, asked.t_end
        assert at.a is not None
        speed = max(float(np.abs(at.v).max()), math.sqrt(length * float(np.abs(at.a).max()))) or length / (t_end - at.t)
        accuracy, held = max(asked.rtol, asked.atol_u / length), bool(info.multipliers)
        return cls(scheme, accuracy, speed, info.contacts, info.frictions, held, length, scene=scene)

    def steps(self, at: Stand, h: float, n: int, mode: Mode = ()) -> Steps | str:
        """See `Reacting.steps`."""
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

    @property
    def reacts(self) -> slice:
        """The places of contacts and frictions among reactions."""
        info = self.scene.info
        return slice(len(info.multipliers), len(info.reactions))

    def pressing(self, stands: Sequence[Stand]) -> Array:
        """See `Reacting.pressing`."""
        return np.array([x.memory[self.scene.info.laws :][self.reacts] for x in stands])

    def drift(self, stands: Sequence[Stand]) -> tuple[Array, Array, Array]:
        """See `Reacting.drift`."""
        t, u, v = (np.array([x[k] for x in stands]) for k in range(3))
        x, rate, _ = self.scene.drift(t, u, v)
        across = np.linalg.norm(self.scene.directions(t, u), axis=-1)
        return x[:, self.reacts], rate[:, self.reacts], across[:, self.reacts]

    def acceleration(self, at: Stand) -> Array:
        """See `Reacting.acceleration`."""
        return self.loaded.acceleration(np.array([at.t]), at.u[None], at.v[None], at.memory[None])[0]

    def pushed(self, at: Stand, reactions: Array) -> Array:
        """See `Reacting.pushed`."""
        t, u, v = np.array([at.t]), at.u[None], at.v[None]
        n, G = len(at.u), self.scene.directions(t, at.u[None])[0][self.reacts]
        M = self.scene.constrained(t, u, v)[0][:n, :n]
        return np.asarray(np.linalg.pinv(M) @ (G.T @ reactions), dtype=np.float64)

    def changes_to(self, at: Stand, closed: NDArray[np.intp], wanted: Array) -> Array:
        """See `Reacting.changes_to`; constraints stay as they are."""
        c = self.reacts.start
        G = self.scene.directions(np.array([at.t]), at.u[None])[0][[*range(c), *(c + closed).tolist()]]
        return np.asarray(np.linalg.pinv(G) @ np.concatenate([np.zeros((c, 2)), wanted]), dtype=np.float64)

    def onto_constraints(self, at: Stand) -> Array:
        """See `Reacting.onto_constraints`."""
        return corrections(self.scene, at.t, at.u, at.v)[:, 1]


@dataclass(frozen=True)
class Sided:
    """A load of substep's own as it is around a time `middle`, on both sides of which it may jump."""

    load: Any
    middle: float

    def __call__(self, t: Any) -> Array:
        """The load at times t."""
        load, times = one_sided(self.load), np.asarray(t, dtype=float)
        return np.array([load(x, self.middle) for x in times.ravel()]).reshape(times.shape)


@dataclass
class _Run(ToEvents[OfScene]):
    """bound: energy in J before which it stops; stands: what is kept of steps."""

    bound: float = math.inf
    stands: list[Stand] = field(default_factory=list[Stand])

    def __post_init__(self) -> None:
        super().__post_init__()
        self.store((self.at,))

    def scales(self, end: Stand) -> Array:
        """See `ToEvents.scales`."""
        asked, fast = self.asked, max(self.reacting.speed, float(np.abs(end.v).max()))
        bases, old = (asked.atol_u, asked.atol_v + asked.share_v * fast), (self.at.u, self.at.v)
        return np.array([
            base + asked.rtol * np.maximum(np.abs(x), np.abs(y))
            for base, x, y in zip(bases, old, (end.u, end.v), strict=True)
        ])  # fmt: skip

    def beyond(self, made: Steps) -> bool:
        """See `ToEvents.beyond`."""
        t, u, v, memory = (np.array([x[k] for x in made.stands]) for k in (0, 1, 2, 5))
        return bool((self.reacting.scene.energy(t, u, v, memory) > self.bound).any())

    def store(self, stands: Sequence[Stand]) -> None:
        """Keep the rows that are wanted."""
        self.stands += [x for x in stands if self.asked.grid is None or x.t in self.asked.grid]

    def response(self, started: State | None) -> Response:
        """What has been kept."""
        t, u, v, memory = (np.array([x[k] for x in self.stands]) for k in (0, 1, 2, 5))
        a = None if any(x.a is None for x in self.stands) else np.array([x.a for x in self.stands])
        scene, at, (made, cost) = self.reacting.scene, self.at, self.statistics
        remembered = dict(zip(scene.info.memory, at.memory.tolist(), strict=True))
        last = partial(State, at.t, at.u, at.v, at.a, dt_next=self.wanted, memory=remembered)
        return Response(
            u, v, made if self.asked.grid is None else made[:0], self.status,
            None if self.status == "completed" else at.t + self.wanted, scene, self.reacting.scheme, math.nan, a, t,
            cost, started=started, last=last, memories=memory, happenings=tuple(self.happenings),
        )  # fmt: skip
