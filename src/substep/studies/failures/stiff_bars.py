"""The elastic pendulum over step and stiffness: where errors along its bar are predicted to grow, and what runs do."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from ...core.scene_by_name import scene
from ...core.schemes import Array, Scheme, scheme, schemes
from ...core.style import COLOURS, styled
from ...figures.charts import save
from ..turning import CLOSE, FARTHEST, bar_of, early_energy, growth
from .maps import MOST_STEPS, SPAN, STEPS
from .outcomes import GAIN, QUICK, SECTION, SURVIVED, WORDS, run, whole_steps, write_rows

STIFFNESS = tuple(10.0**k for k in range(5, 12))  # EA, N
POINTS = 24  # steps h for each
EARLY = 4  # steps of which the energy is predicted, or those of a radian
SHADES = {  # (predicted, observed) -> colour and name
    (False, False): ("0.88", "neither"),
    (True, True): (COLOURS[0], "predicted and observed"),
    (True, False): (COLOURS[1], "predicted alone"),
    (False, True): (COLOURS[3], "observed alone"),
}


@dataclass(frozen=True)
class BarCell:
    """One run: bar stiffness EA in N, step h in s, whether it was predicted to fail, and the word for what it did."""

    scheme: str
    EA: float
    h: float
    predicted: bool
    word: str

    @property
    def agrees(self) -> bool:
        """Whether it failed, in any way, as predicted."""
        return self.predicted == (self.word != WORDS[SURVIVED])


def cells(s: Scheme, EA: float, h: Array) -> list[BarCell]:
    """Prediction and outcome of runs of SPAN or MOST_STEPS steps h (P,) from rest along the bar, with consistent a.

    The bar, unstretched at the start, oscillates by the stretch m v0^2/EA of its tension in steady rotation. A run is
    predicted to fail if errors grow from there, by `growth` a step, to the stretch that holds as much energy as a
    run that survived may have gained; or if the scheme gains that much by itself, by `early_energy` in EARLY steps or
    in the first radian; or if the scheme that starts it does. Raises DeclarationError as `growth`.
    """
    pendulum = scene("elastic_pendulum", EA=EA, a0="consistent")
    bar, n = bar_of(pendulum), np.minimum(whole_steps(SPAN, h), MOST_STEPS)
    Omega, tau = bar.omega * h, bar.rate * h
    factors = growth(s, Omega, tau)
    largest = np.sqrt(GAIN - 1.0) * bar.omega / bar.rate  # of these two stretches one over the other
    predicted = (factors > 1.0 + CLOSE) & (n * np.log(factors) > np.log(max(largest, 1.0)))
    radian = np.maximum(EARLY, 1.0 // tau)
    predicted |= early_energy(s, Omega, tau, np.minimum(radian, n)) > GAIN
    if (starter := s.starter) is not None:
        predicted |= early_energy(starter, Omega, tau, np.full(len(h), s.starting_steps)) > GAIN
    _, outcome = run(pendulum, s, h, n)
    return [
        BarCell(s.name, EA, float(x), bool(failing), WORDS[word])
        for x, failing, word in zip(h, predicted, outcome.word, strict=True)
    ]


def steps() -> Array:
    """The steps h (POINTS,), s, up to the largest turn a step for which growth is predicted."""
    return np.geomspace(STEPS[0], 0.99 * FARTHEST / bar_of(scene("elastic_pendulum", EA=STIFFNESS[0])).rate, POINTS)


@styled
def over_stiffness(folder: Path, full: bool = False) -> list[BarCell]:
    """All cells of one scheme of each kind, or of every scheme, of which growth is derived; as CSV, PNG and SVG."""
    found = []
    for name in schemes() if full else QUICK:
        s = scheme(name)
        if not _is_refused(s):
            found += [cell for EA in STIFFNESS for cell in cells(s, EA, steps())]
    write_rows(folder / "stiff_bars.csv", found)
    share = np.mean([cell.agrees for cell in found])
    failed = np.mean([cell.agrees for cell in found if cell.predicted])
    names = list(dict.fromkeys(cell.scheme for cell in found))
    width = len(STIFFNESS) * POINTS
    shade = [[*SHADES].index((cell.predicted, cell.word != WORDS[SURVIVED])) for cell in found]
    figure = Figure(figsize=(11, 2.2 + 0.14 * len(names)))
    axes = figure.subplots()
    colours = ListedColormap([colour for colour, _ in SHADES.values()])
    axes.imshow(
        np.array(shade).reshape(len(names), width), cmap=colours, vmin=-0.5, vmax=len(SHADES) - 0.5, aspect="auto",
        interpolation="nearest",
    )  # fmt: skip
    for k, EA in enumerate(STIFFNESS):
        axes.axvline(k * POINTS - 0.5, color="white", linewidth=3)
        axes.text((k + 0.5) * POINTS, -0.7, f"$EA = 10^{{{np.log10(EA):.0f}}}$ N", ha="center", va="bottom", fontsize=8)
    h = steps()
    ticks = range(0, width, POINTS // 3)
    axes.set_xticks(ticks, [f"{h[k % POINTS]:.2g}" for k in ticks], rotation=90, fontsize=7)
    axes.set_yticks(range(len(names)), names, fontsize=7)
    axes.grid(visible=False)
    axes.set_xlabel("step $h$ (s), in each block from left to right")
    figure.legend(
        handles=[Patch(facecolor=colour, label=label) for colour, label in SHADES.values()],
        loc="outside lower center", ncols=len(SHADES), title="the run fails",
    )  # fmt: skip
    save(
        figure, folder / "stiff_bars", SECTION,
        f"""The elastic pendulum from bar stiffness EA = 10⁵ to 10¹¹ N, in steps from {h[0]:g} to {h[-1]:.2g} s, of
        {SPAN:g} s or {MOST_STEPS} steps: where errors along the bar are predicted to grow by 1 % of the energy, or the
        first steps to gain as much, from the turning of the bar alone, before any run, and where runs fail (gain more
        than 1 %, blow up, or have no solution). Both agree in {100 * share:.1f} % of {len(found)} runs; of those
        predicted to fail {100 * failed:.1f} % do.""",
    )  # fmt: skip
    return found


def _is_refused(s: Scheme) -> bool:
    try:
        growth(s, 1.0, 0.1)
    except ValueError:
        return True
    return False
