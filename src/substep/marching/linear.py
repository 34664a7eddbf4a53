"""The linear march: one scheme, many oscillators a + 2 xi omega v + omega^2 u = load at once.

It needs no formula of the scheme, only the coefficients D, B, O, P of one step (see `core.coefficients`). A lane is one
run: one oscillator with its step. Lanes are marched side by side in blocks; a lane that overflows is marched once more,
alone, up to the first step that is not finite. A history is u, v, a of every stride-th step; peaks need no history.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import accumulate
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core import coefficients, device, single
from ..core.arrays import Array, product, read_only
from ..core.kernel_modules import committed
from ..core.loads import Load, LoadLanes, Record, values_at
from ..core.response import STATUSES
from ..core.schemes import Scheme
from ..core.threads import spread
from ..derived import modules
from ..run.clock import AT_ZERO, Begin
from ..run.schemes import carried
from .absolute import absolute_rows, with_absolute
from .digital_filter import peaks_from_rest
from .oscillators import Oscillators
from .step_loads import StepLoads

COMPLETED, NON_FINITE = STATUSES.index("completed"), STATUSES.index("non_finite")
NANOSECONDS = 0.25  # for a step of a lane
CHUNK = 32768  # steps of a single lane that are marched at a time: their loads, and rows not asked for, stay near
LOADED, BLOCKS = 128, 4  # steps and blocks that are marched at a time if each lane has its own loads: these stay near


ON_DEVICE = 1 << 16  # lanes, a BLOCKS-th of those that are marched on a device at a time if each has its own loads


@dataclass(frozen=True, eq=False)
class LinearLanes:
    """Results of P runs.

    out (rows, 3, P): u, v, a every stride steps, NaN after n_done; no rows where no history was asked for. peak: the
    largest |u|, |v|, |a| or in its place |2 xi omega v + omega^2 u| (3, P), or |u| (1, P), from t = 0 to n_done; (0, P)
    if a history was asked for. n_done (P,): steps completed. status (P,): index in response.STATUSES. x (m, P): what is
    marched, after the last step; none where peaks were filtered.
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
    begin: Begin = AT_ZERO,
) -> LinearLanes:
    """March n steps of all P oscillators; the scheme's parameters may be arrays (P,).

    begin: where the steps begin, with rows (m, P) of what is marched where the scheme does not start anew.
    load: a function of times of any shape, or LoadLanes; it is divided by the masses. The samples of a Record with a
    sample at each step are not copied. keep: what LinearLanes is to hold; "peak_absolute": the force of spring and
    dashpot over the mass in place of the acceleration, which on a moving ground is the absolute acceleration. out:
    where the history goes, writeable, C-contiguous, of floats and shape (n // stride + 1, 3, P); raises ValueError for
    any other.
    """
    P, rows = len(o.omega), n // stride + 1 if keep == "history" else 0
    followed, absolute = {"history": 0, "peak_u": 1}.get(keep, 3), keep == "peak_absolute"
    done = np.full(P, n), np.full(P, COMPLETED)
    if followed and P and begin is AT_ZERO:
        peak = peaks_from_rest(scheme, o, n, load, followed, absolute)
        if peak is not None and np.isfinite(peak).all():
            return LinearLanes(np.empty((0, 3, P)), peak, *done, np.empty((0, P)))
    x = np.empty((len(coefficients.marched(scheme)), P))
    lanes = LinearLanes(_history(out, (rows, 3, P)), np.zeros((3 if followed else 0, P)), *done, x)
    if rows:
        lanes.out[0] = o.start
    if P == 1:
        _alone(scheme, o, n, load, stride, lanes, 0, absolute, begin)
    elif P and n:
        x[:] = _in_blocks(scheme, o, n, load, stride, lanes, absolute, begin)
        for j in np.flatnonzero(~np.isfinite(x).all(axis=0)):
            _alone(scheme, o, n, load, stride, lanes, int(j), absolute, begin)
    if not followed:
        return lanes
    np.maximum(lanes.peak, np.abs(with_absolute(o, o.start) if absolute else o.start), out=lanes.peak)
    return replace(lanes, peak=lanes.peak[:followed])


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

    march_lanes: Callable[..., None]  # a range of steps of a range of lanes
    march_one: Callable[..., None]  # a range of steps of one lane
    width: int  # lanes of a block, or of a part of those on a device
    C: Array  # coefficients (rows, P)
    x: Array  # what is marched (m, P), at step `first`
    loads: StepLoads
    first: int  # how many steps the starter marched
    head: LinearLanes | None  # results of these first steps, if there is a starter


