"""Figures of inelastic spectra and of incremental dynamic analyses."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..core.style import COLOURS, look, name_curves, styled

if TYPE_CHECKING:
    from xarray import Dataset

SYMBOLS = {"ductility": r"$\mu$", "strength": "$A_y$", "R_y": "$R_y$"}


@styled
def inelastic_figure(spectrum: "Dataset", axes: Sequence[Axes] | None = None) -> Figure:
    """Of an `inelastic_spectrum`: strength, displacement, and what of this remains, over the period.

    A curve for each value of what is constant. Where the strength is constant, the ductility stands in its place, and
    where the spectrum does not say what remains, the energy lost.
    axes: three to draw into, in place of a new figure with a title. Raises ValueError for another number of axes.
    """
    kept = next(name for name in SYMBOLS if name in spectrum.coords)
    s = spectrum if kept in spectrum.dims else spectrum.expand_dims(kept)
    panels = Figure(figsize=(13, 4.2)).subplots(1, 3, sharex=True) if axes is None else np.ravel(axes)
    if len(panels) != 3:
        raise ValueError(f"expected three axes, got {len(panels)}; give one for each panel")
    first = (
        ("ductility_demand", r"ductility $\mu$") if kept == "strength" else ("A_y", "yield strength $A_y$ (m/s$^2$)")
    )
    last = "residual_displacement", "residual displacement, modulus (m)"
    if last[0] not in s:
        last = "hysteretic_energy", "energy lost by yielding (J/kg)"
    for i, value in enumerate(s[kept].to_numpy()):
        colour, line = look(i)
        for panel, name in zip(panels, (first[0], "displacement", last[0]), strict=True):
            y = np.abs(s[name].to_numpy()[i])
            panel.loglog(
                s.period,
                np.where(y > 0.0, y, np.nan),
                color=colour,
                linestyle=line,
                label=f"{SYMBOLS[kept]} = {value:g}",
            )
    for panel, label in zip(panels, (first[1], "largest displacement (m)", last[1]), strict=True):
        panel.set_ylabel(label)
        panel.set_xlabel("period $T$ (s)")
    name_curves(panels[0], beside=False)
    figure = panels[0].get_figure()
    if axes is None:
        settings = rf"$\xi$ = {float(s.xi):g}, {s.law}, hardening {s.hardening:g}, {s.scheme}, $h$ = {s.dt:g} s"
        figure.suptitle(f"Inelastic spectrum: {Path(s.source).name}, {settings}")
    return figure


@styled
def incremental_figure(analysis: "Dataset", axes: Sequence[Axes] | None = None) -> Figure:
    """Of an `incremental_dynamic_analysis`: intensity over ductility, a panel for each period.

    Grey: each record, up to its collapse; coloured: fractiles of the records. axes: one for each period to draw into,
    in place of a new figure with a title. Raises ValueError for another number of axes.
    """
    s, count = analysis, analysis.sizes["period"]
    if axes is None:
        panels = Figure(figsize=(4.4 * count, 4.2)).subplots(1, count, sharex=True, squeeze=False)[0]
    else:
        panels = np.ravel(axes)
    if len(panels) != count:
        raise ValueError(f"expected {count} axes, one for each period, got {len(panels)}")
    for panel, T in zip(panels, s.period.to_numpy(), strict=True):
        at = s.sel(period=T)
        for curve in at.ductility.to_numpy():
            panel.plot(curve, at.intensity, color="0.75", linewidth=0.7, linestyle="-")
        for part, curve, colour in zip(s.fractile.to_numpy(), at.ductility_fractile.to_numpy(), COLOURS, strict=False):
            panel.plot(curve, at.intensity, color=colour, linestyle="-", linewidth=1.8, label=f"{part:.0%} of records")
        panel.set_xlim(0.0, s.collapse)
        panel.set_title(f"$T$ = {T:g} s", loc="left")
        panel.set_xlabel(r"ductility $\mu$")
    name = "$S_a$ (m/s$^2$)" if s.intensity.units == "m s-2" else "scale of the record"
    panels[0].set_ylabel(f"intensity, {name}")
    name_curves(panels[0], beside=False)
    figure = panels[0].get_figure()
    if axes is None:
        figure.suptitle(
            rf"Incremental dynamic analysis of {s.sizes['record']} records: {s.law}, $\xi$ = {float(s.xi):g}, "
            f"collapse at $\\mu$ = {s.collapse:g}, {s.scheme}"
        )
    return figure
