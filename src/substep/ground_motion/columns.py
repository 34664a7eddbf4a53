"""Ground motions in text: columns of time and acceleration, or accelerations alone, row by row."""

import re
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..core.arrays import Array
from ..core.errors import warn
from .formats import Read, numbers

UNEVEN = 0.01  # largest distance of a printed time from equal steps, as a part of a step
MOSTLY = 0.75  # part of the steps of a column that ascend, or are alike, if it is one of times
ALIKE = 0.1  # of those steps, the largest distance from their median, as a part of it
MISSING = 1.5  # steps from which on a longer one among alike ones is a gap
FEW = 10  # samples up to which a first one that is their number may be one of them
COMPONENTS = 3  # numbers a line, at most, that may be components rather than rows of one record
CURE = "correct it, or put '#' before what is no data"
DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+([eE][-+]?\d+)?")


class Row(NamedTuple):
    """A line of numbers."""

    number: int
    text: str
    values: list[float]


def columns(path: Path, lines: list[str], dt: float | None, resampled: bool) -> Read:
    """Two columns, time and acceleration, or with dt accelerations alone; resampled: their steps need not be equal.

    Warns of lines above the data that it skips; raises ValueError, which names the line.
    """
    start = _start(lines)
    header = [number for number, line in enumerate(lines[:start], start=1) if _fields(line)]
    skipped = f"lines {header[0]} to {header[-1]}" if len(header) > 1 else f"line {sum(header)}"
    if header and start == len(lines):
        line = lines[header[0] - 1].strip()
        raise ValueError(f"{path}, line {header[0]}: expected numbers below a header, got none below '{line[:60]}'")
    try:
        found = _accelerations(path, lines, start, dt, resampled)
    except ValueError as error:
        if not header:
            raise
        raise ValueError(f"{error}; skipped as a header: {skipped}") from error
    if header:
        warn(f"{path}: skipped as a header: {skipped}; put '#' before what is no data")
    return found._replace(above="\n".join(lines[:start]))


def starts_with_numbers(lines: list[str]) -> bool:
    """Whether the first line but for blanks and comments is one of numbers."""
    first = next((line for line in lines if _fields(line)), "")
    return first != "" and all(_is_number(text) for text in _fields(first))


def _start(lines: list[str]) -> int:
    """The index of the first line of data: of numbers, or of as many fields as these have, a number first."""
    first = next((k for k, line in enumerate(lines) if starts_with_numbers([line])), len(lines))
    if first == len(lines):
        return first
    width = len(_fields(lines[first]))
    broken = (k for k in range(first) if len(texts := _fields(lines[k])) == width and _is_number(texts[0]))
    return next(broken, first)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _fields(line: str) -> list[str]:
    """What stands between semicolons, tabs, commas or blanks before '#'; the first two may part decimal commas."""
    text = line.partition("#")[0].strip()
    decimal = "," if "." not in text else "."
    if ";" in text:
        return [field.strip().replace(decimal, ".") for field in text.removesuffix(";").split(";")]
    words = text.split()
    if "\t" in text and "." not in text and all(DECIMAL_COMMA.fullmatch(word) for word in words if "," in word):
        return [word.replace(",", ".") for word in words]
    return re.split(r"\s*,\s*|\s+", text.removesuffix(",").rstrip()) if "," in text else words


def _accelerations(path: Path, lines: list[str], start: int, dt: float | None, resampled: bool) -> Read:
    rows = [
        Row(number, line.partition("#")[0].strip(), numbers(path, number, line, texts, CURE))
        for number, line in enumerate(lines[start:], start + 1)
        if (texts := _fields(line))
    ]
    if dt is None or _have_times(rows):
        return _two_columns(path, rows, dt, resampled)
    return Read(float(dt), _row_by_row(path, lines, rows, dt))


def _have_times(rows: list[Row]) -> bool:
    """Whether the first of several numbers a line is a time; of more than two, only where its steps are alike.

    Nor are they times where the last line is shorter than those above, as of a record written in rows.
    """
    if len(rows) < 2 or len(rows[0].values) < 2:
        return False
    steps = np.diff([row.values[0] for row in rows])
    if len(rows[0].values) == 2:
        return bool(np.mean(steps > 0.0) >= MOSTLY)
    if len(rows[-1].values) < len(rows[0].values):
        return False
    return len(steps) > 1 and _alike(steps)


def _alike(steps: Array) -> bool:
    """Whether most of the steps are their median, about, and that is positive."""
    middle = float(np.median(steps))
    return middle > 0.0 and bool(np.mean(np.abs(steps - middle) <= ALIKE * middle) >= MOSTLY)


