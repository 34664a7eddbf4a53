"""CPU and wall-clock seconds of the two commands of a fresh clone, installing apart: `make` and `make test`."""

import os
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from .job import Goal, Job, Table
from .timing import Measured

NAME = "commands"
ROOT = Path(__file__).parents[1]
# command, what is installed before it is timed, and the minutes that are asked of CPU and of the clock on the wall
COMMANDS = (("make", "install", 4.0, 2.0), ("make test", ".venv/.tools", 12.0, 8.0))


def job(quick: bool, full: bool = False) -> Job:
    """Each command in the same clone of the last commit, with caches of its own."""
    found = Job(NAME, "The two commands of a fresh clone, installing apart")
    if not full:
        found.skipped["make, make test"] = "minutes: only with --full"
        return found
    with tempfile.TemporaryDirectory() as folder:
        clone = Path(folder) / "clone"
        subprocess.run(["git", "clone", "--quiet", str(ROOT), str(clone)], check=True)
        home = Path(folder) / "home"
        home.mkdir(mode=0o700)
        for command, before, cpu, wall in COMMANDS:
            _timed(["make", before], clone, home)
            busy, waited = _timed(command.split(), clone, home)
            times = {"CPU": busy, "wall": waited}
            rows = [Measured(what, "substep", np.array([seconds]), {}) for what, seconds in times.items()]
            found.tables.append(Table(command, "run", rows))
            found.goals.append(Goal(f"{command}: CPU time", "<=", 60.0 * cpu, busy, unit="s"))
            found.goals.append(Goal(f"{command}: wall-clock time on two cores", "<=", 60.0 * wall, waited, unit="s"))
    return found


def _timed(command: list[str], clone: Path, home: Path) -> tuple[float, float]:
    """Seconds of CPU, of all processes, and of the clock on the wall. Raises CalledProcessError if it fails."""
    before, began = os.times(), time.perf_counter()
    subprocess.run(command, cwd=clone, env={**os.environ, "HOME": str(home)}, check=True, capture_output=True)
    after, waited = os.times(), time.perf_counter() - began
    return after.children_user + after.children_system - before.children_user - before.children_system, waited
