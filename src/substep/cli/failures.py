"""The command `substep failures`: where methods fail, in files and on one screen."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Column, Table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..studies.failures import BarRow, Row

console = Console()


def failures(
    folder: Annotated[Path, typer.Option(help="where tables and maps go")] = Path("results"),
    full: Annotated[bool, typer.Option("--full", help="every scheme on every scene, maps of 500 x 500 runs")] = False,
) -> None:
    """Run schemes where they fail and report each run as survived, gains energy, blew up or Newton failed."""
    from ..studies import failures as battery  # noqa: PLC0415

    found: list[Row] = []
    fallen: list[BarRow] = []

    def step(rows: "list[Row] | list[BarRow]") -> None:
        found.extend(row for row in rows if isinstance(row, battery.Row))
        fallen.extend(row for row in rows if isinstance(row, battery.BarRow))
        progress.advance(task)

    try:
        with Progress(console=console) as progress:
            task = progress.add_task("battery", total=battery.count())
            battery.battery(folder, step, full)
    finally:  # what was found before Ctrl-C is printed too
        _print_failures(found)
    if fallen:
        console.print(f"A bar that falls on a floor: {battery.summary(fallen)}", soft_wrap=True)
    console.print(f"tables and maps are in {folder.resolve()}")


def _print_failures(rows: "Sequence[Row]") -> None:
    columns = (Column(name, overflow="fold") for name in ("scene", "h (s)", "", "at t (s)", "max E/E0"))
    table = Table(Column("scheme", no_wrap=True), *columns, title="Where methods fail")
    for row in rows:
        at = "" if row.t is None else f"{row.t:.4g}"
        table.add_row(row.scheme, row.scene, f"{row.h:.4g}", row.word, at, f"{row.max_ratio:.4g}")
    console.print(table)
