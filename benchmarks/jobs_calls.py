"""What a user calls beside the kernel in it: sweeps, marches under loads, stability at a few points."""

from functools import partial

import numpy as np

import substep as ss
from substep.marching.scene_lanes import march_lanes

from . import ours
from .job import Goal, Job, Table
from .jobs_startup import first_call
from .linear import record, scheme
from .timing import Alternative, cores, measure, quartiles

NAME = "calls"
LANES, STEPS = 300, 100  # values of each of two parameters, and steps of each run, of the sweep of pendulums
FREQUENCIES, LOADED_STEPS = 1000, 1000  # of the sweep over a load's frequency, with two oscillators


def job(quick: bool) -> Job:
    """Each call on the work that its goal names."""
    found = Job(NAME, "What a user calls beside the kernel in it, one core")
    rounds = 3 if quick else 7
    with cores(1):
        _pendulums(found, 100 if quick else LANES, rounds)
        _loads(found, 1 << 16, rounds)
        _load_lanes(found, rounds)
        _few_points(found, rounds)
    _first_spectrum(found, 3 if quick else 5)
    return found


def _pendulums(found: Job, values: int, rounds: int) -> None:
    """A sweep over two parameters of elastic pendulums, which keeps the last state, or peaks."""
    EA, split, dt = np.geomspace(1e4, 1e6, values), np.linspace(0.2, 0.8, values), 0.01
    lanes, work = values * values, values * values * STEPS
    each_EA, each_split = np.repeat(EA, values), np.tile(split, values)
    handle, scene = ss.scheme("newmark_bdf2", gamma_t=each_split), ours.scene_of_lanes("elastic_pendulum", EA=each_EA)
    swept = partial(
        ss.sweep, "elastic_pendulum", "newmark_bdf2", dt=dt, t_end=STEPS * dt, EA=EA, gamma_t=split, progress=False
    )
    kernel = partial(march_lanes, scene, handle, np.full(lanes, dt), np.full(lanes, STEPS))
    rows = [
        Alternative("the sweep", "substep", swept, work),
        Alternative("march of all its lanes", "limit", kernel, work),
        Alternative("the sweep, keep='peak'", "substep", partial(swept, keep="peak"), work),
    ]
    table = Table(f"sweep of {lanes} elastic pendulums, {STEPS} steps", "lane-step", measure(rows, rounds))
    found.tables.append(table)
    found.compare(table, "sweep, keep='final' / the march of its lanes", rows[0].name, rows[1].name, "<=", 1.15)


def _loads(found: Job, n: int, rounds: int) -> None:
    """One oscillator under loads of several kinds, n steps under each."""
    handle, dt = scheme("newmark_bdf2"), 0.01
    loads = {"Record, its own step": (ss.Record(dt, record(n)), dt)}
    for step in (0.005, 0.004, 0.02):
        loads[f"Record sampled at {dt} s, dt = {step} s"] = (ss.Record(dt, record(round(n * step / dt))), step)
    loads["Harmonic"] = (ss.Harmonic(1.0, 5.0), dt)
    rows = []
    for name, (load, step) in loads.items():
        scene = ours.oscillator(6.28, 0.02, load)
        rows.append(Alternative(name, "substep", partial(ss.march, scene, handle, step, n * step), n))
    table = Table("march of one oscillator under a load, with its history", "step", measure(rows, rounds))
    found.tables.append(table)
    for row in rows[1:-1]:
        found.compare(table, f"march, {row.name} / at the record's own step", row.name, rows[0].name, "<=", 2)
    _below(found, table, "march under a Harmonic load, a step", "Harmonic", 15e-9)


def _load_lanes(found: Job, rounds: int) -> None:
    """A sweep over the frequency of a load, whose values are lanes as those of any other parameter."""
    dt, frequencies = 0.01, np.linspace(1.0, 50.0, FREQUENCIES)
    swept = partial(
        ss.sweep, "linear_oscillator", "newmark_bdf2", dt=dt, t_end=LOADED_STEPS * dt, load=ss.Harmonic(1.0, 1.0),
        load_omega=frequencies, scene_omega=np.array([5.0, 20.0]), progress=False,
    )  # fmt: skip
    rows = [Alternative("the sweep", "substep", swept, 2 * FREQUENCIES * LOADED_STEPS)]
    what = f"sweep over {FREQUENCIES} frequencies of a load, 2 oscillators, {LOADED_STEPS} steps"
    table = Table(what, "lane-step", measure(rows, rounds))
    found.tables.append(table)
    _below(found, table, "sweep over a load's frequency, a lane-step", "the sweep", 10e-9)


def _few_points(found: Job, rounds: int) -> None:
    """Stability functions at a single point, and norms of powers at 100."""
    handle, Omega = scheme("newmark_bdf2"), np.linspace(0.1, 10.0, 100)
    rows = [
        Alternative("stability(1.0)", "substep", partial(handle.stability, 1.0), 1),
        Alternative("spectral_radius(1.0)", "substep", partial(handle.spectral_radius, 1.0), 1),
        Alternative("power_norm of 100 points", "substep", partial(handle.power_norm, Omega), 1),
    ]
    table = Table("stability functions at few points", "call", measure(rows, rounds))
    found.tables.append(table)
    _below(found, table, "stability(1.0)", "stability(1.0)", 8e-6)
    _below(found, table, "power_norm of 100 points", "power_norm of 100 points", 20e-3)


def _first_spectrum(found: Job, repeats: int) -> None:
    """The first response spectrum of a process whose caches are filled."""
    times = first_call(
        "import numpy as np, substep as ss; f = np.sin(0.1 * np.arange(4000.0)); f[0] = 0.0",
        "ss.response_spectrum(f, 0.01)",
        repeats,
    )
    _goal(found, "first response_spectrum of a warm process, CPU time", np.array(times), 0.8)


def _below(found: Job, table: Table, text: str, name: str, bound: float) -> None:
    """A goal on the time of a row, in s."""
    row = table.row(name)
    assert row is not None
    _goal(found, text, row.samples, bound)


def _goal(found: Job, text: str, samples: np.ndarray, bound: float) -> None:
    """A goal on the median of some times, in s."""
    times = quartiles(samples)
    found.goals.append(Goal(text, "<=", bound, times.median, times.low, times.high, unit="s"))
