"""Where schemes fail: a battery of studies, each of which writes a table and most of which draw a chart."""

from collections.abc import Callable, Iterable
from itertools import product
from pathlib import Path
from typing import Any

from .contact import bounce
from .impact_bar import COURANT, GRAVITY, LAWS, BarRow
from .impact_bar import rows_of as bar_rows
from .impact_map import contact_map, summary
from .linear import alternating_steps, limits_crossed, overshoot
from .maps import MAPS, draw, trapezoidal_rule
from .outcomes import WORDS, Outcome, judge
from .plane import failure_map
from .rounding import round_off, separatrix
from .stiff_bars import over_stiffness
from .table import CASES, Row, picture, rows_of

__all__ = ["WORDS", "BarRow", "Outcome", "Row", "battery", "count", "failure_map", "joined", "judge", "part", "summary"]

ITEMS: tuple[Callable[[Path, bool], Any], ...] = (
    trapezoidal_rule,
    over_stiffness,
    limits_crossed,
    overshoot,
    alternating_steps,
    bounce,
    round_off,
    separatrix,
)
BARS = tuple(product(LAWS, COURANT, GRAVITY))
QUICK_POINTS, FULL_POINTS = 100, 500  # along each side of a map


def battery(folder: Path, step: Callable[[list[Row] | list[BarRow]], object], full: bool = False) -> list[Row]:
    """The whole battery into the folder; the rows of its table, scheme by scheme and scene by scene.

    step: called `count()` times, after each part, with the rows of that part. full: every scheme on every scene, and
    maps of 500 x 500 runs; by default one scheme of each kind, and maps of 100 x 100.
    """
    folder.mkdir(parents=True, exist_ok=True)
    parts = []
    for i in range(count()):
        parts.append(part(folder, full, i))
        step(parts[-1])
    return joined(folder, parts)


def part(folder: Path, full: bool, i: int) -> list[Row] | list[BarRow]:
    """Part i of the `count()` parts, none of which needs another; its rows of the table, or of the map of contact."""
    if i < len(CASES):
        return rows_of(CASES[i], full)
    i -= len(CASES)
    if i < len(BARS):
        return bar_rows(*BARS[i], full)
    i -= len(BARS)
    if i < len(MAPS):
        draw(folder, MAPS[i], FULL_POINTS if full else QUICK_POINTS)
    else:
        ITEMS[i - len(MAPS)](folder, full)
    return []


def joined(folder: Path, parts: Iterable[list[Row] | list[BarRow]]) -> list[Row]:
    """The rows of the table of all parts, in their order; they are written and drawn too, as is the map of contact."""
    found = [row for part in parts for row in part]
    rows = [row for row in found if isinstance(row, Row)]
    picture(folder, rows)
    if fallen := [row for row in found if isinstance(row, BarRow)]:
        contact_map(folder, fallen)
    return rows


def count() -> int:
    """How many parts the battery has."""
    return len(CASES) + len(BARS) + len(MAPS) + len(ITEMS)
