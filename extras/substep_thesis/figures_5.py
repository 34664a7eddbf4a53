"""Chapter 5 of the thesis, the elastic pendulum, flexible and stiff: figures 5.2 to 5.25, and longer runs.

Every figure shows the five sets of Table 4.1 and Bathe's scheme. The thesis's text and captions differ on two steps:
its figures show h = 0.01 s in figure 5.15 (p. 36 says 0.1) and h = 0.1 s in 5.16-5.18, 5.23, 5.25 (p. 37 says 0.01).
"""

import csv
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, partial
from itertools import product
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from substep.core.outcome import STATUSES, Status
from substep.core.scene_by_name import scene
from substep.core.scenes import Scene
from substep.core.schemes import Array, scheme
from substep.core.style import COLOURS, styled
from substep.derived import facade
from substep.exact.pendulum import ElasticPendulum
from substep.figures.charts import curves, save
from substep.marching.scene_lanes import Lanes, march_lanes
from substep.run.clock import number_of_steps

from .by_algebra import NEWMARK_SETS

Parameters = tuple[Fraction, Fraction, Fraction]  # gamma_t, beta, gamma

SECTION = "Chapter 5"
SPLITS = tuple(Fraction(split) for split in ("0.2", "0.5", "0.9"))
SETS: tuple[Parameters, ...] = tuple((split, *pair) for split, pair in product(SPLITS, NEWMARK_SETS))
NAMES = ("gamma_t", "beta", "gamma")
ROWS = 3000  # most states kept of a run: 35 in a period of the flexible bar's axial vibration
DRAWN = 1000  # most points of a curve, strain excepted


@dataclass(frozen=True)
class March:
    """A case of the pendulum ("flexible" or "stiff") with time step h and span t_end, both in s."""

    case: str
    h: float
    t_end: float

    @property
    def scene(self) -> Scene:
        """The pendulum of Kuhl & Crisfield 1999; the thesis gives the stiff one 19.6 m/s^2 towards the pivot."""
        if self.case == "flexible":
            return scene("elastic_pendulum", EA=1e4)
        return scene("elastic_pendulum", EA=1e10, a0=(-19.6, 0.0))

    @property
    def steps(self) -> int:
        """Number of steps."""
        return number_of_steps(self.h, self.t_end)

    def __str__(self) -> str:
        power = np.log10(self.scene.parameters["EA"])
        return f"{self.case} pendulum, $EA = 10^{{{power:g}}}$ N, $h$ = {self.h:g} s"


FLEXIBLE = {h: March("flexible", h, 30.0) for h in (0.01, 0.05, 1e-4)}
STIFF = {h: March("stiff", h, t_end) for h, t_end in ((0.1, 50.0), (1e-4, 30.0))}
MARCHES = (*FLEXIBLE.values(), *STIFF.values())
LONG = (March("stiff", 0.1, 2000.0), March("stiff", 0.01, 1000.0))
LONG_FINE = March("stiff", 1e-4, 1000.0)
LONG_FINE_SETS = (SETS[0], SETS[10], SETS[14])  # (1/4, 1/2) at both ends of gamma_t, and the most dissipative


@dataclass(frozen=True)
class Run:
    """One run, every few steps of it kept: t (n,) in s, u (n, 2) in m, energy in J, momentum in kg m^2/s, strain.

    peak: the largest energy of all steps, J; reached: the time of the last good state, s; iterations: Newton's, in all.
    """

    parameters: Parameters | None  # None for Bathe's scheme
    status: Status
    reached: float
    peak: float
    iterations: int
    t: Array
    u: Array
    energy: Array
    angular_momentum: Array
    strain: Array