def _row_by_row(path: Path, lines: list[str], rows: list[Row], dt: float) -> Array:
    width = len(rows[0].values) if rows else 0
    for row, after in pairwise(rows):
        short = after is rows[-1] and len(after.values) < width
        if len(after.values) != width and not short:
            raise ValueError(
                f"{path}, line {after.number}: expected {width} a line as above, got {len(after.values)}: "
                f"'{after.text}'; correct it, or write one number a line"
            )
        gap = next((k for k in range(row.number + 1, after.number) if not lines[k - 1].strip()), None)
        if gap is not None:
            raise ValueError(f"{path}, line {gap}: expected a number, got an empty line; fill it, or delete it")
    for row in rows:
        if width > 1 and re.search(r"[,;\t]", row.text):
            raise ValueError(
                f"{path}, line {row.number}: expected one acceleration a line, or time and acceleration, got {width} "
                f"columns: '{row.text}'; choose one column, separate rows of one record by blanks, or write decimal "
                "points"
            )
    values = np.array([x for row in rows for x in row.values])
    if len(values) < 2:
        raise ValueError(f"{path}: expected at least two numbers, got {len(values)}")
    first, n = values[0], len(values) - 1
    if width == 1 and (first == dt or (first == n and n > FEW)):
        raise ValueError(
            f"{path}, line {rows[0].number}: expected accelerations, got {first:g} first, which is "
            f"{'dt' if first == dt else 'the number of those that follow'}; put '#' before it, or, if it is one of "
            "them, give ss.Record(dt, accelerations)"
        )
    if len(rows) > 1 and 1 < width <= COMPONENTS:
        warn(
            f"{path}: read {len(values)} accelerations row by row, {width} a line; if these are components, choose one "
            "and write it alone"
        )
    return values


def _two_columns(path: Path, rows: list[Row], dt: float | None, resampled: bool) -> Read:
    for row in rows:
        if len(row.values) != 2:
            raise ValueError(
                f"{path}, line {row.number}: expected two columns, time and acceleration, got {len(row.values)}: "
                f"'{row.text}'; put '#' before what is no data, name a PEER file *.AT2, choose two of more columns, "
                "separate decimal commas by ';', or give dt for accelerations alone"
            )
    if len(rows) < 2:
        raise ValueError(f"{path}: expected at least two lines of time and acceleration, got {len(rows)}")
    t, values = np.array([row.values for row in rows]).T
    late = np.flatnonzero(np.diff(t) <= 0.0) + 1
    if late.size:
        k = int(late[0])
        raise ValueError(
            f"{path}, line {rows[k].number}: expected equal steps, or with resample= ascending times, got "
            f"t = {t[k]:g} s after {t[k - 1]:g} s; correct it, or delete the line"
        )
    _require_no_gap(path, rows, t, bridged=resampled and dt is None)
    step = float(f"{(t[-1] - t[0]) / (len(t) - 1):.12g}") if dt is None else float(dt)
    off = np.abs(t - t[0] - step * np.arange(len(t)))
    if (off > UNEVEN * step).any() and (dt is not None or not resampled):
        k = int(np.argmax(off > UNEVEN * step))
        which = "equal steps, in the mean" if dt is None else "steps of the given dt ="
        raise ValueError(
            f"{path}, line {rows[k].number}: expected {which} {step:g} s, each time within {UNEVEN:.0%} of a step of "
            f"where they put it, got t = {t[k]:g} s for {t[0] + k * step:g} s; interpolate by resample=, a "
            f"step in s, print times with more digits, or give the accelerations alone with their dt"
        )
    return Read(step, values, times=t if dt is None else None)


def _require_no_gap(path: Path, rows: list[Row], t: Array, bridged: bool) -> None:
    """Raise ValueError, or warn of what is bridged, where a step among equal ones is longer, as of missing lines."""
    steps = np.diff(t)
    middle = float(np.median(steps))
    gaps = np.flatnonzero(steps > MISSING * middle)
    if not gaps.size or not _alike(steps):
        return
    k = int(gaps[0])
    what = (
        f"{path}, line {rows[k + 1].number}: expected steps of {middle:g} s, as most are, got t = {t[k + 1]:g} s after "
        f"{t[k]:g} s; gaps in all: {gaps.size}"
    )
    if not bridged:
        raise ValueError(f"{what}; fill in what is missing, or bridge it linearly by resample=, a step in s")
    warn(f"{what}, bridged linearly")
