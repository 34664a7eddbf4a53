"""What `substep spectrum --ductility` reports: the strengths that yielding oscillators need, and what it costs them."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console
from rich.table import Table

from ..core.loads import Record
from ..core.schemes import Scheme
from .arguments import names, number

if TYPE_CHECKING:
    from ..ground_motion.inelastic_history import InelasticSpectrum

console = Console()


def inelastic(
    record: Record, periods: list[float] | None, xi: float, s: Scheme, ductility: str, hardening: float, refine: str
) -> "InelasticSpectrum":
    """The spectrum of the ductilities in a text such as 1,2,4. Raises ValueError as `inelastic_spectrum` does."""
    from ..ground_motion.inelastic import inelastic_spectrum  # noqa: PLC0415 (loads numba)

    if refine:
        raise ValueError("expected --refine without --ductility, got both; the errors say where a step is too long")
    values = [number("--ductility", text) for text in names(ductility) or []]
    return inelastic_spectrum(record, periods=periods, xi=xi, scheme=s, ductility=values, hardening=hardening)


def report(s: "InelasticSpectrum", name: str, csv: Path | None, chart: Path | None) -> None:
    """Print the largest values of each ductility, and write or draw all where that was asked for."""
    settings = f"{s.samples} samples, dt = {s.dt:g} s, xi = {float(s.xi):g}, hardening {s.hardening:g}, "
    settings += " ".join((s.scheme, s.parameters)).strip()
    table = Table(
        "ductility", "largest A_y (m/s^2)", "at T (s)", "largest u (m)", "at T (s)", "largest residual (m)", "found",
        "median error of u", title=f"{name}: {settings}",
    )  # fmt: skip
    for i, value in enumerate(s.ductility.to_numpy()):
        at = s.isel(ductility=i)
        found = np.isfinite(at.A_y.to_numpy())
        row: list[str] = []
        for quantity in ("A_y", "displacement"):
            x = np.where(found, at[quantity].to_numpy(), -1.0)
            row += [f"{x.max():.4g}", f"{float(s.period[int(x.argmax())]):.4g}"] if found.any() else ["-", "-"]
        residual = np.nanmax(np.abs(at.residual_displacement.to_numpy()), initial=0.0)
        error = np.median(np.abs(at.displacement_error.to_numpy()[found])) if found.any() else np.nan
        counted = f"{np.count_nonzero(found)} of {found.size}"
        table.add_row(f"{value:g}", *row, f"{residual:.3g}", counted, f"{100.0 * error:.2g} %")
    console.print(table)
    several = int((s.solutions > 1).sum())
    console.print(f"accelerations read in {s.unit}")
    console.print(
        f"the largest strength that gives the ductility within {s.tolerance:.0%}; {several} have more than one"
    )
    if s.unstable:
        console.print(f"{s.scheme} is unstable at {s.unstable} of {s.sizes['period']} periods: nothing is found there")
    if csv is None and chart is None:
        return
    from ..figures import charts, inelastic_charts  # noqa: PLC0415 (Matplotlib only when asked for)

    if csv is not None:
        columns = {}
        for key, x in {"ductility": s.ductility, "period": s.period, **s.data_vars}.items():
            columns[f"{key} ({x.units})"] = np.asarray(x.broadcast_like(s.A_y)).ravel()
        charts.save_csv(csv, list(columns), list(columns.values()))
    if chart is not None:
        charts.save(
            inelastic_charts.inelastic_figure(s), chart, "Response spectra",
            f"""Inelastic spectrum of {name}, {settings}: over the period, for each ductility, the yield strength per
            unit mass, the largest displacement relative to the ground, and that at which the oscillator comes to rest.
            """,
        )  # fmt: skip
