"""The command line `substep`."""

from itertools import groupby
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Column, Table

from .schemes import scheme
from .schemes import schemes as scheme_names

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
console = Console()


@app.callback()
def main() -> None:
    """Direct time integration schemes for structural dynamics: declared once, derived, compiled."""


@app.command()
def schemes() -> None:
    """List all schemes with their parameters (default value) and reference."""
    table = Table(Column("scheme", no_wrap=True), "parameters", "state", "reference")
    for name in scheme_names():
        s = scheme(name)
        parameters = ", ".join(f"{key} ({float(value):.4g})" for key, value in s.parameters.items())
        table.add_row(name, parameters, ", ".join(s.state), s.reference)
    console.print(table)


@app.command()
def show(
    name: Annotated[str, typer.Argument(help="a name listed by `substep schemes`")],
    latex: Annotated[bool, typer.Option("--latex", help="LaTeX in place of text")] = False,
) -> None:
    """Print the closed forms of a scheme: relations, effective stiffness, amplification matrix, limits."""
    from .build import closed_forms  # noqa: PLC0415 (SymPy only when asked for)

    try:
        scheme(name)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    for section, forms in groupby(closed_forms(name), key=lambda form: form.section):
        print(f"% {section}" if latex else f"\n{section}")
        for form in forms:
            print(rf"\[ {form.latex} \]" if latex else f"    {form.name} = {form.text}")


@app.command()
def reproduce(
    folder: Annotated[Path, typer.Option(help="where the results go")] = Path("results"),
) -> None:
    """Draw the thesis's figures 4.1-4.5, write the numbers behind them and the table of properties."""
    from . import reproduce as job  # noqa: PLC0415 (Matplotlib only when asked for)

    with Progress(console=console) as progress:
        task = progress.add_task("chapter 4", total=job.steps())
        rows = job.reproduce(folder, lambda: progress.advance(task))
    table = Table(
        Column("scheme", no_wrap=True),
        *(Column(name, overflow="fold") for name in ("γ_t", "β", "γ", "ρ∞", "order", "damping", "period error")),
        title="Chapter 4 at ξ = 0: exact leading terms in Ω (as CSV: chapter_4_properties.csv)",
    )
    for name, split, beta, gamma, rho, order, k, damping, n, period in rows:
        table.add_row(name, split, beta, gamma, rho, order, f"{damping} Ω^{k}", f"{period} Ω^{n}")
    console.print(table)
    console.print(f"figures and tables are in {folder.resolve()}")
