"""Where schemes fail: a battery of studies, each of which writes a table and most of which draw a chart."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from .contact import bounce
from .linear import alternating_steps, limits_crossed, overshoot
from .maps import MAPS, draw, trapezoidal_rule
from .outcomes import WORDS, Outcome, judge
from .rounding import round_off, separatrix
from .table import CASES, Row, picture, rows_of

__all__ = ["WORDS", "Outcome", "Row", "battery", "count", "judge"]

ITEMS: tuple[Callable[[Path, bool], Any], ...] = (
    trapezoidal_rule,
    limits_crossed,
    overshoot,
    alternating_steps,
    bounce,
    round_off,
    separatrix,
)
QUICK_POINTS, FULL_POINTS = 100, 500  # along each side of a map


def battery(folder: Path, step: Callable[[], object], full: bool = False) -> list[Row]:
    """The whole battery into the folder; the rows of its table, scheme by scheme and scene by scene.

    step: called `count()` times, after each part. full: every scheme on every scene, and maps of 500 x 500 runs; by
    default one scheme of each kind runs on scenes whose kernels are not committed, and maps are 100 x 100.
    """
    folder.mkdir(parents=True, exist_ok=True)
    rows: list[Row] = []
    for case in CASES:
        rows += rows_of(case, full)
        step()
    picture(folder, rows)
    points = FULL_POINTS if full else QUICK_POINTS
    for drawn in MAPS:
        draw(folder, drawn, points)
        step()
    for item in ITEMS:
        item(folder, full)
        step()
    return rows


def count() -> int:
    """How often `battery` calls its step."""
    return len(CASES) + len(MAPS) + len(ITEMS)
