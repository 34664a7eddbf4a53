"""The command `substep choose`."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from .arguments import StartOption, StrainOption, names, numbers, require_folders, scene_of, working


def choose(
    context: typer.Context,
    scene_name: Annotated[str, typer.Argument(metavar="SCENE", help="a name listed by `substep scenes`")],
    accuracy: Annotated[float, typer.Option(help="largest error allowed: relative, or in rad of the angle")],
    quantity: Annotated[str, typer.Option(help="u, v, a, energy or angle")] = "u",
    t_end: Annotated[float | None, typer.Option(help="span in s; by default that of the scene's chart")] = None,
    among: Annotated[str, typer.Option(help="schemes to choose from, as bathe,rk4; by default all")] = "",
    chosen: Annotated[str, typer.Option(help="schemes to try at tolerances too; by default the cheapest")] = "",
    a0: StartOption = "",
    strain: StrainOption = "",
    file: Annotated[Path | None, typer.Option(help="draw why: where the chart goes, without suffix")] = None,
) -> None:
    """Recommend scheme, step or tolerance, and model for a wished accuracy.

    The scene's parameters follow: --EA 1e10. Tolerances, of steps that choose themselves, are tried for the scheme
    that needs the least work in constant steps among those that can change theirs, or for those of --chosen.
    """
    from ..studies.precision import choice  # noqa: PLC0415 (Matplotlib only when asked for)
    from ..studies.precision.cases import span  # noqa: PLC0415

    try:
        require_folders(file)
        here = scene_of(scene_name, a0, strain, numbers(context.args))
        end = span(here) if t_end is None else t_end
        with working(f"choosing for {scene_name}"):
            found = choice.choose(
                here, accuracy, t_end=end, quantity=quantity, among=names(among), chosen=names(chosen)
            )
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    Console().print(found.text, highlight=False)
    if file is not None:
        choice.chart(found, file)
    if found.interrupted:
        raise KeyboardInterrupt
