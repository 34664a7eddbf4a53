"""The steps of a run, dt or tol: all that a user asks of them, checked before anything is marched."""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..core.arrays import Array
from ..core.between_steps import ascending
from ..core.errors import real_array, real_number, whole
from ..core.loads import ROUNDING
from ..core.state import State

CHOSEN = ("rtol", "atol", "dt_first", "dt_min", "dt_max", "grid", "rung")  # what is asked of chosen steps, with tol
MOST_STEPS = 2**53  # beyond, not every whole number is a double


class Begin(NamedTuple):
    """Where the steps of a run begin: at the time origin + first*dt (s), so that a run that goes on counts further.

    rows: what the scheme carries there, in the form of the march that it is for; None where the scheme is to start.
    """

    first: int = 0
    origin: float = 0.0
    rows: Array | None = None

    def time(self, h: float, steps: Any, within: Any = 0.0) -> Any:
        """The time, s, so many whole steps of h (s) after the begin and a part of a step `within`; numbers or arrays.

        Whole steps are added first, so that a run that goes on rounds as one that was not broken.
        """
        return self.origin + (self.first + steps + within) * h


AT_ZERO = Begin()


@dataclass(frozen=True)
class ConstantSteps:
    """n steps of dt (s), of which every stride-th is kept, from t = 0 or from where `begin` says."""

    dt: float
    n: int
    stride: int = 1
    begin: Begin = AT_ZERO

    @classmethod
    def of(cls, dt: Any, t_end: Any, *, stride: Any = 1, start: State | None = None) -> "ConstantSteps":
        """start: where the steps begin, at t = 0 by default.

        Raises ValueError for a step or an end that is not positive, for an end that is not a multiple of dt after the
        start, and for one that is not after it.
        """
        _require_stride(stride)
        t_end = end_asked(t_end) if start is None else real_number("t_end", t_end)
        dt = real_number("dt", dt, positive=True)
        begin = AT_ZERO if start is None else _begin(start, dt)
        if start is not None:
            _require_after(t_end, start.t)
        n = number_of_steps(dt, t_end, begin.origin) - begin.first
        if n == 0:
            raise _not_after(t_end, begin.origin + begin.first * dt)
        return cls(dt, n, int(stride), begin)

    def time(self, steps: int) -> float:
        """The time after so many steps, s."""
        return self.begin.time(self.dt, steps)

    def state(self, steps: int, u: Array, v: Array, a: Array | None, **carried: Any) -> State:
        """Where a run stands after so many steps with u, v, a; carried: what else `State` has of it."""
        begin = self.begin
        return State(self.time(steps), u, v, a, dt=self.dt, steps=begin.first + steps, origin=begin.origin, **carried)

    def times(self, count: int) -> Array | None:
        """The times (count,) of rows of a run that goes on; None for one from t = 0, where they need no memory."""
        first, origin, _ = self.begin
        if first == 0 and origin == 0.0:
            return None
        return origin + (self.stride * self.dt) * (first / self.stride + np.arange(float(count)))


def _begin(start: State, dt: float) -> Begin:
    """Steps are counted from the same time as those before, if they are of the same length; else from t = 0 if that is
    a whole number of steps ago, and from the start if not.
    """
    if start.dt == dt:
        return Begin(start.steps, start.origin)
    ago = start.t / dt
    whole = round(ago) if abs(ago) <= MOST_STEPS else 0
    return Begin(whole) if whole >= 0 and abs(ago - whole) <= 1e-9 + 4e-16 * ago else Begin(0, start.t)


def _require_after(t_end: float, t: float) -> None:
    if t_end <= t + 4e-16 * abs(t):
        raise _not_after(t_end, t)


def _not_after(t_end: float, t: float) -> ValueError:
    return ValueError(
        f"expected t_end after the start at t = {t:.12g}, since time goes on, got {t_end:.12g}; give a later one"
    )


