"""Ground motions from files: two columns of text, or the .AT2 of PEER's strong motion data base."""

import re
from pathlib import Path

import numpy as np

from ..core.errors import called_as, real_number
from ..core.loads import Record
from ..core.schemes import Array
from ..core.units import UNITS, require_plausible, unit_named, unit_of

UNEVEN = 0.01  # largest distance of a printed time from equal steps, as a part of a step
AT2_HEADER = 4  # lines before the samples
NUMBER = r"([0-9]*\.?[0-9]+(?:[eEdD][-+]?[0-9]+)?)"
AT2_SIZES = (  # NPTS= 4000, DT= .01000 SEC, and the older 4000 0.0100 NPTS, DT
    re.compile(rf"NPTS\s*=\s*(\d+)\s*,?\s*DT\s*=\s*{NUMBER}", re.IGNORECASE),
    re.compile(rf"^\s*(\d+)\s+{NUMBER}\s+NPTS\s*,\s*DT", re.IGNORECASE),
)


@called_as('read_record("motion.AT2")')
def read_record(path: str | Path, dt: float | None = None, unit: str | float | None = None) -> Record:
    """The ground acceleration of a file, in m/s^2, with the unit in which it stands there.

    A suffix .AT2, in any case, means PEER's format, in g; any other file has two columns, time in s and acceleration,
    separated by blanks or a comma, with comments after '#'. dt, s: to be given where the times are printed with too few
    digits. unit: of the accelerations, one of `units.UNITS` or a factor to m/s^2; by default the one that a comment
    above the data names, else m/s^2 if its peak is that of a ground motion.

    Raises ValueError, which names file and line, for text that is not a number, for a time more than a hundredth of a
    step from equal steps, for an .AT2 file whose number of samples is not that of its header or whose unit is not g,
    for a dt or a unit that is not the file's, and for accelerations without a unit whose peak is above 5 g or below
    1e-4 g in m/s^2; OSError for a file that cannot be read.

    >>> np.savetxt("motion.txt", [[0.0, 0.0], [0.01, 0.1], [0.02, 0.3]], header="time (s), acceleration (g)")
    >>> motion = ss.read_record("motion.txt")
    >>> motion, float(motion.samples[-1].round(3))  # m/s^2
    (Record(dt=0.01, 3 samples, unit='g', source='motion.txt'), 2.942)
    """
    path = Path(path)
    lines = path.read_text(encoding="utf-8-sig", errors="replace").splitlines()
    if dt is not None:
        real_number("dt", dt, positive=True)
    given = None if unit is None else unit_of(unit)
    if path.suffix.lower() == ".at2":
        step, values, named = (*_at2(path, lines, dt), "g")
    else:
        step, values = _two_columns(path, lines, dt)
        named = _unit_above(path, lines) if given is None or isinstance(unit, str) else None
    if given is None and named is None:
        require_plausible(str(path), values)
    if given is not None and named is not None and given[1] != UNITS[named]:
        raise ValueError(f"{path}: expected unit='{named}', as the file says, got {unit!r}; leave it out")
    taken = (named or "m/s^2") if unit is None else unit
    return Record(step, values, unit=taken, source=str(path))


def _unit_above(path: Path, lines: list[str]) -> str | None:
    """The unit that the comments above the data name."""
    above = []
    for line in lines:
        data, _, comment = line.partition("#")
        if data.strip():
            break
        above.append(comment)
    try:
        return unit_named("\n".join(above))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _numbers(path: Path, number: int, texts: list[str]) -> list[float]:
    try:
        values = [float(text) for text in texts]
    except ValueError as error:
        raise ValueError(f"{path}, line {number}: expected numbers, got '{' '.join(texts)}'; correct it") from error
    if not np.isfinite(values).all():
        raise ValueError(f"{path}, line {number}: expected finite numbers, got '{' '.join(texts)}'; correct it")
    return values


def _two_columns(path: Path, lines: list[str], dt: float | None) -> tuple[float, Array]:
    rows, numbers = [], []
    for number, line in enumerate(lines, start=1):
        texts = line.partition("#")[0].replace(",", " ").split()
        if not texts:
            continue
        if len(texts) != 2:
            raise ValueError(
                f"{path}, line {number}: expected two columns, time and acceleration, got {len(texts)}: "
                f"'{line.strip()}'; put '#' before what is no data, name a PEER file *.AT2"
            )
        rows.append(_numbers(path, number, texts))
        numbers.append(number)
    if len(rows) < 2:
        raise ValueError(f"{path}: expected at least two lines of time and acceleration, got {len(rows)}")
    t, values = np.array(rows).T
    step = float(f"{(t[-1] - t[0]) / (len(t) - 1):.12g}") if dt is None else float(dt)
    off = np.abs(t - t[0] - step * np.arange(len(t)))
    if step <= 0.0 or (off > UNEVEN * step).any():
        k = int(np.argmax(off > UNEVEN * step))
        which = "equal steps, in the mean" if dt is None else "steps of the given dt ="
        raise ValueError(
            f"{path}, line {numbers[k]}: expected {which} {step:g} s, each time within {UNEVEN:.0%} of a step of where "
            f"they put it, got t = {t[k]:g} s for {t[0] + k * step:g} s; resample the record, print times "
            f"with more digits, or give the accelerations alone, as an array with its dt"
        )
    return step, values


def _at2(path: Path, lines: list[str], dt: float | None) -> tuple[float, Array]:
    header = lines[:AT2_HEADER]
    sizes = [(k, found) for k, line in enumerate(header) for form in AT2_SIZES if (found := form.search(line))]
    if not sizes:
        raise ValueError(f"{path}: expected NPTS and DT in the first {AT2_HEADER} lines of a PEER file, got none")
    at, found = sizes[0]
    n, step = int(found[1]), float(found[2].upper().replace("D", "E"))
    units = [(k, line) for k, line in enumerate(header, start=1) if "UNITS" in line.upper()]
    if not units or not re.search(r"ACCELERATION.*UNITS\s*(?:OF|:|=)?\s*\(?G\b(?!\s*[/*])", units[0][1].upper()):
        where, text = (f", line {units[0][0]}", f"'{units[0][1].strip()}'") if units else ("", "no line on units")
        raise ValueError(
            f"{path}{where}: expected an acceleration in units of g, got {text}; convert it to two columns, time in s "
            f"and acceleration in m/s^2"
        )
    values = [x for k, line in enumerate(lines[at + 1 :], start=at + 2) for x in _numbers(path, k, line.split())]
    if len(values) != n:
        raise ValueError(f"{path}, line {at + 1}: expected NPTS = {n} samples to follow, got {len(values)}")
    if step <= 0.0 or n < 2:
        raise ValueError(f"{path}, line {at + 1}: expected two samples or more and DT > 0, got {n} and {step:g}")
    if dt is not None and abs(dt - step) > 1e-9 * step:
        raise ValueError(f"{path}, line {at + 1}: expected the given dt = {dt:g} s, got DT = {step:g} s; leave dt out")
    return step, np.array(values)
