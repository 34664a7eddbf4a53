"""Error over cost, log-log: every scheme on one scene, and general ODE solvers beside them."""

import csv
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...core.scenes import scene
from ...core.schemes import scheme, schemes
from ...derived import facade
from ...figures.charts import COLOURS, REFERENCE, look, save
from ...marching.scene_lanes import march_kernels
from .cases import Case
from .measure import LONG, Run
from .reference import Reference

SECTION = "Speed against accuracy"
KNOWN = 1e-14  # an error of the reference that does not show
TOP = 1.0  # an error of everything there is: what lies beyond, or failed, is marked at this edge
COSTS: Mapping[str, Callable[[Run], float]] = {
    "linear or Newton solves": lambda run: run.cost.solves,
    "force and tangent evaluations": lambda run: run.cost.evaluations,
    "time (ms)": lambda run: 1e3 * run.seconds,
}
SHOWN = {"u": "displacement", "v": "velocity", "a": "acceleration", "energy": "energy"}
STATISTICS = {"final": "at the end", "maximum": "largest", "rms": "root mean square"}


def kinds() -> dict[str, list[str]]:
    """All schemes by what a step is: derived from their kernels and states."""
    found: dict[str, list[str]] = {"explicit": [], "one solve a step": [], "several steps": [], "sub-steps": []}
    where = scene("elastic_pendulum", EA=1e4)
    for name in schemes():
        s = scheme(name)
        implicit = len(march_kernels(where, s).OPERATIONS["iteration"])
        several = any(lag for _, lag in s.history)
        kind = (
            "explicit" if implicit == 0 else
            "sub-steps" if implicit > 1 else
            "several steps" if several else "one solve a step"
        )  # fmt: skip
        found[kind].append(name)
    return found


def order(name: str) -> int:
    """Of u, derived, at the scheme's default parameters."""
    return facade.order(name)[0]


def by_method(runs: Iterable[Run]) -> dict[str, list[Run]]:
    """Runs of each method, in the order of their steps."""
    found: dict[str, list[Run]] = {}
    for run in runs:
        found.setdefault(run.method, []).append(run)
    return found


def work_precision(
    case: Case, exact: Reference, runs: Sequence[Run], peers: Sequence[Run], missing: Mapping[str, str], folder: Path
) -> None:
    """Both charts of a scene, as PNG and SVG, and all numbers as CSV; missing: peers that are not installed."""
    _costs(case, exact, runs, peers, missing, folder)
    _quantities(case, exact, runs, folder)
    write(folder / f"work_precision_{case.name}.csv", [*runs, *peers])


def write(path: Path, runs: Sequence[Run]) -> None:
    """All runs, a row each."""
    names = [f"{q}_{s}" for q in runs[0].errors for s in STATISTICS]
    header = ["method", "dt_s", "steps", "status", "solves", "evaluations", "operations", "seconds", *names]
    with path.open("w", encoding="utf-8", newline="") as file:
        out = csv.writer(file)
        out.writerow(header)
        for run in runs:
            told = [f"{x:.6g}" for errors in run.errors.values() for x in errors]
            out.writerow([run.method, run.dt, run.steps, run.status, *run.cost, f"{run.seconds:.4g}", *told])


def curve(
    axes: Axes, runs: Sequence[Run], cost: Callable[[Run], float], error: Callable[[Run], float], **style: object
) -> None:
    """One method; runs that failed, or whose error is everything there is, as open marks at the edge."""
    x = np.array([cost(run) for run in runs], dtype=np.float64)
    y = np.array([error(run) for run in runs])
    good = (y < TOP) & (x > 0)
    axes.plot(x[good], np.maximum(y[good], 1e-16), **style)  # pyright: ignore
    lost = (y >= TOP) & (x > 0)
    if not lost.any():
        return
    look_of = {key: style[key] for key in ("color", "zorder", "alpha") if key in style}
    (marks,) = axes.plot(
        x[lost], np.full(lost.sum(), TOP), "o", markersize=4, markerfacecolor="none", clip_on=False, **look_of
    )
    marks.set_in_layout(False)


