"""A scheme's step on many undriven and driven oscillators at once, as matrices, from its plan.

This is what a stepper is compared with: no kernel has to be compiled, and parameters may lie outside the intervals that
a declaration allows, since a program may hold a wrong sign.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Literal

import numpy as np

from substep.core.arrays import Array
from substep.core.loads import Load, values_at
from substep.core.schemes import Scheme
from substep.run.schemes import carried
from substep.structures.march.scheme_plan import Steps, System, start_of, step_of

Damping = Literal["declared", "predicted", "start", "end"]
DAMPED_BY: Mapping[Damping, str] = {  # the velocity of the damping force, where it is not the declared one
    "predicted": "the predicted velocity", "start": "the velocity at t_n", "end": "the velocity at t_n + h"
}  # fmt: skip
Loads = tuple[tuple[tuple[float, float], ...], ...]  # of each system: pairs (weight, instant in steps after t_n)


@dataclass(frozen=True)
class Oscillators:
    """P oscillators u'' + 2 xi omega u' + omega^2 u = f(t) of unit mass, and the step h in s; Omega, xi (P,)."""

    Omega: Array
    xi: Array
    h: float

    @cached_property
    def omega(self) -> Array:
        """Circular frequencies (P,), rad/s."""
        return self.Omega / self.h

    @cached_property
    def weights(self) -> Array:
        """(P, 3): what inertia, damping and stiffness are multiplied by, of unit mass."""
        return np.stack([np.ones_like(self.omega), 2.0 * self.xi * self.omega, self.omega**2], axis=-1)

    @cached_property
    def scale(self) -> Array:
        """(P, 3): what u, h*v, h^2*a are divided by, so that none outweighs the others where Omega is large."""
        large = np.maximum(1.0, self.Omega)
        return np.stack([np.ones_like(large), large, large**2], axis=-1)

    @cached_property
    def powers(self) -> Array:
        """(3,): 1, h, h^2, which turn u, v, a into u, h*v, h^2*a."""
        return self.h ** np.arange(3.0)

    def acceleration(self, u: Array, v: Array, f: Array | float) -> Array:
        """From the equation of motion; the last axis of u and v is that of the oscillators."""
        return f - 2.0 * self.xi * self.omega * v - self.omega**2 * u


@dataclass(frozen=True)
class LinearStep:
    """What a plan computes on P oscillators: out (P, G', G + S) and report (P, R, G + S).

    The columns are the G given vectors and unit loads in each of the S systems; the rows are the new state, and u, v
    and, if the scheme has its own, a at the end of the step. loads: of each system, pairs (weight, instant).
    """

    out: Array
    report: Array
    given: int
    loads: Loads

    @classmethod
    def of(cls, steps: Steps, at: Oscillators) -> "LinearStep":
        """The plan on the oscillators. Raises ZeroDivisionError where a system has no solution."""
        P, count = len(at.Omega), len(steps.systems)
        columns = steps.given + count
        X = np.zeros((P, steps.vectors, columns))
        X[:, : steps.given, : steps.given] = np.eye(steps.given)
        slots = [x for s in steps.systems for x in (s.inertia, s.damping, s.linear_stiffness)]
        rows = at.weights @ np.reshape(slots, (count, 3, steps.vectors))  # (S, P, V)
        for s, system in enumerate(steps.systems):
            row = rows[s]
            right = -(row[:, None, : system.place] @ X[:, : system.place])[:, 0]
            right[:, steps.given + s] += 1.0
            pivot = row[:, system.place, None]
            if not pivot.all():
                raise ZeroDivisionError(f"the effective matrix of system {s} is singular")
            X[:, system.place] = right / pivot
        report = steps.report.reshape(-1, steps.vectors)  # a start reports nothing
        return cls(steps.out @ X, report @ X, steps.given, tuple(system.loads for system in steps.systems))

    def forces(self, load: Load | None, t: Array, h: float) -> Array:
        """The sums of w f(t + tau h) of the systems in the steps that begin at the times t, (len(t), S)."""
        found = np.zeros((len(t), len(self.loads)))
        if load is not None:
            for s, row in enumerate(self.loads):
                for w, tau in row:
                    found[:, s] += w * values_at(load, t + tau * h)
        return found


