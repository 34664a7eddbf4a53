"""The table of other programs' arguments, which `ss.dialect` reads."""

from collections.abc import Callable
from pathlib import Path

from substep.auditing.dialects import dialects

from .markdown import code, plain, table


def pages() -> dict[str, Callable[[Path], str]]:
    """Name of a page -> its text."""
    return {"dialects": lambda _: page()}


def page() -> str:
    """One row for each integrator of a program."""
    rows = []
    for name, found in dialects().items():
        scheme, _, values = found.text.partition(": ")
        arguments = ", ".join(map(code, found.arguments)) or "–"
        rows.append([code(name), arguments, f"[{scheme}](schemes/{scheme}.md)", plain(values) or "as declared"])
    header = ["program and integrator", "its arguments", "declared scheme", "whose parameters are"]
    return "\n".join(
        [
            "# Arguments of other programs", "",
            "Found by identification at several values of the arguments, not typed: see [auditing](../auditing.md).",
            "`ss.dialect(name, ...)` reads the same table. Why they differ is explained under",
            "[conventions](../conventions.md).", "",
            *table(header, rows),
        ]
    )  # fmt: skip
