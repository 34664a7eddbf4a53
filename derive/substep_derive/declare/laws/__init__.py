"""Declarations of laws, one kind a file, in the order in which they are listed."""

from collections.abc import Iterator

from ..in_turn import in_turn
from ..law import Law

MODULES = ("elastic", "plastic", "smooth", "viscous")


def declared() -> Iterator[Law]:
    """Every law in the catalogue's order."""
    return in_turn(__name__, MODULES)
