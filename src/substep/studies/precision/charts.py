"""Work-precision charts: error over cost of every scheme on one scene, beside general ODE solvers."""

import csv
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...core.schemes import Kind, scheme, schemes
from ...core.style import COLOURS, MOST, REFERENCE, look, styled
from ...derived import facade
from ...figures.charts import save
from .cases import Case
from .measure import LONG, OWN, Run
from .reference import Reference

SECTION = "Speed against accuracy"
KNOWN = 1e-14  # an error of the reference up to this is not marked in a chart
TOP = 1.0  # a relative error of 100 %: runs beyond it, and runs that failed, are marked at this edge
COSTS: Mapping[str, Callable[[Run], float]] = {
    "linear or Newton solves": lambda run: run.cost.solves,
    "force and tangent evaluations": lambda run: run.cost.evaluations,
    "time (ms)": lambda run: 1e3 * run.seconds,
}
SHOWN = {"u": "displacement", "v": "velocity", "a": "acceleration", "energy": "energy"}
SHOWN_CONSTRAINED = {
    "u": "displacement $u$", "v": "velocity $v$", "multipliers": r"multipliers $\lambda$ from $u$ and $v$",
    OWN: r"the scheme's own $\lambda$",
}  # fmt: skip
WHAT = {  # by whether there are constraints
    False: "displacement, velocity, acceleration and energy (its drift)",
    True: "displacement, velocity, the multipliers that follow from these, and those that schemes have solved for",
}
SOLVERS = f"Black: general solvers at falling tolerances, until a run takes {LONG:g} s."
CHOSEN = """Below, dashed: steps that choose themselves, at falling tolerances, beside constant steps of the same
    schemes; a rejected step is counted as an accepted one."""
STATISTICS = {"final": "at the end", "maximum": "largest", "rms": "root mean square"}


def kinds() -> dict[str, list[str]]:
    """All schemes by the kind of their step, which their balances and states show."""
    return {kind: [name for name in schemes() if scheme(name).kind == kind] for kind in get_args(Kind)}


def order(name: str) -> int:
    """Derived order of accuracy of u at the scheme's default parameters."""
    return facade.order(name)[0]


@dataclass(frozen=True)
class Panel:
    """Schemes of one kind that stand together, ascending in order of accuracy."""

    title: str
    names: tuple[str, ...]


