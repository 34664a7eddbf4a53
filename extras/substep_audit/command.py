"""The command `substep audit`."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from substep.cli.arguments import numbers, refuse, require_folders
from substep.cli.command import Command


def audit(
    context: typer.Context,
    program: Annotated[str, typer.Argument(help="one that `substep audit list` names, or the path of an adapter")],
    integrator: Annotated[str, typer.Option(help="one of its integrators; by default all")] = "",
    python: Annotated[str, typer.Option(help="the interpreter that has the program; by default this one")] = "",
    json: Annotated[Path | None, typer.Option(help="where a list of reports goes as JSON")] = None,
    html: Annotated[Path | None, typer.Option(help="a folder for a page of each report")] = None,
) -> None:
    """Find out which scheme a program's integrator is, and where it departs from what its manual says.

    Arguments of the integrator, under the names of its manual, may follow: --beta 0.3025.
    """
    from . import program as programs  # noqa: PLC0415 (SciPy only when asked for)
    from .instrument import audit_program  # noqa: PLC0415

    console = Console()
    if program == "list":
        try:
            refuse(context, ("integrator", "python", "json", "html"), "with list")
        except ValueError as error:
            raise typer.BadParameter(str(error)) from error
        console.print("\n".join(programs.programs()), highlight=False)
        return
    try:
        require_folders(json, html)
        arguments = numbers(context.args)
        if arguments and not integrator:
            raise ValueError("expected --integrator with arguments for it, got arguments only; name the integrator")
        with programs.Program(program, python or programs.THIS) as running:
            found = []
            for report in audit_program(running, [integrator] if integrator else None, arguments):
                console.print(report.text, highlight=False, soft_wrap=True)
                found.append(report)
                if html is not None:
                    html.mkdir(exist_ok=True)
                    report.to_html(html / f"{report.stepper.name.replace(' ', '_')}.html")
                if json is not None:
                    json.write_text(f"[{', '.join(r.to_json() for r in found)}]\n", encoding="utf-8")
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


COMMAND = Command("Programs and results", "substep audit opensees --integrator HHT", audit, parameters=True)
