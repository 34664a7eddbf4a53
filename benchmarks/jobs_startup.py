"""Time to the first result of a new process: import, caches, compilation."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median

from .job import Goal, Job

NAME = "startup"

FIRST_RESULT = """
import substep as ss
s = ss.scheme("newmark_bdf2", gamma_t=0.2, beta=0.3025, gamma=0.6)
s.period_error([0.1, 1.0], xi=0.05)
ss.march(ss.scene("linear_oscillator", omega=6.28, xi=0.02), s, dt=0.02, t_end=1.0)
"""
PENDULUM = """
import substep as ss
ss.march(ss.scene("elastic_pendulum", EA=1e4), ss.scheme("bathe"), dt=0.01, t_end=1.0)
"""
SHARED = """
import substep as ss
ss.scheme("newmark").spectral_radius(1.0)
"""
OWN_SCHEME = """
from sympy import Interval, Rational, Symbol
from substep_derive import Balance, Parameter, Scheme, h, knot
import substep as ss
gamma, half = Symbol("gamma"), Rational(1, 2)
u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
relations = {
    u1: u0 + h * v0 + h**2 * ((half - gamma**2 / 2) * a0 + gamma**2 / 2 * a1),
    v1: v0 + h * ((1 - gamma) * a0 + gamma * a1),
}
gammas = Parameter(gamma, Interval(half, 2), Rational(3, 5))
mine = ss.scheme(Scheme("mine", relations, (Balance.at(end, 1),), parameters=(gammas,)))
mine.spectral_radius([0.1, 10.0])
"""


def job(quick: bool) -> Job:
    """Wall-clock times of whole processes, with warm caches and with empty ones."""
    found = Job(NAME, "Start-up, whole processes, by the clock on the wall")
    repeats = 3 if quick else 5
    for text, code in (("stability and linear march", FIRST_RESULT), ("pendulum", PENDULUM)):
        _process(code, {})  # fills the caches
        times, busy = zip(*(_process(code, {}) for _ in range(repeats)), strict=True)
        found.goals.append(
            Goal(f"warm start to first result, {text}", "<=", 0.8, median(times), min(times), max(times), unit="s")
        )
        found.notes.append(f"{text}: {median(busy):.2f} s of that on the processor; the rest is waiting.")
    bare = [_process("import numpy, numba", {})[0] for _ in range(repeats)]
    found.notes.append(f"`import numpy, numba` alone takes {median(bare):.2f} s here.")
    own = [_cold(OWN_SCHEME, SHARED) for _ in range(1 if quick else repeats)]
    walls, busy = zip(*own, strict=True)
    found.goals.append(
        Goal(
            "a scheme of one's own, shared kernels compiled: import, derive, compile, rho, CPU time",
            "<=", 2.0, median(busy), min(busy), max(busy), unit="s",
        )
    )  # fmt: skip
    found.notes.append(f"A scheme of one's own takes {median(walls):.1f} s by the clock on the wall.")
    return found


def first_call(before: str, call: str, repeats: int) -> list[float]:
    """CPU seconds of a call, after the lines `before`, each time in a new process whose caches are filled."""
    return [_call(before, call, {}) for _ in range(repeats + 1)][1:]  # the first may have filled them


def compiling(before: str, call: str) -> float:
    """CPU seconds of a call, after the lines `before`, in a new process whose caches are empty."""
    with _no_caches() as more:
        return _call(before, call, more)


def _call(before: str, call: str, more: dict[str, str]) -> float:
    timed = f"{before}\nimport time; began = time.process_time()\n{call}\nprint(time.process_time() - began)"
    command = [sys.executable, "-c", timed]
    return float(subprocess.run(command, capture_output=True, text=True, check=True, env={**os.environ, **more}).stdout)


def _cold(code: str, before: str) -> tuple[float, float]:
    """Seconds of a process as `_process` gives them; its caches hold what the lines `before` have compiled."""
    with _no_caches() as more:
        _process(before, more)
        return _process(code, more)


@contextmanager
def _no_caches() -> Iterator[dict[str, str]]:
    """The environment variables of a process that has nothing compiled."""
    with tempfile.TemporaryDirectory() as folder:
        private = Path(folder) / "substep"
        private.mkdir(mode=0o700)
        yield {"NUMBA_CACHE_DIR": f"{folder}/numba", "SUBSTEP_CACHE": str(private)}


def _process(code: str, more: dict[str, str]) -> tuple[float, float]:
    """Seconds a process takes by the clock on the wall, and on the processor."""
    before, began = os.times(), time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, **more}, capture_output=True, text=True, check=False
    )  # fmt: skip
    wall, after = time.perf_counter() - began, os.times()
    if done.returncode:
        raise RuntimeError(f"a process of the start-up job failed:\n{done.stderr[-2000:]}")
    busy = after.children_user + after.children_system - before.children_user - before.children_system
    return wall, busy
