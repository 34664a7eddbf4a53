"""Ground motions in formats that say their step: PEER's .AT2, ESM's ASCII, and what ObsPy reads."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..core.arrays import Array
from ..core.errors import optional, real_array, real_number
from ..core.units import unit_of

AT2_HEADER = 4  # lines before the samples
NUMBER = r"([0-9]*\.?[0-9]+(?:[eEdD][-+]?[0-9]+)?)"
AT2_SIZES = (  # NPTS= 4000, DT= .01000 SEC, and the older 4000 0.0100 NPTS, DT
    re.compile(rf"NPTS\s*=\s*(\d+)\s*,?\s*DT\s*=\s*{NUMBER}", re.IGNORECASE),
    re.compile(rf"^\s*(\d+)\s+{NUMBER}\s+NPTS\s*,\s*DT", re.IGNORECASE),
)
ESM_KEY = re.compile(r"([A-Z][A-Z0-9_/^]*):(.*)")
ESM_STEP = "SAMPLING_INTERVAL_S"
ESM_HEADER = 100  # lines, at most; ESM writes 64
KNET_SCALE = "Scale Factor"  # counts to gal, in the header of K-NET and KiK-net
KNET_HEADER = 17  # lines before the samples
KNET_FORMAT = "KNET"  # ObsPy's name of it, in a trace's stats
SEISMIC = re.compile(r"\.(sac|mseed|gse|v[12]|(ew|ns|ud)[12]?)", re.IGNORECASE)

UNREAD = (".v1", ".v2")  # of CSMIP and COSMOS, in blocks of acceleration, velocity and displacement


class Read(NamedTuple):
    """What a file says: accelerations (n,) in their unit, None for none, a step apart or at times (n,)."""

    step: float
    values: Array
    unit: str | None = None
    times: Array | None = None  # where they were printed
    above: str = ""  # the text above the data, which may name a unit


class Said(NamedTuple):
    """A value in a header: its name, the value, and the file and line where it stands."""

    name: str
    value: Any
    where: str


def numbers(path: Path, number: int, line: str, texts: list[str], cure: str = "correct it") -> list[float]:
    """The numbers that the texts of a line are; raises ValueError, which names the line."""
    try:
        values = [float(text) for text in texts]
    except ValueError as error:
        raise ValueError(f"{path}, line {number}: expected numbers, got '{line.strip()}'; {cure}") from error
    if not np.isfinite(values).all():
        raise ValueError(f"{path}, line {number}: expected finite numbers, got '{line.strip()}'; correct it")
    return values


def is_at2(path: Path, lines: list[str]) -> bool:
    """Whether the file is PEER's, by its suffix or its sizes."""
    header = [line for line in lines[:AT2_HEADER] if not line.lstrip().startswith("#")]
    return path.suffix.lower() == ".at2" or any(form.search(line) for line in header for form in AT2_SIZES)


def at2(path: Path, lines: list[str], dt: float | None) -> Read:
    """A file of PEER's strong motion data base, in g; raises ValueError."""
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
    size, h = (Said(name, value, f"{path}, line {at + 1}") for name, value in (("NPTS", n), ("DT", step)))
    return Read(step, _samples(path, lines, at + 1, size, h, dt), "g")


def is_esm(lines: list[str]) -> bool:
    """Whether the file has the header of the Engineering Strong-Motion database."""
    return any(line.startswith(f"{ESM_STEP}:") for line in lines[:ESM_HEADER])


def esm(path: Path, lines: list[str], dt: float | None) -> Read:
    """A file of the Engineering Strong-Motion database (ESM), one sample a line; raises ValueError."""
    header: dict[str, tuple[str, int]] = {}
    for number, line in enumerate(lines, start=1):
        found = ESM_KEY.match(line)
        if found is None:
            break
        header[found[1]] = found[2].strip(), number

    def said(key: str, of: Callable[[str], Any]) -> Said:
        text, number = header.get(key, ("none", 0))
        where = f"{path}, line {number}" if number else str(path)
        try:
            return Said(key, of(text), where)
        except ValueError as error:
            raise ValueError(f"{where}: expected {key} in the header of ESM, got {text}; download it again") from error

    kind = said("DATA_TYPE", str)
    if kind.value != "ACCELERATION":
        raise ValueError(
            f"{kind.where}: expected DATA_TYPE: ACCELERATION, got {kind.value}; take ESM's file of accelerations"
        )
    step, unit = said(ESM_STEP, float), said("UNITS", lambda text: unit_of(text)[0])
    return Read(step.value, _samples(path, lines, len(header), said("NDATA", int), step, dt), unit.value)


def _samples(path: Path, lines: list[str], start: int, n: Said, step: Said, dt: float | None) -> Array:
    """The samples from a line on, as many, and in such steps, as the header says."""
    values = [x for k, line in enumerate(lines[start:], start + 1) for x in numbers(path, k, line, line.split())]
    if len(values) != n.value:
        raise ValueError(f"{n.where}: expected {n.name} = {n.value} samples to follow, got {len(values)}; correct it")
    if not step.value > 0.0 or len(values) < 2:
        raise ValueError(
            f"{step.where}: expected two samples or more and {step.name} > 0, got {len(values)} and {step.value:g}"
        )
    _require_step(dt, step)
    return np.array(values)


def _require_step(dt: float | None, step: Said) -> None:
    if dt is not None and abs(dt - step.value) > 1e-9 * step.value:
        raise ValueError(
            f"{step.where}: expected the given dt = {dt:g} s, got {step.name} = {step.value:g} s; leave dt out"
        )


def is_seismic(path: Path, lines: list[str]) -> bool:
    """Whether ObsPy is to read the file: by its suffix, or by the scale of counts in a header of K-NET."""
    return bool(SEISMIC.fullmatch(path.suffix)) or any(line.startswith(KNET_SCALE) for line in lines[:KNET_HEADER])


def seismic(path: Path, dt: float | None, unit: str | float | None) -> Read:
    """A file of one trace, read by ObsPy: K-NET's in m/s^2, by its scale, others as they stand; raises ValueError."""
    if path.suffix.lower() in UNREAD:
        raise ValueError(
            f"{path}: expected a format that is read, got CSMIP's or COSMOS's {path.suffix}, which ObsPy does not read "
            "either; write its accelerations alone, as a file *.txt, and give dt"
        )
    obspy = optional("obspy", f"{path}, a file of seismology", "seismic")
    try:
        traces = list(obspy.read(str(path)))
    except TypeError as error:  # which ObsPy raises for a format that it does not know
        raise ValueError(f"{path}: expected a format that ObsPy reads, got: {error}; convert it to text") from error
    if len(traces) != 1:
        names = ", ".join(trace.id for trace in traces) or "none"
        raise ValueError(
            f"{path}: expected one trace, got {len(traces)}: {names}; choose one, as "
            "substep.Record(trace.stats.delta, trace.data, unit=...)"
        )
    stats, values = traces[0].stats, real_array(f"samples of {path}", traces[0].data)
    step = real_number(f"the step of {path}", stats.delta, positive=True)
    _require_step(dt, Said("delta", step, str(path)))
    if getattr(stats, "_format", "") == KNET_FORMAT:
        return Read(step, values * real_number(f"calib of {path}", stats.calib, positive=True), "m/s^2")
    if unit is None:
        raise ValueError(f'{path}: expected the unit of its samples, which the format does not say; give unit="m/s^2"')
    return Read(step, values)
