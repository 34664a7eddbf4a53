"""The command `substep explorer`: one page with every scheme, to be opened in any browser."""

from pathlib import Path
from typing import Annotated

import typer

from .arguments import require_folders


def explorer(
    out: Annotated[Path, typer.Option("--out", "-o", help="where the page goes")] = Path("explorer.html"),
) -> None:
    """Write a page that compares two schemes as you move their parameters; it needs no server and no network."""
    from ..figures.explorer import write  # noqa: PLC0415

    try:
        require_folders(out)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    print(f"open {write(out).resolve()} in a browser")