@dataclass(frozen=True)
class Candidate:
    """A scheme with numbers, on P oscillators.

    loads: how a step takes the load, in place of the scheme's own way; damping: by which velocity it is damped.
    """

    scheme: Scheme
    at: Oscillators
    loads: Loads | None = None
    damping: Damping = "declared"

    @cached_property
    def step(self) -> LinearStep:
        """The matrices of a step."""
        step = LinearStep.of(with_damping(step_of(self.scheme, self.at.h), self.damping), self.at)
        return step if self.loads is None else replace(step, loads=self.loads)

    @cached_property
    def state(self) -> tuple[tuple[int, int], ...]:
        """Of each entry of the state: its kind, 0 for u, 1 for v, 2 for a, and how many steps before t_n it stands."""
        return self.scheme.history

    @property
    def lag(self) -> int:
        """How many steps the state reaches back."""
        return max(steps for _, steps in self.state)

    def undriven(self, rows: Array) -> Array:
        """What each step reports (P, K, R) without a load, from the state that u, v, a (P, n+1, 3) are before it.

        Of the steps that end at 2 + lag, .., n: the first one plays no part, nor does what it starts from.
        """
        n, lag = rows.shape[1] - 1, self.lag
        state = np.stack([rows[:, 1 + lag - steps : n - steps, kind] for kind, steps in self.state], axis=1)
        return np.einsum("prg,pgk->pkr", self.step.report[:, :, : self.step.given], state)

    def histories(self, start: Array, a0: Array | None, n: int, load: Load | None = None) -> Array:
        """u, v, a (P, n+1, 3) from t = 0 on; NaN where the scheme has no acceleration of its own.

        start: u, v (2,) of all; a0: (P,), None for that of the equation of motion.
        """
        P, h = len(self.at.Omega), self.at.h
        f0 = 0.0 if load is None else float(values_at(load, np.zeros(1))[0])
        u, v = (np.full(P, x) for x in start)
        first = np.stack([u, v, self.at.acceleration(u, v, f0) if a0 is None else a0], axis=-1)
        rows = np.full((P, n + 1, 3), np.nan)
        rows[:, 0] = first
        with np.errstate(all="ignore"):
            if self.scheme.starter is not None:
                lag = self.scheme.starting_steps
                past = Candidate(self.scheme.starter, self.at).histories(start, a0, min(lag, n), load)
                if np.isnan(past[..., 2]).any():
                    past[..., 2] = self._accelerations(past, load)
                rows[:, : lag + 1] = past
                if n <= lag:
                    return rows
                state = np.ascontiguousarray(carried(self.state, lag, lambda k, kind: rows[:, k, kind]).T)
                done = lag
            else:
                state, done = self._started(first, load), 0
            both = np.concatenate([self.step.report, self.step.out], axis=1)
            R = self.step.report.shape[1]
            undriven = np.ascontiguousarray(both[:, :, : self.step.given])
            driven = self.step.forces(load, np.arange(done, n) * h, h) @ both[:, :, self.step.given :].swapaxes(1, 2)
            for k in range(done, n):
                after = (undriven @ state[:, :, None])[..., 0] + driven[:, k - done]
                rows[:, k + 1, :R], state = after[:, :R], after[:, R:]
        return rows

    def _accelerations(self, past: Array, load: Load | None) -> Array:
        t = np.arange(past.shape[1]) * self.at.h
        f = np.zeros(len(t)) if load is None else values_at(load, t)
        return np.stack([self.at.acceleration(u, v, x) for u, v, x in zip(*past.T[:2], f, strict=True)], axis=-1)

    def _started(self, first: Array, load: Load | None) -> Array:
        if self.scheme.info.start == "given":
            return first[:, [kind for kind, _ in self.state]]
        start = LinearStep.of(start_of(self.scheme, self.at.h), self.at)
        forces = start.forces(load, np.zeros(1), self.at.h)[0]
        return np.einsum("prg,pg->pr", start.out[..., : start.given], first) + start.out[..., start.given :] @ forces


def with_damping(steps: Steps, damping: Damping) -> Steps:
    """The plan of a scheme of one balance with the damping force of another velocity.

    The predicted velocity is what the declared one is without the acceleration that the balance is solved for.
    """

    def row(system: System) -> Array:
        known = np.arange(steps.vectors) != system.place
        rows = {"predicted": system.damping * known, "start": steps.rows["v_0"], "end": steps.report[1]}
        return rows[damping]

    if damping == "declared":
        return steps
    return replace(steps, systems=tuple(replace(s, damping=row(s)) if s.balance else s for s in steps.systems))


def with_parameters(scheme: Scheme, values: Mapping[str, float]) -> Scheme:
    """The scheme at any values of its parameters, inside their intervals or not."""
    new = {**scheme.parameters, **{name: np.float64(x) for name, x in values.items()}}
    return replace(scheme, parameters=MappingProxyType(new), given=MappingProxyType(dict(new)))
