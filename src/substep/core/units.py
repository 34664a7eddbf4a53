"""Units of numbers: that of ground accelerations, as given or as a file says, and what is refused as another's.

docs/conventions.md lists these rules, `errors.damping_ratio` among them, and how to say that the unlikely is meant.
"""

import re

import numpy as np

from .arrays import Array
from .errors import real_number

STANDARD_GRAVITY = 9.80665  # m/s^2
LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}  # in m
UNITS = {
    **{f"{length}/s^2": factor for length, factor in LENGTHS.items()},
    **{"g": STANDARD_GRAVITY, "%g": 0.01 * STANDARD_GRAVITY, "mg": 0.001 * STANDARD_GRAVITY, "gal": 0.01},
}
LARGEST, LEAST = 5.0 * STANDARD_GRAVITY, 1e-4 * STANDARD_GRAVITY  # peaks of ground motions, about
LONGEST_STEP = 1.0  # s, between samples of a ground motion, of which 1 s is long
TURN = 2.0 * np.pi
OVERDAMPED = 2.0  # the damping ratio from which on percent is likelier
_SECOND = r"s(?:ec)?(?:onds?)?"
_PER_SECOND_SQUARED = (
    rf"(?:\s*/\s*{_SECOND}\s*/\s*{_SECOND}|(?:\s*/|\s*\bper\b|_per_|_)\s*{_SECOND}\s*(?:\^|\*\*)?\s*(?:[2²]|squared)"
    rf"|ps2|\.?\s*s\s*\^?\s*[-⁻][2²])(?![a-z])"
)
_ACCELERATION = r"(?<![a-z])(?:acc[a-z]*|beschl[a-z]*|a\b)\.?"
_LENGTHS = {"in": "in(?:ch)?(?:es)?", "ft": "(?:ft|foot|feet)"}  # how those are written that are not by their symbol
_SPELLED = {
    **{f"{length}/s^2": rf"(?<![a-zµμ]){_LENGTHS.get(length, length)}{_PER_SECOND_SQUARED}" for length in LENGTHS},
    "gal": r"(?:\b|_)gals?\b",
    "%g": r"(?:%|\bpercent)\s*(?:of\s+)?g\b",
    "mg": r"[(\[]\s*mg\s*[)\]]|\bmilli-?\s?g\b|(?<![a-z])acc[a-z]*\.?\s+mg\b",
    "g": r"[(\[]\s*(?-i:g)(?:'?s)?\s*[)\]]|\b(?:in|units?(?:\s+of)?|units?\s*[:=])\s*\(?g\b(?!\s*[/*])"
    rf"|{_ACCELERATION}\s*(?:[(\[]\s*g\s*[)\]]|/\s*g\b(?!\s*[/*]))|(?<![a-z])acc[a-z]*\.?\s+g(?:'s)?(?![\w/*-])",
}
# what may name a unit: after acceleration, in brackets; any length per second squared; what is said to be the unit
_UNIT_LIKE = (
    rf"{_ACCELERATION}\s*[(\[]([^)\]]+)[)\]]",
    rf"(?<![a-zµμ])([a-zµμ]+{_PER_SECOND_SQUARED})",
    r"\bunits?\s*(?:of\b|[:=])\s*(\S+)",
    r"(?<![a-z])(acc[a-z]*_g|a_g)\b",  # g, or that of the ground
)
_HEADING = r"\W*(?:t|time|zeit|temps|tiempo|tempo)\b[^\w(\[]*(?:[(\[]\s*([^)\]]*?)\s*[)\]])?"
_SECONDS = ("", "s", "sec", "secs", "second", "seconds")
_OTHERS = r"(?<![a-z])(?:vel|disp|geschw|weg\b)[a-z]*"


