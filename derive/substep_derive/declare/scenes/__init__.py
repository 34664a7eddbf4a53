"""Declarations of scenes, one system a file, in the order in which they are listed."""

from collections.abc import Iterator

from ..in_turn import in_turn
from ..scene import Scene

MODULES = (
    "oscillator",
    "pendulum",
    "nonlinear",
    "contact",
    "hysteretic",
    "lagrange",
    "constrained",
    "mechanisms",
    "impact",
)


def declared() -> Iterator[Scene]:
    """Every scene in the catalogue's order."""
    return in_turn(__name__, MODULES)
