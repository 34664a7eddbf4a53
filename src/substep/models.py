"""Model no more than a scene needs: the stiff pendulum as an elastic bar (2 coordinates) and as a rigid one (1).

What a user asks for is the bar's angle at the end and its energy; the reference is the elastic bar's exact
motion, so that the rigid model pays for leaving the bar's stretching out.
"""

import csv
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from itertools import product
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np
from matplotlib.figure import Figure

from .charts import REFERENCE, look, save
from .exact_pendulum import ElasticPendulum
from .lanes import pair_module
from .marching import march
from .scenes import Scene, scene
from .schemes import scheme, schemes

SCHEMES = ("average_acceleration", "bathe", "generalized_alpha", "energy_momentum", "rk4")
STEPS = (0.1, 0.01, 1e-3, 1e-4, 2e-5)


@dataclass(frozen=True)
class Attempt:
    """One model, scheme and step (s): errors at the end, the angle's in rad and the energy's relative, and cost in s.

    An error is inf where the run failed.
    """

    model: str
    scheme: str
    dt: float
    angle_error: float
    energy_error: float
    seconds: float


def attempt(model: Scene, name: str, dt: float, t_end: float, angle: float, repeats: int) -> Attempt:
    """The run, timed warm; angle: the exact one at t_end, in rad."""
    s = scheme(name)
    stride = max(1, round(0.1 / dt))  # rows close enough to count revolutions
    march(model, s, dt, dt)  # compiles
    spent, r = [], None
    for _ in range(repeats):
        began = perf_counter()
        r = march(model, s, dt, t_end, stride=stride)
        spent.append(perf_counter() - began)
    assert r is not None
    errors = (float("inf"), float("inf"))
    if r.status == "completed":
        turned = r.u[:, 0] if r.u.shape[1] == 1 else np.unwrap(np.arctan2(r.u[:, 1], r.u[:, 0]))
        errors = abs(turned[-1] - angle), abs(r.energy[-1] / r.energy[0] - 1)
    return Attempt(model.name, name, dt, float(errors[0]), float(errors[1]), median(spent))


def compare(
    EA: float = 1e10,
    t_end: float = 30.0,
    names: Sequence[str] | None = None,
    steps: Sequence[float] = STEPS,
    repeats: int = 3,
) -> list[Attempt]:
    """Both models with every scheme (SCHEMES if none is named) and step.

    EA in N; t_end and steps in s, every step a divisor of 0.1 and of t_end.
    """
    exact = ElasticPendulum(EA)
    times = np.linspace(0.0, t_end, 1 + 4 * int(np.ceil(t_end)))
    positions = exact.position(times)
    angle = float(np.unwrap(np.arctan2(positions[:, 1], positions[:, 0]))[-1])
    runs = product((scene("rigid_pendulum"), scene("elastic_pendulum", EA=EA)), names or SCHEMES, steps)
    return [attempt(model, name, dt, t_end, angle, repeats) for model, name, dt in runs]


def cheapest(attempts: Sequence[Attempt], angle: float, energy: float = float("inf")) -> Attempt | None:
    """The least costly attempt within both errors (rad; relative), None if there is none.

    Of equal cost, to a tenth of a millisecond, the simpler model and the larger step.
    """
    good = [a for a in attempts if a.angle_error <= angle and a.energy_error <= energy]
    return min(good, key=lambda a: (round(a.seconds, 4), a.model != "rigid_pendulum", -a.dt), default=None)


def chart(attempts: Sequence[Attempt], folder: Path) -> None:
    """Angle error over time spent, both models, as PNG, SVG and CSV."""
    figure = Figure(figsize=(8.5, 5.6), layout="constrained")
    axes = figure.subplots()
    names = list(dict.fromkeys(a.scheme for a in attempts))
    for i, name in enumerate(names):
        mine = [a for a in attempts if a.scheme == name and a.model != "rigid_pendulum" and np.isfinite(a.angle_error)]
        colour, style = look(i)
        x, y = [a.seconds for a in mine], [a.angle_error for a in mine]
        axes.plot(x, y, "o", markersize=4, color=colour, linestyle=style, linewidth=1.4, label=f"elastic bar, {name}")
    rigid = [a for a in attempts if a.model == "rigid_pendulum" and np.isfinite(a.angle_error)]
    axes.plot(
        [a.seconds for a in rigid], [a.angle_error for a in rigid],
        linestyle="", marker="s", markersize=5, color=REFERENCE, markerfacecolor="none",
        label="rigid bar, every scheme",
    )  # fmt: skip
    axes.set(xscale="log", yscale="log", xlabel="time spent (s)", ylabel="error of the angle at the end (rad)")
    axes.grid(visible=True, linewidth=0.3, color="0.8")
    figure.suptitle("The stiff pendulum, elastic and rigid: error against time spent", fontsize=11)
    figure.legend(loc="outside lower center", ncols=3, fontsize=9, frameon=False)
    save(
        figure, folder / "models", "Elastic or rigid",
        """Error of the angle at the end against the time a run took, stiff pendulum (EA = 10¹⁰ N, 30 s), as an elastic
        bar with each scheme at steps of 0.1 to 2·10⁻⁵ s, and as a rigid one. The rigid bar is off by what the elastic
        one stretches, 3·10⁻⁶ rad, at any step: where that suffices it is cheapest. Times are of the machine that drew
        this.""",
    )  # fmt: skip
    with (folder / "models.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([[f.name for f in fields(Attempt)], *(astuple(a) for a in attempts)])


def operations(folder: Path) -> list[tuple[str, int, str, int]]:
    """Of every scheme: operations a step (and in each Newton iteration) on the elastic bar and on the rigid one."""
    elastic, rigid = scene("elastic_pendulum", EA=1e10), scene("rigid_pendulum")
    rows = []
    for name in schemes():
        bar, stiff = (pair_module(model, scheme(name)).OPERATIONS for model in (elastic, rigid))
        rows.append((name, bar["step"], " + ".join(map(str, bar["iteration"])) or "0", stiff["step"]))
    header = ("scheme", "elastic: a step", "elastic: an iteration of each balance", "rigid: a step")
    with (folder / "operations.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([header, *rows])
    return rows
