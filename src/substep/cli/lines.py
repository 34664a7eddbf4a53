"""Text in lines no wider than the terminal."""

from itertools import zip_longest
from textwrap import wrap

from rich.console import Console

HARD_SPACE = "\0"  # at which no line is broken


def width() -> int:
    """The columns of the terminal."""
    return Console().width


def wrapped(label: str, text: str, indent: str = "  ") -> str:
    """Label and text in lines no wider than the terminal, broken between the terms of the outermost sum if they fit."""
    widest, depth, kept = max(40, width() - 2), 0, ""
    for letter in text.replace(" + ", f" +{HARD_SPACE}").replace(" - ", f" -{HARD_SPACE}"):
        depth += (letter == "(") - (letter == ")")
        kept += HARD_SPACE if letter == " " and depth else letter
    terms = (x if len(x) < widest - 6 else x.replace(HARD_SPACE, " ") for x in f"{label}{kept}".split(" "))
    lines = wrap(" ".join(terms), widest, initial_indent=indent, subsequent_indent=f"{indent}    ",
                 break_long_words=False, break_on_hyphens=False)  # fmt: skip
    return "\n".join(lines).replace(HARD_SPACE, " ")


def labelled(label: str, text: str, room: int = 9) -> str:
    """Label and text in lines no wider than the terminal; the text has a column of its own, which begins at `room`."""
    lines = wrap(text, max(40, width()) - room, break_long_words=False, break_on_hyphens=False) or [""]
    return "\n".join(f"{start:<{room}}{line}" for start, line in zip_longest([label], lines, fillvalue=""))


def folded(text: str) -> str:
    """The lines of a text, of which those that are wider than the terminal go on in the next ones, further indented."""
    return "\n".join(line if len(line) <= width() else _fold(line) for line in text.splitlines())


def _fold(line: str) -> str:
    return wrapped("", line.lstrip(), line[: len(line) - len(line.lstrip())])
