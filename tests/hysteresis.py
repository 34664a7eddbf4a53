"""The exact motion of an oscillator with a bilinear spring, from event to event, and its energy account.

u'' + 2 xi omega u' + q = f(t), where q = alpha k u + (1 - alpha) k (u - p), k = omega^2, and the elongation p that
remains moves only while |u - p| is the elongation at yield, strength/k. Between events the spring is linear, and with
a load that is a line or a sine in t the state (u, v, f, f', 1) follows a linear equation without right side, so that
its matrix's exponential is the motion, to rounding. Events are roots of it: u - p reaches the elongation at yield, the
velocity of a yielding spring changes its sign, the load changes its form. Nothing of the project is used.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

Array = Any


@dataclass(frozen=True)
class Piece:
    """A load from t on: f'' = -rate^2 f with f and f' at t; with a rate of 0 it is linear."""

    t: float
    f: float
    slope: float = 0.0
    rate: float = 0.0

    def __call__(self, t: float) -> float:
        """Its value at t."""
        x = t - self.t
        sine = np.sin(self.rate * x) / self.rate if self.rate else x
        return self.f * np.cos(self.rate * x) + self.slope * sine

    def slope_at(self, t: float) -> float:
        """Its derivative at t."""
        x = self.rate * (t - self.t)
        return self.slope * np.cos(x) - self.f * self.rate * np.sin(x)


def constant(value: float) -> list[Piece]:
    return [Piece(0.0, value)]


def sine(amplitude: float, rate: float) -> list[Piece]:
    return [Piece(0.0, 0.0, amplitude * rate, rate)]


def half_sine(amplitude: float, duration: float) -> list[Piece]:
    rate = np.pi / duration
    return [Piece(0.0, 0.0, amplitude * rate, rate), Piece(duration, 0.0)]


def record(dt: float, values: Sequence[float]) -> list[Piece]:
    """Linear between samples, 0 after the last."""
    lines = [Piece(i * dt, a, (b - a) / dt) for i, (a, b) in enumerate(pairwise(values))]
    return [*lines, Piece((len(values) - 1) * dt, 0.0)]


@dataclass(frozen=True)
class Oscillator:
    omega: float
    xi: float
    strength: float
    alpha: float = 0.0

    @property
    def at_yield(self) -> float:
        """The elongation of the spring at yield."""
        return self.strength / self.omega**2

    def force(self, u: Array, p: Array) -> Array:
        """The spring's force at u where p remains."""
        k = self.omega**2
        return self.alpha * k * u + (1 - self.alpha) * k * (u - p)

    def committed(self, u: float, p: float) -> float:
        """What remains once the spring was strained to u on a path without a turn, by cases."""
        if u - p > self.at_yield:
            return u - self.at_yield
        if u - p < -self.at_yield:
            return u + self.at_yield
        return p

    def stored(self, u: Array, p: Array) -> Array:
        """The energy that the spring gives back."""
        k = self.omega**2
        return self.alpha * k * u**2 / 2 + (1 - self.alpha) * k * (u - p) ** 2 / 2

    def work(self, a: float, b: float, p: float) -> float:
        """The integral of the force from u = a, where p is committed, to b: a trapezium before yield, one after."""
        at = self.at_yield
        turn = float(np.clip(b, p - at, p + at))
        total = (self.force(a, p) + self.force(turn, p)) / 2 * (turn - a)
        return total + (self.force(turn, p) + self.force(b, self.committed(b, p))) / 2 * (b - turn)


@dataclass(frozen=True)
class Arc:
    """Motion without an event from t on: (u, v, f, f', 1) there, and the matrix of its rate.

    p: what remains at t; moved: the length of its way up to t; yields: the sign of the yielding spring's velocity, 0
    where it is elastic.
    """

    t: float
    y: Array
    matrix: Array
    p: float
    moved: float
    yields: int

    def at(self, t: float) -> Array:
        """(u, v, f, f', 1) at t."""
        return expm(self.matrix * (t - self.t)) @ self.y

    def event(self, y: Array, of: Oscillator) -> float:
        """Negative before the event that ends it, where (u, v, ...) is y."""
        return float(-self.yields * y[1] if self.yields else abs(y[0] - self.p) - of.at_yield)


@dataclass(frozen=True)
class Motion:
    of: Oscillator
    arcs: Sequence[Arc]

    @property
    def events(self) -> list[float]:
        """Times at which the spring begins to yield or ceases to."""
        return [b.t for a, b in pairwise(self.arcs) if a.yields != b.yields]

    def at(self, times: Array) -> Array:
        """u, v, what remains, and the energy that the spring has dissipated, each at the times."""
        starts, rows = [arc.t for arc in self.arcs], []
        for t in np.atleast_1d(times):
            arc = self.arcs[max(int(np.searchsorted(starts, t, side="right")) - 1, 0)]
            u, v = arc.at(float(t))[:2]
            p = u - arc.yields * self.of.at_yield if arc.yields else arc.p
            rows.append((u, v, p, (1 - self.of.alpha) * self.of.strength * (arc.moved + abs(p - arc.p))))
        return np.array(rows).T