def unit_named(text: str) -> str | None:
    """The unit of acceleration that a text above data names: as in UNITS, or as it stands there if it is none of these.

    None for none. Raises ValueError for more than one, for times in another unit than s, and for a heading of columns
    that names velocities or displacements, and no accelerations.
    """
    found = [unit for unit, spelled in _SPELLED.items() if re.search(spelled, text, re.IGNORECASE)]
    if len({UNITS[unit] for unit in found}) > 1:
        raise ValueError(
            f"expected one unit of acceleration, got {' and '.join(found)} in '{text.strip()}'; correct the text"
        )
    heading = next((line for line in reversed(text.splitlines()) if line.strip()), "")
    columns = re.match(_HEADING, heading, re.IGNORECASE)
    if columns and (columns[1] or "").lower() not in _SECONDS:
        raise ValueError(f"expected times in s, got '{heading.strip()}'; convert them, and correct the text")
    if not found and re.search(_OTHERS, heading, re.IGNORECASE) and not re.search(_ACCELERATION, text, re.IGNORECASE):
        raise ValueError(f"expected accelerations, got '{heading.strip()}'; take those, or correct the text")
    if found:
        return found[0]
    unlike = (re.search(like, text, re.IGNORECASE) for like in _UNIT_LIKE)
    beside = re.findall(r"[(\[]([^)\]]+)[)\]]", heading[columns.end() :]) if columns else []
    return next((like[1].strip() for like in unlike if like), beside[0].strip() if beside else None)


def unit_of(unit: str | float) -> tuple[str, float]:
    """A unit that was given, by its name or as a factor to m/s^2: its name, and that factor. Raises ValueError."""
    if not isinstance(unit, str):
        factor = real_number("unit", unit, positive=True)
        return f"{factor:g} m/s^2", factor
    name = unit if unit in UNITS else unit_named(f"acc ({unit})")
    if name is None or name not in UNITS:
        raise ValueError(f"expected unit as one of {', '.join(UNITS)}, or a factor to m/s^2, got {unit!r}")
    return name, UNITS[name]


def require_plausible(what: str, values: Array, cure: str = "") -> None:
    """Raise ValueError where a record without a unit has a peak that no ground motion in m/s^2 has.

    cure: another one than to give the unit.
    """
    peak = float(np.abs(values).max(initial=0.0))
    if peak != 0.0 and not LEAST <= peak <= LARGEST:
        raise ValueError(
            f"{what}: expected the unit of accelerations, got none and a peak of {peak:.6g}, which is {readings(peak)}"
            f'; give unit="m/s^2", "g" or "cm/s^2"{cure}'
        )


def readings(value: float) -> str:
    """What an acceleration is in g, in each unit that it may have."""
    return ", ".join(f"{value * UNITS[u] / STANDARD_GRAVITY:.3g} g in {u}" for u in ("m/s^2", "g", "cm/s^2"))


def require_step(what: str, dt: float) -> None:
    """Raise ValueError for a step between samples of a ground motion that is longer than any in s."""
    if dt > LONGEST_STEP:
        raise ValueError(
            f"{what}: expected the step between samples in s, got {dt:g}; {dt:g} ms are {dt / 1000.0:g} s, {dt:g} "
            f"samples a second are dt = {1.0 / dt:g}; if the step is {dt:g} s, give ss.Record({dt:g}, accelerations, "
            'unit="m/s^2")'
        )


def require_ground_motion(dt: float, values: Array) -> None:
    """Raise ValueError for a record without a unit that is likely not one in m/s^2 and s."""
    require_step("dt of the record", dt)
    require_plausible("the record", values, ", or ss.Record(dt, values, unit=...)")


def require_angle(what: str, angle: Array | float) -> None:
    """Raise ValueError for an angle of more than a turn, which is likely one in degrees."""
    largest = float(np.max(np.abs(angle), initial=0.0))
    if largest > TURN * (1.0 + 1e-9):
        raise ValueError(
            f"expected {what} in rad, within a turn, got {largest:g}; {largest:g} degrees are "
            f"{np.deg2rad(largest):.5g} rad, and {largest:g} rad are {largest % TURN:.5g} rad but for whole turns"
        )


def require_ratio(what: str, xi: Array | float) -> None:
    """Raise ValueError for a damping ratio, the largest of several, that is likely one in percent."""
    largest = float(np.max(xi, initial=0.0))
    if largest >= OVERDAMPED:
        raise ValueError(
            f"expected {what} as a ratio, got {largest:g}; {largest:g} % is {largest / 100.0:g}; if the ratio "
            f"{largest:g} is meant, add overdamped=True"
        )