@dataclass(frozen=True)
class Control:
    """What is asked of steps chosen from t_begin to t_end (s); rtol, atol_u and share_v may be (P,), for lanes.

    A step is accepted if the root of the mean square of its estimated errors, each over its scale, is at most 1. The
    scale of a component of u is atol_u + rtol*|u|, that of v is atol_v + share_v*(largest |v| so far) + rtol*|v|.
    dt_first: 0 to choose it from the first accelerations; dt_min, dt_max: bounds, s. grid (n,): times at which rows are
    wanted, None for a row a step. rung: ratio of the lengths between which steps move, 0 for any length, None for what
    the kernels' derivation says. start: where they begin, unless it is t = 0 or dt_first was asked for; they go on from
    its fork if it is one of the same march.
    """

    t_end: float
    rtol: Any
    atol_u: Any
    atol_v: float
    share_v: Any
    dt_first: float = 0.0
    dt_min: float = 0.0
    dt_max: float = math.inf
    grid: Array | None = None
    rung: float | None = None
    t_begin: float = 0.0
    start: State | None = None

    @classmethod
    def of(
        cls,
        length: float,
        tol: float,
        t_end: float,
        *,
        rtol: float | None = None,
        atol: float | Sequence[float] | None = None,
        dt_first: float | None = None,
        dt_min: float | None = None,
        dt_max: float | None = None,
        grid: ArrayLike | None = None,
        rung: float | None = None,
        start: State | None = None,
    ) -> "Control":
        """Checked arguments of `march`; length: of the scene; start: where steps begin, at t = 0 by default.

        Raises ValueError, with the cure.
        """
        tol = real_number("tol", tol, positive=True)
        if start is not None and start.t < 0.0:
            raise ValueError(
                f"expected a start at t >= 0 where steps are chosen, got t = {start.t:.12g}, since before 0 they do "
                "not end where a load jumps; give dt in place of tol, or count time, in the loads too, from the start"
            )
        t_end = end_asked(t_end)
        rtol = tol if rtol is None else real_number("rtol", rtol)
        atol_u, atol_v, share_v = tol * length, 0.0, tol
        if atol is not None:
            given = real_array("atol", atol)
            if given.shape not in ((), (2,)):
                raise ValueError(f"expected atol of u, or of u and v, got shape {given.shape}; give one or two numbers")
            atol_u = float(given.flat[0])
            if given.ndim:
                atol_v, share_v = float(given[1]), 0.0
        if min(rtol, atol_u, atol_v) < 0 or (rtol == 0 and atol_u == 0) or (rtol == 0 and atol_v + share_v == 0):
            raise ValueError(
                f"expected rtol >= 0 and atol >= 0, not both 0, got {rtol} and {atol}; one of them must bound the error"
            )
        found = {"dt_first": dt_first, "dt_min": dt_min, "dt_max": dt_max}
        steps = {name: real_number(name, x, positive=True) for name, x in found.items() if x is not None}
        low, high = steps.get("dt_min", 0.0), steps.get("dt_max", math.inf)
        if low > high:
            raise ValueError(f"expected dt_min <= dt_max, got {low} > {high}; exchange them or drop one")
        if "dt_first" in steps and not low <= steps["dt_first"] <= high:
            raise ValueError(
                f"expected dt_first between dt_min = {low} and dt_max = {high}, got {steps['dt_first']}; "
                "change it, or leave it out"
            )
        if rung is not None and (rung := real_number("rung", rung)) != 0.0 and not 1.0 < rung <= 10.0:
            raise ValueError(
                f"expected rung between 1 and 10, the ratio of two lengths of steps, or 0 for any length, got {rung}; "
                "take 2**0.5, or leave it out"
            )
        t_begin = 0.0
        if start is not None:
            _require_after(t_end, t_begin := start.t)
            start = None if "dt_first" in steps else start
            if start is not None and start.dt_next is not None:
                steps["dt_first"] = min(max(start.dt_next, low), high)
        rows = None if grid is None else _grid(grid, t_begin, t_end)
        return cls(t_end, rtol, atol_u, atol_v, share_v, **steps, grid=rows, rung=rung, t_begin=t_begin, start=start)

    def behind(self, times: Any) -> Any:
        """Whether times are after the one at which the steps begin, by more than rounding."""
        return times > self.t_begin * (1.0 + ROUNDING)

    def over(self, length: Any, tol: Any, given: Collection[str]) -> "Control":
        """The same for lanes: scene's lengths and tolerances (P,); given: arguments that stay as they are."""
        own: dict[str, Any] = {} if "rtol" in given else {"rtol": tol}
        if "atol" not in given:
            own["atol_u"] = tol * length
        return replace(self, **own, share_v=tol if self.share_v else 0.0)


