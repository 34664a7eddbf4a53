"""An audit as one static page: what it found, and the measured curves over those of the identified scheme."""

from io import StringIO
from pathlib import Path

import matplotlib as mpl
import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from matplotlib.figure import Figure

from ..figures.charts import COLOURS, SVG_IS_REPRODUCIBLE
from .report import Report

LABELS = (
    ("radius", "spectral radius $\\rho$"), ("damping", "numerical damping"), ("period", "period error"),
)  # fmt: skip


def write(report: Report, path: Path) -> Path:
    """Write the page and return its path."""
    environment = Environment(
        loader=PackageLoader("substep.auditing"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    with mpl.rc_context(SVG_IS_REPRODUCIBLE):
        drawing = StringIO()
        curves_figure(report).savefig(drawing, format="svg", metadata={"Date": None})
    svg = drawing.getvalue()
    page = environment.get_template("report.html").render(report=report, svg=svg[svg.index("<svg") :])
    path.write_text(page, encoding="utf-8")
    return path


def curves_figure(report: Report) -> Figure:
    """Spectral radius, numerical damping and period error: marks as measured, lines of the identified scheme."""
    figure = Figure(figsize=(11, 3.6), layout="constrained")
    panels = figure.subplots(1, 3)
    matched = report.matches[0].scheme if report.matches else None
    for i, curve in enumerate(report.curves):
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
            axes.grid(lw=0.4, alpha=0.5)
    for axes in panels[1:]:
        axes.set(xlim=(report.curves[0].Omega[0], 12.0))
        shown = np.concatenate([line.get_ydata()[line.get_xdata() <= 12.0] for line in axes.lines])
        low, high = np.nanmin(shown, initial=-1e-3), np.nanmax(shown, initial=1e-3)
        axes.set_ylim(low - 0.08 * (high - low), high + 0.08 * (high - low))
    panels[0].set_ylim(0.0, min(3.0, 1.1 * max(float(np.nanmax(curve.radius)) for curve in report.curves)))
    panels[0].legend(title="measured; lines: the scheme" if matched else "measured", fontsize=8, title_fontsize=8)
    return figure