def _costs(
    case: Case, exact: Reference, runs: Sequence[Run], peers: Sequence[Run], missing: Mapping[str, str], folder: Path
) -> None:
    """The largest error of u over each cost: a row for each kind of scheme, the others in grey."""
    mine, others, groups = by_method(runs), by_method(peers), kinds()
    shown = {kind: [name for name in names if name in mine] for kind, names in groups.items()}
    shown = {kind: names for kind, names in shown.items() if names}
    figure = Figure(figsize=(15, 3.3 * len(shown) + 1.2), layout="constrained")
    room = figure.subplots(len(shown), len(COSTS) + 1, sharex="col", squeeze=False, width_ratios=(1, 1, 1, 0.7))
    grid = room[:, :-1]

    def error(run: Run) -> float:
        return run.errors["u"].maximum

    low = max(1e-13, 0.1 * min(error(run) for run in runs))

    for (*row, beside), (kind, names) in zip(room, shown.items(), strict=True):
        beside.axis("off")
        for axes, cost in zip(row, COSTS.values(), strict=True):
            pieces = [
                [*((cost(r), error(r)) for r in found), (np.nan, np.nan)] for n, found in mine.items() if n not in names
            ]
            axes.plot(*np.array([xy for piece in pieces for xy in piece]).reshape(-1, 2).T, color="0.85", linewidth=0.7)
            for i, name in enumerate(names):
                colour, line = look(i)
                curve(axes, mine[name], cost, error, color=colour, linestyle=line, linewidth=1.5,
                      marker=".", markersize=4, label=name, zorder=3)  # fmt: skip
            for i, (name, found) in enumerate(others.items()):
                curve(axes, found, cost, error, color=REFERENCE, linestyle=":", linewidth=1, marker="xsd^v+"[i % 6],
                      markersize=4, markerfacecolor="none", label=name, zorder=2)  # fmt: skip
            axes.set(xscale="log", yscale="log", ylim=(low, 3))
            axes.grid(visible=True, linewidth=0.3, color="0.85")
            if exact.error > KNOWN:
                axes.axhline(exact.error, color="0.3", linestyle=(0, (1, 2)), linewidth=1)
            for i, p in enumerate(sorted({order(name) for name in names}, reverse=True)):
                slope_triangle(axes, p, low * 10 ** (1.4 + 1.4 * i))
        row[0].set_ylabel(f"{kind}\n\nlargest error of $u$")
        handles, labels = row[1].get_legend_handles_labels()
        beside.legend(handles, labels, loc="center left", fontsize=8, frameon=False)
    for axes, label in zip(grid[-1], COSTS, strict=True):
        axes.set_xlabel(label)
    title = f"{case.title}: error against cost; open marks at the edge: failed, or an error above 100 %"
    absent = f"not installed: {', '.join(missing)}" if missing else ""
    floor = f"dotted: how far {exact.source} itself is off, below which nothing is told" if exact.error > KNOWN else ""
    figure.suptitle("\n".join(line for line in (title, case.note, floor, absent) if line), fontsize=11)
    said = f"{case.title}: the largest error of u, relative to its largest value, over three costs of a run"
    save(
        figure, folder / f"work_precision_{case.name}", SECTION,
        f"""{said}: solves (of a balance by its effective stiffness, or by the mass if explicit), evaluations of force
        and tangent, and time with compilation apart. A row for each kind of scheme, at default parameters, the others
        in grey; a composite is compared at equal work, since its sub-steps count. Triangles have the derived orders,
        which hold with damping and load too: undamped, as here, a scheme may be better. Black: general solvers at
        falling tolerances, until a run takes {LONG:g} s. {_told(case.note, floor, absent)}""",
    )  # fmt: skip


def slope_triangle(axes: Axes, p: int, top: float) -> None:
    """On the left, below top: a slope of the derived order p, 10 times less error for 10^(1/p) times the cost."""
    left, right = axes.get_xlim()
    x, low = left * (right / left) ** 0.06, top / 10
    axes.plot([x, x * 10 ** (1 / p), x, x], [top, low, low, top], color="0.3", linewidth=0.8, scalex=False)
    text = axes.annotate(f"{p}", (x, top / 4), xytext=(-7, -3), textcoords="offset points", fontsize=8, color="0.3")
    text.set_in_layout(False)


def _told(*remarks: str) -> str:
    return " ".join(f"{remark[0].upper()}{remark[1:]}." for remark in remarks if remark)


def _quantities(case: Case, exact: Reference, runs: Sequence[Run], folder: Path) -> None:
    """Errors of u, v, a and the energy, three ways each, over evaluations; colours tell the kind of scheme."""
    mine, groups = by_method(runs), kinds()
    figure = Figure(figsize=(14, 9.5), layout="constrained")
    grid = figure.subplots(len(STATISTICS), len(SHOWN), sharex=True, sharey="col")
    label, cost = list(COSTS.items())[1]
    for axes, title in zip(grid[0], SHOWN.values(), strict=True):
        axes.set_title(title, fontsize=10)
    for row, (statistic, words) in zip(grid, STATISTICS.items(), strict=True):
        for axes, quantity in zip(row, SHOWN, strict=True):

            def error(run: Run, quantity: str = quantity, statistic: str = statistic) -> float:
                return getattr(run.errors[quantity], statistic)

            for i, (kind, names) in enumerate(groups.items()):
                for j, name in enumerate(name for name in names if name in mine):
                    curve(axes, mine[name], cost, error, color=COLOURS[i], linewidth=0.9, alpha=0.8,
                          linestyle=("-", "--", ":", "-.")[i], label=kind if j == 0 else None)  # fmt: skip
            axes.set(xscale="log", yscale="log")
            axes.grid(visible=True, linewidth=0.3, color="0.85")
        row[0].set_ylabel(f"relative error, {words}")
    for axes in grid[-1]:
        axes.set_xlabel(label)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False, fontsize=9)
    figure.suptitle(f"{case.title}: errors of every quantity" + (f"\n{case.note}" if case.note else ""), fontsize=11)
    save(
        figure, folder / f"work_precision_{case.name}_quantities", SECTION,
        f"""{case.title}: errors of displacement, velocity, acceleration and energy (its drift) at the end, the largest,
        and the root of the mean square on a grid of {len(exact.t) - 1} intervals, each relative to the largest value of
        the exact motion, over evaluations of force and tangent. Every scheme, coloured by its kind.
        {_told(case.note)}""",
    )  # fmt: skip
