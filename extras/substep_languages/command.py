"""The command `substep emit`: a scheme as one self-contained file in another language."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from substep.cli.arguments import SchemeArgument, exact_options, require_folders, source_of, working
from substep.cli.command import Command


def emit(
    context: typer.Context,
    name: SchemeArgument,
    language: Annotated[str, typer.Option(help="c, fortran, javascript, julia, matlab or python")],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="write this file, such as bathe.F90 for fortran; by default it is printed"),
    ] = None,
) -> None:
    """Print a scheme as one self-contained file: a step, stability functions and a test of itself.

    Parameters follow as exact numbers, --gamma-t 1/5, and are the file's defaults.
    """
    from .standalone import language_of, standalone  # noqa: PLC0415 (SymPy only when asked for)

    try:
        require_folders(out)
        if out is not None and out.suffix != (suffix := f".{language_of(language).suffix}"):
            raise ValueError(
                f"expected a file name that ends in {suffix}, by which a program of {language} is recognised, got "
                f"'{out}'; write {out.with_suffix(suffix)}"
            )
        source, given = source_of(name, exact_options(context.args))
        with working(f"deriving {name} for {language}"):
            text = standalone(source, language, **given)
    except (ValueError, TypeError, OSError) as error:
        raise typer.BadParameter(str(error)) from error
    if out is None:
        print(text, end="")
    else:
        out.write_text(text, encoding="utf-8", newline="\n")
        Console().print(f"{out}")


COMMAND = Command("Programs and results", "substep emit bathe --language c --out bathe.c", emit, parameters=True)
