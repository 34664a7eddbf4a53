"""Docstrings are plain text with names between backticks; Sphinx wants reStructuredText."""

import re
from typing import Any

MARKS = re.compile(r"([*|\\]|_(?!\w))")  # what reStructuredText would take for markup


def as_rst(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Escape what is not meant as markup, outside backticks; indented lines that follow a line become its own."""
    del app, what, name, obj, options
    lines[:] = [escaped(line) for line in lines]


def escaped(line: str) -> str:
    """The line with `*`, `|`, `\\` and trailing underscores as characters."""
    parts = line.split("`")
    return "`".join(part if i % 2 else MARKS.sub(r"\\\1", part) for i, part in enumerate(parts))