def prepared(
    scheme: Scheme, o: Oscillators, n: int, load: Load | None, absolute: bool = False, begin: Begin = AT_ZERO
) -> _Run:
    """The kernels and their arrays, ready for the first step that the scheme itself marches."""
    module, Omega, stencil = scheme.kernels, o.omega * o.dt, scheme.stencil()
    excess, head, first = np.zeros(len(Omega)), None, 0
    if begin.rows is None:
        state, head, first = _started(scheme, o, Omega, n, load, begin)
        x = state[list(coefficients.marched(scheme))]
    else:
        state, x = o.start * np.array([np.ones(len(o.dt)), o.dt, o.dt * o.dt]), begin.rows.copy()
    if module.CARRIER:
        excess = _excess(o, Omega, state, load, begin)
    at_ends = stencil.ndim == 1 and not excess.any() and _linear_within_steps(scheme, load, o.dt, n, begin)
    C = _coefficients(scheme, Omega, o, stencil if at_ends else None)
    if at_ends:
        loads = StepLoads(load, np.array([0.0, 1.0]), o.dt, 2, excess, begin, _samples(load, o.dt, n, begin))
    else:
        loads = StepLoads(load, stencil, o.dt, module.LOADS, excess * o.mass / o.dt**2, begin)
    x = np.ascontiguousarray(x)
    shape = module.MARCH
    if absolute:
        shape, absolute_C = absolute_rows(scheme, C, o, loads.K)
        head = head and replace(head, out=with_absolute(o, head.out))
        return _Run(*_here(shape, loads.K), single.rounded(absolute_C), x, loads, first, head)
    return _Run(*_here(shape, loads.K), single.rounded(C), x, loads, first, head)


def _coefficients(scheme: Scheme, Omega: Array, o: Oscillators, stencil: Array | None = None) -> Array:
    """Coefficients (rows, P) as the kernels take them: for loads f, not h^2 f / mass, and for v, a, not h*v, h^2*a.

    The last rows are 1/h and 1/h^2 for those of v, a that are taken from x. With a stencil, the loads are those at the
    two ends of a step, between which the load is linear; without, those at the scheme's own instants.
    """
    m, R, instants = coefficients.sizes(scheme)
    C, D = coefficients.coefficient_rows(scheme, Omega, o.xi), m * m  # D stays as it is, to the last bit
    rest = C[D:]
    if stencil is not None:
        rest = product(_to_ends(m, R, instants, stencil.tobytes()), rest)
    blocks = _factors(m, instants if stencil is None else 2, coefficients.places(scheme))
    h, found = o.dt, np.empty((D + blocks[-1][1], len(o.dt)))
    found[:D], found[D : D + len(rest)], found[D + len(rest) :] = C[:D], rest, 1.0
    scales = 1.0, 1.0 / h, 1.0 / (h * h), h * h / o.mass, h / o.mass, 1.0 / o.mass
    for first, last, kind in blocks:
        if kind:
            found[D + first : D + last] *= scales[kind]
    return found


@cache
def _factors(m: int, K: int, places: tuple[str, ...]) -> list[tuple[int, int, int]]:
    """What the rows of B, O, P, and the scales after them, are multiplied by: 1, 1/h, 1/h^2, h^2/m, h/m or 1/m, 0 to 5.

    Of each block of rows the first, the one after the last, and that number. places: those of u, h*v and h^2*a in x,
    "y" for one that is not in it.
    """
    outputs = [kind for kind, place in enumerate(places) if place == "y"]
    of_y, of_loads = [(kind, m) for kind in outputs], [(3 + kind, K) for kind in outputs]
    scales = [(kind, 1) for kind, place in enumerate(places) if place != "y" and kind > 0]
    sized = [(3, m * K), *of_y, *of_loads, *scales]
    ends = [*accumulate(size for _, size in sized)]
    return [(end - size, end, kind) for end, (kind, size) in zip(ends, sized, strict=True)]


