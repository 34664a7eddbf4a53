"""Steps of a structure that are chosen from the estimated local error, by the controller of the scenes' kernels."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from ...core.arrays import Array
from ...core.kernel_modules import loaded
from ...core.outcome import Status
from ...core.state import State
from ...run.clock import Control
from ..model.memory import RememberingForce
from ..solvers.combine import combined
from .fork import gone_on_from
from .local_error import Estimate, Source
from .scheme_plan import step_of
from .sided_loads import Forces
from .step_lengths import Lengths, Scales, reach, rms
from .steps import Run
from .time_loop import Trial
from .within_step import seen_within

CHANGE = 40.0  # solves that a factorization takes: 20 to 70
PARTS = 1000  # of the span, for the bar


class ChosenSteps:
    """The clock of steps of chosen length, which count where their estimated error is small enough.

    t: how far the march is, s; here (3, n): u, v, a there; dt_next: length of the step that follows, s. energy_loads:
    the values (J,) of the loads in the middle of the last step, at its end, and, after a jump, where the next begins.
    """

    unit, total = "parts", PARTS
    energy_loads: tuple[Array, Array, Array]

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
        self.run, self.asked, self.shares, self.t_end = run, asked, shares, t_end
        self.estimate = Estimate(
            scheme.local_error(s.C is not None or (s.internal is not None and s.internal.reads > 1))
        )
        self.power = 0.5 / (self.estimate.error.order + 1)
        self.lengths, gone_on = Lengths(run), gone_on_from(run, asked, shares)
        self.t: float = float(gone_on["numbers"][0]) if gone_on else asked.t_begin
        self.forces = Forces(s, self.t, t_end)
        changing = [
            x for x in step_of(scheme, t_end).systems
            if x.implicit or (s.C is not None and x.damping[x.unknowns].any())
        ]  # fmt: skip
        self.rung = asked.rung if asked.rung is not None else math.sqrt(2.0) if changing else 0.0
        control = loaded("shared.step_control")
        self.low: float = control._kept_from(self.rung, self.power)  # size from which on a step keeps its length
        self.change = CHANGE / max(len(changing), 1)  # in steps
        self.length = reach(s, t_end, *self.here[:2])
        self.scales = Scales(asked.rtol, (asked.atol_u, asked.atol_v), shares, [self.length, rms(self.here[1])])
        self.status: Status = "completed"
        self.done: int = 0
        self.targets: list[float] = self.forces.targets.tolist()  # that are ahead
        self.middle: float = 0.5 * (self.t + self.targets[0])  # of the time until the first of them
        self.rejected: int = 0
        self.newton_failed: int = 0
        self.shortened: int = 0  # corrections of Newton's iteration in all trials
        self.lag, self.kinds = self.estimate.error.lag, [kind for kind, _ in scheme.history]
        self.carries = self.lag is not None or bool(self.estimate.names("start"))  # the motion's own a at the start
        self.state: Array = self.here[self.kinds]
        self.memory = run.memory  # what the internal force remembers there
        self.known: dict[Source, Array] = {}
        self.dt_next: float = math.nan
        self.wanted = self.held = self.base = math.nan  # length of the step to try, of those before, and of the first
        self.before, self.last = -1.0, math.nan  # size of the error of the step before, negative for none; its length
        self.made: float = math.nan  # length of the step that an acceleration in the state is of
        self.seen: float = 0.0  # length of the last step, s, as far as it is after the start
        self.fork = dict[str, Array]()  # where the march was before t_end first changed a step; empty before that
        if gone_on:
            self._resume(gone_on)

    @property
    def stands(self) -> State:
        """What a later march goes on from, but for the fork."""
        s = self.run.structure
        u, v, *a = (s.T @ x for x in self.here[: len(step_of(self.run.scheme, 1.0).report)])
        found = State(self.t, u, v, a[0] if a else None, dt_next=self.dt_next)
        if self.memory is None or not isinstance(s.internal, RememberingForce):
            return found
        return replace(found, memory=s.internal.named(self.memory))

    def trials(self) -> Iterator[Trial]:
        """The steps to compute. Raises ValueError for a singular effective matrix."""
        asked, control = self.asked, loaded("shared.step_control")
        if math.isnan(self.base):
            if self.carries:
                self.known["start", "a"] = self.forces.acceleration(self.t, self.middle, *self.here[:2], self.memory)
            first = self.first()
            self.base = self.held = self.wanted = self.dt_next = asked.dt_first or first
        while self.t < self.t_end:
            wanted, spared = self.wanted, False
            if wanted != self.held and self.rung > 1.0:
                wanted, spared = control._on_ladder(
                    wanted, self.held, self.base, self.rung, self.t_end - self.t, asked.dt_min, self.change
                )
            longest = min(wanted, asked.dt_max)
            h, landing = control._reaching(longest, self.targets[0] - self.t)
            if not self.fork and (spared or (len(self.targets) == 1 and (landing or h < longest))):
                self.fork = self._as_arrays()
            self.wanted = self.held = wanted
            if not wanted >= asked.dt_min or wanted <= 1e-15 * self.t:
                self.dt_next, self.status = wanted, "step_too_small"
                return
            march = self.lengths.of(h)
            self.shortened -= march.shortened  # in steps before
            self._adapt(h)
            X = march.run.room(march.steps)
            march.begin(X, self.state, self.memory)
            end = self.targets[0] if landing else self.t + h
            yield Trial(march, X, *self.forces.over(march, self.t, self.middle), end, h)

    def accepted(self, step: Trial) -> bool:
        """Whether the error is small enough; the length of the next step follows from it."""
        control, h, by_before = loaded("shared.step_control"), step.h, self.estimate.by_before
        self.shortened += step.march.shortened
        rows, size = self._measured(step)
        if not size <= 1.0:
            self.rejected += 1
            self.wanted, self.before = control._shorter(h, size, self.power), -1.0
            return False
        self.scales.saw(rows)
        self._go_on(step, rows)
        measured = not (any(by_before) and math.isnan(self.last))
        self.wanted = float(
            control._next(h, self.wanted, size, self.before, self.last, self.low, self.rung, self.power, measured)
        )
        self.before, self.last, self.made = size, h, h
        if step.t == self.targets[0] and len(self.targets) > 1:
            self._cross()
            if any(by_before):
                self.before, self.last = -1.0, math.nan
            if by_before[0]:
                self.wanted = min(self.wanted, self.first())
        self.dt_next = self.wanted
        return True

    def failed(self, step: Trial) -> None:
        """Try a shorter step."""
        self.newton_failed, self.rejected = self.newton_failed + 1, self.rejected + 1
        self.shortened += step.march.shortened
        self.wanted, self.before = 0.25 * step.h, -1.0

    def first(self) -> float:
        """Length of a step of which nothing is known before it, from the motion's first derivatives."""
        control, scales, (u, v, own) = loaded("shared.step_control"), self.scales, self.here
        a = self.forces.acceleration(self.t, self.middle, u, v, self.memory)
        fastest = max(rms(v), math.sqrt(self.length * max(rms(own), rms(a))))
        scales.largest[1] = max(scales.largest[1], fastest)
        of_u, of_v = scales.of(0, u, u), scales.of(1, v, v)
        d0, d1 = (math.sqrt(float(np.mean((x / of_u) ** 2 + (y / of_v) ** 2))) for x, y in ((u, v), (v, a)))
        trial = control._trial(d0, d1, self.length, fastest)
        then = self.forces.acceleration(self.t + trial, self.middle, u + trial * v, v + trial * a, self.memory)
        if scales.largest[1] == 0.0:  # complete rest: only the load tells how fast the motion will be
            scales.largest[1] = math.sqrt(self.length * rms(then))
            of_v = scales.of(1, v, v)
        d2 = math.sqrt(float(np.mean((trial * a / of_u) ** 2 + ((then - a) / of_v) ** 2))) / trial
        return float(control._first_length(d1, d2, trial, self.power))

    def _adapt(self, h: float) -> None:
        """Bring an acceleration in the state that depends on the length of its step from that to this one."""
        if self.lag is not None and h != self.made and not math.isnan(self.made):
            a, own = self.kinds.index(2), self.known["start", "a"]
            self.state[a] = own + (h / self.made) ** self.lag * (self.state[a] - own)
            self.made = h

    def _measured(self, step: Trial) -> tuple[Array, float]:
        """u, v and a reported, and the mean of the squares of the errors over their scales."""
        march, X = step.march, step.X
        rows = combined(march.steps.report, X)
        kinds = self.estimate.kinds(math.isnan(self.last))
        if "a" in self.estimate.names("end", kinds):
            self.known["end", "a"] = self.forces.acceleration(step.t, self.middle, *rows[:2], march.memory)
        if names := self.estimate.names("halved"):
            halves = self._halved(0.5 * march.run.h)
            self.known |= {("halved", name): halves["uv".index(name)] for name in names}
        sizes = {}
        for kind in kinds:
            error, of = self.estimate.of(kind, march, X, self.last / march.run.h, self.known), min(kind, 1)
            sizes[kind] = rms(error / self.scales.of(of, self.here[of], rows[of])) ** 2
        late = sizes.pop(2, 0.0)
        size = sum(sizes.values()) / len(sizes) if sizes else 0.0
        size = size if late <= 1.0 else late  # where it is not too large, lengths do not depend on it
        if not math.isfinite(float(X[-1].sum())):
            return rows, math.nan
        if self.memory is not None and march.memory is not None:
            ends = self.here[:2], rows[:2], (self.memory, march.memory)
            size = seen_within(self.forces, self.middle, self.t, step.t - self.t, *ends, self.scales, size)
        return rows, size

    def _halved(self, h: float) -> Array:
        """u and v after two steps of h."""
        march = self.lengths.of(h)
        X, state, memory = march.run.room(march.steps), self.state, self.memory
        for t in (self.t, self.t + h):
            march.begin(X, state, memory)
            march.complete(X, *self.forces.over(march, t, self.middle))
            march.commit(X, t + h)
            state, memory = combined(march.steps.out, X), march.memory
        return combined(march.steps.report[:2], X)

    def _go_on(self, step: Trial, rows: Array) -> None:
        """Go on from the end of a step."""
        march, X, t = step.march, step.X, step.t
        march.look(X, step.times)
        self.memory = march.memory
        if self.carries:
            own = self.known.pop(("end", "a"), None)
            at_end = t, self.middle, *rows[:2], self.memory
            self.known["start", "a"] = self.forces.acceleration(*at_end) if own is None else own
        for name in self.estimate.names("before"):
            self.known["before", name] = combined(march.steps.rows[name][None], X)[0]
        self.state = combined(march.steps.out, X)
        self.here = rows if len(rows) == 3 else np.vstack([rows, np.zeros_like(rows[:1])])
        begin = self.asked.t_begin
        self.seen = step.h if self.t >= begin else t - begin
        self.t, self.done = t, max(self.done, int(PARTS * (t - begin) / (self.t_end - begin)))
        half, load = (self.forces.factors(x, self.middle) for x in (t - 0.5 * self.seen, t))
        self.energy_loads = half, load, load

    def _as_arrays(self) -> dict[str, Array]:
        """All that the steps from here on follow from, for `_resume`."""
        numbers = [self.t, self.wanted, self.held, self.base, self.before, self.last, self.made, self.length]
        found = {"numbers": np.array([*numbers, *self.scales.largest]), "here": self.here, "state": self.state}
        found |= {f"{name} {where}": x for (where, name), x in self.known.items() if where in ("start", "before")}
        if self.memory is not None and isinstance(force := self.run.structure.internal, RememberingForce):
            found |= {f"memory {name}": x for name, x in force.named(self.memory).items()}
        return {name: x.copy() for name, x in (found | self.lengths.arrays).items()}

    def _resume(self, fork: Mapping[str, Array]) -> None:
        """Go on from there."""
        numbers = fork["numbers"].tolist()
        _, self.wanted, self.held, self.base, self.before, self.last, self.made, self.length = numbers[:8]
        self.dt_next, self.scales.largest = self.wanted, numbers[8:]
        self.here, self.state = fork["here"].copy(), fork["state"].copy()
        self.known = {
            (where, name): fork[f"{name} {where}"]
            for where in ("start", "before") for name in (*self.estimate.names(where), "a") if f"{name} {where}" in fork
        }  # fmt: skip
        if isinstance(force := self.run.structure.internal, RememberingForce):
            named = {name.removeprefix("memory "): x for name, x in fork.items() if name.startswith("memory ")}
            self.memory = force.remembered(named)
        self.lengths.recall(fork)

    def _cross(self) -> None:
        """Go on behind a break point: where the load jumps, the acceleration jumps with it, by M^-1 of it."""
        self.middle = 0.5 * (self.targets.pop(0) + self.targets[0])
        half, load, _ = self.energy_loads
        new = self.forces.factors(self.t, self.middle)
        jump = combined((new - load)[None], self.run.structure.load_vectors.T)[0]
        if not jump.any():
            return
        self.energy_loads = half, load, new
        change = self.run.structure.solve_mass(jump)
        if 2 in self.kinds:
            self.state[self.kinds.index(2)] += change
        if self.carries:
            self.known["start", "a"] = self.known["start", "a"] + change
        self.here[2] += change