@cache
def runs(march: March, sets: tuple[Parameters, ...] = SETS) -> dict[Parameters | None, Run]:
    """Newmark-BDF2 with each of the sets, and Bathe's scheme under None; computed once and shared by all figures."""
    n = march.steps
    stride = next(k for k in range(-(-n // ROWS), n + 1) if n % k == 0)  # a divisor, so that the end is kept
    columns = zip(NAMES, np.array(sets, dtype=np.float64).T, strict=True)
    return _runs(march, "newmark_bdf2", sets, stride, dict(columns)) | _runs(march, "bathe", (None,), stride, {})


def _runs(
    march: March, name: str, keys: Sequence[Parameters | None], stride: int, values: dict[str, Array]
) -> dict[Parameters | None, Run]:
    """One run, a lane of the march, for each key; values: the scheme's parameters, one for each key."""
    ones = np.ones(len(keys))
    lanes = march_lanes(
        march.scene, scheme(name, **values), march.h * ones, (march.steps * ones).astype(np.int64),
        stride=stride, history=True,
    )  # fmt: skip
    return {key: _run(march, lanes, k, stride, key) for k, key in enumerate(keys)}


def _run(march: March, lanes: Lanes, k: int, stride: int, key: Parameters | None) -> Run:
    pendulum, n_done = march.scene, int(lanes.n_done[k])
    rows = lanes.out[k, : n_done // stride + 1].copy()
    t, u, v = np.arange(len(rows)) * stride * march.h, rows[:, 0], rows[:, 1]
    momentum = pendulum.angular_momentum(t, u, v)
    assert momentum is not None
    return Run(
        key, STATUSES[lanes.status[k]], n_done * march.h, float(lanes.peak[k]), int(lanes.newton[k, 0].sum()),
        t, u, pendulum.energy(t, u, v), momentum, pendulum.outputs(t, u, v)["strain"],
    )  # fmt: skip


def at_split(found: dict[Parameters | None, Run], split: Fraction) -> dict[str, Run]:
    """The curves of one panel by their labels: the sets of Table 4.1 at this gamma_t, and Bathe's scheme last."""
    newmark = {key: run for key, run in found.items() if key is not None and key[0] == split}
    labels = {rf"$\beta$ = {float(b):g}, $\gamma$ = {float(c):g}": run for (_, b, c), run in newmark.items()}
    return {**labels, "Bathe": found[None]}


@cache
def exact(march: March, every: int) -> tuple[Array, Array]:
    """(t, u): times in s, every `every`-th of those kept of a completed run, and the exact positions in m there."""
    t = runs(march)[None].t[::every]
    return t, ElasticPendulum(**march.scene.parameters).position(t)


@dataclass(frozen=True)
class Plot:
    """Figure 5.number of the thesis; gamma_t is None for a figure with a panel for each gamma_t."""

    number: int
    kind: str  # "energy", "trajectory" or "strain"
    march: March
    gamma_t: Fraction | None = None

    @styled
    def figure(self) -> Figure:
        """All panels and one legend."""
        figure = {"energy": _energy_figure, "trajectory": _trajectory_figure, "strain": _strain_figure}[self.kind](self)
        figure.suptitle(f"Figure 5.{self.number}: {self._subject()}, {self.march}")
        handles = {label: line for axes in figure.axes for line, label in zip(*_legend(axes), strict=True)}
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=4)
        return figure

    def draw(self, folder: Path) -> None:
        """Write figure_5_number as PNG and SVG into the folder."""
        save(self.figure(), folder / f"figure_5_{self.number}", SECTION, self.caption())

    def caption(self) -> str:
        """What the figure shows, as a text for the page of results."""
        march, sets = self.march, "Newmark-BDF2 with the five sets (β, γ) of Table 4.1"
        scene = f"Elastic pendulum of Kuhl & Crisfield 1999, {march.case} (EA = {march.scene.parameters['EA']:g} N)"
        split = "γ_t = 0.2, 0.5, 0.9" if self.gamma_t is None else f"γ_t = {float(self.gamma_t):g}"
        content = {
            "energy": "(a) energy, (b) angular momentum, both constant in the exact motion, "
            "(c) relative change of energy",
            "trajectory": "path of the mass, with dots where runs end and a cross at the exact end; below, the "
            "distance from the exact position",
            "strain": "axial strain; the wide grey line is "
            + ("the exact strain, first 15 s" if march.case == "flexible" else "that of steady rotation"),
        }[self.kind]
        return (
            f"{scene}, h = {march.h:g} s, {march.t_end:g} s, {sets} at {split}, and Bathe's scheme in black: "
            f"{content}. "
            f"A curve ends where its run failed. Kumar 2015, figure 5.{self.number}."
        )

    def _subject(self) -> str:
        if self.gamma_t is not None:
            return rf"energy and angular momentum, $\gamma_t$ = {float(self.gamma_t):g}"
        if self.kind == "trajectory":
            return "trajectory, where it ends (dots), and its error"
        return "axial strain" + (" (its start from 0 is off the axis)" if self.march.case == "stiff" else "")


def _plots() -> Iterator[Plot]:
    """All figures, in the order of the thesis."""
    contents: list[tuple[str, March, Fraction | None]] = [
        *(("energy", march, split) for march, split in product(FLEXIBLE.values(), SPLITS)),
        *(("trajectory", march, None) for march in FLEXIBLE.values()),
        *(("strain", FLEXIBLE[h], None) for h in (1e-4, 0.01)),
        *(("energy", march, split) for march, split in product(STIFF.values(), SPLITS)),
        *(("strain", STIFF[h], None) for h in (1e-4, 0.1)),
        *(("trajectory", STIFF[h], None) for h in (1e-4, 0.1)),
    ]
    return (Plot(number, *content) for number, content in enumerate(contents, start=2))


def _legend(axes: Axes) -> tuple[list, list[str]]:
    return axes.get_legend_handles_labels()


def _lines(axes: Axes, x: Array, series: dict[str, Array], y_label: str, x_label: str = "time $t$ (s)") -> None:
    """Draw curves, Bathe's last and thinner, so that a curve below it still shows."""
    curves(axes, x, series, x_label=x_label, y_label=y_label)
    for line in axes.lines:
        line.set_linewidth(0.7 if line is axes.lines[-1] else 1.5)
    axes.set_xlim(0.0, x[-1])


def _lettered(axes: Iterable[Axes], titles: Iterable[str]) -> None:
    for letter, (a, title) in zip("abcdef", zip(axes, titles, strict=True), strict=False):
        a.set_title(f"({letter}) {title}", loc="left")


def _energy_figure(plot: Plot) -> Figure:
    assert plot.gamma_t is not None
    found = at_split(runs(plot.march), plot.gamma_t)
    t = found["Bathe"].t
    some = slice(None, None, -(-len(t) // DRAWN))
    E0 = plot.march.scene.E0
    figure = Figure(figsize=(13, 4.4))
    a, b, c = figure.subplots(1, 3)
    _lines(a, t[some], {label: run.energy[some] for label, run in found.items()}, "energy $E$ (J)")
    momenta = {label: run.angular_momentum[some] for label, run in found.items()}
    _lines(b, t[some], momenta, "angular momentum $J$ (kg m$^2$/s)")
    changes = {label: np.abs(run.energy[some] / E0 - 1)[1:] for label, run in found.items()}
    _lines(c, t[some][1:], changes, "$|E - E_0|/E_0$")
    c.set_yscale("log")
    for axes in (a, b):
        axes.ticklabel_format(useOffset=False)
    _lettered((a, b, c), ("total energy", "angular momentum", "relative change of energy"))
    return figure


def _trajectory_figure(plot: Plot) -> Figure:
    every = -(-len(runs(plot.march)[None].t) // DRAWN)
    t, truth = exact(plot.march, every)
    figure = Figure(figsize=(13, 8.8))
    top, bottom = figure.subplots(2, 3, sharex="row", sharey="row", height_ratios=(1.7, 1))
    for axes, below, split in zip(top, bottom, SPLITS, strict=True):
        found = at_split(runs(plot.march), split)
        # the paths, thousands of points upon each other, are an image in the SVG too
        for i, (label, run) in enumerate(found.items()):
            colour = COLOURS[i] if label != "Bathe" else "black"
            axes.plot(*run.u.T, color=colour, linewidth=0.5, rasterized=True)
            axes.plot(*run.u[-1], "o", color=colour, markersize=9 - i, zorder=3)
        axes.plot(*truth[-1], "x", color="black", markersize=12, zorder=4, label="exact end position", linestyle="none")
        axes.set(aspect="equal", xlabel="$x$ (m)", ylabel="$y$ (m)")
        errors = {label: np.linalg.norm(run.u[::every] - truth, axis=1)[1:] for label, run in found.items()}
        _lines(below, t[1:], errors, "distance from exact position (m)")
        below.set_yscale("log")
    for axes in (*top[1:], *bottom[1:]):
        axes.set_ylabel("")
    names = [rf"$\gamma_t$ = {float(split):g}" for split in SPLITS]
    _lettered((*top, *bottom), (*names, *names))
    return figure


def _strain_figure(plot: Plot) -> Figure:
    march, t = plot.march, runs(plot.march)[None].t
    stiff = march.case == "stiff"
    some = t <= (march.t_end if stiff else 15.0)
    unit, text = (1e-8, " ($10^{-8}$)") if stiff else (1.0, "")
    truth = np.full(t[some].shape, rigid_strain(march)) if stiff else exact_strain(march, t[some])
    figure = Figure(figsize=(13, 8.2))
    panels = figure.subplots(3, 1, sharex=True)
    for axes, split in zip(panels, SPLITS, strict=True):
        series = {label: run.strain[some] / unit for label, run in at_split(runs(march), split).items()}
        _lines(axes, t[some], series, rf"strain $\epsilon${text}")
        name = "rigid limit" if stiff else "exact"
        axes.plot(t[some], truth / unit, color="0.75", linewidth=4, zorder=0, label=name)
        if stiff:  # the first 2 % of the run, in which the strain rises from 0, do not decide the axis
            settled = np.array(list(series.values()))[:, len(t) // 50 :]
            margin = 0.1 * np.ptp(settled)
            axes.set_ylim(settled.min() - margin, settled.max() + margin)
        axes.ticklabel_format(useOffset=False)
        axes.label_outer()
    _lettered(panels, (rf"$\gamma_t$ = {float(split):g}" for split in SPLITS))
    return figure


def exact_strain(march: March, t: Array) -> Array:
    """Axial strain (n,) of the exact motion at times t (n,) in s."""
    u = ElasticPendulum(**march.scene.parameters).position(t)
    return march.scene.outputs(t, u, np.zeros_like(u))["strain"]


def rigid_strain(march: March) -> float:
    """Axial strain in steady rotation at the initial speed, m*v0^2/(EA*L), as EA tends to infinity."""
    EA, L, m, v0 = march.scene.parameters.values()
    return m * v0**2 / (EA * L)


PLOTS = tuple(_plots())

HEADER = (
    *("figures", "case", "EA (N)", "h (s)", "t_end (s)", "scheme", "gamma_t", "beta", "gamma", "status"),
    *("t reached (s)", "E at end (J)", "largest E (J)", "J at end (kg m^2/s)", "largest strain of rows kept"),
    *("x at end (m)", "y at end (m)", "Newton iterations"),
)


def end_rows(march: March, found: dict[Parameters | None, Run]) -> Iterator[list[object]]:
    """A line under HEADER for each run, at its last kept state, which for a completed run is its end."""
    for key, run in found.items():
        split = key and key[0]
        shown = [p.number for p in PLOTS if p.march == march and (None in (split, p.gamma_t) or split == p.gamma_t)]
        name, parameters = ("bathe", ("", "", "")) if key is None else ("newmark_bdf2", tuple(map(float, key)))
        yield [
            *(" ".join(f"5.{number}" for number in shown), march.case, march.scene.parameters["EA"], march.h),
            *(march.t_end, name, *parameters, run.status, run.reached, run.energy[-1], run.peak),
            *(run.angular_momentum[-1], run.strain.max(), *run.u[-1], run.iterations),
        ]


def _write_ends(path: Path, rows: Iterable[Iterable[object]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([HEADER, *rows])


def end_values(folder: Path) -> None:
    """The numbers behind figures 5.2-5.25: chapter_5_end_values.csv, one line for each run."""
    _write_ends(folder / "chapter_5_end_values.csv", (row for march in MARCHES for row in end_rows(march, runs(march))))


JOBS: tuple[Callable[[Path], None], ...] = (*(plot.draw for plot in PLOTS), end_values)


@cache
def rigid_growth(parameters: Parameters | None) -> tuple[int, Fraction]:
    """(p, c): in the rigid limit a settled step changes E by c*tau^p*E, tau = h*v/L, to leading order; derived."""
    values = dict(zip(NAMES, parameters or (), strict=False))
    settled = facade.rigid_energy("newmark_bdf2" if values else "bathe", **values).settled
    power = min(settled)
    return power, Fraction(settled[power])


def rigid_energy(march: March, parameters: Parameters | None, t: Array) -> Array:
    """Energy (n,) in J at times t (n,) in s by the leading term of `rigid_growth`; NaN beyond its time of blow-up."""
    power, c = rigid_growth(parameters)
    _, L, _, v0 = march.scene.parameters.values()
    shrinking = 1 - power / 2 * float(c) * (march.h * v0 / L) ** power * t / march.h
    return march.scene.E0 * np.where(shrinking > 0, shrinking, np.nan) ** (-2 / power)


@styled
def long_figure(march: March, folder: Path) -> None:
    """Draw the energy of the stiff pendulum far beyond the thesis's 50 s, and the leading term of the rigid limit."""
    found = runs(march)
    figure = Figure(figsize=(13, 5))
    panels = figure.subplots(1, 3, sharey=True)
    t = np.linspace(0.0, march.t_end, DRAWN)
    for axes, split in zip(panels, SPLITS, strict=True):
        for i, (label, run) in enumerate(at_split(found, split).items()):
            colour = COLOURS[i] if label != "Bathe" else "black"
            axes.plot(run.t, run.energy, color=colour, linewidth=1.2, label=label)
            axes.plot(t, rigid_energy(march, run.parameters, t), color=colour, linewidth=2.5, linestyle=":")
        axes.axvline(50.0, color="0.6", linewidth=0.8)
        axes.set_yscale("log")
        axes.set_xlabel("time $t$ (s)")
        axes.margins(x=0)
    panels[0].set_ylabel("energy $E$ (J)")
    _lettered(panels, (rf"$\gamma_t$ = {float(split):g}" for split in SPLITS))
    figure.suptitle(f"Long runs, {march}; dotted: rigid limit; grey line: where the thesis ends, 50 s")
    handles, labels = _legend(panels[0])
    figure.legend(handles, labels, loc="outside lower center", ncols=6)
    save(
        figure, folder / f"chapter_5_long_h_{march.h:.0e}", SECTION,
        f"""Energy of the stiff pendulum (EA = 10¹⁰ N) with h = {march.h:g} s over {march.t_end:g} s, far beyond the 50
        s of the thesis (grey line), for Newmark-BDF2 with the five sets of Table 4.1 at three γ_t, and Bathe's scheme
        in black. Dotted: the leading term of the energy change a step in the rigid limit, derived.""",
    )  # fmt: skip


def long_values(folder: Path) -> None:
    """The numbers behind the long runs: chapter_5_long_end_values.csv."""
    found = {**{march: runs(march) for march in LONG}, LONG_FINE: runs(LONG_FINE, LONG_FINE_SETS)}
    _write_ends(folder / "chapter_5_long_end_values.csv", (row for item in found.items() for row in end_rows(*item)))


LONG_JOBS: tuple[Callable[[Path], None], ...] = (*(partial(long_figure, march) for march in LONG), long_values)