def panels(names: Collection[str], most: int) -> tuple[Panel, ...]:
    """Schemes by the kind of their step and by their derived order, at most so many together."""
    found = []
    for kind, members in kinds().items():
        ascending = sorted((name for name in members if name in names), key=order)
        parts = -(-len(ascending) // most)
        for part in np.array_split(np.array(ascending, dtype=object), parts) if parts else ():
            orders = sorted({order(name) for name in part})
            between = f"order {orders[0]}" if len(orders) == 1 else f"orders {orders[0]} to {orders[-1]}"
            found.append(Panel(f"{kind}, {between}", tuple(part)))
    return tuple(found)


def by_method(runs: Iterable[Run]) -> dict[str, list[Run]]:
    """Runs of each method, in the order of their steps."""
    found: dict[str, list[Run]] = {}
    for run in runs:
        found.setdefault(run.method, []).append(run)
    return found


def work_precision(
    case: Case,
    exact: Reference,
    runs: Sequence[Run],
    chosen: Sequence[Run],
    peers: Sequence[Run],
    missing: Mapping[str, str],
    folder: Path,
) -> None:
    """Both charts of a scene, as PNG and SVG, and all numbers as CSV.

    runs: in constant steps; chosen: in chosen steps, of schemes among those of runs; peers: runs of general solvers;
    missing: packages of such solvers that are not installed, and why.
    """
    _costs(case, exact, runs, chosen, peers, missing, folder)
    _quantities(case, exact, runs, chosen, folder)
    write(folder / f"work_precision_{case.name}.csv", [*runs, *chosen, *peers])


def write(path: Path, runs: Sequence[Run]) -> None:
    """All runs, a row each."""
    names = [f"{q}_{s}" for q in runs[0].errors for s in STATISTICS]
    header = ["method", "dt_s", "tol", "steps", "status", "solves", "evaluations", "operations", "seconds", *names]
    with path.open("w", encoding="utf-8", newline="") as file:
        out = csv.writer(file)
        out.writerow(header)
        for run in runs:
            errors = [f"{x:.6g}" for of_quantity in run.errors.values() for x in of_quantity]
            how = [run.method, run.dt, f"{run.tol:.4g}", run.steps, run.status]
            out.writerow([*how, *run.cost, f"{run.seconds:.4g}", *errors])


def curve(
    axes: Axes, runs: Sequence[Run], cost: Callable[[Run], float], error: Callable[[Run], float], **style: object
) -> None:
    """Draw one method; runs that failed or have an error above 100 % are open marks at the edge."""
    x = np.array([cost(run) for run in runs], dtype=np.float64)
    y = np.array([error(run) for run in runs])
    good = (y < TOP) & (x > 0)
    axes.plot(x[good], np.maximum(y[good], 1e-16), **style)  # pyright: ignore
    beyond = (y >= TOP) & (x > 0)
    if not beyond.any():
        return
    look_of = {key: style[key] for key in ("color", "zorder", "alpha") if key in style}
    (marks,) = axes.plot(
        x[beyond], np.full(beyond.sum(), TOP), "o", markersize=4, markerfacecolor="none", clip_on=False, **look_of
    )
    marks.set_in_layout(False)


@dataclass(frozen=True)
class Row:
    """A row of the chart of costs: its label, and the curves of some methods with how each is drawn."""

    label: str
    curves: Sequence[tuple[str, Sequence[Run], Mapping[str, object]]]
    methods: Sequence[str]


def _rows(mine: Mapping[str, list[Run]], chosen: Mapping[str, list[Run]]) -> list[Row]:
    """Rows for each kind of scheme, then rows of schemes that choose their steps, beside their constant steps.

    Schemes of a row differ in colour, and a row has at most `MOST` curves besides those of general solvers.
    """
    found = []
    for panel in panels(mine, len(COLOURS)):
        styles = ({"color": look(i)[0], "linestyle": look(i)[1], "marker": "."} for i in range(len(panel.names)))
        curves = [(name, mine[name], style) for name, style in zip(panel.names, styles, strict=True)]
        found.append(Row(panel.title, curves, panel.names))
    names = list(chosen)
    for first in range(0, len(names), MOST // 2):
        drawn = names[first : first + MOST // 2]
        curves = []
        for name, colour in zip(drawn, COLOURS, strict=False):
            curves.append((f"{name}, constant steps", mine[name], {"color": colour, "linestyle": "-", "marker": "."}))
            dashed = {"color": colour, "linestyle": "--", "marker": "D", "markerfacecolor": "white"}
            curves.append((f"{name}, chosen steps", chosen[name], dashed))
        found.append(Row("steps that choose themselves", curves, drawn))
    return found


@styled
def _costs(
    case: Case,
    exact: Reference,
    runs: Sequence[Run],
    chosen: Sequence[Run],
    peers: Sequence[Run],
    missing: Mapping[str, str],
    folder: Path,
) -> None:
    """The largest error of u over each cost: rows for each kind of scheme, the others in grey."""
    mine, others = by_method(runs), by_method(peers)
    rows = _rows(mine, by_method(chosen))
    figure = Figure(figsize=(15, 2.3 * len(rows) + 1.2))
    room = figure.subplots(len(rows), len(COSTS) + 1, sharex="col", squeeze=False, width_ratios=(1, 1, 1, 0.7))
    grid = room[:, :-1]

    def error(run: Run) -> float:
        return run.errors["u"].maximum

    low = max(1e-13, 0.1 * min(error(run) for run in [*runs, *chosen]))

    for (*axes_of_row, beside), row in zip(room, rows, strict=True):
        beside.axis("off")
        for axes, cost in zip(axes_of_row, COSTS.values(), strict=True):
            pieces = [
                [*((cost(r), error(r)) for r in found), (np.nan, np.nan)]
                for n, found in mine.items() if n not in row.methods
            ]  # fmt: skip
            axes.plot(*np.array([xy for piece in pieces for xy in piece]).reshape(-1, 2).T, color="0.85", linewidth=0.7)
            for label, found, style in row.curves:
                curve(axes, found, cost, error, linewidth=1.5, markersize=4, label=label, zorder=3, **style)
            for i, (name, found) in enumerate(others.items()):
                curve(axes, found, cost, error, color=REFERENCE, linestyle=":", linewidth=1, marker="xsd^v+"[i % 6],
                      markersize=4, markerfacecolor="none", label=name, zorder=2)  # fmt: skip
            axes.set(xscale="log", yscale="log", ylim=(low, 3))
            if exact.error > KNOWN:
                axes.axhline(exact.error, color="0.3", linestyle=(0, (1, 2)), linewidth=1)
            for i, p in enumerate(sorted({order(name) for name in row.methods}, reverse=True)):
                slope_triangle(axes, p, low * 10 ** (1.4 + 1.4 * i))
        axes_of_row[0].set_ylabel(f"{row.label.replace(', ', chr(10))}\n\nlargest error of $u$")
        handles, labels = axes_of_row[1].get_legend_handles_labels()
        beside.legend(handles, labels, loc="center left", fontsize=8)
    for axes, label in zip(grid[-1], COSTS, strict=True):
        axes.set_xlabel(label)
    title = f"{case.title}: error against cost; open marks at the edge: failed, or an error above 100 %"
    absent = f"not installed: {', '.join(missing)}" if missing else ""
    floor = f"dotted: the error of {exact.source}, below which no error is known" if exact.error > KNOWN else ""
    figure.suptitle("\n".join(line for line in (title, case.note, floor, absent) if line))
    subject = f"{case.title}: the largest error of u, relative to its largest value, over three costs of a run"
    save(
        figure, folder / f"work_precision_{case.name}", SECTION,
        f"""{subject}: solves (of a balance by its effective stiffness, or by the mass if explicit), evaluations of
        force and tangent, and time without compilation. Rows by kind and order of schemes, at default parameters,
        others in grey; a composite is compared at equal work, since its sub-steps count. Triangles have the derived
        orders, which hold with damping and load too: undamped, as here, a scheme may be better.
        {SOLVERS if peers else ""} {CHOSEN if chosen else ""}
        {_sentences(case.note, floor, absent)}""",
    )  # fmt: skip


def slope_triangle(axes: Axes, p: int, top: float) -> None:
    """Draw a triangle on the left, below top, with the slope of order p: a tenth of the error for 10^(1/p) the cost."""
    left, right = axes.get_xlim()
    x, low = left * (right / left) ** 0.06, top / 10
    axes.plot([x, x * 10 ** (1 / p), x, x], [top, low, low, top], color="0.3", linewidth=0.8, scalex=False)
    text = axes.annotate(f"{p}", (x, top / 4), xytext=(-7, -3), textcoords="offset points", fontsize=8, color="0.3")
    text.set_in_layout(False)


def _sentences(*remarks: str) -> str:
    return " ".join(f"{remark[0].upper()}{remark[1:]}." for remark in remarks if remark)


def best(
    runs: Iterable[Run], cost: Callable[[Run], float], error: Callable[[Run], float]
) -> tuple[list[float], list[float]]:
    """The least error of the runs that cost no more than x, where it falls: ascending x, and errors below `TOP`."""
    x: list[float] = []
    y: list[float] = []
    for run in sorted(runs, key=lambda run: (cost(run), error(run))):
        if cost(run) > 0 and error(run) < (y[-1] if y else TOP):
            x.append(cost(run))
            y.append(max(error(run), 1e-16))
    return x, y


@styled
def _quantities(case: Case, exact: Reference, runs: Sequence[Run], chosen: Sequence[Run], folder: Path) -> None:
    """Errors of four quantities, three ways each, over evaluations: every scheme, and the best of each kind.

    They are u, v, a and the energy; with constraints u, v and the multipliers, in both ways.
    """
    shown = SHOWN_CONSTRAINED if exact.scene.info.multipliers else SHOWN
    mine = by_method(runs)
    groups = {kind: [run for name in names for run in mine.get(name, ())] for kind, names in kinds().items()}
    groups |= {"steps that choose themselves": list(chosen)} if chosen else {}
    figure = Figure(figsize=(14, 9.5))
    grid = figure.subplots(len(STATISTICS), len(shown), sharex=True, sharey="col")
    label, cost = list(COSTS.items())[1]
    for axes, title in zip(grid[0], shown.values(), strict=True):
        axes.set_title(title)
    for row, (statistic, label_of) in zip(grid, STATISTICS.items(), strict=True):
        for axes, quantity in zip(row, shown, strict=True):

            def error(run: Run, quantity: str = quantity, statistic: str = statistic) -> float:
                return getattr(run.errors[quantity], statistic)

            for found in mine.values():
                curve(axes, found, cost, error, color="0.85", linewidth=0.7, zorder=1)
            for i, (kind, found) in enumerate(groups.items()):
                x, y = best(found, cost, error)
                axes.plot(x, y, color=look(i)[0], linestyle=look(i)[1], linewidth=1.6, label=kind,
                          drawstyle="steps-post")  # fmt: skip
            axes.set(xscale="log", yscale="log")
        row[0].set_ylabel(f"relative error, {label_of}")
    for axes in grid[-1]:
        axes.set_xlabel(label)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5)
    figure.suptitle(f"{case.title}: errors of every quantity" + (f"\n{case.note}" if case.note else ""))
    save(
        figure, folder / f"work_precision_{case.name}_quantities", SECTION,
        f"""{case.title}: errors of {WHAT[bool(exact.scene.info.multipliers)]} at the end, the largest, and the root
        of the mean square on a grid of {len(exact.t) - 1} intervals, each relative to the largest value of the exact
        motion, over evaluations of force and tangent. Grey: every scheme in constant steps. Coloured, for each kind of
        scheme: the least error of any of its runs that costs no more.
        {_sentences(case.note)}""",
    )  # fmt: skip
