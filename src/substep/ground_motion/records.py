"""Ground motions from files of the formats that people have."""

import re
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from pathlib import Path

import numpy as np

from ..core.arrays import Array
from ..core.errors import called_as, real_number, warn
from ..core.loads import Record
from ..core.units import UNITS, require_plausible, require_step, unit_named, unit_of
from .columns import columns, starts_with_numbers
from .formats import Read, at2, esm, is_at2, is_esm, is_seismic, seismic


@called_as('read_record("motion.AT2")')
def read_record(
    path: str | Path,
    dt: float | None = None,
    unit: str | float | None = None,
    *,
    resample: float | None = None,
) -> Record:
    """The ground acceleration of a file, in m/s^2, with the unit in which it stands there.

    A file is, by its content or suffix: PEER's .AT2, in g; ESM's ASCII, by its header; one trace of K-NET, SAC,
    miniSEED or GSE, read by ObsPy (the extra `seismic`); else text. Text has two columns, time in s and acceleration,
    parted by blanks, tabs, commas or semicolons, with decimal points or, between semicolons or tabs, commas; or, with
    dt, accelerations alone, one a line or several parted by blanks, row by row, as OpenSees reads them. With dt, two
    numbers a line are columns unless the first does not ascend. Comments follow '#'; other lines above the data are
    skipped with a warning. Of times only the steps count: the record starts at 0, wherever they do. No baseline is
    corrected.

    dt, s: of accelerations alone, or of times that are printed with too few digits, which are held to it. unit: of the
    accelerations, one of `units.UNITS` or a factor to m/s^2; by default the one that the file says, text in a line
    above the data, else of text m/s^2 if its peak is that of a ground motion. SAC, miniSEED and GSE do not say it.
    resample, s: the step of the record that is made by interpolating linearly from the first time to the last, whose
    steps then need not be equal; what is left at the end, less than a step, is dropped. Where a was smooth, this is
    wrong by at most h^2 max|a''|/8 for steps h of the file: it takes from high frequencies. No filter precedes it, so
    that longer steps alias what is above 1/(2 resample) Hz.

    Raises ValueError, which names file and line, for what is not a number, for unequal steps without resample, times
    that do not ascend, a time more than a hundredth of a step from equal steps, for a number of samples that is not the
    header's, for what is no acceleration, for a dt or a unit that is not the file's, and for accelerations of text
    without a unit whose peak is above 5 g or below 1e-4 g in m/s^2, and for steps above 1 s, which are likely ms;
    ImportError where ObsPy is needed and not
    installed; OSError for a file that cannot be read.

    >>> np.savetxt("motion.txt", [[0.0, 0.0], [0.01, 0.1], [0.02, 0.3]], header="time (s), acceleration (g)")
    >>> motion = ss.read_record("motion.txt")
    >>> motion, float(motion.samples[-1].round(3))  # m/s^2
    (Record(dt=0.01, 3 samples, unit='g', source='motion.txt'), 2.942)
    """
    path = Path(path)
    lines = _text(path).splitlines()
    for name, step in (("dt", dt), ("resample", resample)):
        if step is not None:
            real_number(name, step, positive=True)
    given = None if unit is None else unit_of(unit)
    found = _read(path, lines, dt, unit, resampled=resample is not None)
    require_step(str(path), found.step)
    forced = given is not None and not isinstance(unit, str)
    named = found.unit or _unit_above(path, found.above, forced)
    if given is None and named is None:
        require_plausible(str(path), found.values, ", or name it in a comment above the data")
    if given is None and named is not None and named not in UNITS:
        raise ValueError(
            f"{path}: expected a unit of acceleration, one of {', '.join(UNITS)}, got '{named}'; give unit=, one of "
            "these or a factor to m/s^2, or correct the text above the data"
        )
    if given is not None and given[1] != UNITS.get(named or "", given[1]):
        if found.unit is not None or not forced:
            raise ValueError(f"{path}: expected unit='{named}', as the file says, got {unit!r}; leave it out")
        warn(f"{path}: taken in {given[0]}, as unit={unit!r} says, though the text above the data names {named}")
    _require_no_filler(path, found)
    source, step, values = str(path), found.step, found.values
    if resample is not None:
        step = float(resample)
        values, error = _resampled(path, found, step)
        source += f", resampled with an error of {error / (np.abs(found.values).max() or 1.0):.1%} of the peak"
    return Record(step, values, unit=(named or "m/s^2") if unit is None else unit, source=source)


def _read(path: Path, lines: list[str], dt: float | None, unit: str | float | None, resampled: bool) -> Read:
    """What the file says, by its format."""
    if is_at2(path, lines):
        return at2(path, lines, dt)
    if is_esm(lines):
        return esm(path, lines, dt)
    if is_seismic(path, lines) and not starts_with_numbers(lines):
        return seismic(path, dt, unit)
    return columns(path, lines, dt, resampled)


def _text(path: Path) -> str:
    """The text of a file, in UTF-8, or as spreadsheets write it: UTF-16 with its mark, or Windows-1252."""
    written = path.read_bytes()
    if written.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        return written.decode("utf-16", errors="replace")
    try:
        return written.decode("utf-8-sig")
    except UnicodeDecodeError:
        return written.decode("cp1252", errors="replace")


def _unit_above(path: Path, text: str, forced: bool) -> str | None:
    """The unit that the text above the data names; forced: whether a factor is given, which counts
    whatever that text is."""
    try:
        return unit_named(text)
    except ValueError as error:
        if forced:
            return None
        raise ValueError(f"{path}: {error}") from error


def _require_no_filler(path: Path, found: Read) -> None:
    """Raise ValueError for samples of nines, as -999, where no other one is near as large: they stand for none."""
    size = np.abs(found.values)
    largest = f"{size.max():.10g}"
    others = size[size < size.max()]
    if re.fullmatch(r"999+(\.9*)?", largest) and 10.0 * others.max(initial=0.0) < size.max():
        k = int(size.argmax())
        raise ValueError(
            f"{path}: expected accelerations, got {found.values[k]:.10g} as number {k + 1} of them, which is likely "
            "the filler of a missing one; put a number in its place"
        )


def _resampled(path: Path, found: Read, step: float) -> tuple[Array, float]:
    """The accelerations in steps from the first time to the last, linear between those of the file, and the error.

    That is the largest, in the file's unit, where a'' is what differences of the samples say.
    """
    t = found.step * np.arange(len(found.values)) if found.times is None else found.times - found.times[0]
    n = int(t[-1] / step * (1.0 + 1e-9)) + 1
    if n < 2:
        raise ValueError(f"{path}: expected resample of at most the record's {t[-1]:g} s, got {step:g} s; give less")
    x = step * np.arange(n)
    h = np.diff(t)
    bent = np.abs(np.diff(np.diff(found.values) / h) / (0.5 * (h[1:] + h[:-1])))  # |a''|
    k = np.clip(np.searchsorted(t, x, side="right") - 1, 0, len(h) - 1)
    error = 0.5 * (x - t[k]) * (t[k + 1] - x) * np.maximum(np.append(0.0, bent), np.append(bent, 0.0))[k]
    return np.interp(x, t, found.values), float(error.max())
