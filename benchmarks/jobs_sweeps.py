"""What a sweep of cheap runs takes besides its kernels, and what a second core brings it."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from types import ModuleType
from typing import Any
from unittest.mock import patch

import numpy as np
import substep_kernels.marches.linear_march_2_01y as linear_kernels
from substep_kernels.shared import formulas as formulas_kernels

import substep as ss
from substep.marching import linear
from substep.marching.scene_lanes import pair_kernels

from .job import Goal, Job, Table
from .timing import Alternative, Ratio, available_cores, cores, keep_memory, measure, quartiles

NAME = "sweeps"
PENDULUM = ss.scene("elastic_pendulum", EA=1e4)
Kernels = Sequence[tuple[ModuleType, str]]


def job(quick: bool) -> Job:
    """Process time of one core for the overhead, wall-clock time for two cores."""
    found = Job(NAME, "Sweeps of many runs: what is not a kernel, and two cores")
    rounds, P = (5, 10**5) if quick else (9, 10**6)
    march = [(linear_kernels, "march_2"), (formulas_kernels, "evaluate")]
    omega, v0 = np.linspace(1.0, 50.0, P), np.linspace(6.0, 8.0, P)
    for n in (100, 500, 2000):
        _overhead(found, f"{P} oscillators of {n} steps", lambda n=n: _oscillators(omega, n), march, rounds)
    pendulums = [(pair_kernels(PENDULUM, ss.scheme("bathe")), "march_block")]
    for n in (100, 300):
        _overhead(found, f"{P} pendulums of {n} steps", lambda n=n: _pendulums(v0, n), pendulums, rounds)
    if available_cores() < 2:
        found.skipped["two cores"] = "this process may use one core only"
        return found
    works = {"oscillators of 2000 steps": lambda: _oscillators(omega, 2000, None)}
    works["pendulums of 300 steps"] = lambda: _pendulums(v0, 300, None)
    for what, run in works.items():
        _two_cores(found, what, run, P, rounds)
    return found


def _oscillators(omega: np.ndarray, n: int, workers: int | None = 1) -> Any:
    given: dict[str, Any] = {"keep": "peak", "workers": workers, "progress": False}
    return ss.sweep("linear_oscillator", "newmark", dt=0.01, t_end=n * 0.01, omega=omega, **given)


def _pendulums(v0: np.ndarray, n: int, workers: int | None = 1) -> Any:
    given: dict[str, Any] = {"keep": "peak", "workers": workers, "progress": False}
    return ss.sweep("elastic_pendulum", "bathe", EA=1e4, dt=0.01, t_end=n * 0.01, v0=v0, **given)


def _overhead(found: Job, what: str, run: Callable[[], Any], kernels: Kernels, rounds: int) -> None:
    """A goal on the process time of a sweep without its kernels, over that of its kernels in the same call."""
    keep_memory()
    run()
    ratios = list[float]()
    for _ in range(rounds):
        with timed(kernels) as inside:
            began = time.process_time()
            run()
            whole = time.process_time() - began
        ratios.append(whole / sum(inside) - 1.0)
    r: Ratio = quartiles(np.array(ratios))
    found.goals.append(Goal(f"{what}: all else over the kernels", "<=", 0.1, r.median, r.low, r.high))


@contextmanager
def timed(kernels: Kernels) -> Iterator[list[float]]:
    """Within it, the process time of each call of these functions of generated modules is added to the list."""
    spent = list[float]()

    def of(kernel: Callable[..., Any]) -> Callable[..., Any]:
        def call(*given: Any) -> Any:
            began = time.process_time()
            result = kernel(*given)
            spent.append(time.process_time() - began)
            return result

        return call

    with ExitStack() as stack:
        for module, name in kernels:
            stack.enter_context(patch.object(module, name, of(getattr(module, name))))
        linear._kernels.cache_clear()  # it keeps functions of the modules
        try:
            yield spent
        finally:
            linear._kernels.cache_clear()


def _two_cores(found: Job, what: str, run: Callable[[], Any], P: int, rounds: int) -> None:
    """A goal on the wall-clock time of one core over that of two, and the share of the thread that shares out work."""

    def pinned() -> Any:
        with cores(1):
            return run()

    rows = [Alternative("one core", "substep", pinned, P), Alternative("two cores", "substep", run, P)]
    table = Table(what, "run", measure(rows, rounds, wall=True))
    found.tables.append(table)
    found.compare(table, f"{what}: two cores against one", "one core", "two cores", ">=", 1.9)
    began = time.process_time(), time.thread_time()
    run()
    whole, alone = time.process_time() - began[0], time.thread_time() - began[1]
    share = alone / whole
    found.notes.append(
        f"{what}: the thread that shares out the work takes {share:.3f} of the process time; if none of it overlapped, "
        f"two cores would be {1.0 / (share + (1.0 - share) / 2.0):.2f} times as fast as one"
    )
