"""The unit of ground accelerations: as it is given, or as a file says it; never guessed."""

import re

import numpy as np

from .arrays import Array
from .errors import real_number

STANDARD_GRAVITY = 9.80665  # m/s^2
UNITS = {"m/s^2": 1.0, "g": STANDARD_GRAVITY, "cm/s^2": 0.01, "gal": 0.01, "in/s^2": 0.0254}
LARGEST, LEAST = 5.0 * STANDARD_GRAVITY, 1e-4 * STANDARD_GRAVITY  # peaks of ground motions, about
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


def require_plausible(what: str, values: Array) -> None:
    """Raise ValueError where a record without a unit has a peak that no ground motion in m/s^2 has."""
    peak = float(np.abs(values).max(initial=0.0))
    if peak != 0.0 and not LEAST <= peak <= LARGEST:
        readings = ", ".join(f"{peak * UNITS[u] / STANDARD_GRAVITY:.3g} g in {u}" for u in ("m/s^2", "g", "cm/s^2"))
        raise ValueError(
            f"{what}: expected the unit of accelerations, got none and a peak of {peak:.6g}, which is {readings}; "
            'give unit="m/s^2", "g" or "cm/s^2", or name it in a comment above the data'
        )
