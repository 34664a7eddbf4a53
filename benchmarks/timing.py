"""Medians of interleaved runs: the alternatives take turns, so that drifts of the machine's speed affect them alike."""

import ctypes
import os
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Kind = Literal["substep", "limit", "peer"]
LEAST = 2e-2  # s, of one sample: a shorter call is repeated within it, after one call that is not timed
SLOW = 0.25  # s: longer calls are sampled once or twice


@dataclass(frozen=True)
class Alternative:
    """One way to do the work. run() does `units` units of it; errors(result) are printed beside the speed."""

    name: str
    kind: Kind
    run: Callable[[], Any]
    units: int
    errors: Callable[[Any], dict[str, float]] = field(default=lambda _: {})


@dataclass(frozen=True)
class Measured:
    """One alternative, measured. samples (rounds,): s a unit, NaN in rounds without a sample; errors by name."""

    name: str
    kind: Kind
    samples: NDArray[np.float64]
    errors: dict[str, float]

    @property
    def seconds(self) -> float:
        """Median time of one unit, s."""
        return float(np.nanmedian(self.samples))

    @property
    def spread(self) -> float:
        """Distance of the quartiles, relative to the median."""
        low, high = np.nanpercentile(self.samples, [25, 75])
        return float((high - low) / self.seconds)


def measure(alternatives: Sequence[Alternative], rounds: int, *, wall: bool = False) -> list[Measured]:
    """Run each alternative once to warm up and for its errors, then all in turn, `rounds` times.

    Times are the process's own, which other programs on the machine do not lengthen; threads add up in it, so measure
    inside `cores(1)`. wall: wall-clock times instead, for work on several cores.
    """
    keep_memory()
    clock = time.perf_counter if wall else time.process_time
    errors, repeats, turns = [], [], []
    for one in alternatives:
        errors.append({name: float(value) for name, value in one.errors(one.run()).items()})
        began = clock()
        one.run()
        took = max(clock() - began, 1e-7)
        repeats.append(max(1, round(LEAST / took)))
        turns.append(rounds if took < SLOW else 2 if took < 4 * SLOW else 1)
    samples = np.full((len(alternatives), rounds), np.nan)
    for turn in range(rounds):
        for k, one in enumerate(alternatives):
            if turn >= turns[k]:
                continue
            if repeats[k] > 1:
                one.run()  # fills the caches with its own data again
            began = clock()
            for _ in range(repeats[k]):
                one.run()
            samples[k, turn] = (clock() - began) / (repeats[k] * one.units)
    return [Measured(one.name, one.kind, samples[k], errors[k]) for k, one in enumerate(alternatives)]


def keep_memory() -> None:
    """Have the C library keep memory that is freed, instead of giving it back to the system.

    Else calls that return arrays would pay for fresh pages at some sizes and not at others, by what was allocated
    before, and C, which writes into arrays that it has, never. Fresh pages have a row of their own among the histories.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)  # of glibc
    if mallopt is not None:
        trim_threshold, mmap_threshold = -1, -3
        mallopt(mmap_threshold, 1 << 25)  # the most it takes
        mallopt(trim_threshold, 1 << 30)


@dataclass(frozen=True)
class Ratio:
    """The ratio of two times in the same rounds: median and quartiles."""

    median: float
    low: float
    high: float


def ratio(slow: Measured, fast: Measured) -> Ratio:
    """The time of `slow` over the time of `fast`, round by round."""
    return quartiles(slow.samples / fast.samples)


def quartiles(values: NDArray[np.float64]) -> Ratio:
    """Median and quartiles of values, NaN left out."""
    median, low, high = np.nanpercentile(values, [50, 25, 75])
    return Ratio(float(median), float(low), float(high))


@contextmanager
def cores(count: int) -> Iterator[None]:
    """Restrict all threads of the process to `count` cores, where the system can pin threads."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    _pin(set(sorted(before)[:count]))
    try:
        yield
    finally:
        _pin(before)


def _pin(chosen: set[int]) -> None:
    for thread in Path("/proc/self/task").iterdir():
        try:
            os.sched_setaffinity(int(thread.name), chosen)
        except ProcessLookupError:  # it ended meanwhile
            continue


def available_cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
