"""The linear march: one scheme, many oscillators a + 2 xi omega v + omega^2 u = load at once.

It needs no formula of the scheme, only the coefficients D, B, O, P of one step (see `core.coefficients`). A lane is one
run: one oscillator with its step. Lanes are marched side by side in blocks; a lane that overflows is marched once more,
alone, up to the first step that is not finite. A history is u, v, a of every stride-th step; peaks need no history.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core import coefficients, device, single
from ..core.arrays import Array, alike, read_only, repeated
from ..core.kernel_modules import committed
from ..core.loads import Load, LoadLanes, Record, values_at
from ..core.outcome import STATUSES
from ..core.schemes import Scheme
from ..core.threads import ranges, spread
from ..derived import modules
from ..run.clock import AT_ZERO, Begin
from ..run.schemes import carried
from .absolute import absolute_rows, absolute_shape, with_absolute
from .digital_filter import peaks_from_rest
from .oscillators import Oscillators
from .step_loads import StepLoads

COMPLETED, NON_FINITE = STATUSES.index("completed"), STATUSES.index("non_finite")
NANOSECONDS = 0.25  # for a step of a lane
CHUNK = 32768  # steps of a single lane that are marched at a time: their loads, and rows not asked for, stay near
LOADED, BLOCKS = 128, 4  # steps and blocks that are marched at a time if each lane has its own loads: these stay near
TOGETHER = 192  # blocks whose coefficients are in memory at a time: these stay near
SETTING_UP = 200  # steps of a lane that take as long as its coefficients

ON_DEVICE = 1 << 16  # lanes, a BLOCKS-th of those that are marched on a device at a time if each has its own loads


@dataclass(frozen=True, eq=False)
class LinearLanes:
    """Results of P runs.

    out (rows, 3, P): u, v, a every stride steps, NaN after n_done; no rows where no history was asked for. peak: the
    largest |u|, |v|, |a| or in its place |2 xi omega v + omega^2 u| (3, P), or |u| (1, P), from t = 0 to n_done; (0, P)
    if a history was asked for, or where they are the caller's arrays. n_done (P,): steps completed. status (P,): index
    in response.STATUSES; both are not to be written to. x (m, 1): what a single run marches, after the last step.
    """

    out: Array
    peak: Array
    n_done: NDArray[np.int64]
    status: NDArray[np.int64]
    x: Array


def march_linear(
    scheme: Scheme,
    o: Oscillators,
    n: int,
    load: Load | None = None,
    *,
    stride: int = 1,
    keep: Literal["history", "peak", "peak_u", "peak_absolute"] = "history",
    out: Array | None = None,
    peaks: Sequence[Array] | None = None,
    begin: Begin = AT_ZERO,
    consistent: bool = False,
) -> LinearLanes:
    """March n steps of all P oscillators; the scheme's parameters may be arrays (P,).

    begin: where the steps begin, with rows (m, P) of what is marched where the scheme does not start anew.
    load: a function of times of any shape, or LoadLanes; it is divided by the masses. The samples of a Record with a
    sample at each step are not copied. keep: what LinearLanes is to hold; "peak_absolute": the force of spring and
    dashpot over the mass in place of the acceleration, which on a moving ground is the absolute acceleration. out:
    where the history goes, writeable, C-contiguous, of floats and shape (n // stride + 1, 3, P); raises ValueError for
    any other. peaks: where three peaks go, arrays (P,) such as `out`. consistent: whether the accelerations at the
    start are those of the equation of motion; False has that found out.
    """
    P, rows = len(o.omega), n // stride + 1 if keep == "history" else 0
    followed, absolute = {"history": 0, "peak_u": 1}.get(keep, 3), keep == "peak_absolute"
    done, status = (np.array([x]) if P == 1 else np.broadcast_to(np.int64(x), P) for x in (n, COMPLETED))
    none = np.empty((0, P))
    if followed and P and begin is AT_ZERO:
        peak = peaks_from_rest(scheme, o, n, load, followed, absolute, consistent)
        if peak is not None and np.isfinite(peak).all():
            for row, found in zip(peaks or (), peak, strict=bool(peaks)):
                row[:] = found
            return LinearLanes(none[:, None], none if peaks else peak, done, status, none)
    largest = np.empty((3 if followed and not peaks else 0, P))
    rows_kept = _history(out, (rows, 3, P))
    march = _March(scheme, o, n, load, stride, rows_kept, peaks or [*largest], absolute, begin, consistent)
    failed = march.in_blocks() if P > 1 and n else [*range(P)]
    if failed:
        done, status = done.copy(), status.copy()
    x = none
    for j in failed:
        x, done[j], status[j] = march.alone(j)
    return LinearLanes(march.out, largest[:followed], done, status, x)


def _history(out: Array | None, shape: tuple[int, ...]) -> Array:
    """The caller's array, checked, or a new one."""
    if out is None:
        return np.empty(shape)
    if out.shape != shape or out.dtype != np.float64 or not (out.flags.c_contiguous and out.flags.writeable):
        raise ValueError(
            f"expected out to be writeable, C-contiguous, of floats and shape {shape}, got {out.dtype} and shape "
            f"{out.shape}; make it with numpy.empty({shape})"
        )
    return out


class _Run(NamedTuple):
    """The two kernels of a march, and what they take."""

    march_lanes: Callable[..., Any]  # a range of steps of some lanes
    march_one: Callable[..., Any]  # a range of steps of one lane
    width: int  # lanes of a block, or of a part of those on a device
    # of some lanes: coefficients (rows, p), what is marched (m, p) at step `first`, u, v, a at the start (3, p)
    of: Callable[[slice], tuple[Array, Array, Array]]
    loads: StepLoads
    first: int  # how many steps the starter marched
    head: LinearLanes | None  # results of these first steps, if there is a starter


def prepared(
    scheme: Scheme,
    o: Oscillators,
    n: int,
    load: Load | None,
    absolute: bool = False,
    begin: Begin = AT_ZERO,
    consistent: bool = False,
) -> _Run:
    """The kernels and what they take of lanes, ready for the first step that the scheme itself marches."""
    module, stencil, marched = scheme.kernels, scheme.stencil(), coefficients.marched(scheme)
    excess, head, first, kinds = repeated(0.0, len(o.omega)), None, 0, [kind for kind, _ in scheme.history]
    if begin.rows is not None:
        state, carried_rows = None, begin.rows
    elif scheme.info.start == "given":
        state, carried_rows = None, None
    else:
        state, head, first = _started(scheme, o, n, load, begin, consistent)
        carried_rows = state[list(marched)]
    if module.CARRIER and not consistent:
        excess = _excess(o, state if state is not None else _in_steps(o, range(3)), load, begin)
    if inconsistent := excess.strides != (0,) and bool(excess.any()):
        excess = excess * o.mass / o.dt**2
    at_ends = stencil.ndim == 1 and not inconsistent and _linear_within_steps(scheme, load, o.dt, n, begin)
    if at_ends:
        loads = StepLoads(load, np.array([0.0, 1.0]), o.dt, 2, excess, begin, _samples(load, o.dt, n, begin))
    else:
        loads = StepLoads(load, stencil, o.dt, module.LOADS, excess, begin)
    rounded = single.rounding()
    last = _at_start(load, o, begin) if consistent else o.start[2]
    given = o.omega, o.xi, o.mass, o.dt, o.start[0], o.start[1], repeated(last, len(o.omega))
    own = () if carried_rows is not None else tuple(kinds[k] for k in marched)
    rows = coefficients.march_rows(scheme, given, stencil if at_ends else None, own, consistent)

    def of(lanes: slice) -> tuple[Array, Array, Array]:
        C, x, start = rows(lanes)
        if carried_rows is not None:
            x = np.array(carried_rows[:, lanes], order="C")
        if absolute:
            some = o.lanes(lanes)
            return rounded(absolute_rows(scheme, C, some, loads.K)), x, with_absolute(some, start)
        return rounded(C), x, start

    if absolute:
        head = head and replace(head, out=with_absolute(o, head.out))
    return _Run(*_here(absolute_shape(scheme) if absolute else module.MARCH, loads.K), of, loads, first, head)


def _at_start(load: Load | None, o: Oscillators, begin: Begin) -> Array:
    """The load (1,) or (P,) where the march begins."""
    if isinstance(load, Record) and begin is AT_ZERO:
        return load.samples[:1]
    if load is None:
        return np.zeros(1)
    return values_at(load, np.zeros(1) if begin is AT_ZERO else begin.origin + begin.first * o.dt)


def _in_steps(o: Oscillators, kinds: Sequence[int]) -> Array:
    """Of u, h*v, h^2*a at t = 0 those of these kinds (k, P)."""
    return np.array([o.start[kind] * (1.0, o.dt, o.dt * o.dt)[kind] for kind in kinds])


@cache
def _kernels(name: str, K: int, in_single: bool) -> tuple[Callable[..., Any], Callable[..., Any], int]:
    """The kernels for many lanes and for one, and how many lanes are in a block: committed, or printed on first use.

    name: of the module, which determines the shape of the march; K: load instants a step; in_single: the precision.
    """
    module = None if in_single else committed(f"marches.{name}")
    if module is None or not hasattr(module, f"march_{K}"):
        module = modules.march_module(name, K, in_single)
    return getattr(module, f"march_{K}"), getattr(module, f"run_{K}"), module.WIDTH


def _here(name: str, K: int) -> tuple[Callable[..., Any], Callable[..., Any], int]:
    """The same, where many lanes are threads of a GPU if that is asked for; the CPU is faster at one."""
    many, one, width = _kernels(name, K, single.is_on())
    return (device.march_of_shape(name, K), one, ON_DEVICE) if device.is_on() else (many, one, width)


def _started(
    scheme: Scheme, o: Oscillators, n: int, load: Load | None, begin: Begin, consistent: bool
) -> tuple[Array, LinearLanes | None, int]:
    """The scheme's state (s, P) at its first own step; the starter's results, if there is one, and steps.

    It is for schemes whose state is not that which is given.
    """
    units = np.array([np.ones(len(o.dt)), o.dt, o.dt * o.dt])
    if scheme.info.start == "function":
        S, T = coefficients.start_coefficients(scheme, o.omega * o.dt, o.xi)
        at_start = begin.origin + (begin.first + np.array(scheme.kernels.START_STENCIL)[:, None]) * o.dt
        forces = o.dt**2 / o.mass * (values_at(load, at_start) if load else np.zeros_like(at_start))
        u, v, a = o.start
        if consistent:
            a = _at_start(load, o, begin) / o.mass - o.omega**2 * u - 2.0 * o.xi * o.omega * v
        return np.einsum("pmk,kp->mp", S, np.array([u, v, a]) * units) + np.einsum("pmk,kp->mp", T, forces), None, 0
    assert scheme.starter is not None
    first = min(scheme.starting_steps, n)
    head = march_linear(scheme.starter, o, first, load, begin=begin, consistent=consistent)
    return carried(scheme.history, first, lambda k, kind: head.out[k, kind] * units[kind]), head, first


def _excess(o: Oscillators, state: Array, load: Load | None, begin: Begin) -> Array:
    """h^2 (a + 2 xi omega v + omega^2 u - load) at the start (P,): 0 where the given acceleration is consistent.

    A value below 1e-15 of the sum of the terms' moduli is rounding, and counts as 0; where the march goes on, below
    1e-9, since the acceleration is then the rounded one of a step, which is consistent unless the load, or the
    oscillator, has become another.
    """
    rounding = 1e-15 if begin.rows is None else 1e-9
    value, Omega = _at_start(load, o, begin), o.omega * o.dt
    terms = Omega**2 * state[0], 2 * o.xi * Omega * state[1], state[2], o.dt**2 / o.mass * value
    if len(Omega) == 1:  # numbers, at a fourth of the time
        terms = tuple(float(x[0]) for x in terms)
    spring, dashpot, inertia, force = terms
    excess = spring + dashpot + inertia - force
    size = abs(spring) + abs(dashpot) + abs(inertia) + abs(force)
    return np.where(abs(excess) <= rounding * size, 0.0, excess).reshape(len(Omega))


def _linear_within_steps(scheme: Scheme, load: Load | None, dt: Array, n: int, begin: Begin) -> bool:
    """Whether the load is linear within each step and taken only there, so that its values at the ends determine it.

    So it is for a record with a whole number of steps from sample to sample, and a scheme that takes the load within
    its step.
    """
    if not isinstance(load, Record) or begin.origin or not scheme.loaded_within or not alike(dt):
        return False
    whole, n = round(load.dt / dt[0]), begin.first + n
    if abs(load.dt - whole * dt[0]) * n > 1e-9 * load.dt:  # what a record takes for rounding
        return False
    jumps = (len(load.samples) - 1) * whole < n  # to 0 after the last sample
    return not jumps or bool(np.isin(scheme.stencil(), (0.0, 1.0)).all())


def _samples(load: Load | None, dt: Array, n: int, begin: Begin) -> tuple[Array, Array] | None:
    """Those of a record with a sample at each step, at the start and at the end of the steps, without a copy."""
    first, end = begin.first, begin.first + n
    if not isinstance(load, Record) or load.dt != dt[0] or len(load.samples) <= end:
        return None
    return load.samples[first:end, None], load.samples[first + 1 : end + 1, None]


def pieces(first: int, n: int, stride: int, most: int) -> Iterator[tuple[int, int, int, int]]:
    """Ranges of the steps first to n - 1: begin, end, and the step from which rows are counted, one every `pace` steps.

    A range has at most `most` steps with those before it from which rows are counted. It ends where a row is, or it has
    none; so a stride longer than `most` is marched in several ranges.
    """
    whole, begin = max(most // stride, 1) * stride, first
    while begin < n:
        end = min(n, begin - begin % whole + whole, begin + most)
        base, pace = (begin - begin % stride, stride) if stride <= most else (begin, end - begin + (end % stride > 0))
        yield begin, end, base, pace
        begin = end


@dataclass(frozen=True, eq=False)
class _March:
    """A march into rows of a history `out`, or into the largest values `peaks` (3, P); see `march_linear`."""

    scheme: Scheme
    o: Oscillators
    n: int
    load: Load | None
    stride: int
    out: Array
    peaks: Sequence[Array]
    absolute: bool
    begin: Begin
    consistent: bool

    def in_blocks(self) -> list[int]:
        """March all lanes side by side; returns those that overflow, to be marched alone."""
        r = prepared(self.scheme, self.o, self.n, self.load, self.absolute, self.begin, self.consistent)
        P, n, stride, out = len(self.o.omega), self.n, self.stride, self.out
        K, loads, shared = r.loads.K, r.loads, (read_only(np.empty(0)),) * r.loads.K
        if loads.shared:
            shared, loaded, together, most = loads.of_all(0, n), 0, P, n
        else:
            loads, loaded, together, most = loads.beforehand(n), LOADED, r.width * BLOCKS, LOADED
        shared, peaks, failed = tuple(map(single.rounded, shared)), self.peaks or [np.empty(0)] * 3, list[int]()

        def march(some: slice, C: Array, x: Array, before: Array) -> None:
            room, bad = np.zeros((K, loaded, some.stop - some.start)), 0
            if r.first == n:  # no step is left
                for row, first in zip(self.peaks, before, strict=True):
                    np.abs(first, out=row[some])
            for done, end, base, pace in pieces(r.first, n, stride if len(out) else n, most):
                if loaded:
                    loads.of_each(base, end, some, room)
                each = (f[base:end] for f in shared)
                bad = r.march_lanes(
                    C, x, before, *each, room, done - base, end - base, pace, out[done // stride :], *peaks, some.start
                )  # fmt: skip
                if end < n and self.peaks:
                    before = np.array([row[some] for row in peaks])
            if bad:
                failed.extend((some.start + np.flatnonzero(~np.isfinite(x).all(axis=0))).tolist())

        def part(first: int, last: int) -> None:
            for near in ranges(first, last, r.width * TOGETHER):
                found = r.of(near)
                if len(out):
                    out[0, :, near] = found[2]
                for some in ranges(near.start, near.stop, together):
                    here = slice(some.start - near.start, some.stop - near.start)
                    march(some, *(np.ascontiguousarray(x[:, here]) for x in found))

        # one thread of the CPU serves a device
        nanoseconds = 0.0 if device.is_on() else P * (n + SETTING_UP) * NANOSECONDS
        spread(part, P, r.width if r.loads.shared else together, nanoseconds=nanoseconds)
        if r.head is not None:
            self._rows_of_head(r.head, slice(None))
        return sorted(failed)

    def _rows_of_head(self, head: LinearLanes, lanes: slice) -> None:
        """Put the starter's results into the rows and peaks of some lanes."""
        if len(self.out):
            kept = head.out[:: self.stride]
            self.out[: len(kept), :, lanes] = kept
        for k, row in enumerate(self.peaks):
            row[lanes] = np.fmax(row[lanes], np.abs(head.out[:, k]).max(axis=0))

    def alone(self, j: int) -> tuple[Array, int, int]:
        """March lane j alone, up to the first step that is not finite, into its place of the results.

        Returns what is marched (m, 1), the steps completed and the status.
        """
        begin, load, n, out, stride = self.begin, self.load, self.n, self.out, self.stride
        if begin.rows is not None:
            begin = begin._replace(rows=begin.rows[:, j : j + 1])
        lane, load = slice(j, j + 1), load.lane(j) if isinstance(load, LoadLanes) else load
        r = prepared(self.scheme.lane(j), self.o.lanes(lane), n, load, self.absolute, begin, self.consistent)
        done, status, made = r.first, COMPLETED, n
        C, x, start = (y[:, 0].copy() for y in r.of(slice(0, 1)))
        for row, first in zip(self.peaks, start, strict=bool(self.peaks)):
            row[j] = abs(first)
        if len(out):
            out[0, :, j] = start
        if r.head is not None:
            self._rows_of_head(r.head, lane)
            status, made = int(r.head.status[0]), n if r.head.status[0] == COMPLETED else int(r.head.n_done[0])
        direct = stride == 1 and out.shape[2] == 1 and len(out) > 0
        x = single.rounded(x)
        most = n if direct and r.loads.at_hand else min(n, CHUNK)
        room = np.empty((0 if direct else most, 3))
        while done < n and status == COMPLETED:
            end = min(n, done + most)
            rows = out[done + 1 : end + 1, :, 0] if direct else room[: end - done]
            r.march_one(C, x, *map(single.rounded, r.loads.of_all(done, end)), rows)
            made = end
            if not all(map(math.isfinite, rows[-1].tolist())):
                good = int(np.argmin(np.isfinite(rows).all(axis=1)))
                made, status, rows = done + good, NON_FINITE, rows[:good]
            for k, row in enumerate(self.peaks if len(rows) else ()):
                row[j] = max(row[j], np.abs(rows[:, k]).max())
            if not direct:
                at = np.arange(-(-(done + 1) // stride), (done + len(rows)) // stride + 1)
                out[at[: len(out)], :, j] = rows[at * stride - done - 1] if len(out) else 0.0
            done = end
        if made < n:
            out[made // stride + 1 :, :, j] = np.nan
        return x[:, None], made, status
