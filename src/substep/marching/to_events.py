"""March with constraints, contacts or friction in chosen steps, which end where what acts changes.

The error of a step is what it differs by from two steps of half the length, which are those that count: an estimate
from accelerations would not say that of reactions. Where the mode of reactions is another one by the end of a step,
bisection finds where it changes. The run is brought there, and a short step passes over the event: an impact, a contact
that opens, a body that begins to slide, stops, or turns.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Array
from ..core.kernel_modules import loaded
from ..core.loads import ROUNDING
from ..core.outcome import Happening, Statistics, Status
from ..core.schemes import Scheme
from ..run.clock import Control
from .events import BEGINS, HIT, Mode, Reacting, Stand, Steps

R = TypeVar("R", bound=Reacting)
FIRST = 0.01  # of the time in which the motion goes its length: the first step


def require_changing(what: str, scheme: Scheme, asked: Control, *, carries: bool, later: bool) -> None:
    """Raises ValueError for a scheme whose step cannot change, and for a rung; what: the scene, or a structure.

    carries: whether the scheme carries more than u, v, a at t_n; later: whether it holds displacements of the next
    step.
    """
    if asked.rung:
        raise ValueError(
            f"expected no rung on {what}, whose steps end at events and are of any length, got {asked.rung:g}; "
            "leave it out"
        )
    if carries or scheme.starter is not None:
        raise ValueError(
            f"expected a scheme whose state is u, v, a at t_n alone where steps change, got {scheme.name}, which "
            f"carries {', '.join(scheme.state)}; give dt, or take a one-step or composite scheme"
        )
    if later:
        raise ValueError(
            f"expected a scheme that holds constraints at the displacements of its own step where steps change, got "
            f"{scheme.name}, which holds those of the next; give dt, or take an implicit scheme"
        )


def needs_restitution(what: str, contact: str, declare: str) -> ValueError:
    """The error of a contact without a restitution; declare: what to declare."""
    return ValueError(
        f"expected a restitution of contact '{contact}' of {what} where steps end at impacts, which does not depend "
        f"on the phase of an impact in its step; {declare}, or give dt"
    )


@dataclass
class ToEvents(ABC, Generic[R]):
    """A run in such steps. reacting: where it is made; at: where it is; breaks: times at which loads jump or bend.

    wanted: length of the next step; pressed: reactions of the step before and its length, where they have gone on
    since; passed: how many steps in a row have passed over events; before, last: size of the error of the step before,
    negative for none, and its length; iterations, lengths: of the steps that count.
    """

    reacting: R
    asked: Control
    at: Stand
    breaks: frozenset[float]
    status: Status = "completed"
    rejected: int = 0
    failed: int = 0
    passed: int = 0
    pressed: tuple[Array, float] | None = None
    before: float = -1.0
    last: float = math.nan
    iterations: list[NDArray[np.int64]] = field(default_factory=list[NDArray[np.int64]])
    happenings: list[Happening] = field(default_factory=list[Happening])
    lengths: list[float] = field(default_factory=list[float])

    def __post_init__(self) -> None:
        asked, reacting, t = self.asked, self.reacting, self.at.t
        first = asked.dt_first or min(FIRST * reacting.length / reacting.speed, 0.1 * (asked.t_end - t))
        self.wanted = min(max(first, asked.dt_min), asked.dt_max)
        order = reacting.scheme.order
        self.power = 0.5 / (min(order[:2] if order else (1,)) + 1)
        grid = np.empty(0) if asked.grid is None else asked.grid
        ahead = np.union1d([*self.breaks, asked.t_end], grid)
        self.targets: list[float] = ahead[ahead > t * (1.0 + ROUNDING)].tolist()
        self._look()
        self.mode: Mode | None = reacting.mode(self.at)

    @abstractmethod
    def scales(self, end: Stand) -> Array:
        """What errors of u and v (2, d) at the end of a step may be."""

    def beyond(self, made: Steps) -> bool:
        """Whether the energy is beyond a bound in some steps."""
        del made
        return False

    @cached_property
    def control(self) -> Any:
        """How lengths follow from errors: as of other chosen steps."""
        return loaded("shared.step_control")

    def march(self) -> Iterator[Steps]:
        """The steps that count, up to the end, or to one that cannot be made."""
        asked = self.asked
        while self.at.t < asked.t_end and self.status == "completed":
            least = max(asked.dt_min, self.reacting.least, 1.1e-15 * abs(self.at.t))
            if self.mode is None or not self.wanted >= least:
                self.status = "step_too_small"
            else:
                longest, left = min(self.wanted, asked.dt_max), self.targets[0] - self.at.t
                yield from self._step(self.mode, *self.control._reaching(longest, left))

    def _step(self, mode: Mode, h: float, landing: bool) -> Iterator[Steps]:
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
            yield from self._accepted(made, mode, landing=landing)
            if self.status != "completed":
                return
            low = self.control._kept_from(0.0, self.power)
            wanted = self.control._next(h, self.wanted, size, self.before, self.last, low, 0.0, self.power, True)
            self.wanted, self.before, self.last, self.passed = wanted, size, h, 0
            self.pressed = self.reacting.pressing(made.stands)[-1], 0.5 * h
        if event:
            yield from self._pass(mode)
        elif landing:
            self.mode = self.reacting.mode(self.at)  # another one where the load jumps
            if self.mode is not None:
                within = tuple(x % HIT for x in self.mode)
                self.happenings += self.reacting.happened(self.at.t, mode, within, self.mode)

    def _until(self, h: float, mode: Mode) -> float:
        """How long the mode stays, of a step of h in which it changes; 0 if not at all."""
        low, high, short = 0.0, h, self.reacting.moment(self.at.t)
        while high - low > short and low < (middle := 0.5 * (low + high)) < high:
            if self.reacting.changes(self.at, middle, mode):
                high = middle
            else:
                low = middle
        return low

    def _pass(self, before: Mode) -> Iterator[Steps]:
        """Make a short step over an event, and a longer one where the one before has been over an event too."""
        left, short = self.targets[0] - self.at.t, self.reacting.moment(self.at.t)
        h = min(short * 2.0**self.passed, max(short, self.wanted), left)
        made = self.reacting.steps(self.at, h, 1)
        if isinstance(made, str):
            self.status = "step_too_small"
            return
        (within,) = self.reacting.modes(made, BEGINS)
        self.mode = after = self.reacting.mode(made.stands[-1])
        yield from self._accepted(made, after or within, landing=h == left)
        if self.status == "completed":
            self.passed, self.before, self.pressed = self.passed + 1, -1.0, None
            self.happenings += self.reacting.happened(self.at.t, before, within, after or within)

    def _reject(self, wanted: float) -> None:
        self.rejected, self.wanted, self.before = self.rejected + 2, wanted, -1.0

    def _size(self, whole: Steps | str, made: Steps | str) -> float:
        """The mean of the squares of the errors over their scales, of u and v at the end of two steps.

        Or that of the velocity which the errors of reactions would give, if it is larger: what is held has no other,
        and what lets go of it would be passed over. Reactions are off by what one step and two differ by, or by what
        the second of these differs from a straight line through those before, of which a third is in the velocity as by
        the trapezoidal rule: where a motion is prescribed, their means are exact in steps of any length.
        """
        if isinstance(whole, str) or isinstance(made, str):
            return math.inf
        one, end = whole.stands[-1], made.stands[-1]
        scales = self.scales(end)
        size = float(np.mean(np.square(np.array([end.u - one.u, end.v - one.v]) / scales)))
        if self.reacting.contacts or self.reacting.frictions:
            h, (first, second) = end.t - self.at.t, self.reacting.pressing(made.stands)
            before, length = self.pressed or (first, 0.5 * h)
            bent = (second - first - (first - before) * h / (0.5 * h + length)) / 3.0
            for off in (0.5 * (first + second) - self.reacting.pressing(whole.stands)[0], bent):
                by_reactions: Array = h * self.reacting.pushed(end, off) / scales[1]
                size = max(size, float(np.mean(np.square(by_reactions))))
        return size

    def _accepted(self, made: Steps, mode: Mode, *, landing: bool) -> Iterator[Steps]:
        """Some steps, from the end of which the run goes on, unless the energy is beyond the bound."""
        if self.beyond(made):
            self.status = "energy_bound"
            return
        *within, end = made.stands
        end = self.reacting.held(end._replace(t=self.targets[0]) if landing else end, mode)
        self.lengths += np.diff([self.at.t, *(x.t for x in within), end.t]).tolist()
        self.iterations += list(made.iterations)
        fastest = max(float(np.abs(x.v).max()) for x in made.stands)
        self.reacting.speed = max(self.reacting.speed, fastest)
        self.at = end
        yield made._replace(stands=(*within, end))
        if landing:
            self._cross(self.targets.pop(0))

    def _look(self) -> None:
        """Take the load as it is up to the next of its break points."""
        ahead = min((x for x in self.breaks if x > self.at.t), default=self.asked.t_end)
        self.reacting.middle = 0.5 * (self.at.t + ahead)

    def _cross(self, t: float) -> None:
        """Go on behind a break point of the load: where it jumps, the acceleration that is carried jumps with it."""
        if t not in self.breaks:
            return
        self.pressed = None
        old = self.reacting.acceleration(self.at)
        self._look()
        new = self.reacting.acceleration(self.at)
        assert self.at.rows is not None
        rows = self.at.rows + np.array([[kind == 2] for kind, _ in self.reacting.scheme.history]) * (new - old)
        self.at = self.at._replace(rows=rows)

    @property
    def statistics(self) -> tuple[NDArray[np.int64], Statistics]:
        """The iterations (n, balances) of the steps that count, and what they have cost."""
        made = np.array(self.iterations).reshape(len(self.iterations), self.reacting.scheme.balances)
        return made, Statistics(
            len(made), self.rejected, self.failed, tuple(made.sum(axis=0).tolist()),
            tuple(made.max(axis=0, initial=0).tolist()), min(self.lengths, default=math.nan),
            max(self.lengths, default=math.nan),
        )  # fmt: skip
