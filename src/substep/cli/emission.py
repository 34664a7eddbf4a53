"""The command `substep emit`: a scheme as one self-contained file in another language."""

from pathlib import Path
from typing import Annotated

import typer

from .arguments import exact_options, known_schemes, require_files, require_folders


def emit(
    context: typer.Context,
    name: Annotated[
        str,
        typer.Argument(
            help="a name listed by `substep schemes`, or file.py:name of a declaration", autocompletion=known_schemes
        ),
    ],
    language: Annotated[str, typer.Option(help="c, fortran, javascript, julia, matlab or python")],
    out: Annotated[Path | None, typer.Option(help="write the file here; by default it is printed")] = None,
) -> None:
    """Print a scheme as one self-contained file: a step, stability functions and a test of itself.

    Parameters follow as exact numbers, --gamma-t 1/5, and are the file's defaults.
    """
    from ..derived import facade  # noqa: PLC0415 (SymPy only when asked for)

    try:
        require_folders(out)
        file, _, own = name.rpartition(":")
        require_files(Path(file) if file else None)
        scheme = facade.declaration(Path(file), own) if file else name
        text = facade.standalone(scheme, language, **exact_options(context.args))
    except (ValueError, TypeError, OSError) as error:
        raise typer.BadParameter(str(error)) from error
    if out is None:
        print(text, end="")
    else:
        out.write_text(text, encoding="utf-8", newline="\n")
