"""The declarations of a package of the catalogue, whose modules are imported one after the other."""

from collections.abc import Iterator, Sequence
from importlib import import_module
from typing import Any


def in_turn(package: str, modules: Sequence[str]) -> Iterator[Any]:
    """What modules list as ALL, in order. A module is imported when its turn comes: to declare all takes seconds."""
    for name in modules:
        yield from import_module(f".{name}", package).ALL
