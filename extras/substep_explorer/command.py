"""The command `substep explorer`: one page with every scheme, to be opened in any browser."""

from pathlib import Path
from typing import Annotated

import typer

from substep.cli.arguments import require_folders
from substep.cli.command import Command


def explorer(
    out: Annotated[Path, typer.Option("--out", "-o", help="where the page goes")] = Path("explorer.html"),
) -> None:
    """Write a page that compares two schemes as you move their parameters; it needs no server and no network."""
    from .page import write  # noqa: PLC0415

    try:
        require_folders(out)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    print(f"open {write(out).resolve()} in a browser")


COMMAND = Command("What there is", "substep explorer --out explorer.html", explorer)
