"""What is audited: a stepper, which runs one oscillator with one integrator, and what it can do."""

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..core.arrays import Array
from .programs.adapter import Integrator, Load, Spring

Run = Callable[..., tuple[Any, ...]]
FINEST = 1e-15  # of a unit start, the largest share that an absolute tolerance may be
RESOLVED = 10.0  # omega h beyond which there is no motion before t = 0 to resolve, and a damped one overflows


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
    arguments: Mapping[str, Any] = field(default_factory=dict)
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

        What u0 and v0 the program cannot be given is superposed: from the rest of them it moves as this motion less
        u0 + v0 t, under the load less the forces of that. All is made larger where its tolerance is absolute.
        Raises RunFailed for a run that raises, ValueError for histories of another length.
        """
        can, h, steps = self.can, dt / self.can.calls, n * self.can.calls
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
                found = self.run(omega, xi, h, steps, *start, load=load, **given)
            histories = [np.full(steps + 1, np.nan) if y is None else np.asarray(y, np.float64).ravel() for y in found]
        except Exception as error:
            raise RunFailed(
                f"expected histories from {self.name} at omega = {omega:g}, xi = {xi:g}, dt = {dt:g}, got "
                f"{type(error).__name__}: {error}; say what it cannot run in its Integrator, or cure the adapter"
            ) from error
        if len(histories) != 3 or any(len(y) != steps + 1 for y in histories):
            lengths = [len(y) for y in histories]
            raise ValueError(
                f"expected u, v and a with {steps + 1} numbers each from {self.name}, the start included, got {lengths}"
            )
        for j, kind in enumerate("uva"):
            if kind not in can.outputs or kind in can.late:
                histories[j] = np.full(steps + 1, np.nan)
        t = h * np.arange(steps + 1)
        superposed = np.stack([p + q * t, np.full_like(t, q), np.zeros_like(t)], axis=-1)
        return (np.stack(histories, axis=-1) / size + superposed)[:: can.calls]

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
                raise ValueError(f"{len(times)} times, {len(rows)} rows, {np.shape(errors)} errors")
            if not (np.diff(times) > 0).all() or not np.isfinite(rows).all():
                raise ValueError("times that do not ascend, or numbers that are not finite")
        except Exception as error:
            raise RunFailed(f"{type(error).__name__}: {error}") from error
        return times, rows, estimates


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


def states_before(omega: float, xi: float, h: float, rows: int, u0: float, v0: float, load: Load) -> Array:
    """u, v, a (rows, 3) of the exact motion at t = -h, -2 h, ...; copies of the start above omega h = 10."""
    from scipy.linalg import expm  # noqa: PLC0415 (slow to import)

    p = load.omega
    constant = load.offset + (load.amplitude if load.kind == "constant" else 0.0)
    slope = load.slope + (load.amplitude if load.kind == "ramp" else 0.0)
    sine = load.amplitude if load.kind == "harmonic" else 0.0
    rates = np.zeros((6, 6))  # of u, v, 1, t, sin(p t + phase), cos(p t + phase)
    rates[0, 1] = rates[3, 2] = 1.0
    rates[1] = -(omega**2), -2 * xi * omega, constant, slope, sine, 0.0
    rates[4, 5], rates[5, 4] = p, -p
    state = np.array([u0, v0, 1.0, 0.0, math.sin(load.phase), math.cos(load.phase)])
    step = np.eye(6) if omega * h > RESOLVED else expm(-h * rates)
    states = [np.linalg.matrix_power(step, k) @ state for k in range(1, rows + 1)]
    return np.array([[x[0], x[1], rates[1] @ x] for x in states])
