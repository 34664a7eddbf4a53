"""An elastic bar falls on a floor: how much energy each scheme gains there, under each law of contact.

The benchmark of Doyen, Ern & Piperno (SIAM J. Sci. Comput. 33, 2011, 223): a bar of length 10, E = 900, rho = 1, with
lumped masses, falls with the velocity 10 and meets the floor after 0.5 s. It is in contact for 2/3 s, with the pressure
300, and leaves as it came, with the energy 500. Under gravity, 10, it falls from rest and meets the floor after 1 s
with the same velocity; the pressure is 300 t up to 5/3 s, from 11/3 to 13/3 s it is 500 - 300 (t - 11/3), and after
16/3 s the bar is back. What a scheme makes of that depends on the phase of the impact in the step, so that every figure
is taken over phases.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from math import ceil
from typing import Any

import numpy as np
from scipy import sparse

from ...core.laws import law as material
from ...core.schemes import Array, Scheme, scheme, schemes
from ...marching.run import marched
from ...structures.model.redistributed_mass import redistributed_mass
from ...structures.structure import Structure, structure
from .outcomes import QUICK

LAWS: dict[str, dict[str, Any]] = {  # arguments of `structure`
    "impulse": {},
    "remembered": {"remembered": True},
    "restitution 0": {"restitution": 0.0},
    "restitution 1": {"restitution": 1.0},
    "massless node": {"remembered": True},
    "penalty": {},  # no contact, but a spring
}
PENALTY = 1.0  # the stiffness of that spring, of an element's, E/l: Chouly & Hild (Appl. Numer. Math. 65, 2013, 27)
COURANT = (0.5, 0.9, 2.0)  # the step times the velocity of sound over the length of an element
GRAVITY = (0.0, 10.0)
LENGTH, SOUND, SPEED, GAP = 10.0, 30.0, 10.0, 5.0
PRESSURE = 300.0  # at the impact, in the exact motion
SPAN, PERIOD = 1.25, 16.0 / 3.0  # s, of a run without gravity, and with it
HELD = 0.05, 0.6  # s after the first impact, from and to when the pressure is looked at
GAINS = 1e-6  # of E0: what is less is rounding
QUICK_SIZE, FULL_SIZE, FULL_BOUNCES = (12, 32), (100, 32), (50, 32)  # elements and phases; the last under gravity


@dataclass(frozen=True)
class BarRow:
    """What becomes of the bar at all phases of the first impact, under one scheme and law, at one Courant number.

    gravity: 0 or 10. failed: the share of phases whose run did not reach its end; of the others: gain, how far the
    energy exceeds that at the start at any time, relative to it, the worst of all phases; gain_at_end: the same once
    the bar has left; share: of phases whose gain exceeds 1e-6; loss: what is missing at the end, the mean over phases;
    pressure: 300 and the mean of what it differs by from the exact motion, 0.05 to 0.6 s after the first impact;
    scatter: the standard deviation of that, the worst of all phases; entered: how far the node is below the floor at
    the end of any step, at most. All are None where no run was made, and refused says why, or none reached its end.
    """

    scheme: str
    law: str
    courant: float
    elements: int
    phases: int
    gravity: float
    failed: float | None = None
    gain: float | None = None
    gain_at_end: float | None = None
    share: float | None = None
    loss: float | None = None
    pressure: float | None = None
    scatter: float | None = None
    entered: float | None = None
    refused: str = ""

    @property
    def safe(self) -> bool:
        """Whether all phases reached their end without a gain."""
        return self.failed == 0.0 and self.share == 0.0


def bars(law: str, n: int, gaps: Array, gravity: float = 0.0) -> Structure:
    """Bars of n elements beside each other in one structure, each with its gap (P,), u by bar and then by node."""
    mass = np.r_[0.5, np.ones(n - 1), 0.5] * LENGTH / n
    if law == "massless node":
        line = np.column_stack([np.ones(n + 1), np.linspace(0.0, LENGTH, n + 1)])
        mass = redistributed_mass(np.diag(mass), [0], line).diagonal()
    P, k = len(gaps), SOUND**2 * n / LENGTH
    along, beside = np.r_[k, np.full(n - 1, 2 * k), k], np.r_[np.full(n, -k), 0.0]
    off = np.tile(beside, P)[:-1]
    K = sparse.diags_array((np.tile(along, P), off, off), offsets=(0, 1, -1)).tocsr()
    mass = np.tile(mass, P)
    given: dict[str, Any] = {"v0": -SPEED} if gravity == 0.0 else {"load": (-gravity * mass, np.ones_like)}
    nodes = np.arange(P) * (n + 1)
    if law == "penalty":
        stops = (material("slip", stiffness=PENALTY * k, q_y=1e300, gap=float(gap)) for gap in gaps)
        given["springs"] = [({int(node): -1.0}, stop) for node, stop in zip(nodes, stops, strict=True)]
    else:
        first = np.zeros((P, len(mass)))
        first[np.arange(P), nodes] = 1.0
        given["contacts"] = {"floor": (first, gaps)}
    return structure(sparse.diags_array(mass).tocsr(), K, **given, **LAWS[law])


def fall(s: Scheme, law: str, courant: float, n: int, gaps: Array, gravity: float = 0.0) -> Array:
    """Energy, pressure and gap (3, P, T) of bars of n elements; NaN after a run has failed.

    The pressure is the mean of each step, under the penalty that at its end, and the energy is that above the floor.
    All bars march at once, in a tenth of the time that they take one by one. Where one fails, each marches alone.
    """
    h = courant * LENGTH / n / SOUND
    steps, P = ceil((PERIOD if gravity else SPAN) / h), len(gaps)
    falling = bars(law, n, gaps, gravity)
    r = marched(falling, s, h, steps * h, of_structure={"account": False})
    if r.status != "completed" and P > 1:
        return np.concatenate([fall(s, law, courant, n, gap[None], gravity) for gap in gaps], axis=1)
    mass, k = falling.M.diagonal()[: n + 1], SOUND**2 * n / LENGTH
    u, v = (x.reshape(len(r.t), P, n + 1) for x in (r.u, r.v))
    energy = 0.5 * (v**2 @ mass + k * (np.diff(u) ** 2).sum(axis=2)) + gravity * (u @ mass + mass.sum() * gaps)
    gap = gaps + u[:, :, 0]
    if law == "penalty":
        pressure = PENALTY * k * np.maximum(-gap, 0.0)
        energy += pressure**2 / (2.0 * PENALTY * k)
    else:
        pressure = r.memory["floor"].reshape(len(r.t), P)
    found = np.full((3, P, steps + 1), np.nan)
    found[:, :, : len(r.t)] = energy.T, pressure.T, gap.T
    return found


@cache
def _why_not(s: Scheme, law: str) -> str:
    """Why a scheme is not for the bar under a law; nothing where it is."""
    try:
        marched(bars(law, QUICK_SIZE[0], np.array([GAP])), s, 1e-3, 2e-3)
    except ValueError as error:
        return str(error)
    return ""


@cache
def _longest(s: Scheme, n: int, stop: float) -> float:
    """The step, s, below which a scheme is stable on the bar, against a spring of so many elements' stiffness."""
    if s.critical_Omega is None or s.critical_Omega == np.inf:
        return np.inf
    of = bars("impulse", n, np.array([GAP]))
    held = sparse.diags_array(np.r_[stop * SOUND**2 * n / LENGTH, np.zeros(n)])
    return structure(of.M, of.K + held).critical_step(s).dt


