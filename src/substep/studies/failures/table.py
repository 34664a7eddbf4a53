"""Every scheme on scenes where schemes fail, at a few steps each: a table of outcomes, and a chart of it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from ...core.scene_by_name import scene
from ...core.scenes import Scene
from ...core.schemes import scheme, schemes
from ...core.style import styled
from ...exact.periods import period
from ...figures.charts import save
from .outcomes import NEWTON, QUICK, SECTION, WORDS, paint, run, whole_steps, word_legend, write_rows


@dataclass(frozen=True)
class Row:
    """One run: step h and time of failure t in s (None if it reached its end), max_ratio the largest E/E0 before t."""

    scheme: str
    scene: str
    h: float
    word: str
    t: float | None
    max_ratio: float


@dataclass(frozen=True)
class Case:
    """A scene, the steps tried on it and the span of the runs, as parts and multiples of a characteristic time.

    given: the characteristic time in s; None stands for the scene's exact period.
    """

    label: str
    make: Callable[[], Scene]
    given: float | None
    parts: tuple[float, ...]
    span: float

    @cached_property
    def time(self) -> float:
        """The characteristic time, s."""
        return period(self.make()) if self.given is None else self.given

    @property
    def steps(self) -> tuple[float, ...]:
        """The steps h, s."""
        return tuple(self.time / part for part in self.parts)


CONTACT_TIME = 1e-3  # 1/omega_c of the bounce, s


def stiff(a0: float = -19.6, **parameters: float) -> Scene:
    """The stiff pendulum of Kuhl & Crisfield 1999 with its given initial acceleration a0 (m/s^2, along the bar)."""
    return scene("elastic_pendulum", **{"EA": 1e10, **parameters}, a0=(a0, 0.0))


CASES = (
    Case("stiff pendulum", stiff, 1.0, (10, 20, 50, 1 / 0.009, 1e3, 1e4), 50.0),
    Case("flexible pendulum", lambda: scene("elastic_pendulum", EA=1e4), 1.0, (20, 100, 1e3), 30.0),
    Case("Duffing", lambda: scene("duffing"), None, (4, 10, 20), 100.0),
    Case("softening", lambda: scene("softening"), None, (4, 20), 100.0),
    Case("near separatrix", lambda: scene("simple_pendulum"), None, (20, 100), 10.0),
    Case("Bathe-Noh", lambda: scene("bathe_noh"), 0.2618, (1, 10), 40.0),
    Case("penalty bounce", lambda: scene("penalty_bounce"), CONTACT_TIME, (0.1, 1, 10), 100.0),
)


def rows_of(case: Case, full: bool = False) -> list[Row]:
    """The outcome of one scheme of each kind, or of every scheme, at its default parameters."""
    model, steps = case.make(), np.array(case.steps)
    found = []
    for name in schemes() if full else QUICK:
        _, outcome = run(model, scheme(name), steps, whole_steps(case.span * case.time, steps))
        for h, word, t, ratio in zip(steps, outcome.word, outcome.t, outcome.max_ratio, strict=True):
            found.append(Row(name, case.label, float(h), WORDS[word], None if np.isnan(t) else float(t), float(ratio)))
    return found


@styled
def picture(folder: Path, rows: list[Row]) -> None:
    """The table as CSV, and its outcomes as a map of schemes over scenes and steps."""
    write_rows(folder / "failures.csv", rows)
    columns = [(case.label, h) for case in CASES for h in case.steps]
    names = list(dict.fromkeys(row.scheme for row in rows))
    word = np.full((len(names), len(columns)), np.nan)
    for row in rows:
        word[names.index(row.scheme), columns.index((row.scene, row.h))] = WORDS.index(row.word)
    figure = Figure(figsize=(11, 2.5 + 0.12 * len(names)))
    axes = figure.subplots()
    paint(axes, np.arange(len(columns)), np.arange(len(names)), word)
    for row in rows:
        if row.t is not None:
            x, y = columns.index((row.scene, row.h)), names.index(row.scheme)
            axes.text(x, y, f"{row.t:.3g}", ha="center", va="center", fontsize=6, color="white")
    axes.set_xticks(range(len(columns)), [f"{h:.3g}" for _, h in columns], rotation=90, fontsize=8)
    axes.set_yticks(range(len(names)), names, fontsize=8)
    axes.invert_yaxis()
    axes.set_xlabel("step $h$ (s)")
    start = 0
    for case in CASES:
        axes.axvline(start - 0.5, color="white", linewidth=3)
        axes.text(start - 0.4, -0.8, case.label, rotation=25, fontsize=9)
        start += len(case.steps)
    figure.legend(
        handles=word_legend(), loc="outside lower center", ncols=NEWTON + 1, title="numbers: time of failure in s"
    )
    save(
        figure, folder / "failures", SECTION,
        """Outcomes of schemes, each at its default parameters, on scenes where methods fail, at a few steps each:
        survived, gains energy (more than 1 %), blew up (a thousandfold energy, or no finite number), Newton failed. The
        number in a cell is the time of failure in s.""",
    )  # fmt: skip
