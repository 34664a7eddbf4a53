"""A pendulum on an elastic bar, a stiff one and a rigid one: error and work of three models over the stiffness."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...core.scene_by_name import scene
from ...core.scenes import Scene
from ...core.schemes import Scheme, scheme
from ...core.style import COLOURS, REFERENCE, styled
from ...figures.charts import save
from ..step_counts import FINER, SAMPLES
from .cases import lag
from .charts import SECTION
from .measure import Run, measure
from .models import difference
from .reference import reference
from .scene_choice import Candidate, choose

SCHEMES = (("average_acceleration", {}), ("generalized_alpha", {}), ("bathe", {}), ("newmark_bdf2", {"gamma_t": 0.3}))
T_END, STEPS, FINEST = 10.0, 800, 14  # s; steps of the left panel; the finest of the middle one are SAMPLES*2^FINEST
WISHED = 1e-3  # rad
ASKED = (("angle", 1e-2), ("angle", 1e-5), ("u", 1e-2), ("u", 1e-5))
MODELS = {"elastic_pendulum": "elastic bar", "rod_pendulum": "rod, a constraint", "rigid_pendulum": "angle alone"}
LINES, MARKERS = dict(zip(MODELS, ("-", "--", ":"), strict=True)), dict(zip(MODELS, "osD", strict=True))


@dataclass(frozen=True)
class Point:
    """A run of a scheme on a model of the pendulum with a bar of EA (N)."""

    EA: float
    model: str
    scheme: Scheme
    run: Run

    @property
    def method(self) -> str:
        """The scheme, with what it was given."""
        return ", ".join([self.scheme.name, *(f"{name} = {float(x):g}" for name, x in self.scheme.given.items())])

    @property
    def error(self) -> float:
        """The largest error of the angle, rad, against the exact motion of the elastic bar."""
        return self.run.errors["angle"].maximum


class Found(NamedTuple):
    """points: runs at STEPS; cheapest: those of the fewest operations within WISHED; chosen: what `choose` recommends
    for each quantity and accuracy of ASKED, by EA; lags: EA, and the angle in rad that rigid models leave out.
    """

    points: list[Point]
    cheapest: list[Point]
    chosen: dict[tuple[str, float], list[tuple[float, Candidate]]]
    lags: list[tuple[float, float]]


def models(EA: float) -> tuple[Scene, ...]:
    """The pendulum on an elastic bar, on a rod that is a constraint, and in its angle."""
    return scene("elastic_pendulum", EA=EA), scene("rod_pendulum"), scene("rigid_pendulum")


def measured(stiffnesses: Sequence[float], among: Sequence[Scheme] | None = None, repeats: int = 3) -> Found:
    """All runs over the stiffnesses EA, N, of some schemes, by default those of SCHEMES."""
    schemes = [scheme(name, **given) for name, given in SCHEMES] if among is None else among
    found = Found([], [], {asked: [] for asked in ASKED}, [])
    for EA in stiffnesses:
        full, *simple = models(EA)
        exact = reference(full, T_END, SAMPLES, 1e-12)
        found.lags.append((EA, lag(full, T_END)))
        for model in (full, *simple):
            suffices = model is full or difference(exact, model, "angle", WISHED / FINER) <= WISHED
            for one in schemes:
                found.points.append(Point(EA, model.name, one, measure(exact, one, STEPS, repeats, model)))
                runs = (measure(exact, one, SAMPLES << k, 0, model) for k in range(FINEST + 1))
                good = (run for run in runs if run.errors["angle"].maximum <= WISHED)
                if suffices and (coarsest := next(good, None)):
                    found.cheapest.append(Point(EA, model.name, one, coarsest))
        for (quantity, accuracy), recommended in found.chosen.items():
            best = choose(full, accuracy, t_end=T_END, quantity=quantity, simpler=simple, among=schemes, chosen=()).best
            recommended.extend([(EA, best)] if best else [])
    return found


@styled
def chart(found: Found, folder: Path) -> None:
    """Draw error at one step, work for one error, and what `choose` recommends, over EA; all runs as CSV."""
    _write(found, folder)
    names = list(dict.fromkeys(point.method for point in found.points))
    colour = dict(zip(names, COLOURS, strict=False))
    figure = Figure(figsize=(15, 5.6))
    left, middle, right = figure.subplots(1, 3, sharex=True)
    for axes, points, of in (
        (left, found.points, lambda point: point.error),
        (middle, found.cheapest, lambda point: point.run.cost.operations / T_END),
    ):
        for model, line in LINES.items():
            for name in names:
                xy = [(x.EA, of(x)) for x in points if (x.model, x.method) == (model, name)]
                good = [(x, y if y < 1.0 or axes is middle else np.nan) for x, y in xy]
                axes.plot(*np.array(good).reshape(-1, 2).T, line, color=colour[name], marker=".")
                if axes is left:
                    gone = [x for x, y in xy if not y < 1.0]
                    axes.plot(gone, np.ones(len(gone)), "o", color=colour[name], markerfacecolor="none", clip_on=False)
    left.plot(*zip(*found.lags, strict=True), color=REFERENCE, linewidth=1)
    left.annotate("lag of the bar", found.lags[len(found.lags) // 2], (6, 4), textcoords="offset points", fontsize=8)
    left.set(ylabel=r"largest error of the angle $\theta$ (rad)", ylim=(1e-12, 2.0))
    left.set_title(f"error at $h$ = {T_END / STEPS:g} s; open: failed, or above 1 rad", fontsize=10)
    middle.set(ylabel="operations for 1 s of motion")
    middle.set_title(rf"work for an error of $\theta$ below {WISHED:g} rad", fontsize=10)
    for i, ((quantity, accuracy), recommended) in enumerate(found.chosen.items()):
        xy = [(EA, c.run.cost.operations / T_END) for EA, c in recommended]
        label = rf"$\theta$, {accuracy:g} rad" if quantity == "angle" else f"$u$, {accuracy:g} of its length"
        right.plot(*np.array(xy).reshape(-1, 2).T, color=COLOURS[-1 - i], label=label, zorder=1)
        for (EA, y), (_, c) in zip(xy, recommended, strict=True):
            right.plot(EA, y, MARKERS[c.model.name], color=COLOURS[-1 - i], markerfacecolor="white", markersize=7)
    right.set(ylabel="operations for 1 s of motion", ylim=(20, 1e8))
    right.set_title("what `choose` recommends; marks: the model", fontsize=10)
    for axes in (left, middle, right):
        axes.set(xscale="log", yscale="log", xlabel="stiffness $EA$ (N)")
    of_scheme = [Line2D([], [], color=colour[name], label=name) for name in names]
    of_model = [
        Line2D([], [], color="0.3", linestyle=LINES[m], marker=MARKERS[m], markerfacecolor="white", label=label)
        for m, label in MODELS.items()
    ]
    figure.legend(handles=[*of_scheme, *of_model], loc="outside lower center", ncols=len(names) + len(of_model))
    right.legend(fontsize=8, loc="upper right", frameon=True)
    figure.suptitle(f"A pendulum that turns for {T_END:g} s: elastic bar, rod as a constraint, angle alone")
    save(
        figure, folder / "models", SECTION,
        f"""One pendulum over the stiffness EA of its bar, by three models: the elastic bar, which is also the penalty
        form of the rod, the rod as a constraint with its multiplier, and the angle alone. Errors are the largest over
        {T_END:g} s against the exact motion of the elastic bar; black: the angle by which that lags behind a rigid one,
        which both rigid models leave out. Left: at one step. Middle: operations of the cheapest run within
        {WISHED:g} rad, for a second of motion; no mark where no step is accurate. Right: what `choose` recommends among
        schemes and models, for an error of the angle or of x and y, which the model in angles does not have; the marks
        are those of the models.""",
    )  # fmt: skip


def _write(found: Found, folder: Path) -> None:
    with (folder / "models.csv").open("w", encoding="utf-8", newline="") as file:
        out = csv.writer(file)
        out.writerow(["what", "EA_N", "model", "scheme", "steps", "operations", "seconds", "error"])
        for what, points in (("one step", found.points), ("cheapest", found.cheapest)):
            for p in points:
                cost, seconds = p.run.cost.operations, f"{p.run.seconds:.4g}"
                out.writerow([what, p.EA, p.model, p.method, p.run.steps, cost, seconds, f"{p.error:.6g}"])
        for (quantity, accuracy), recommended in found.chosen.items():
            for EA, c in recommended:
                of_run = c.method, c.run.steps, c.run.cost.operations, f"{c.run.seconds:.4g}", f"{c.error:.6g}"
                out.writerow([f"choose {quantity} {accuracy:g}", EA, c.model.name, *of_run])
