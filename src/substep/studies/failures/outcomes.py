"""The outcome of a run, one of four, and how outcomes are written to files and coloured."""

import csv
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch
from numpy.typing import NDArray

from ...core.outcome import STATUSES
from ...core.scenes import Scene
from ...core.schemes import Array, Scheme
from ...core.style import COLOURS
from ...marching.scene_lanes import Lanes, march_lanes

WORDS = ("survived", "gains energy", "blew up", "Newton failed")
SURVIVED, GAINS, BLEW_UP, NEWTON = range(4)
SECTION = "Where methods fail"  # of the page of results
GAIN = 1.01  # largest E/E0 of a run that survived
BLOW_UP = 1e3  # E/E0 beyond which a run has blown up

COLOUR_OF_WORD = ("0.88", COLOURS[1], COLOURS[3], COLOURS[0])
QUICK = (  # schemes run unless all are asked for: one of each kind, as each costs a compilation
    "central_difference",
    "average_acceleration",
    "generalized_alpha",
    "houbolt",
    "newmark_bdf2",
    "energy_momentum",
)


@dataclass(frozen=True)
class Outcome:
    """The outcomes of P runs.

    word (P,): place in WORDS; t (P,): end of the step that failed, s, NaN of a run that reached its end; max_ratio
    (P,): largest E/E0 of the states before that step, which is small for a run that blew up in a single step.
    """

    word: NDArray[np.int64]
    t: Array
    max_ratio: Array


def judge(lanes: Lanes, dt: Array, E0: float | Array) -> Outcome:
    """The outcome of runs in steps of dt (P,), s, marched with bound = BLOW_UP*E0, J; E0: one, or (P,).

    The first of these that holds: Newton failed; blew up: E > 1e3 E0 or a state that is not finite; gains energy:
    max E > 1.01 E0; survived.
    """
    ratio = lanes.peak / E0
    newton, completed = (lanes.status == STATUSES.index(status) for status in ("newton_failed", "completed"))
    blew_up = ~completed | (ratio > BLOW_UP)
    word = np.select([newton, blew_up, ratio > GAIN], [NEWTON, BLEW_UP, GAINS], SURVIVED)
    return Outcome(word, np.where(completed, np.nan, (lanes.n_done + 1) * dt), ratio)


def run(scene: Scene, scheme: Scheme, dt: Array, n: NDArray[np.int64], **options: Any) -> tuple[Lanes, Outcome]:
    """Lanes of `march_lanes`, each stopped when it blows up, and their outcomes; the scene may be one of lanes."""
    of_lanes = scene.u0.ndim > 1
    E0 = scene.energy(np.zeros(len(dt)), scene.u0, scene.v0) if of_lanes else scene.E0
    lanes = march_lanes(scene, scheme, dt, n, bound=BLOW_UP * E0, **options)
    return lanes, judge(lanes, dt, E0)


def whole_steps(span: float, dt: Array) -> NDArray[np.int64]:
    """How many whole steps dt (P,) fit into a span, both in s; a last step too long by rounding alone counts."""
    return np.floor(span / dt + 1e-9).astype(np.int64)


def write_rows(path: Path, rows: Sequence[Any]) -> None:
    """A table of rows of one dataclass as CSV, under the names of its fields."""
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([[f.name for f in fields(rows[0])], *(astuple(row) for row in rows)])


def paint(axes: Axes, x: Array, y: Array, word: Array) -> None:
    """Draw the cells of a map in the colours of their outcomes; NaN stays empty."""
    colours = ListedColormap(COLOUR_OF_WORD)
    axes.pcolormesh(x, y, word, cmap=colours, vmin=-0.5, vmax=len(WORDS) - 0.5, shading="nearest", rasterized=True)


def word_legend() -> list[Patch]:
    """Handles of a legend of the outcomes."""
    return [Patch(facecolor=colour, label=word) for colour, word in zip(COLOUR_OF_WORD, WORDS, strict=True)]
