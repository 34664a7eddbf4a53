"""Units of numbers: that of ground accelerations, as given or as a file says, and what is refused as another's.

docs/conventions.md lists these rules, `errors.damping_ratio` among them, and how to say that the unlikely is meant.
"""

import re

import numpy as np

from .arrays import Array
from .errors import real_number

STANDARD_GRAVITY = 9.80665  # m/s^2
UNITS = {"m/s^2": 1.0, "g": STANDARD_GRAVITY, "cm/s^2": 0.01, "gal": 0.01, "in/s^2": 0.0254}
LARGEST, LEAST = 5.0 * STANDARD_GRAVITY, 1e-4 * STANDARD_GRAVITY  # peaks of ground motions, about
LONGEST_STEP = 1.0  # s, between samples of a ground motion, of which 1 s is long
TURN = 2.0 * np.pi
OVERDAMPED = 2.0  # the damping ratio from which on percent is likelier
_PER_SECOND_SQUARED = r"\s*(?:/\s*s(?:ec)?\s*/\s*s(?:ec)?|/\s*s(?:ec)?\s*(?:\^|\*\*)?\s*[2²]|\.?\s*s\s*\^?\s*[-⁻][2²])"
_SPELLED = {
    **{f"{length}/s^2": rf"(?<![a-z]){length}{_PER_SECOND_SQUARED}" for length in ("m", "cm", "in")},
    "gal": r"\bgals?\b",
    "g": r"[(\[]\s*g\s*[)\]]|\b(?:in|units?(?:\s+of)?|units?\s*[:=])\s*\(?g\b(?!\s*[/*])",
}


def unit_named(text: str) -> str | None:
    """The unit of acceleration that a text names, as in UNITS; None for none. Raises ValueError for more than one."""
    found = [unit for unit, spelled in _SPELLED.items() if re.search(spelled, text, re.IGNORECASE)]
    if len({UNITS[unit] for unit in found}) > 1:
        raise ValueError(
            f"expected one unit of acceleration, got {' and '.join(found)} in '{text.strip()}'; correct the text"
        )
    return found[0] if found else None


def unit_of(unit: str | float) -> tuple[str, float]:
    """A unit that was given, by its name or as a factor to m/s^2: its name, and that factor. Raises ValueError."""
    if not isinstance(unit, str):
        factor = real_number("unit", unit, positive=True)
        return f"{factor:g} m/s^2", factor
    name = unit if unit in UNITS else unit_named(f"({unit})")
    if name is None:
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
            f"samples a second are dt = {1.0 / dt:g}; if the step is {dt:g} s, give ss.Record({dt:g}, accelerations)"
        )


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