def exact(
    of: Oscillator, load: Sequence[Piece], t_end: float, u: float = 0.0, v: float = 0.0, p: float | None = None
) -> Motion:
    """The motion from u, v at t = 0, where p remains; without p the spring was strained to u at once."""
    p = of.committed(u, 0.0) if p is None else p
    scan = 2 * np.pi / of.omega / 256  # an event is looked for between instants so far apart
    t, state, moved, arcs = 0.0, np.array([u, v]), 0.0, list[Arc]()
    on = int(np.sign(u - p)) if abs(u - p) >= of.at_yield * (1 - 1e-13) else 0
    sign = on if on * v > 0 else 0
    for piece, until in zip(load, _ends(load, t_end), strict=True):
        while t < until:
            arc = _arc(of, piece, t, state, p, moved, sign)
            arcs.append(arc)
            found = _found(of, arc, until, scan)
            t = until if found is None else found
            state = arc.at(t)[:2]
            if sign:
                at = float(state[0] - sign * of.at_yield)
                p, moved = at, moved + abs(at - p)
            if found is not None:
                sign = 0 if sign else int(np.sign(state[0] - p))
    return Motion(of, arcs)


def _ends(load: Sequence[Piece], t_end: float) -> list[float]:
    """Of each piece, but none after t_end."""
    return [min(t, t_end) for t in [*(piece.t for piece in load[1:]), np.inf]]


def _arc(of: Oscillator, piece: Piece, t: float, state: Array, p: float, moved: float, sign: int) -> Arc:
    k, alpha = of.omega**2, of.alpha
    stiffness, rest = (alpha * k, (1 - alpha) * of.strength * sign) if sign else (k, -(1 - alpha) * k * p)
    matrix = np.array([
        [0, 1, 0, 0, 0],
        [-stiffness, -2 * of.xi * of.omega, 1, 0, -rest],
        [0, 0, 0, 1, 0],
        [0, 0, -(piece.rate**2), 0, 0],
        [0, 0, 0, 0, 0],
    ])  # fmt: skip
    return Arc(t, np.array([*state, piece(t), piece.slope_at(t), 1.0]), matrix, p, moved, sign)


def _found(of: Oscillator, arc: Arc, until: float, scan: float) -> float | None:
    """When the arc's event is; None if not before `until`."""
    times = np.linspace(arc.t, until, max(int(np.ceil((until - arc.t) / scan)), 1) + 1)
    step, y = expm(arc.matrix * (times[1] - times[0])), arc.y
    for before, after in pairwise(times):
        y = step @ y
        if arc.event(y, of) > 0:  # an arc begins where the event of the one before it is: its own is after that
            low = before if before > arc.t else arc.t + 1e-6 * (after - arc.t)
            if arc.event(arc.at(low), of) > 0:
                return low
            return float(brentq(lambda t: arc.event(arc.at(t), of), low, after, xtol=1e-14, rtol=1e-14))
    return None


def integrated(of: Oscillator, load: Sequence[Piece], t_end: float, u: float = 0.0, v: float = 0.0) -> Array:
    """u, v, what remains, the energies lost in the damper and in the spring, and the work of the load, at t_end.

    A second way to the same: DOP853 integrates each branch up to SciPy's own event, and the energies with it.
    """
    p, t, sign = of.committed(u, 0.0), 0.0, 0
    y = np.array([u, v, p, 0.0, 0.0, 0.0])
    on = int(np.sign(u - p)) if abs(u - p) >= of.at_yield * (1 - 1e-13) else 0
    sign = on if on * v > 0 else 0
    for piece, until in zip(load, _ends(load, t_end), strict=True):
        while t < until:

            def rate(t: float, y: Array, piece: Piece = piece, sign: int = sign) -> list[float]:
                u, v, p = y[:3]
                f, yielding = piece(t), abs(sign)
                lost = (1 - of.alpha) * of.strength * abs(v) * yielding
                return [
                    v,
                    f - 2 * of.xi * of.omega * v - of.force(u, p),
                    v * yielding,
                    2 * of.xi * of.omega * v**2,
                    lost,
                    f * v,
                ]

            def event(t: float, y: Array, sign: int = sign) -> float:
                return -sign * y[1] if sign else abs(y[0] - y[2]) - of.at_yield

            event.terminal, event.direction = True, 1  # type: ignore[attr-defined]
            done = solve_ivp(rate, (t, until), y, "DOP853", events=event, rtol=3e-14, atol=1e-14, max_step=0.02)
            t, y = float(done.t[-1]), done.y[:, -1]
            if done.status == 1:
                sign = 0 if sign else int(np.sign(y[0] - y[2]))
    return y