def row(s: Scheme, law: str, courant: float, elements: int, phases: int, gravity: float = 0.0) -> BarRow:
    """A row of the map."""
    given = s.name, law, courant, elements, phases, gravity
    h = courant * LENGTH / elements / SOUND
    why, stop = _why_not(s, law), PENALTY if law == "penalty" else 0.0
    if not why and h >= (longest := _longest(s, elements, stop)):
        where = "against the spring" if stop else "without a floor"
        why = f"unstable steps of {h:.3g} s on the bar {where}: stable ones are below {longest:.3g} s"
    if why:
        return BarRow(*given, refused=why)
    speed, impact = (SPEED, GAP / SPEED) if gravity == 0.0 else (0.0, SPEED / gravity)
    impact = impact + h * (np.arange(phases) + 0.5) / phases
    found = fall(s, law, courant, elements, impact * (speed + gravity * impact / 2.0), gravity)
    ended = np.isfinite(found[0, :, -1])
    failed = 1.0 - float(ended.mean())
    if not ended.any():
        return BarRow(*given, failed=failed)
    energy, pressure, gap = found[:, ended]
    t = h * np.arange(energy.shape[1])
    since, exact = t - impact[ended, None], SOUND * (speed + gravity * t)
    held = np.where((since > HELD[0]) & (since < HELD[1]), pressure - exact, np.nan)
    gain = energy / energy[:, :1] - 1.0
    worst, end = gain.max(axis=1), gain[:, -1]
    numbers = worst.max(), end.max(), np.mean(worst > GAINS), -end.mean()
    numbers += PRESSURE + np.nanmean(held, axis=1).mean(), np.nanstd(held, axis=1).max(), -gap.min()
    return BarRow(*given, failed, *(float(x) for x in numbers))


def rows_of(law: str, courant: float, gravity: float, full: bool = False) -> list[BarRow]:
    """The rows of one scheme of each kind, or of every scheme, that take some law."""
    size = (FULL_BOUNCES if gravity else FULL_SIZE) if full else QUICK_SIZE
    handles = [scheme(name) for name in (schemes() if full else QUICK)]
    return [row(s, law, courant, *size, gravity) for s in handles if not all(_why_not(s, one) for one in LAWS)]


def by_pair(rows: Iterable[BarRow]) -> dict[tuple[str, str], list[BarRow]]:
    """The rows of each scheme and law, one for each Courant number, without gravity and with it."""
    found: dict[tuple[str, str], list[BarRow]] = {}
    for one in rows:
        found.setdefault((one.scheme, one.law), []).append(one)
    return found


@dataclass(frozen=True)
class Pair:
    """A scheme and a law that never gain; scatter, of 300, and loss, of the energy, the worst of all rows."""

    scheme: str
    law: str
    scatter: float
    loss: float

    @property
    def error(self) -> float:
        """The larger of the two, to four digits behind the point: what is nearer is the same."""
        return round(max(self.scatter, self.loss), 4)


def never_gain(rows: Iterable[BarRow]) -> list[Pair]:
    """Schemes and laws that reach the end at all phases and Courant numbers without a gain, the least error first."""
    found = []
    for (name, law), own in by_pair(rows).items():
        if all(one.safe for one in own):
            scatter, loss = (max(getattr(one, of) for one in own) for of in ("scatter", "loss"))
            found.append(Pair(name, law, scatter / PRESSURE, loss))
    return sorted(found, key=lambda pair: pair.error)
