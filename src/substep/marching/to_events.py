"""March a scene with constraints, contacts or friction in chosen steps, which end where what acts changes.

The error of a step is what it differs by from two steps of half the length, which are those that count: an estimate
from accelerations would not say that of reactions. Where the mode of reactions is another one by the end of a step,
bisection finds where it changes. The run is brought there, and a short step passes over the event: an impact, a contact
that opens, a body that begins to slide, stops, or turns.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Array
from ..core.kernel_modules import loaded
from ..core.loads import ROUNDING, break_points
from ..core.response import Happening, Response, Statistics, Status
from ..core.scenes import Scene
from ..core.schemes import Scheme
from ..core.state import State
from ..run.clock import Control
from .events import BEGINS, Mode, Reacting, Stand, Steps
from .scene_lanes import memory_of, pair_kernels

FIRST = 0.01  # of the time in which the motion goes its scene's length: the first step


def require_changing(scene: Scene, scheme: Scheme, asked: Control) -> None:
    """Raises ValueError for a scheme whose step cannot change, for contacts without a restitution, and for a rung."""
    name, module = scheme.name, pair_kernels(scene, scheme)
    if asked.rung:
        raise ValueError(
            f"expected no rung on {scene.name}, whose steps end at events and are of any length, got {asked.rung:g}; "
            "leave it out"
        )
    if any(lag for _, lag in module.STATE) or scheme.starter is not None or module.START_ARGUMENTS:
        raise ValueError(
            f"expected a scheme whose state is u, v, a at t_n alone where steps change, got {name}, which carries "
            f"{', '.join(scheme.state)}; give dt, or take a one-step or composite scheme"
        )
    if hasattr(module, "held_first"):
        raise ValueError(
            f"expected a scheme that holds constraints at the displacements of its own step where steps change, got "
            f"{name}, which holds those of the next; give dt, or take an implicit scheme"
        )
    if held := scene.info.held_gaps:
        raise ValueError(
            f"expected a restitution of contact '{held[0]}' of {scene.name} where steps end at impacts, which does "
            "not depend on the phase of an impact in its step; declare Contact(gap, restitution=0), or give dt"
        )


def march_to_events(
    scene: Scene, scheme: Scheme, asked: Control, start: tuple[Array, Array, Array], state: State | None, bound: float
) -> Response:
    """One run from u, v, a at the start; state: where it goes on from; bound: energy in J before which it stops.

    Raises ValueError as `require_changing`.
    """
    require_changing(scene, scheme, asked)
    memory = scene.memory0 if state is None else memory_of(scene, state)
    run = _Run(scene, scheme, asked, Stand(asked.t_begin, *start, None, memory), bound)
    run.march()
    return run.response(state)


@dataclass
class _Run:
    """at: where it is; wanted: length of the next step; stands, iterations: what is kept of steps; passed: how many
    steps in a row have passed over events; before, last: size of the error of the step before, negative for none, and
    its length.
    """

    scene: Scene
    scheme: Scheme
    asked: Control
    at: Stand
    bound: float
    status: Status = "completed"
    rejected: int = 0
    failed: int = 0
    passed: int = 0
    before: float = -1.0
    last: float = math.nan
    stands: list[Stand] = field(default_factory=list[Stand])
    iterations: list[NDArray[np.int64]] = field(default_factory=list[NDArray[np.int64]])
    happenings: list[Happening] = field(default_factory=list[Happening])
    lengths: list[float] = field(default_factory=list[float])

    def __post_init__(self) -> None:
        asked, length, (t, _, v, a, *_) = self.asked, self.scene.length, self.at
        assert a is not None
        speed = max(float(np.abs(v).max()), math.sqrt(length * float(np.abs(a).max())))
        speed = speed or length / (asked.t_end - t)
        self.reacting = Reacting(self.scene, self.scheme, max(asked.rtol, asked.atol_u / length), speed)
        first = asked.dt_first or min(FIRST * length / speed, 0.1 * (asked.t_end - t))
        self.wanted = min(max(first, asked.dt_min), asked.dt_max)
        self.power = 0.5 / (min(self.scheme.order[:2] if self.scheme.order else (1,)) + 1)
        breaks = np.empty(0) if self.scene.load is None else break_points(self.scene.load, asked.t_end)
        self.breaks = set(breaks.tolist())
        grid = np.empty(0) if asked.grid is None else asked.grid
        ahead = np.union1d(np.append(breaks, asked.t_end), grid)
        self.targets: list[float] = ahead[ahead > t * (1.0 + ROUNDING)].tolist()
        self._look()
        self._store(self.at)
        self.mode: Mode | None = self.reacting.mode(self.at)

    @cached_property
    def control(self) -> Any:
        """How lengths follow from errors: as of other chosen steps."""
        return loaded("shared.step_control")

    def march(self) -> None:
        """Make steps up to the end, or to one that cannot be made."""
        asked = self.asked
        while self.at.t < asked.t_end and self.status == "completed":
            least = max(asked.dt_min, self.reacting.least, 1.1e-15 * abs(self.at.t))
            if self.mode is None or not self.wanted >= least:
                self.status = "step_too_small"
            else:
                longest, left = min(self.wanted, asked.dt_max), self.targets[0] - self.at.t
                self._step(self.mode, *self.control._reaching(longest, left))

    def _step(self, mode: Mode, h: float, landing: bool) -> None:
        """Make a step of h, as two of half of it, or what of it is before an event, and pass over that."""
        made = self.reacting.steps(self.at, 0.5 * h, 2, mode)
        if isinstance(made, str):
            self.failed += made == "newton_failed"
            self._reject(0.25 * h)
            return
        if event := not self.reacting.keeps(made, mode) or self.reacting.mode(made.stands[-1]) != mode:
            h, landing = self._until(h, mode), False
        if h > 0.0:
            made = self.reacting.steps(self.at, 0.5 * h, 2, mode) if event else made
            size = self._size(self.reacting.steps(self.at, h, 1, mode), made)
            if not size <= 1.0:
                self._reject(self.control._shorter(h, size, self.power))
                return
            assert not isinstance(made, str)
            if not self._accept(made, mode, landing=landing):
                return
            low = self.control._kept_from(0.0, self.power)
            wanted = self.control._next(h, self.wanted, size, self.before, self.last, low, 0.0, self.power, True)
            self.wanted, self.before, self.last, self.passed = wanted, size, h, 0
        if event:
            self._pass(mode)
        elif landing:
            self.mode = self.reacting.mode(self.at)  # another one where the load jumps

    def _until(self, h: float, mode: Mode) -> float:
        """How long the mode stays, of a step of h in which it changes; 0 if not at all."""
        low, high, short = 0.0, h, self.reacting.moment(self.at.t)
        while high - low > short and low < (middle := 0.5 * (low + high)) < high:
            if self.reacting.changes(self.at, middle, mode):
                high = middle
            else:
                low = middle
        return low

    def _pass(self, before: Mode) -> None:
        """Make a short step over an event, and a longer one where the one before has been over an event too."""
        left, short = self.targets[0] - self.at.t, self.reacting.moment(self.at.t)
        h = min(short * 2.0**self.passed, max(short, self.wanted), left)
        made = self.reacting.steps(self.at, h, 1)
        if isinstance(made, str):
            self.status = "step_too_small"
            return
        (within,) = self.reacting.modes(made, BEGINS)
        self.mode = after = self.reacting.mode(made.stands[-1])
        if self._accept(made, after or within, landing=h == left):
            self.passed, self.before = self.passed + 1, -1.0
            self.happenings += self.reacting.happened(self.at.t, before, within, after or within)

    def _reject(self, wanted: float) -> None:
        self.rejected, self.wanted, self.before = self.rejected + 2, wanted, -1.0

    def _size(self, whole: Steps | str, made: Steps | str) -> float:
        """The mean of the squares of the errors over their scales, of u and v at the end of two steps."""
        if isinstance(whole, str) or isinstance(made, str):
            return math.inf
        asked, one, end = self.asked, whole.stands[-1], made.stands[-1]
        fast = max(self.reacting.speed, float(np.abs(end.v).max()))
        found = list[Array]()
        for x, old, new, base in (
            (one.u, self.at.u, end.u, asked.atol_u), (one.v, self.at.v, end.v, asked.atol_v + asked.share_v * fast)
        ):  # fmt: skip
            found.append((new - x) / (base + asked.rtol * np.maximum(np.abs(old), np.abs(new))))
        return float(np.mean(np.square(found)))

    def _accept(self, made: Steps, mode: Mode, *, landing: bool) -> bool:
        """Go on from the end of some steps, unless the energy is beyond the bound."""
        t = np.array([x.t for x in made.stands])
        u, v, memory = (np.array([x[k] for x in made.stands]) for k in (1, 2, 5))
        if (self.scene.energy(t, u, v, memory) > self.bound).any():
            self.status = "energy_bound"
            return False
        *within, end = made.stands
        end = self.reacting.held(end._replace(t=self.targets[0]) if landing else end, mode)
        self.lengths += np.diff([self.at.t, *(x.t for x in within), end.t]).tolist()
        self.iterations += list(made.iterations)
        self.reacting.speed = max(self.reacting.speed, float(np.abs(v).max()))
        self.at = end
        for stand in (*within, end):
            self._store(stand)
        if landing:
            self._cross(self.targets.pop(0))
        return True

    def _store(self, at: Stand) -> None:
        if self.asked.grid is None or at.t in self.asked.grid:
            self.stands.append(at)

    def _look(self) -> None:
        """Take the load as it is up to the next of its break points."""
        ahead = min((x for x in self.breaks if x > self.at.t), default=self.asked.t_end)
        self.reacting.middle = 0.5 * (self.at.t + ahead)

    def _cross(self, t: float) -> None:
        """Go on behind a break point of the load: where it jumps, the acceleration that is carried jumps with it."""
        if t not in self.breaks:
            return
        at = np.array([t]), self.at.u[None], self.at.v[None], self.at.memory[None]
        old = self.reacting.loaded.acceleration(*at)[0]
        self._look()
        new = self.reacting.loaded.acceleration(*at)[0]
        assert self.at.rows is not None
        rows = self.at.rows + np.array([[kind == 2] for kind, _ in self.scheme.history]) * (new - old)
        self.at = self.at._replace(rows=rows)

    def response(self, started: State | None) -> Response:
        """What has been kept."""
        t, u, v, memory = (np.array([x[k] for x in self.stands]) for k in (0, 1, 2, 5))
        a = None if any(x.a is None for x in self.stands) else np.array([x.a for x in self.stands])
        made = np.array(self.iterations).reshape(len(self.iterations), self.scheme.balances)
        cost = Statistics(
            len(made), self.rejected, self.failed, tuple(made.sum(axis=0).tolist()),
            tuple(made.max(axis=0, initial=0).tolist()), min(self.lengths, default=math.nan),
            max(self.lengths, default=math.nan),
        )  # fmt: skip
        names, at = self.scene.info.memory, self.at
        last = partial(
            State, at.t, at.u, at.v, at.a, dt_next=self.wanted, memory=dict(zip(names, at.memory.tolist(), strict=True))
        )
        return Response(
            u, v, made if self.asked.grid is None else made[:0], self.status,
            None if self.status == "completed" else at.t + self.wanted, self.scene, self.scheme, math.nan, a, t, cost,
            started=started, last=last, memories=memory, happenings=tuple(self.happenings),
        )  # fmt: skip
