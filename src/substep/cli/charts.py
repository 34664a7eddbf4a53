"""The command `substep chart`: stability functions of schemes, and speed against accuracy."""

import math
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
import typer
from rich.console import Console
from rich.progress import Progress

from .arguments import known_schemes, refuse, require_folders, scheme_of, working

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ..core.schemes import Array

Quantity = Literal["spectral_radius", "numerical_damping", "amplitude_error", "period_error"]
Over = Literal["h/T", "Omega"]


def chart(
    context: typer.Context,
    names: Annotated[
        list[str],
        typer.Argument(
            help="schemes such as bathe, newmark:beta=1/4 or file.py:mine; or work-precision, and which of its scenes",
            autocompletion=known_schemes,
        ),
    ],
    file: Annotated[Path, typer.Option("--file", "--out", "-o", help="where the chart goes, without suffix")] = Path(
        "chart"
    ),
    quantity: Annotated[Quantity | None, typer.Option(help="this alone; else three panels")] = None,
    over: Annotated[Over, typer.Option(help="the axis, with --quantity")] = "h/T",
    xi: Annotated[float, typer.Option(help="damping ratio")] = 0.0,
    full: Annotated[bool, typer.Option("--full", help="work-precision: every step, medians of 20")] = False,
) -> None:
    """Draw spectral radius, amplitude error and period error of schemes over h/T, or one quantity; as PNG and SVG.

    Parameters of a scheme follow its name after a colon. The last scheme is drawn in black. work-precision: draw error
    against cost of all schemes on three scenes (--full: on thirteen), where general solvers overtake, and a pendulum by
    three models, into the folder of the file. work-precision rod rods crank squeezer: these scenes alone, which have
    constraints.
    """
    of_work = names[0] == "work-precision"
    try:
        useless, where = (("quantity", "over", "xi"), "with") if of_work else (("full",), "without")
        refuse(context, useless, f"{where} work-precision")
        refuse(context, () if quantity else ("over",), "without --quantity")
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    if of_work:
        _work_precision(file.parent, names[1:], full)
        return
    from ..figures import charts  # noqa: PLC0415 (Matplotlib only when asked for)

    file = file.with_suffix("") if file.suffix in (".png", ".svg") else file
    wide, narrow = 2 * math.pi * charts.RADIUS_RATIOS, 2 * math.pi * charts.ERROR_RATIOS
    try:
        require_folders(file)
        with working(f"drawing {', '.join(names)}"):
            several = len({*map(_label, names)}) < len({*names})  # two files may have schemes of one name
            drawn = {name if several else _label(name): scheme_of(name) for name in names}
            if quantity is None:
                amplitude = {name: s.amplitude_error(narrow, xi) for name, s in drawn.items()}
                period = {name: s.period_error(narrow, xi) for name, s in drawn.items()}
                _require_values("amplitude_error", amplitude, xi)
                _require_values("period_error", period, xi)
                figure = charts.stability_figure(
                    f"Spectral radius, amplitude and period error at $\\xi$ = {xi:g}",
                    (charts.RADIUS_RATIOS, {name: s.spectral_radius(wide, xi) for name, s in drawn.items()}),
                    (charts.ERROR_RATIOS, amplitude, period),
                )
                what = "(a) spectral radius, (b) amplitude error a period, (c) period error"
            else:
                Omega = wide if quantity == "spectral_radius" else narrow
                series = {name: getattr(s, quantity)(Omega, xi) for name, s in drawn.items()}
                _require_values(quantity, series, xi)
                radii = {name: s.spectral_radius(Omega, xi) for name, s in drawn.items()}
                x = Omega if over == "Omega" else Omega / (2 * math.pi)
                figure, what = charts.quantity_figure(quantity, over, x, series, xi, radii), quantity.replace("_", " ")
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    charts.save(
        figure, file, "Charts",
        f"""{"; ".join(drawn)}, on the oscillator with the damping ratio {xi:g}, parameters that are not named at their
        defaults: {what}, over {over if quantity else "h/T"}; the last is black.""",
    )  # fmt: skip
    Console().print(f"{file}.png and {file}.svg")


def _require_values(what: str, series: "Mapping[str, Array]", xi: float) -> None:
    """Raise ValueError where no curve has a value: errors and damping are those of a motion that oscillates."""
    if all(np.isnan(values).all() for values in series.values()):
        raise ValueError(
            f"expected xi < 1 for {what}, and a scheme whose eigenvalues are a complex pair, got {', '.join(series)} "
            f"at xi = {xi:g}, where none is defined; draw --quantity spectral_radius"
        )


def _label(name: str) -> str:
    return name.rpartition(".py:")[2].replace(":", ", ").replace(",", ", ").replace("  ", " ").replace("=", " = ")


def _work_precision(folder: Path, scenes: list[str], full: bool) -> None:
    """The charts of some scenes, by their names on the charts, or all."""
    from ..studies.precision.jobs import cases_named, jobs, operations, work_precision  # noqa: PLC0415

    try:
        asked = [partial(work_precision, case, full=full) for case in cases_named(scenes)]
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    folder.mkdir(parents=True, exist_ok=True)
    console = Console()
    with Progress(console=console) as progress:
        for job in progress.track(asked or jobs(full), description="speed against accuracy"):
            job(folder)()
    if not asked:
        operations(folder)
    console.print(f"charts and tables are in {folder.resolve()}")
