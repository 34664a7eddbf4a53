"""An audit as one static page: what it found, and the measured curves over those of the identified scheme."""

from collections.abc import Sequence
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from matplotlib.figure import Figure

from substep.core.schemes import Scheme
from substep.core.style import COLOURS, styled

from .curve import Curve

LABELS = (
    ("radius", "spectral radius $\\rho$"), ("damping", "numerical damping"), ("period", "period error"),
)  # fmt: skip


@styled
def write(report: Any, curves: Sequence[Curve], matched: Scheme | None, path: Path) -> Path:
    """Write the page of a `Report`, with curves beside those of the scheme that was found, and return its path."""
    environment = Environment(
        loader=PackageLoader(__package__),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    drawing = StringIO()
    curves_figure(curves, matched).savefig(drawing, format="svg", metadata={"Date": None})
    svg = drawing.getvalue()
    page = environment.get_template("report.html").render(report=report, svg=svg[svg.index("<svg") :])
    path.write_text(page, encoding="utf-8")
    return path


def curves_figure(curves: Sequence[Curve], matched: Scheme | None) -> Figure:
    """Spectral radius, numerical damping and period error: marks as measured, lines of the identified scheme."""
    figure = Figure(figsize=(11, 3.6))
    panels = figure.subplots(1, 3)
    for i, curve in enumerate(curves):
        Omega = np.geomspace(curve.Omega[0], curve.Omega[-1], 400)
        expected = None if matched is None else matched.stability(Omega, curve.xi)
        for j, (axes, (name, label)) in enumerate(zip(panels, LABELS, strict=True)):
            colour = COLOURS[i % len(COLOURS)]
            if expected is not None:
                axes.plot(Omega, expected[j], color=colour, lw=1.2)
            measured = getattr(curve, name)
            axes.plot(
                curve.Omega, measured, "osD^v"[i % 5], color=colour, ms=5, mfc="none", label=f"$\\xi$ = {curve.xi:g}"
            )
            axes.set(xscale="log", xlabel="$\\Omega = \\omega h$", ylabel=label)
    for axes in panels[1:]:
        axes.set(xlim=(curves[0].Omega[0], 12.0))
        shown = np.concatenate([line.get_ydata()[line.get_xdata() <= 12.0] for line in axes.lines])
        low, high = np.nanmin(shown, initial=-1e-3), np.nanmax(shown, initial=1e-3)
        axes.set_ylim(low - 0.08 * (high - low), high + 0.08 * (high - low))
    panels[0].set_ylim(0.0, min(3.0, 1.1 * max(float(np.nanmax(curve.radius)) for curve in curves)))
    panels[0].legend(title="measured; lines: the scheme" if matched else "measured", fontsize=8, title_fontsize=8)
    return figure
