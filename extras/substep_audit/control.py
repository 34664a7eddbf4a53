"""What a program does in steps of its own choice: its error against the tolerance, its estimates against the truth."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from substep.core.arrays import Array

from .orders import OMEGA, Motion, written
from .programs.adapter import Load
from .stepper import RunFailed, Stepper

TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
START = (1.0, 0.7)  # u, v
T_END = 4.0 * np.pi / OMEGA  # two periods
ENDS = 2  # steps left out at either end: the first one is short, the last one may be cut

Pair = tuple[float | None, float | None]


@dataclass(frozen=True)
class ControlledRun:
    """Two periods of an undamped oscillator at a tolerance.

    Omega: of the mean step. error: the largest of u and v/omega at the ends of steps, over the largest that they are.
    local: root mean squares of the true errors of u and v in one step from the program's own u and v; estimated: those
    of the program's estimates; None where all are rounding, or none is returned. failed: why there is no run.
    """

    tol: float
    steps: int = 0
    Omega: float = 0.0
    error: float = 0.0
    local: Pair = (None, None)
    estimated: Pair = (None, None)
    failed: str = ""

    @property
    def effectivity(self) -> Pair:
        """Estimate over true local error, of u and of v."""
        u, v = (
            e / x if e is not None and x is not None else None for e, x in zip(self.estimated, self.local, strict=True)
        )
        return u, v


@dataclass(frozen=True)
class Control:
    """Runs at the tolerances. power: the error is proportional to tol to that power; None if fewer than two are known.

    orders, estimated_orders: of the steps of u and v, and of their estimates: p, where the error of a step is of order
    h^(p+1).
    """

    runs: tuple[ControlledRun, ...]

    @property
    def done(self) -> tuple[ControlledRun, ...]:
        """The runs that did not fail."""
        return tuple(run for run in self.runs if not run.failed)

    @property
    def power(self) -> float | None:
        """The error is proportional to tol to this power."""
        return slope([run.tol for run in self.done], [run.error for run in self.done])

    @property
    def orders(self) -> Pair:
        """Of the steps that the program takes."""
        return self._orders([run.local for run in self.smallest])

    @property
    def estimated_orders(self) -> Pair:
        """Of the estimates."""
        return self._orders([run.estimated for run in self.smallest])

    @property
    def smallest(self) -> tuple[ControlledRun, ...]:
        """The three runs of the smallest steps, whose slopes are orders."""
        return self.done[-3:]

    def _orders(self, sizes: Sequence[Pair]) -> Pair:
        found = [slope([run.Omega for run in self.smallest], [size[kind] for size in sizes]) for kind in range(2)]
        u, v = (None if x is None else x - 1.0 for x in found)
        return u, v

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        found = {name: getattr(self, name) for name in ("power", "orders", "estimated_orders", "text")}
        return asdict(self) | found

    @property
    def text(self) -> tuple[str, ...]:
        """In words, a line each."""
        lines = [f"fails at tol = {run.tol:.0e}: {run.failed}" for run in self.runs if run.failed]
        if not self.done:
            return tuple(lines)
        first, last = self.done[0], self.done[-1]
        like = "" if self.power is None else f", as tol^{self.power:.2f}"
        lines.append(
            f"error {first.error:.1e} at tol = {first.tol:.0e} ({first.steps} steps), {last.error:.1e} at "
            f"{last.tol:.0e} ({last.steps}){like}"
        )
        for kind, name in enumerate("uv"):
            known = [(run.Omega, run.effectivity[kind]) for run in self.done if run.effectivity[kind] is not None]
            if known:
                indices = ", ".join(f"{index:.3g} at Omega = {Omega:.2g}" for Omega, index in (known[0], known[-1]))
                orders = " against ".join(_order(pair[kind]) for pair in (self.estimated_orders, self.orders))
                lines.append(f"estimate of {name} over true local error {indices}; orders {orders}")
        return tuple(lines)


def _order(p: float | None) -> str:
    return "?" if p is None else written(round(p, 1))


def controlled_runs(stepper: Stepper) -> Control | None:
    """None for a stepper that does not choose its steps."""
    if stepper.controlled is None:
        return None
    return Control(tuple(_run(stepper, tol) for tol in TOLERANCES))


def _run(stepper: Stepper, tol: float) -> ControlledRun:
    try:
        t, y, estimates = stepper.own_steps(OMEGA, tol, T_END, *START)
    except RunFailed as error:
        return ControlledRun(tol, failed=str(error))
    if t[-1] < T_END * (1.0 - 1e-9):
        return ControlledRun(tol, len(t) - 1, failed=f"it ends at t = {t[-1]:.4g}, before {T_END:.4g}")
    scale = np.array([1.0, OMEGA])
    exact = Motion(*START, Load()).exact(t, 0.0)[:, :2] / scale
    size = float(np.abs(exact).max())
    h = np.diff(t)
    true = np.abs(y[1:] - Motion(*y[:-1].T, Load()).exact(h, 0.0)[:, :2])
    rounding = 10.0 ** (2.0 - stepper.can.digits) * size * scale
    local = _sizes(true, rounding)
    return ControlledRun(
        tol,
        len(h),
        OMEGA * float(h.mean()),
        float(np.abs(y / scale - exact).max()) / size,
        local,
        (None, None) if estimates is None else _sizes(np.abs(estimates), np.zeros(2)),
    )


def _sizes(errors: Array, rounding: Array) -> Pair:
    """Root mean squares of u and of v over the steps but the first and last ones; None for one that is rounding."""
    inner = errors[ENDS:-ENDS] if len(errors) > 2 * ENDS else errors
    u, v = (
        float(x) if x > least else None for x, least in zip(np.sqrt((inner**2).mean(axis=0)), rounding, strict=True)
    )
    return u, v


def slope(x: Sequence[float], y: Sequence[float | None]) -> float | None:
    """Of log y over log x, where y is known; None for fewer than two."""
    known = [(a, b) for a, b in zip(x, y, strict=True) if b is not None and b > 0]
    if len({a for a, _ in known}) < 2:
        return None
    logs = np.log(np.array(known))
    return float(np.polyfit(logs[:, 0], logs[:, 1], 1)[0])
