"""Steps of a structure that are chosen from the estimated local error, by the controller of the scenes' kernels."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ...core.arrays import Array
from ...core.response import Status
from ...core.state import State
from ...run.clock import Control
from ..solvers.combine import combined
from .local_error import Estimate, Source
from .newton import NewtonFailed
from .scheme_plan import step_of
from .sided_loads import Forces, step_control
from .step_lengths import Lengths, Scales, reach, rms
from .steps import Run, StructureSteps

CHANGE = 40.0  # solves that a factorization takes: 20 to 70


@dataclass(frozen=True, eq=False)
class Taken:
    """An accepted step of length h to the time t: rows u, v and, where the scheme has its own, a, (2 or 3, n).

    half_load: the values (J,) of the loads at the middle of the step; load, next_load: at t, of the side of the step
    and of what follows. counts: iterations of balances.
    """

    t: float
    h: float
    rows: Array
    half_load: Array
    load: Array
    next_load: Array
    counts: list[int]


class ChosenSteps:
    """A march in steps of chosen length: `steps` makes them; t: how far it is, s; status: how it ended."""

    def __init__(self, run: Run, asked: Control, shares: tuple[float, float]) -> None:
        """shares: of the largest u and v so far in their scales.

        Raises ValueError for a scheme without an estimate of its error, and for degrees of freedom without mass.
        """
        s, scheme, t_end = run.structure, run.scheme, asked.t_end
        self.here: Array = run.given
        if len(s.massless):
            raise ValueError(
                f"expected mass at each degree of freedom where steps are chosen, got none at "
                f"{s.named(int(s.massless[0]))}; condense such degrees of freedom, or give dt"
            )
        self.run, self.asked, self.t_end = run, asked, t_end
        self.estimate = Estimate(
            scheme.local_error(s.C is not None or (s.internal is not None and s.internal.reads > 1))
        )
        self.power = 0.5 / (self.estimate.error.order + 1)
        self.forces, self.lengths = Forces(s, asked.t_begin, t_end), Lengths(run)
        changing = [
            x for x in step_of(scheme, t_end).systems
            if x.linear_stiffness[x.place] != 0.0 or (s.C is not None and x.damping[x.place] != 0.0)
        ]  # fmt: skip
        self.rung = asked.rung if asked.rung is not None else math.sqrt(2.0) if changing else 0.0
        self.change = CHANGE / max(len(changing), 1)  # in steps
        self.length = reach(s, t_end, *self.here[:2])
        self.scales = Scales(asked.rtol, (asked.atol_u, asked.atol_v), shares, [self.length, rms(self.here[1])])
        self.status: Status = "completed"
        self.t: float = asked.t_begin
        self.proposed: float = math.nan
        self.accepted: int = 0
        self.rejected: int = 0
        self.failed: int = 0
        self.lag, self.kinds = self.estimate.error.lag, [kind for kind, _ in scheme.history]
        self.carries = self.lag is not None or bool(self.estimate.names("start"))  # the motion's own a at the start
        self.state: Array = self.here[self.kinds]
        self.known: dict[Source, Array] = {}

    @property
    def stands(self) -> State:
        """What a later march goes on from."""
        u, v, *a = (self.run.structure.T @ x for x in self.here[: len(step_of(self.run.scheme, 1.0).report)])
        return State(self.t, u, v, a[0] if a else None, dt_next=self.proposed)

    def steps(self) -> Iterator[Taken]:
        """The accepted steps. Raises ValueError for a singular effective matrix."""
        asked, control = self.asked, step_control()
        targets: list[float] = self.forces.targets.tolist()
        at: int = 0
        middle: float = 0.5 * (self.t + targets[0])
        if self.carries:
            self.known["start", "a"] = self.forces.acceleration(self.t, middle, *self.here[:2])
        first = self.first(middle)
        base: float = asked.dt_first or first
        held: float = base
        proposed: float = base
        self.proposed = base
        before, last, made = -1.0, math.nan, math.nan
        low: float = control._kept_from(self.rung, self.power)
        while self.t < self.t_end:
            if proposed != held:
                if self.rung > 1.0:
                    proposed = control._on_ladder(
                        proposed, held, base, self.rung, self.t_end - self.t, asked.dt_min, self.change
                    )
                held = proposed
            if not proposed >= asked.dt_min or proposed <= 1e-15 * self.t:
                self.proposed, self.status = proposed, "step_too_small"
                return
            h, landing = control._reaching(min(proposed, asked.dt_max), targets[at] - self.t)
            end: float = targets[at] if landing else self.t + h
            march = self.lengths.of(h)
            made = self._adapted(h, made)
            try:
                X, rows, size = self._tried(march, end, middle, last)
            except NewtonFailed:
                self.failed, self.rejected = self.failed + 1, self.rejected + 1
                proposed, before = 0.25 * h, -1.0
                continue
            if not size <= 1.0:
                self.rejected += 1
                proposed, before = control._shorter(h, size, self.power), -1.0
                continue
            self.accepted += 1
            self.scales.saw(rows)
            taken = self._taken(march, X, rows, end, middle, h)
            measured = not any(self.estimate.by_before) or not math.isnan(last)
            proposed = float(control._next(h, proposed, size, before, last, low, self.rung, self.power, measured))
            before, last, made = size, h, h
            if landing and at + 1 < len(targets):
                at, middle = at + 1, 0.5 * (targets[at] + targets[at + 1])
                taken = self._crossed(taken, middle)
                if any(self.estimate.by_before):
                    before, last = -1.0, math.nan
                    if self.estimate.by_before[0]:
                        proposed = min(proposed, self.first(middle))
            self.proposed = proposed
            yield taken

    def first(self, middle: float) -> float:
        """Length of a step of which nothing is known before it, from the motion's first derivatives."""
        control, scales, (u, v, own) = step_control(), self.scales, self.here
        a = self.forces.acceleration(self.t, middle, u, v)
        brief = np.array([[rms(u)], [rms(v)], [rms(own)]])
        scales.largest[1] = max(scales.largest[1], float(control._fastest(brief, np.array([rms(a)]), self.length)))
        of_u, of_v = scales.of(0, u, u), scales.of(1, v, v)
        trial, d1 = control._trial(self.here, a, of_u, of_v, self.t_end)
        then = self.forces.acceleration(self.t + trial, middle, u + trial * v, v + trial * a)
        if scales.largest[1] == 0.0:  # complete rest: only the load tells how fast the motion will be
            scales.largest[1] = math.sqrt(self.length * rms(then))
            of_v = scales.of(1, v, v)
        return float(control._first_length(trial * a, then - a, of_u, of_v, trial, d1, self.power, self.t_end))

    def _adapted(self, h: float, made: float) -> float:
        """Bring an acceleration that depends on the length of its step from that to this one; the length it is of."""
        if self.lag is None or h == made or math.isnan(made):
            return made
        a, own = self.kinds.index(2), self.known["start", "a"]
        self.state[a] = own + (h / made) ** self.lag * (self.state[a] - own)
        return h

    def _tried(self, march: StructureSteps, end: float, middle: float, last: float) -> tuple[Array, Array, float]:
        """X (V, n), u, v and a reported, and the mean of the squares of the errors over their scales."""
        X = march.run.room(march.steps)
        march.begin(X, self.state)
        self.forces.completed(march, X, self.t, middle)
        rows = combined(march.steps.report, X)
        kinds = self.estimate.kinds(math.isnan(last))
        if "a" in self.estimate.names("end", kinds):
            self.known["end", "a"] = self.forces.acceleration(end, middle, *rows[:2])
        if names := self.estimate.names("halved"):
            halves = self._halved(0.5 * march.run.h, middle)
            self.known |= {("halved", name): halves["uv".index(name)] for name in names}
        sizes = {}
        for kind in kinds:
            error, of = self.estimate.of(kind, march, X, last / march.run.h, self.known), min(kind, 1)
            sizes[kind] = rms(error / self.scales.of(of, self.here[of], rows[of])) ** 2
        late = sizes.pop(2, 0.0)
        size = sum(sizes.values()) / len(sizes) if sizes else 0.0
        size = size if late <= 1.0 else late  # where it is not too large, lengths do not depend on it
        return X, rows, size if math.isfinite(float(X[-1].sum())) else math.nan

    def _halved(self, h: float, middle: float) -> Array:
        """u and v after two steps of h."""
        march = self.lengths.of(h)
        X = march.run.room(march.steps)
        march.begin(X, self.state)
        self.forces.completed(march, X, self.t, middle)
        march.begin(X, combined(march.steps.out, X))
        self.forces.completed(march, X, self.t + h, middle)
        return combined(march.steps.report[:2], X)

    def _taken(self, march: StructureSteps, X: Array, rows: Array, end: float, middle: float, h: float) -> Taken:
        """Go on from the end of a step."""
        march.look(X, [self.t + system.instant * h for system in march.steps.systems])
        if self.carries:
            own = self.known.pop(("end", "a"), None)
            self.known["start", "a"] = self.forces.acceleration(end, middle, *rows[:2]) if own is None else own
        for name in self.estimate.names("before"):
            self.known["before", name] = combined(march.steps.rows[name][None], X)[0]
        self.state = combined(march.steps.out, X)
        self.here = rows if len(rows) == 3 else np.vstack([rows, np.zeros_like(rows[:1])])
        self.t = end
        half, load = (self.forces.factors(t, middle) for t in (end - 0.5 * h, end))
        return Taken(end, h, rows, half, load, load, march.counts)

    def _crossed(self, taken: Taken, middle: float) -> Taken:
        """Go on behind a break point: where the load jumps, the acceleration jumps with it, by M^-1 of it."""
        new = self.forces.factors(taken.t, middle)
        jump = combined((new - taken.load)[None], self.run.structure.load_vectors.T)[0]
        if not jump.any():
            return taken
        change = self.run.structure.solve_mass(jump)
        if 2 in self.kinds:
            self.state[self.kinds.index(2)] += change
        if self.carries:
            self.known["start", "a"] = self.known["start", "a"] + change
        self.here[2] += change
        return replace(taken, rows=self.here[: len(taken.rows)].copy(), next_load=new)
