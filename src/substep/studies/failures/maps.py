"""Maps of the stiff pendulum: what becomes of a run, and of its energy, over the step and one parameter."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.colors import SymLogNorm
from matplotlib.figure import Figure

from ...core.scenes import Scene
from ...core.schemes import Array, Scheme, scheme
from ...core.style import COLOURS, REFERENCE, styled
from ...derived import facade
from ...figures.charts import save, save_csv
from ...marching.scene_lanes import march_lanes, pair_kernels
from ..turning import CLOSE, FARTHEST, bar_of, growth
from .outcomes import BLEW_UP, NEWTON, SECTION, WORDS, Outcome, paint, run, whole_steps, word_legend
from .table import stiff

SPAN, MOST_STEPS = 10.0, 500  # a run takes SPAN (s) or MOST_STEPS steps, whichever is shorter
STEPS = (1e-3, 1.0)  # least and largest h, s
LINE = 60  # steps and values of a parameter between which a derived line is drawn


@dataclass(frozen=True)
class Map:
    """A map of outcomes over the step h and one parameter y of a scheme.

    y: its range; make: the scheme with an array of y; lines: values of y, derived, that are drawn as dashed lines. A
    solid line is where errors along the bar begin to grow, derived too.
    """

    name: str
    title: str
    y: tuple[float, float]
    y_name: str
    y_label: str
    make: Callable[[Array], Scheme]
    lines: Callable[[], tuple[float, ...]] = lambda: ()


def _split_of_no_change() -> tuple[float, ...]:
    return facade.rigid_energy("newmark_bdf2", beta="1/4", gamma="1/2").sign_changes


def _along_gamma(gamma: Array) -> Scheme:
    return scheme("newmark_bdf2", gamma_t=0.2, beta=(gamma + 0.5) ** 2 / 4, gamma=gamma)


MAPS = (
    Map(
        "newmark_bdf2_gamma_t",
        "Newmark-BDF2, β = 1/4, γ = 1/2",
        (0.01, 0.99),
        "gamma_t",
        r"sub-step ratio $\gamma_t$",
        lambda y: scheme("newmark_bdf2", gamma_t=y, beta=0.25, gamma=0.5),
        _split_of_no_change,
    ),
    Map(
        "newmark_bdf2_gamma",
        "Newmark-BDF2, γₜ = 1/5, β = (γ + 1/2)²/4",
        (0.3, 0.9),
        "gamma",
        r"Newmark's $\gamma$",
        _along_gamma,
    ),
    Map("hht_alpha", "HHT-α", (-0.5, 0.0), "alpha", r"$\alpha$", lambda y: scheme("hht_alpha", alpha=y)),
    Map(
        "generalized_alpha",
        "Generalized-α",
        (0.0, 1.0),
        "rho_inf",
        r"spectral radius at infinity $\rho_\infty$",
        lambda y: scheme("generalized_alpha", rho_inf=y),
    ),
)


def lattice(pendulum: Scene, make: Callable[[Array], Scheme], h: Array, y: Array) -> tuple[Outcome, Array]:
    """Outcomes at h (P,) and y (P,), and the energy of the last good state over E0 (P,).

    The scheme must carry u and v of t_n in its state.
    """
    s = make(y)
    lanes, outcome = run(pendulum, s, h, np.minimum(whole_steps(SPAN, h), MOST_STEPS))
    rows = pair_kernels(pendulum, s).STATE
    u, v = (lanes.state[:, rows.index((kind, 0))] for kind in "uv")
    return outcome, pendulum.energy(np.zeros(len(h)), u, v) / pendulum.E0


@styled
def draw(folder: Path, drawn: Map, points: int) -> tuple[Outcome, Array]:
    """One map of points x points runs, as PNG, SVG and CSV; what `lattice` returns."""
    h, y = (x.ravel() for x in np.meshgrid(np.geomspace(*STEPS, points), np.linspace(*drawn.y, points)))
    outcome, end = lattice(stiff(), drawn.make, h, y)
    square, lines = (points, points), drawn.lines()
    bar = bar_of(stiff())
    grid = np.geomspace(STEPS[0], FARTHEST / bar.rate, LINE), np.linspace(*drawn.y, LINE)
    steps, values = np.meshgrid(*grid)
    grows = growth(drawn.make(values), bar.omega * steps, bar.rate * steps)
    figure = Figure(figsize=(12, 5.2))
    a, b = figure.subplots(1, 2, sharey=True)
    paint(a, h.reshape(square), y.reshape(square), outcome.word.reshape(square))
    change = np.where(np.isin(outcome.word, (BLEW_UP, NEWTON)), np.nan, end - 1)
    mesh = b.pcolormesh(
        h.reshape(square), y.reshape(square), change.reshape(square),
        norm=SymLogNorm(1e-7, vmin=-1, vmax=1), cmap="PuOr_r", shading="nearest", rasterized=True,
    )  # fmt: skip
    b.set_facecolor("0.6")
    figure.colorbar(mesh, ax=b, label="$E_{end}/E_0 - 1$ (grey: failed)", extend="max")
    for axes, letter in ((a, "a"), (b, "b")):
        axes.set_xscale("log")
        axes.set_xlabel("step $h$ (s)")
        axes.set_title(f"({letter})", loc="left")
        for line in lines:
            label = f"derived: settled energy change is 0 at {line:.4f}"
            axes.axhline(line, color=REFERENCE, linewidth=1, linestyle="--", label=label)
        if (grows > 1.0 + CLOSE).any():
            axes.contour(*grid, grows, levels=[1.0 + CLOSE], colors="black", linewidths=1.2)
            axes.plot([], [], color="black", linewidth=1.2, label="derived: on its right errors along the bar grow")
    a.set_ylabel(drawn.y_label)
    figure.suptitle(f"{drawn.title}: stiff pendulum, {SPAN:g} s or {MOST_STEPS} steps")
    handles = word_legend() + a.get_legend_handles_labels()[0]
    figure.legend(handles=handles, loc="outside lower center", ncols=5)
    save(
        figure, folder / f"map_{drawn.name}", SECTION,
        f"""The stiff pendulum (EA = 10¹⁰ N, a0 = -19.6 m/s² along the bar) with {drawn.title}: (a) the outcome of a
        run of {SPAN:g} s or {MOST_STEPS} steps, whichever is shorter, and (b) its relative change of energy, over the
        step h and one parameter; {points} x {points} runs. Grey in (b):
        failed. On the right of the solid line errors along the bar grow, as is derived for steady turning.
        {"Dashed: derived." if lines else ""}""",
    )  # fmt: skip
    columns = [h, y, outcome.word, outcome.t, outcome.max_ratio, end - 1]
    words = "; ".join(f"{k} {word}" for k, word in enumerate(WORDS))
    header = f"h,{drawn.y_name},word: {words},t,largest E/E0,last E/E0 - 1"
    formats = ["%.9g", "%.9g", "%d", "%.6g", "%.6g", "%.4e"]  # 17 digits of 250 000 runs would be 20 MB
    path = folder / f"map_{drawn.name}.csv"
    np.savetxt(path, np.column_stack(columns), formats, delimiter=",", header=header, comments="")
    return outcome, end


FIRST_ENERGY = 1.1  # E/E0 beyond which the energy of the trapezoidal rule counts as risen
STARTS = {"published": -19.6, "rigid rotation": -(7.72**2) / 3.0443, "consistent": 0.0}  # a0, m/s^2


def first_rise(pendulum: Scene, h: Array, span: float = 50.0) -> Array:
    """When the trapezoidal rule's energy first exceeds 1.1 E0, s, for steps h (P,); NaN if not within the span."""
    rule = scheme("average_acceleration")
    lanes = march_lanes(pendulum, rule, h, whole_steps(span, h), bound=FIRST_ENERGY * pendulum.E0)
    return np.where(lanes.status == 0, np.nan, (lanes.n_done + 1) * h)


