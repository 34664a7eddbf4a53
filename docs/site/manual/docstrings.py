"""Docstrings are plain text with names between backticks; Sphinx wants reStructuredText."""

import re
from typing import Any

from numpy.typing import ArrayLike
from sphinx.util.typing import stringify_annotation

EXPANDED = (stringify_annotation(ArrayLike, "smart"), stringify_annotation(ArrayLike, "fully-qualified"))
MARKS = re.compile(r"([*|\\]|_(?!\w))")  # what reStructuredText would take for markup


def as_rst(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Escape what is not meant as markup, outside backticks and outside of examples, which reach to a blank line."""
    del app, what, name, obj, options
    example = False
    for i, line in enumerate(lines):
        example = line.startswith(">>>") or (example and bool(line))
        lines[i] = line if example else escaped(line)


def escaped(line: str) -> str:
    """The line with `*`, `|`, `\\` and trailing underscores as characters."""
    parts = line.split("`")
    return "`".join(part if i % 2 else MARKS.sub(r"\\\1", part) for i, part in enumerate(parts))


def as_written(
    app: Any, what: str, name: str, obj: Any, options: Any, signature: str | None, returns: str | None
) -> tuple[str | None, str | None]:
    """The signature with `ArrayLike` in place of the union that it stands for."""
    del app, what, name, obj, options
    for text in EXPANDED:
        signature = signature and signature.replace(text, "ArrayLike")
    return signature, returns
