"""The charts and tables of speed against accuracy that `substep reproduce` writes, as jobs.

A job measures times, so nothing else may run beside it; what it returns draws what it found, in any process.
"""

import csv
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from ...core.errors import unknown_name
from ...core.scene_by_name import scene
from ...core.schemes import scheme, schemes
from ...marching.scene_lanes import pair_kernels
from . import charts, crossover, peers, scene_choice, stiffness, tolerance_runs
from .cases import CASES, EVERY, Case, runs

Drawing = Callable[[], object]

# the quick form takes every second step, few repeats and, for `choose` on the stiff pendulum, these schemes only
FEW = ("central_difference", "average_acceleration", "wilson_theta", "generalized_alpha", "newmark_bdf2", "bathe",
       "energy_momentum", "rk4")  # fmt: skip
GOOD = 1e-4  # the error at which schemes are compared to find those that are drawn in chosen steps too
ACCURACIES = (1e-5, 1e-7)  # rad: a rigid bar suffices for the first


def work_precision(case: Case, folder: Path, *, full: bool) -> Drawing:
    """Measure one scene: all schemes and the general solvers that are installed.

    Of schemes that can choose their steps the quick form takes the one that needs the least work in constant steps,
    since kernels are compiled for it alone.
    """
    every, repeats = (1, 20) if full else (2, 3)
    exact = case.reference()
    general, missing = peers.peers(exact, None if full else (*crossover.PEERS, "scipy Radau"))
    theirs = [run for peer in general for run in peers.runs(exact, peer, every=every, repeats=repeats)]
    constant = runs(case, exact, every=every, repeats=repeats)
    handles = {name: scheme(name) for name in charts.by_method(constant)}
    if full:
        able = [s for s in handles.values() if tolerance_runs.can_choose(s, exact.scene)]
    else:
        tried = [(handles[run.method], run) for run in constant]
        able = tolerance_runs.least(tried, exact.scene, "u", GOOD)
    chosen = [run for s in able for run in tolerance_runs.runs(exact, s, every=every, repeats=repeats)]
    return partial(charts.work_precision, case, exact, constant, chosen, theirs, missing, folder)


def turning_points(folder: Path, *, full: bool) -> Drawing:
    """Measure where general solvers overtake."""
    names = [name for name in schemes() if charts.order(name) >= 2] if full else crossover.QUICK
    found, missing = crossover.points(names, every=1 if full else 2, repeats=20 if full else 3)
    return partial(crossover.chart, found, missing, folder)


def models(folder: Path, *, full: bool) -> Drawing:
    """Measure an elastic bar, a constraint and an angle over the stiffness of one pendulum."""
    found = stiffness.measured([10.0**k for k in range(4, 15, 1 if full else 2)], repeats=20 if full else 3)
    return partial(stiffness.chart, found, folder)


def stiff_pendulum(folder: Path, *, full: bool) -> Drawing:
    """Find what to choose for the stiff pendulum: elastic or rigid bar, scheme, and step or, if full, tol too."""
    among = [scheme(name) for name in (schemes() if full else FEW)]
    stiff = scene("elastic_pendulum", EA=1e10, a0=(-19.6, 0.0))
    chosen = None if full else ()
    found = [
        scene_choice.choose(stiff, a, t_end=10.0, quantity="angle", among=among, chosen=chosen) for a in ACCURACIES
    ]
    return partial(_choices, found, folder)


def _choices(found: Sequence[scene_choice.Choice], folder: Path) -> None:
    """Charts of what was found for each accuracy."""
    for one in found:
        scene_choice.chart(one, folder / f"choose_stiff_pendulum_{one.accuracy:.0e}")


def operations(folder: Path) -> list[tuple[str, int, str, int]]:
    """Table of every scheme's operations a step, and in each Newton iteration, on the elastic and the rigid bar."""
    elastic, rigid = scene("elastic_pendulum", EA=1e10), scene("rigid_pendulum")
    rows = []
    for name in schemes():
        bar, stiff = (pair_kernels(model, scheme(name)).OPERATIONS for model in (elastic, rigid))
        rows.append((name, bar["step"], " + ".join(map(str, bar["iteration"])) or "0", stiff["step"]))
    header = ("scheme", "elastic: a step", "elastic: an iteration of each balance", "rigid: a step")
    with (folder / "operations.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([header, *rows])
    return rows


def cases_named(names: Sequence[str]) -> tuple[Case, ...]:
    """The cases of these names. Raises ValueError for one that there is not."""
    by = {case.name: case for case in EVERY}
    if wrong := next((name for name in names if name not in by), None):
        raise unknown_name("a scene of the work-precision charts", wrong, by)
    return tuple(by[name] for name in names)


def jobs(full: bool) -> tuple[Callable[[Path], Drawing], ...]:
    """All measurements of times, one job each; what each returns draws it."""
    scenes = (partial(work_precision, case, full=full) for case in (EVERY if full else CASES))
    return (*scenes, *(partial(job, full=full) for job in (turning_points, models, stiff_pendulum)))