@cache
def _to_ends(m: int, R: int, K: int, stencil: bytes) -> Array:
    """The matrix that turns the rows B, O, P for loads at the stencil into those for loads at the two ends of a step.

    stencil: the instants as bytes of doubles, which the cache can hash.
    """
    share = np.zeros(K)
    share[: len(stencil) // 8] = np.frombuffer(stencil)
    ends = np.stack([1.0 - share, share])
    whole = np.zeros((2 * m + R * m + 2 * R, m * K + R * m + R * K))
    whole[: 2 * m, : m * K] = np.kron(np.eye(m), ends)
    whole[2 * m : (2 + R) * m, m * K : (K + R) * m] = np.eye(R * m)
    whole[(2 + R) * m :, (K + R) * m :] = np.kron(np.eye(R), ends)
    return whole


@cache
def _kernels(name: str, K: int, in_single: bool) -> tuple[Callable[..., None], Callable[..., None], int]:
    """The kernels for many lanes and for one, and how many lanes are in a block: committed, or printed on first use.

    name: of the module, which determines the shape of the march; K: load instants a step; in_single: the precision.
    """
    module = None if in_single else committed(f"marches.{name}")
    if module is None or not hasattr(module, f"march_{K}"):
        module = modules.march_module(name, K, in_single)
    return getattr(module, f"march_{K}"), getattr(module, f"run_{K}"), module.WIDTH


def _here(name: str, K: int) -> tuple[Callable[..., None], Callable[..., None], int]:
    """The same, where many lanes are threads of a GPU if that is asked for; the CPU is faster at one."""
    many, one, width = _kernels(name, K, single.is_on())
    return (device.march_of_shape(name, K), one, ON_DEVICE) if device.is_on() else (many, one, width)


def _started(
    scheme: Scheme, o: Oscillators, Omega: Array, n: int, load: Load | None, begin: Begin
) -> tuple[Array, LinearLanes | None, int]:
    """The scheme's state (s, P) at its first own step; the starter's results, if there is one, and steps."""
    units = np.array([np.ones(len(o.dt)), o.dt, o.dt * o.dt])
    given = o.start * units
    if scheme.info.start == "given":
        return given[[kind for kind, _ in scheme.history]], None, 0
    if scheme.info.start == "function":
        S, T = coefficients.start_coefficients(scheme, Omega, o.xi)
        at_start = begin.origin + (begin.first + np.array(scheme.kernels.START_STENCIL)[:, None]) * o.dt
        forces = o.dt**2 / o.mass * (values_at(load, at_start) if load else np.zeros_like(at_start))
        return np.einsum("pmk,kp->mp", S, given) + np.einsum("pmk,kp->mp", T, forces), None, 0
    assert scheme.starter is not None
    first = min(scheme.starting_steps, n)
    head = march_linear(scheme.starter, o, first, load, begin=begin)
    return carried(scheme.history, first, lambda k, kind: head.out[k, kind] * units[kind]), head, first


def _excess(o: Oscillators, Omega: Array, state: Array, load: Load | None, begin: Begin) -> Array:
    """h^2 (a + 2 xi omega v + omega^2 u - load) at the start (P,): 0 where the given acceleration is consistent.

    A value below 1e-15 of the sum of the terms' moduli is rounding, and counts as 0; where the march goes on, below
    1e-9, since the acceleration is then the rounded one of a step, which is consistent unless the load, or the
    oscillator, has become another.
    """
    rounding = 1e-15 if begin.rows is None else 1e-9
    value: Array | float = 0.0
    if isinstance(load, Record) and begin is AT_ZERO:
        value = load.samples[0]
    elif load is not None:
        value = values_at(load, np.zeros(1) if begin is AT_ZERO else begin.origin + begin.first * o.dt)
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
    if not isinstance(load, Record) or begin.origin or not scheme.loaded_within or not (dt == dt[0]).all():
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


def _in_blocks(
    scheme: Scheme,
    o: Oscillators,
    n: int,
    load: Load | None,
    stride: int,
    lanes: LinearLanes,
    absolute: bool,
    begin: Begin,
) -> Array:
    """March all lanes side by side into `lanes`; returns their last state (m, P)."""
    r, P = prepared(scheme, o, n, load, absolute, begin), len(o.omega)
    K, loads, shared = r.loads.K, r.loads, (read_only(np.empty(0)),) * r.loads.K
    if loads.shared:
        shared, loaded, together, most = loads.of_all(0, n), 0, P, n
    else:
        loads, loaded, together, most = loads.beforehand(n), LOADED, r.width * BLOCKS, LOADED
    shared = tuple(map(single.rounded, shared))

    def part(first: int, last: int) -> None:
        for lane in range(first, last, together):
            some = slice(lane, min(lane + together, last))
            room = np.zeros((K, loaded, some.stop - some.start))
            for done, end, base, pace in pieces(r.first, n, stride if len(lanes.out) else n, most):
                if loaded:
                    loads.of_each(base, end, some, room)
                before = lanes.peak[:, some].copy()
                r.march_lanes(
                    r.C, r.x, *(f[base:end] for f in shared), room, done - base, end - base, pace,
                    lanes.out[done // stride :], lanes.peak, some.start, some.stop,
                )  # fmt: skip
                np.maximum(lanes.peak[:, some], before, out=lanes.peak[:, some])

    nanoseconds = 0.0 if device.is_on() else P * n * NANOSECONDS  # one thread of the CPU serves a device
    spread(part, P, r.width if r.loads.shared else together, nanoseconds=nanoseconds)
    if r.head is not None:
        _rows_of_head(r, stride, lanes, slice(None))
    return r.x


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


def _rows_of_head(r: _Run, stride: int, lanes: LinearLanes, j: slice) -> None:
    """Put the starter's results into the rows and peaks of the lanes j."""
    assert r.head is not None
    if len(lanes.out):
        kept = r.head.out[::stride]
        lanes.out[: len(kept), :, j] = kept
    if lanes.peak.size:
        lanes.peak[:, j] = np.fmax(lanes.peak[:, j], np.abs(r.head.out).max(axis=0))


def _alone(
    scheme: Scheme,
    o: Oscillators,
    n: int,
    load: Load | None,
    stride: int,
    lanes: LinearLanes,
    j: int,
    absolute: bool,
    begin: Begin,
) -> None:
    """March lane j alone, up to the first step that is not finite, into its place of the results."""
    if begin.rows is not None:
        begin = begin._replace(rows=begin.rows[:, j : j + 1])
    r = prepared(scheme.lane(j), o.lane(j), n, load.lane(j) if isinstance(load, LoadLanes) else load, absolute, begin)
    if lanes.peak.size:
        lanes.peak[:, j] = 0.0
    if r.head is not None:
        _rows_of_head(r, stride, lanes, slice(j, j + 1))
        lanes.n_done[j], lanes.status[j] = r.head.n_done[0], r.head.status[0]
    direct = stride == 1 and lanes.out.shape[2] == 1 and len(lanes.out) > 0
    done, x, C = r.first, single.rounded(r.x[:, 0].copy()), r.C[:, 0].copy()
    most = n if direct and r.loads.at_hand else min(n, CHUNK)
    room = np.empty((0 if direct else most, 3))
    while done < n and lanes.status[j] == COMPLETED:
        end = min(n, done + most)
        rows = lanes.out[done + 1 : end + 1, :, 0] if direct else room[: end - done]
        r.march_one(C, x, *map(single.rounded, r.loads.of_all(done, end)), rows)
        lanes.n_done[j] = end
        if not all(map(math.isfinite, rows[-1].tolist())):
            good = int(np.argmin(np.isfinite(rows).all(axis=1)))
            lanes.n_done[j], lanes.status[j], rows = done + good, NON_FINITE, rows[:good]
        if lanes.peak.size and len(rows):
            lanes.peak[:, j] = np.maximum(lanes.peak[:, j], np.abs(rows).max(axis=0))
        if not direct:
            at = np.arange(-(-(done + 1) // stride), (done + len(rows)) // stride + 1)
            lanes.out[at[: len(lanes.out)], :, j] = rows[at * stride - done - 1] if len(lanes.out) else 0.0
        done = end
    lanes.x[:, j] = x
    if lanes.n_done[j] < n:
        lanes.out[lanes.n_done[j] // stride + 1 :, :, j] = np.nan
