"""What a second core brings: the same calls with the process on one core and on two."""

import numpy as np

import substep as ss

from . import jobs_pendulum, jobs_spectrum, jobs_stability, ours
from .job import Job, Table
from .linear import record
from .timing import Alternative, available_cores, cores, measure

NAME = "cores"


def job(quick: bool) -> Job:
    """Marches and stability functions in wall-clock time, which other programs on the machine lengthen."""
    found = Job(NAME, "Two cores against one, by the clock on the wall")
    if available_cores() < 2:
        found.skipped["two cores"] = "this process may use one core only"
        return found
    rounds, n = (5, 1 << 17) if quick else (11, 1 << 20)
    Omega, xi, *parameters = jobs_stability.random_points("newmark_bdf2", n)
    handle = ours.handle("newmark_bdf2", tuple(parameters))
    load, EA = ss.Record(jobs_spectrum.DT, record(4096, jobs_spectrum.DT)), jobs_pendulum.CASES["flexible"][0]
    times = 1 if quick else 8
    omegas, speeds = np.repeat(jobs_spectrum.OMEGAS, 4 * times), np.repeat(jobs_pendulum.V0, times)
    works = {  # the work, its units, what they are, the goal
        "march, response spectrum": (
            lambda: ours.spectrum_peaks("newmark_bdf2", omegas, jobs_spectrum.XI, load),
            4096 * len(omegas), "lane-step", 1.8,
        ),
        "march, pendulum batch": (
            lambda: ours.pendulum_batch("bathe", EA, (0.0, 0.0), speeds, jobs_pendulum.H, 500),
            500 * len(speeds), "lane-step", 1.8,
        ),
        "stability": (lambda: ours.stability(handle, Omega, xi), n, "point", 1.6),
    }  # fmt: skip
    for what, (run, units, unit, bound) in works.items():
        alone = run()
        with cores(1):
            same = run()
        together = Alternative("two cores", "substep", run, units, lambda y, x=same: _differ(x, y))
        table = Table(what, unit, measure([_one_core(run, units, alone), together], rounds, wall=True))
        table.errors = {"cores": "largest difference between the two, which must be 0"}
        found.tables.append(table)
        found.compare(table, f"{what}: two cores against one", "one core", "two cores", ">=", bound)
    return found


def _one_core(run, units: int, alone) -> Alternative:
    def pinned():
        with cores(1):
            return run()

    return Alternative("one core", "substep", pinned, units, lambda x: _differ(x, alone))


def _differ(a, b) -> dict[str, float]:
    pairs = zip(a, b, strict=True) if isinstance(a, tuple) else [(a, b)]
    return {"cores": max(float(np.nanmax(np.abs(x - y), initial=0.0)) for x, y in pairs)}
