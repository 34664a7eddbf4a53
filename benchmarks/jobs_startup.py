"""Time to the first result of a new process: import, caches, compilation."""

import os
import subprocess
import sys
import tempfile
import time
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
OWN_SCHEME = """
from dataclasses import replace
from substep_derive.declare.schemes import ALL
import substep as ss
mine = replace(next(s for s in ALL if s.name == "newmark_bdf2"), name="mine")
ss.scheme(mine).period_error([0.1, 1.0], xi=0.05)
"""
EVERYTHING = """
import substep as ss
linear, pendulum = ss.scene("linear_oscillator", omega=6.28, xi=0.02), ss.scene("elastic_pendulum", EA=1e4)
for name in ss.schemes():
    s = ss.scheme(name)
    for function in (s.spectral_radius, s.numerical_damping, s.period_error, s.amplitude_error, s.amplification):
        function(0.1, xi=0.05)
    for scene in (linear, pendulum):
        try:
            ss.march(scene, s, dt=0.01, t_end=0.1)
        except ValueError:  # the scheme is not for this scene
            pass
"""


def job(quick: bool, full: bool = False) -> Job:
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
    if not quick:
        found.notes.append(
            f"A scheme of one's own, derived, compiled and asked, nothing cached: {_cold(OWN_SCHEME):.1f} s."
        )
    if full:
        found.notes.append(f"The whole committed set, compiled from nothing: {_cold(EVERYTHING):.0f} s.")
    else:
        found.skipped["compile time of the committed set"] = "minutes: only with --full"
    return found


def first_call(before: str, call: str, repeats: int) -> list[float]:
    """CPU seconds of a call, after the lines `before`, each time in a new process whose caches are filled."""
    timed = f"{before}\nimport time; began = time.process_time()\n{call}\nprint(time.process_time() - began)"
    command = [sys.executable, "-c", timed]
    runs = [subprocess.run(command, capture_output=True, text=True, check=True) for _ in range(repeats + 1)]
    return [float(run.stdout) for run in runs[1:]]  # the first may have filled them


def _cold(code: str) -> float:
    """Wall-clock seconds of a process whose caches are empty."""
    with tempfile.TemporaryDirectory() as folder:
        private = Path(folder) / "substep"
        private.mkdir(mode=0o700)
        return _process(code, {"NUMBA_CACHE_DIR": f"{folder}/numba", "SUBSTEP_CACHE": str(private)})[0]


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
