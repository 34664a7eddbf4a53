"""What is audited: a stepper, which runs one oscillator with one integrator, and what it can do."""

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from substep.core.arrays import Array

from .history import states_before
from .programs.adapter import Integrator, Load, Spring

Run = Callable[..., tuple[Any, ...]]
FINEST = 1e-15  # of a unit start, the largest share that an absolute tolerance may be


class RunFailed(ValueError):
    """That a program raised in a run."""


@dataclass(frozen=True)
class Stepper:
    """An integrator as a black box.

    run(omega, xi, dt, n, u0, v0, load) returns histories u, v, a of u'' + 2 xi omega u' + omega**2 u = load(t), n + 1
    numbers each from t = 0 on, None for one that the program does not return. It takes a0 besides where "a" is in
    `can.sets`, and before, the states u, v, a at t = -dt, -2 dt, ..., where `can.history` says how many.
    load is a function of t; run may ask its `kind`, `amplitude`, `omega` and `phase` to make a load of the program's
    own. Where `can.nonlinear` it may be given force=, a `Spring` N(u) that takes the place of omega**2 u.
    can: see `Integrator`. name, version: of the program and its integrator, for the report.

    written_out: the same with the `can.defaults` of its arguments given as well; None where there are none.

    controlled(omega, xi, tol, t_end, u0, v0), where it chooses its steps by a tolerance, returns times t, u and v
    (m+1,) at the ends of its steps, the start included, and the errors of u and v that it has estimated in each step
    (2, m), or None.
    """

    run: Run
    can: Integrator = field(default_factory=Integrator)
    name: str = "stepper"
    version: str = ""
    arguments: Mapping[str, Any] = field(default_factory=dict[str, Any])
    controlled: Run | None = None
    written_out: Run | None = None

    def histories(
        self,
        omega: float,
        xi: float,
        dt: float,
        n: int,
        u0: float,
        v0: float,
        a0: float | None,
        load: Load,
        force: Spring | None = None,
    ) -> Array:
        """u, v, a (n+1, 3) at the ends of the scheme's steps dt, each of `can.calls` runs of the program; NaN for none.

        What is late by whole steps is moved to the ends that it stands at, of a run that is as much longer; what is
        late by less is left out. What u0 and v0 the program cannot be given is superposed: from the rest of them it
        moves as this motion less u0 + v0 t, under the load less the forces of that. All is made larger where its
        tolerance is absolute.
        Raises RunFailed for a run that raises, ValueError for histories of another length.
        """
        can, h, steps = self.can, dt / self.can.calls, n * self.can.calls
        late = [float(can.late.get(kind, 0.0) * can.calls) for kind in "uva"]
        longer = steps + max(-int(x) if x.is_integer() else 0 for x in (0.0, *late))
        size = 1.0 if force is not None else 2.0 ** max(0, math.ceil(math.log2(max(can.absolute / FINEST, 1.0))))
        p, q = 0.0 if "u" in can.sets else u0, 0.0 if "v" in can.sets else v0
        start = size * (u0 - p), size * (v0 - q)
        line = -size * (2 * xi * omega * q + omega**2 * p), -size * omega**2 * q
        load = replace(load, amplitude=size * load.amplitude, offset=line[0], slope=line[1], called=load.called)
        given: dict[str, Any] = {"a0": None if a0 is None else size * a0} if "a" in can.sets else {}
        if can.history:
            given["before"] = states_before(omega, xi, h, can.history, *start, load).tolist()
        if force is not None:
            given["force"] = force
        try:
            with np.errstate(all="ignore"):  # an unstable run overflows
                found = self.run(omega, xi, h, longer, *start, load=load, **given)
            nothing = np.full(longer + 1, np.nan)
            histories = [nothing if y is None else np.asarray(y, np.float64).ravel() for y in found]
        except Exception as error:
            raise RunFailed(
                f"expected histories from {self.name} at omega = {omega:g}, xi = {xi:g}, dt = {dt:g}, got "
                f"{type(error).__name__}: {error}; say what it cannot run in its Integrator, or cure the adapter"
            ) from error
        if len(histories) != 3 or any(len(y) != longer + 1 for y in histories):
            lengths = [len(y) for y in histories]
            raise ValueError(
                f"expected u, v and a with {longer + 1} numbers each from {self.name}, the start included, got "
                f"{lengths}"
            )
        returned = [y if kind in can.outputs else nothing for kind, y in zip("uva", histories, strict=True)]
        rows = np.stack([_at_ends(y, by, steps + 1) for y, by in zip(returned, late, strict=True)], axis=-1)
        t = h * np.arange(steps + 1)
        superposed = np.stack([p + q * t, np.full_like(t, q), np.zeros_like(t)], axis=-1)
        return (rows / size + superposed)[:: can.calls]

    def own_steps(
        self, omega: float, tol: float, t_end: float, u0: float, v0: float
    ) -> tuple[Array, Array, Array | None]:
        """Times (m+1,), u and v (m+1, 2), and estimated errors (m, 2) or None, undamped, in steps of its own choice.

        Raises RunFailed for a run that raises, or returns arrays that do not fit each other.
        """
        assert self.controlled is not None
        try:
            t, u, v, errors = self.controlled(omega, 0.0, tol, t_end, u0, v0)
            times, rows = np.asarray(t, np.float64), np.stack([np.asarray(x, np.float64) for x in (u, v)], axis=-1)
            estimates = None if errors is None else np.asarray(errors, np.float64).T
            if rows.shape != (len(times), 2) or (estimates is not None and estimates.shape != (len(times) - 1, 2)):
                raise ValueError(
                    f"{len(times)} times, {len(rows)} rows, {0 if estimates is None else len(estimates)} errors"
                )
            if not (np.diff(times) > 0).all() or not np.isfinite(rows).all():
                raise ValueError("times that do not ascend, or numbers that are not finite")
        except Exception as error:
            raise RunFailed(f"{type(error).__name__}: {error}") from error
        return times, rows, estimates


def _at_ends(history: Array, late: float, n: int) -> Array:
    """The first n numbers at the ends of steps, of a history that stands so many steps after them; NaN for none."""
    if not late.is_integer():
        return np.full(n, np.nan)
    by = int(late)
    return np.concatenate([np.full(max(by, 0), np.nan), history])[max(-by, 0) :][:n]


def as_stepper(given: "Stepper | Run") -> Stepper:
    """A stepper from what `audit` takes: a bare function can set a0 if it has an argument of that name."""
    if isinstance(given, Stepper):
        return given
    if not callable(given):
        raise ValueError(
            "expected a function run(omega, xi, dt, n, u0, v0, load) -> u, v, a, or a Stepper, got "
            f"{type(given).__name__}"
        )
    sets = "uva" if "a0" in inspect.signature(given).parameters else "uv"
    return Stepper(given, Integrator(sets=sets), getattr(given, "__name__", "stepper"))
