"""Pieces of Markdown that several pages are put together from."""

import re
from collections.abc import Iterable, Sequence

LONGEST = 4000  # characters of LaTeX; a longer formula fills pages and is left to the command line
SPECIAL = re.compile(r"([\\`*_{}\[\]<>#|~$])")


def plain(text: str) -> str:
    """Text that Markdown shows as it is."""
    return SPECIAL.sub(r"\\\1", " ".join(text.split()))


def code(text: str) -> str:
    """Text as code within a line, also inside a table."""
    return "`" + text.replace("|", "¦").replace("`", "'") + "`"


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Lines of a table, of cells that are Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return [*(f"| {' | '.join(line)} |" for line in lines), ""]


def block(language: str, text: str) -> list[str]:
    """Lines of a block of code."""
    return [f"```{language}", text.rstrip(), "```", ""]


def formula(latex: str, otherwise: str) -> list[str]:
    """Lines of a displayed formula, or a line that says where one too long to be read is printed."""
    if len(latex) > LONGEST:
        return [f"A formula of {len(latex)} characters: {otherwise}.", ""]
    return ["$$", latex, "$$", ""]


def folded(title: str, lines: Sequence[str]) -> list[str]:
    """Lines that are shown when the title is opened."""
    return ["<details>", f"<summary>{title}</summary>", "", *lines, "</details>", ""]


def toctree(entries: Iterable[str], depth: int = 1) -> list[str]:
    """Lines of a table of contents."""
    return [":::{toctree}", f":maxdepth: {depth}", "", *entries, ":::", ""]
