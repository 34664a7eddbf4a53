"""Where rounding decides: very small steps, and a pendulum at rest at the top."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...core.scene_by_name import scene
from ...core.schemes import Array, scheme, schemes
from ...exact.pendulum import ElasticPendulum
from ...exact.periods import period
from ...marching.scene_lanes import Lanes, march_lanes
from .outcomes import QUICK, WORDS, judge, whole_steps, write_rows

TINY = np.array([1e-6, 1e-7])  # steps h, s
TINY_SPAN = 2e-4  # s


@dataclass(frozen=True)
class RoundOffRow:
    """Errors at 2e-4 s: u in m, energy relative, a in m/s^2 and relative, None where a scheme has no a of its own.

    displacement_unknown: the error a would have, m/s^2, if Newton's method solved for u, of which a were the second
    difference.
    """

    scheme: str
    h: float
    u: float
    energy: float
    a: float | None
    a_relative: float | None
    displacement_unknown: float


def round_off(folder: Path, full: bool = False) -> list[RoundOffRow]:
    """Every scheme on the flexible pendulum in very small steps, against the exact motion.

    The force itself has only 9 digits, being the small difference of two lengths (the strain is 1e-7). Errors of a that
    are proportional to h are truncation: the acceleration of the alpha-methods is of first order.
    """
    flexible = scene("elastic_pendulum", EA=1e4)
    parameters = flexible.parameters
    exact = ElasticPendulum(parameters["EA"], parameters["L"], parameters["m"], parameters["v0"])
    u = exact.position(TINY_SPAN)
    a = flexible.acceleration(np.zeros(()), u, flexible.v0)
    steps = whole_steps(TINY_SPAN, TINY)
    stride, rows = int(steps.min()), []
    for name in schemes():
        lanes = march_lanes(flexible, scheme(name), TINY, steps, stride=stride, history=True)
        for h, n, out in zip(TINY.tolist(), steps, lanes.out, strict=True):
            last = out[n // stride]
            energy = float(flexible.energy(np.zeros(()), last[0], last[1]) / flexible.E0 - 1)
            error = float(np.abs(last[2] - a).max()) if len(last) > 2 else None
            relative = None if error is None else error / float(np.abs(a).max())
            lost = float(np.spacing(parameters["L"]) / h**2)
            rows.append(RoundOffRow(name, h, float(np.abs(last[0] - u).max()), energy, error, relative, lost))
    write_rows(folder / "round_off.csv", rows)
    return rows


AWAY = 0.1  # rad from the top
SWINGS = 10  # periods
SWING_PARTS, TOP_PARTS = (20, 100), (20, 100, 1000)  # steps per period
TOP_SPAN = 200.0  # s


def fall_time() -> float:
    """When a pendulum u'' + sin u = 0, released at rest at the double nearest pi, is AWAY (rad) from pi, s.

    It starts at delta = 1.22e-16 from the top, and with sin(angle/2) = sin(delta/2) cosh(w) its energy integral is
    t = integral of 1/sqrt(1 - sin^2(delta/2) cosh^2 w), to w = acosh(sin(AWAY/2)/sin(delta/2)): about ln(2 AWAY/delta).
    """
    small = math.sin(math.sin(math.pi) / 2)  # sin(math.pi) is by how much the double math.pi falls short of pi
    end = math.acosh(math.sin(AWAY / 2) / small)
    x, weights = np.polynomial.legendre.leggauss(200)
    w = end * (x + 1) / 2
    return float(end / 2 * np.sum(weights / np.sqrt(1 - (small * np.cosh(w)) ** 2)))


@dataclass(frozen=True)
class TopRow:
    """When |u - pi| first exceeds 0.1 rad, s, None if not within 200 s; exact: when it does in the exact motion."""

    scheme: str
    h: float
    t: float | None
    exact: float


@dataclass(frozen=True)
class SwingRow:
    """A swing whose exact motion turns back just below the top.

    rotates_at: when the computed one passes the top, None if never; ended_at: when the run ended; in periods.
    """

    scheme: str
    h: float
    rotates_at: float | None
    word: str
    ended_at: float
    max_ratio: float


def separatrix(folder: Path, full: bool = False) -> tuple[list[TopRow], list[SwingRow]]:
    """The pendulum released at the top for 200 s, and the swing that almost reaches it for 10 periods."""
    top, swing, exact = scene("simple_pendulum", u0=math.pi, v0=0.0), scene("simple_pendulum"), fall_time()
    T, falls, swings = period(swing), [], []
    for name in schemes() if full else QUICK:
        s = scheme(name)
        h = T / np.array(TOP_PARTS)
        lanes = march_lanes(top, s, h, whole_steps(TOP_SPAN, h), history=True)
        for step, path in zip(h.tolist(), _paths(lanes), strict=True):
            falls.append(TopRow(name, step, _first(np.abs(path - math.pi) > AWAY, step), exact))
        h = T / np.array(SWING_PARTS)
        lanes = march_lanes(swing, s, h, whole_steps(SWINGS * T, h), history=True)
        outcome = judge(lanes, h, swing.E0)
        runs = zip(h.tolist(), _paths(lanes), outcome.word, outcome.max_ratio.tolist(), strict=True)
        for step, path, word, ratio in runs:
            in_periods = step / T
            over = _first(np.abs(path) > math.pi, in_periods)
            swings.append(SwingRow(name, step, over, WORDS[word], (len(path) - 1) * in_periods, ratio))
    write_rows(folder / "separatrix_top.csv", falls)
    write_rows(folder / "separatrix_swing.csv", swings)
    return falls, swings


def _paths(lanes: Lanes) -> Iterator[Array]:
    """u at every completed step of each lane."""
    return (out[: n + 1, 0, 0] for out, n in zip(lanes.out, lanes.n_done, strict=True))


def _first(holds: NDArray[np.bool_], h: float) -> float | None:
    """The time of the first step at which a condition holds, None if it never does."""
    return float(np.argmax(holds) * h) if holds.any() else None
