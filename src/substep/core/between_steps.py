"""A response at other times than the ends of its steps, and up to an event."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from .arrays import Array
from .errors import real_array
from .kernel_modules import loaded
from .loads import jumps

if TYPE_CHECKING:
    from .response import Response

Event = Callable[[float, Array, Array], float]  # of t, u (d,) and v (d,); a root of it is the event
R = TypeVar("R", bound="Response")
JUMP = 1e-9  # of a step, by which its end may differ from the time at which a load jumps
SHARE = 4e-16  # of a step, to which the time of an event is found
AT_START = 1e-9  # of the first step, within which a root is that of the event at which the run before has ended


def ascending(name: str, times: ArrayLike) -> Array:
    """A row of ascending times. Raises ValueError for anything else."""
    found = real_array(name, times).copy()
    if found.ndim != 1 or not found.size or (np.diff(found) <= 0).any():
        raise ValueError(f"expected {name} to be a row of ascending times, got shape {found.shape}; sort it, each once")
    return found


def sampled(r: R, times: ArrayLike) -> R:
    """The response at these times, by Hermite's polynomial of each step, those after its last row left out.

    Raises ValueError for times that do not ascend, and for one before its first row.
    """
    wanted = ascending("at", times)
    if wanted[0] < r.t[0] - 1e-12 * abs(r.t[0]):
        raise ValueError(
            f"expected at within the run, which begins at t = {r.t[0]:.12g}, got {wanted[0]:.12g}; leave it out"
        )
    wanted = wanted[wanted <= r.t[-1] + 1e-12 * abs(r.t[-1])]
    if not wanted.size:
        raise ValueError(
            f"expected a time in at that the run has reached, got none up to t = {r.t[-1]:.12g}, where it has ended, "
            f"{r.status}; give earlier ones"
        )
    u, v, a = _at(r, np.clip(wanted, r.t[0], r.t[-1]))
    last = r.last or partial(getattr, r, "state")
    return replace(r, u=u, v=v, own_a=a, times=wanted, step=np.nan, last=last, before=None, **r.at_times(wanted, u))


def require_reached(times: Array, t_end: float) -> None:
    """Raises ValueError for times of which the last is beyond the end of a run."""
    if times[-1] > t_end + 1e-12 * abs(t_end):
        raise ValueError(f"expected at up to t_end = {t_end:.12g}, got {times[-1]:.12g}; cut it, or change t_end")


def ended(r: R, until: Event | Sequence[Event]) -> R:
    """The response up to the first root of an event after its first row; the whole one where there is none.

    The response has a row for each step. Its last row is at that root, found within the step by Hermite's polynomial,
    and `t_events` says of which event.
    Raises ValueError for an event that is not a function of t, u and v with a number for value.
    """
    given = cast("Any", until)
    events: list[Any] = list(cast("Sequence[Any]", given)) if isinstance(given, list | tuple) else [given]
    if not events or not all(map(callable, events)):
        raise ValueError(
            f"expected until as a function of t, u, v or a list of them, got {repr(cast(object, given))[:60]}; give "
            "such as lambda t, u, v: u[0] - 0.1, whose sign changes at the event"
        )
    roots = [_first_root(r, event) for event in events]
    t_events = np.array([np.nan if root is None else root for root in roots])
    if np.isnan(t_events).all():
        return replace(r, t_events=t_events)
    end = float(np.nanmin(t_events))
    t_events[t_events > end] = np.nan
    k = int(np.searchsorted(r.t, end))  # of the first row that is not before it
    times = np.append(r.t[:k], end)
    u, v, a = _at(r, times)
    return replace(
        r, u=u, v=v, own_a=a, times=times, newton_iterations=r.newton_iterations[:k], status="completed", t_failed=None,
        last=None, t_events=t_events, **r.at_times(times, u),
    )  # fmt: skip


def _at(r: Response, times: Array) -> tuple[Array, Array, Array | None]:
    """u, v, a (k, d) at times within the run; rows of steps' ends as they are.

    The step before a jump of the load ends with the acceleration after it, so that u and v alone make its polynomial.
    """
    t, u, v = r.t, np.asarray(r.u), np.asarray(r.v)
    a = np.asarray(r.a) if r.has_a else None
    rows = (u, v, a)
    if r.before is not None and len(t) > 1:
        begin, (first_u, first_v, *first_a) = r.before
        t, u, v = np.append(begin, t[1:]), np.vstack([first_u, u[1:]]), np.vstack([first_v, v[1:]])
        a = None if a is None else np.vstack([*first_a, a[1:]])
    k = np.clip(np.searchsorted(t, times, side="right") - 1, 0, max(len(t) - 2, 0))
    if len(t) == 1:
        return u[k], v[k], None if a is None else a[k]
    h = (t[k + 1] - t[k])[:, None]
    share = (times - t[k])[:, None] / h
    module = loaded("shared.interpolant")
    found: list[Array] = list(module.of_velocities(share, h, u[k], v[k], u[k + 1], v[k + 1]))
    if a is not None:
        order = min(r.scheme.order[:2]) if r.scheme.order else 2
        between = module.high if order >= module.HIGH else module.low
        whole: list[Array] = list(between(share, h, u[k], v[k], a[k], u[k + 1], v[k + 1], a[k + 1]))
        breaks = np.concatenate([jumps(load) for load in r.loads] or [np.empty(0)])
        away = np.asarray(np.abs(t[k + 1, None] - breaks) > JUMP * h)
        smooth = away.all(axis=1, keepdims=True)
        found = [np.where(smooth, x, y) for x, y in zip(whole, found, strict=True)]
    at_end = (times == r.t[k]) * 1 + (times == r.t[k + 1]) * 2
    for x, of in zip(found, rows, strict=True):
        for place in (1, 2):
            if of is not None:
                x[at_end == place] = of[k[at_end == place] + place - 1]
    return found[0], found[1], None if a is None else found[2]


def _first_root(r: Response, event: Event) -> float | None:
    """The time of the first change of sign of an event after the first row, None where there is none."""

    def value(t: float, u: Array, v: Array) -> float:
        found: Any = event(t, u, v)
        if np.ndim(found) or np.asarray(found).dtype.kind not in "iuf" or math.isnan(found):
            raise ValueError(
                f"expected until as a function of t, u, v with one number for value, got {found!r} at t = {t:.6g}; "
                "return such as u[0] - 0.1, whose sign changes at the event"
            )
        return float(found)

    before = value(float(r.t[0]), r.u[0], r.v[0])
    for k in range(1, len(r.t)):
        now = value(float(r.t[k]), r.u[k], r.v[k])
        if now == 0.0:
            return float(r.t[k])
        if before * now < 0.0:
            root, begin = _within(r, k, value), float(r.t[0])
            if root - begin > max(AT_START * (float(r.t[1]) - begin), 4e-15 * abs(begin)):
                return root
        before = now
    return None


def _within(r: Response, k: int, value: Event) -> float:
    """The root between rows k - 1 and k."""
    from scipy.optimize import brentq  # noqa: PLC0415  # pyright: ignore

    begin, end = float(r.t[k - 1]), float(r.t[k])

    def at(t: float) -> float:
        u, v, _ = _at(r, np.array([t]))
        return value(t, u[0], v[0])

    root = cast("Callable[..., float]", brentq)
    return root(at, begin, end, xtol=max(SHARE * (end - begin), 4e-16 * abs(end)), rtol=8.9e-16)
