"""Where general high-order solvers overtake second-order schemes, over error, stiffness and number of runs at once."""

import csv
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from ...core.scene_by_name import scene
from ...core.scenes import Scene
from ...core.schemes import Scheme, scheme
from ...core.style import COLOURS, styled
from ...core.threads import at_most
from ...figures.charts import save
from ...marching.scene_lanes import march_lanes
from ..step_counts import SAMPLES
from . import peers as others
from .charts import SECTION, order
from .measure import measure, timed
from .reference import Reference, reference

STIFFNESSES = (1e4, 1e6, 1e8, 1e10)  # EA, N
QUICK = ("noh_bathe", "average_acceleration", "newmark_bdf2", "energy_momentum", "rk4")  # one of each kind
PEERS = ("scipy DOP853", "scipy LSODA", "numbalsoda dop853", "numbalsoda lsoda")  # those that win somewhere
LANES = 96
T_END, FINEST = 10.0, 12
ERRORS = 10.0 ** -np.arange(1.0, 9.5, 0.5)


@dataclass(frozen=True)
class Point:
    """A method on a bar of EA (N): largest error of the angle in rad; s a run, alone and as one of LANES together."""

    EA: float
    method: str
    kind: str
    steps: int
    error: float
    alone: float
    together: float


def points(names: Sequence[str] = QUICK, *, every: int = 2, repeats: int = 3) -> tuple[list[Point], dict[str, str]]:
    """All schemes named and the solvers that are installed, on one core; and which solvers are missing, and why."""
    found: list[Point] = []
    missing: dict[str, str] = {}
    with at_most(1):
        for EA in STIFFNESSES:
            pendulum = scene("elastic_pendulum", EA=EA)
            exact = reference(pendulum, T_END, SAMPLES, 1e-12)
            for name in names:
                found += [_point(exact, scheme(name), SAMPLES << k, repeats) for k in range(0, FINEST + 1, every)]
            general, missing = others.peers(exact, PEERS)
            for peer in general:
                for run in others.runs(exact, peer, every=every, repeats=repeats):
                    error = run.errors["angle"].maximum
                    found.append(Point(EA, run.method, "general solver", 0, error, run.seconds, run.seconds))
    return found, missing


def _point(exact: Reference, s: Scheme, steps: int, repeats: int) -> Point:
    run, pendulum = measure(exact, s, steps, repeats), exact.scene
    p = order(s.name)
    kind = "second order" if p == 2 else "higher order"
    together = _together(pendulum, s, steps, repeats) / LANES if run.status == "completed" else np.inf
    return Point(pendulum.parameters["EA"], s.name, kind, steps, run.errors["angle"].maximum, run.seconds, together)


def _together(pendulum: Scene, s: Scheme, steps: int, repeats: int) -> float:
    """Seconds of LANES runs from start velocities that differ by up to 10 %."""
    zero, v0 = np.zeros((LANES, 2)), pendulum.v0 * np.linspace(0.95, 1.05, LANES)[:, None]
    dt, n = np.full(LANES, T_END / steps), np.full(LANES, steps)
    start = zero + pendulum.u0, v0, zero + pendulum.a0
    march_lanes(pendulum, s, dt, np.minimum(n, 1), start=start)  # compiles
    lanes, seconds = timed(lambda: march_lanes(pendulum, s, dt, n, start=start), repeats)
    return seconds if (lanes.n_done == n).all() else np.inf


def least(found: Sequence[Point], EA: float, kind: str, error: float, together: bool) -> Point | None:
    """The fastest method of a kind whose error is at most the given one; None if there is none."""
    good = [p for p in found if (p.EA, p.kind) == (EA, kind) and p.error <= error]
    return min(good, key=lambda p: time(p, together), default=None)


def overtaken(found: Sequence[Point], EA: float, together: bool) -> float | None:
    """The largest wished error at and below which solvers beat schemes of second order; None if there is none."""
    threshold = None
    for error in ERRORS[::-1]:
        mine, theirs = (least(found, EA, kind, error, together) for kind in ("second order", "general solver"))
        if theirs is None or (mine is not None and time(mine, together) <= time(theirs, together)):
            break
        threshold = float(error)
    return threshold


def time(point: Point, together: bool) -> float:
    """Seconds a run, alone or as one of LANES together."""
    return point.together if together else point.alone


@styled
def chart(found: Sequence[Point], missing: dict[str, str], folder: Path) -> None:
    """Draw the time of a run over the wished error, a panel for each EA; all points as CSV."""
    with (folder / "turning.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([[f.name for f in fields(Point)], *(astuple(p) for p in found)])
    kinds = list(dict.fromkeys(p.kind for p in found))
    handles: list = []
    labels: list = []
    figure = Figure(figsize=(14, 4.8))
    (row,) = figure.subplots(1, len(STIFFNESSES), sharex=True, sharey=True, squeeze=False)
    for axes, EA in zip(row, STIFFNESSES, strict=True):
        for i, kind in enumerate(kinds):
            for together in (False, True) if kind != "general solver" else (False,):
                best = [least(found, EA, kind, e, together) for e in ERRORS]
                y = [np.nan if p is None else 1e3 * time(p, together) for p in best]
                label = f"{kind}, {LANES} runs at once" if together else f"{kind}, one run"
                axes.plot(ERRORS, y, color=COLOURS[i], linestyle="--" if together else "-", marker="so^v"[i],
                          markersize=4, markerfacecolor="none" if together else COLOURS[i], label=label)  # fmt: skip
        axes.set(xscale="log", yscale="log", xlabel="wished error of the angle (rad)")
        thresholds = [overtaken(found, EA, together) for together in (False, True)]
        alone, at_once = (f"{e:.0e} rad" if e else "nowhere" for e in thresholds)
        axes.set_title(
            f"$EA$ = {EA:.0e} N; solvers ahead below:\n{alone} (one run), {at_once} ({LANES} runs)", fontsize=9
        )
        if not handles:
            axes.invert_xaxis()
            axes.set_ylabel("time a run (ms), one core")
            handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5)
    names = dict.fromkeys(p.method for p in found if p.kind == "general solver")
    absent = f"; not installed: {', '.join(missing)}" if missing else ""
    figure.suptitle(
        f"Elastic pendulum, {T_END:g} s: the fastest of each kind\nsolvers: {', '.join(names) or 'none'}{absent}"
    )
    save(
        figure, folder / "turning", SECTION,
        f"""Where general high-order solvers overtake: time a run, on one core, of the fastest method that keeps the
        angle of the elastic pendulum within an error over {T_END:g} s, for four stiffnesses EA. Schemes of second order
        and of higher order, alone and {LANES} runs at once, with start velocities that differ by 10 %; general solvers,
        one run after another. The orders are those with damping: undamped, as here, a scheme may be better.
        Above each panel: the error from which on solvers are faster than schemes of second
        order{absent}.
        """,
    )  # fmt: skip