def _grid(grid: ArrayLike, t_begin: float, t_end: float) -> Array:
    times = ascending("grid", grid)
    if times[0] < t_begin or times[-1] > t_end + 1e-12 * abs(t_end):
        raise ValueError(
            f"expected grid within {t_begin:.12g} and t_end = {t_end:.12g}, got {times[0]:.12g} to {times[-1]:.12g}; "
            "cut it, or change t_end"
        )
    return np.minimum(times, t_end)


def _require_stride(stride: Any) -> None:
    whole("stride", stride, 1, "steps", "1 keeps every step")


def steps_of(
    dt: Any,
    tol: Any,
    t_end: Any,
    *,
    stride: Any = 1,
    length: float = 1.0,
    start: State | None = None,
    chosen: Mapping[str, Any],
) -> ConstantSteps | Control:
    """Constant steps if dt is given, chosen ones if tol is; length: of the scene; chosen: of CHOSEN, by name.

    Raises ValueError for neither or both, for what goes with the other, and for values that no run can have.
    """
    require_one(dt, tol, t_end)
    if dt is not None:
        require_tol(chosen)
        return ConstantSteps.of(dt, t_end, stride=stride, start=start)
    if stride != 1:
        raise ValueError(f"expected stride with dt only, got {stride}; give the times you want as grid=")
    return Control.of(length, tol, t_end, start=start, **chosen)


def require_one(dt: Any, tol: Any, t_end: Any) -> None:
    """Raises ValueError unless t_end and one of dt and tol are given."""
    if t_end is None or (dt is None) == (tol is None):
        got = ", ".join(f"{name} = {x}" for name, x in (("dt", dt), ("tol", tol), ("t_end", t_end)) if x is not None)
        raise ValueError(
            f"expected t_end and either dt, a constant step, or tol, for steps that are chosen; got {got or 'none'}"
        )


def end_asked(t_end: Any) -> float:
    """t_end, s. Raises ValueError for anything but a positive number."""
    return real_number("t_end", t_end, positive=True)


def require_tol(chosen: Iterable[str]) -> None:
    """Raises ValueError for an argument of chosen steps, by name, where the step is constant."""
    for name in chosen:
        raise ValueError(f"expected {name} with tol only, got it with dt; give tol in place of dt, or drop it")


def number_of_steps(dt: float, t_end: float, origin: float = 0.0) -> int:
    """(t_end - origin)/dt. Raises ValueError, which names the two nearest t_end, unless it is whole to 1e-9, relative.

    So it does for more steps than a double counts one by one.
    """
    ratio = (t_end - origin) / dt
    if not ratio <= MOST_STEPS:
        raise ValueError(
            f"expected at most 2**53 steps, got t_end/dt = {t_end - origin:.12g}/{dt:.12g} = {ratio:.3g}; take "
            "a longer dt or an earlier t_end"
        )
    n, rounding = round(ratio), 4e-16 * abs(origin) / dt
    if abs(ratio - n) > 1e-9 * max(1.0, ratio) + rounding or n == 0:
        low = math.floor(ratio)
        around = [f"{origin + k * dt:.12g}" for k in (low, low + 1) if k > 0]
        after = f" after t = {origin:.12g}" if origin else ""
        raise ValueError(
            f"expected t_end to be a multiple of dt = {dt:.12g}{after}, got {t_end:.12g}; "
            f"the nearest {'is' if len(around) == 1 else 'are'} {' and '.join(around)}"
        )
    return n
