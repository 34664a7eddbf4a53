"""Yielding oscillators under a record, as lanes of one march: peaks of many strengths, and all that one demands."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Array
from ..core.loads import Record
from ..core.outcome import STATUSES
from ..core.scene_catalogue import WITH_LAW, checked_parameters, scene_info
from ..core.scenes import make_scene
from ..core.schemes import Scheme
from ..marching.scene_lanes import Lanes, Reader, march_lanes
from .peaks import refined

RESTING = ("bilinear", "isotropic_bilinear")  # laws that are elastic about a plastic part p, the first of their memory
LAWS = (*RESTING, "clough")  # elastic until they yield
COMPLETED = STATUSES.index("completed")
ROUNDING = 1e-9  # of the yield displacement: a smaller change of the plastic part in a step is none
AT_REST = 1e-4  # of the yield displacement, by which a free vibration may exceed what yields no more
LONGEST = 256.0  # periods of free vibration, at most, in which an oscillator comes to rest


class Yielding(NamedTuple):
    """P oscillators per unit mass: omega (P,), rad/s, xi and strength, m/s^2, likewise; of one law and hardening."""

    omega: Array
    xi: Array
    strength: Array
    hardening: float
    law: str

    @property
    def yield_displacement(self) -> Array:
        """The displacement (P,), m, at which each first yields."""
        return self.strength / self.omega**2

    def some(self, where: NDArray[np.bool_] | NDArray[np.int64]) -> "Yielding":
        """Some of the oscillators."""
        return self._replace(omega=self.omega[where], xi=self.xi[where], strength=self.strength[where])


class Demand(NamedTuple):
    """What a record demands of P oscillators, NaN where the march fails.

    peak: largest |u| at the samples, m; residual: the displacement at which each comes to rest after the record, m, NaN
    where it does not, as of laws that are not RESTING; energy: what yielding dissipated during the record, per unit
    mass, J/kg; excursions: how often it began to yield.
    """

    peak: Array
    residual: Array
    energy: Array
    excursions: Array


def peaks(s: Scheme, o: Yielding, load: Record) -> Array:
    """The largest |u| (P,), m, at the samples; NaN where the march fails."""
    lanes = _march(s, o, load, 1, np.zeros(len(o.omega), np.int64), extremes="u")
    return np.where(lanes.status == COMPLETED, lanes.extremes[:, 0, 0], np.nan)


def demands(s: Scheme, o: Yielding, load: Record, times: int = 1) -> Demand:
    """All that the record demands, by the scheme with so many steps from sample to sample; values at the samples."""
    P = len(o.omega)
    found, ends, u_y = Demand(*np.full((4, P), np.nan)), np.full((4, P), np.nan), o.yield_displacement

    def read(where: slice, out: Array, memory: Array) -> None:
        u = out[:, :, 0, 0]  # what is remembered ends with the energy lost
        plastic = memory[:, :, 0] if o.law in RESTING else memory[:, :, 2] + memory[:, :, 3]  # of clough both peaks
        way = np.sign(np.where(np.abs(flow := np.diff(plastic)) > ROUNDING * u_y[where, None], flow, 0.0))
        before = np.pad(way, ((0, 0), (1, 0)))[:, :-1]
        found.peak[where] = np.abs(u).max(axis=1)
        begins = (way != 0.0) & (way != before)
        found.excursions[where] = begins.sum(axis=1)
        found.energy[where] = np.where(begins.any(axis=1), memory[:, -1, -1], 0.0)  # else rounding alone
        ends[:, where] = out[:, -1, 0, 0], out[:, -1, 1, 0], *memory[:, -1, :2].T

    lanes = _march(s, o, load, times, np.zeros(P, np.int64), read)
    if o.law in RESTING:
        found.residual[:] = _at_rest(s, o, load, times, ends)
    for values in found:
        values[lanes.status != COMPLETED] = np.nan
    return found


def _at_rest(s: Scheme, o: Yielding, load: Record, times: int, ends: Array) -> Array:
    """The displacement (P,) at which oscillators come to rest after the record.

    ends (4, P): u, v and the first two things that are remembered at the record's end, of a law that is RESTING.
    Where the free vibration can still yield it is marched, in runs of 1, 4, 16, ... periods from the record's end.
    """
    todo, periods = np.flatnonzero(~_yields_no_more(o, ends)), 1.0
    while len(todo) and periods <= LONGEST:
        some = o.some(todo)
        more = np.ceil(periods * 2.0 * np.pi / some.omega / load.dt).astype(np.int64)
        last = len(load.samples) - 1 + more
        rows = ends[:, todo]

        def read(where: slice, out: Array, memory: Array, last: NDArray[np.int64] = last, rows: Array = rows) -> None:
            at = np.arange(len(out)), last[where]
            rows[:, where] = out[*at, 0, 0], out[*at, 1, 0], *memory[at][:, :2].T

        _march(s, some, load, times, more, read)
        ends[:, todo] = rows
        todo, periods = todo[~_yields_no_more(some, rows)], 4.0 * periods
    residual = np.where(np.abs(ends[2]) > ROUNDING * o.yield_displacement, _elastic(o, ends)[0], 0.0)
    residual[todo] = np.nan
    return residual


def _yields_no_more(o: Yielding, ends: Array) -> NDArray[np.bool_]:
    """Whether a free vibration from u, v and what is remembered (4, P) stays elastic: its amplitude only falls.

    What is not finite, where a march failed, is not marched on.
    """
    middle, reach = _elastic(o, ends)
    return ~(np.hypot(ends[0] - middle, ends[1] / o.omega) > reach + AT_REST * o.yield_displacement)


def _elastic(o: Yielding, ends: Array) -> tuple[Array, Array]:
    """About which displacement (P,) an elastic oscillator swings, and how far it may do so before it yields.

    By the kinematic law of hardening it yields where u - p leaves the yield displacement, and its force is 0 at
    (1 - hardening)*p; by the isotropic one, whose strength has grown with the sum kappa of p's amounts, at p.
    """
    _, _, p, kappa = ends
    if o.law == "bilinear":
        return (1.0 - o.hardening) * p, o.yield_displacement - o.hardening * np.abs(p)
    return p, o.yield_displacement + o.hardening / (1.0 - o.hardening) * kappa


def _march(
    s: Scheme, o: Yielding, load: Record, times: int, more: NDArray[np.int64], reader: Reader | None = None,
    extremes: str = "",
) -> Lanes:  # fmt: skip
    """March all from rest under the record, and `more` (P,) samples beyond it; the reader has a row for each sample.

    extremes: as of `march_lanes`, at the samples.
    """
    ground, P = refined(Record(load.dt, -load.samples), times), len(o.omega)
    info = scene_info(WITH_LAW, {"law": o.law})
    given = {"omega": o.omega, "xi": o.xi, "strength": o.strength, "hardening": np.full(P, o.hardening)}
    values = checked_parameters(info, given, lambda _, value: np.asarray(value))
    lanes = make_scene(info, values, None, ground)
    n = times * (len(load.samples) - 1 + more)
    return march_lanes(lanes, s, np.full(P, ground.dt), n, stride=times, reader=reader, extremes=extremes)