def critical_step(pendulum: Scene) -> float:
    """The step h, s, beyond which the trapezoidal rule's axial oscillation grows: h^2 omega v0/L = 4, as is derived."""
    bar, product = bar_of(pendulum), facade.turning("average_acceleration").product
    return float((float(product) / (bar.omega * bar.rate)) ** 0.5)


@styled
def trapezoidal_rule(folder: Path, full: bool = False) -> Array:
    """When the trapezoidal rule's energy rises, over 400 steps h, for three initial accelerations: (3, 400)."""
    h = np.geomspace(5e-3, 0.5, 400)
    figure = Figure(figsize=(8, 5.2))
    axes = figure.subplots()
    rises = {label: first_rise(stiff(a0), h) for label, a0 in STARTS.items()}
    for (label, t), colour, marker in zip(rises.items(), COLOURS, "o^s", strict=False):
        axes.loglog(h, t, marker, color=colour, markersize=3, label=f"$a_0$ = {STARTS[label]:.5g} m/s² ({label})")
    axes.axvline(critical_step(stiff()), color=REFERENCE, linewidth=1, linestyle="--", label="$h^2 \\omega v_0/L$ = 4")
    axes.set_xlabel("step $h$ (s)")
    axes.set_ylabel(f"first $t$ with $E$ > {FIRST_ENERGY:g} $E_0$ (s)")
    axes.set_title("Trapezoidal rule, stiff pendulum, 50 s: no rise left of the line")
    figure.legend(loc="outside lower center", ncols=2)
    save(
        figure, folder / "trapezoidal_rule", SECTION,
        f"""The trapezoidal rule on the stiff pendulum (EA = 10¹⁰ N, 50 s): when its energy first exceeds
        {FIRST_ENERGY:g} of that at the start, over the step h, for three initial accelerations along the bar. Left of
        h²ωv₀/L = 4, where errors along a bar that turns begin to grow, it never does, whatever they are.""",
    )  # fmt: skip
    save_csv(folder / "trapezoidal_rule.csv", ["h", *(f"a0 = {a0:g}" for a0 in STARTS.values())], [h, *rises.values()])
    return np.array(list(rises.values()))
