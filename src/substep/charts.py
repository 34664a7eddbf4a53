"""Figures. Colours are Okabe and Ito's, which survive colour-blindness; line styles survive print."""

from collections.abc import Mapping
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .schemes import Array

COLOURS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7")
REFERENCE = "#000000"
STYLES = ("-", "--", "-.", (0, (1, 1)), (0, (8, 2)))
SVG_IS_REPRODUCIBLE = {"svg.hashsalt": "substep"}


def look(i: int) -> tuple[str, str | tuple[int, tuple[int, ...]]]:
    """Colour and line style of the i-th curve; no two of the first 25 share both."""
    return COLOURS[i % 5], STYLES[(i + i // 5) % 5]


def curves(axes: Axes, x: Array, series: Mapping[str, Array], *, x_label: str, y_label: str) -> None:
    """One line for each named series; the last is drawn in black as the reference."""
    for i, (label, y) in enumerate(series.items()):
        reference = i == len(series) - 1
        colour, style = (REFERENCE, "-") if reference else look(i)
        axes.plot(x, y, color=colour, linestyle=style, linewidth=1.4, label=label)
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.grid(visible=True, linewidth=0.3, color="0.8")


def stability_figure(
    title: str,
    radius: tuple[Array, Mapping[str, Array]],
    errors: tuple[Array, Mapping[str, Array], Mapping[str, Array]],
) -> Figure:
    """Spectral radius over h/T (log), amplitude and period error in per cent over h/T, one legend below."""
    figure = Figure(figsize=(13, 4.6), layout="constrained")
    a, b, c = figure.subplots(1, 3)
    curves(a, *radius, x_label="time ratio $h/T$", y_label=r"spectral radius $\rho$")
    a.set_xscale("log")
    a.axhline(1.0, color="0.5", linewidth=0.6)
    x, amplitude, period = errors
    percent = [{label: 100 * y for label, y in series.items()} for series in (amplitude, period)]
    curves(b, x, percent[0], x_label="time ratio $h/T$", y_label="amplitude error (%)")
    curves(c, x, percent[1], x_label="time ratio $h/T$", y_label="period error (%)")
    for axes in (b, c):
        axes.locator_params(axis="x", nbins=5)
    for axes, letter in zip((a, b, c), "abc", strict=True):
        axes.set_title(f"({letter})", loc="left", fontsize=10)
    figure.suptitle(title, fontsize=11)
    handles, labels = a.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=9, frameon=False)
    return figure


def save(figure: Figure, path: Path) -> None:
    """Write path.png and path.svg."""
    with matplotlib.rc_context(SVG_IS_REPRODUCIBLE):
        figure.savefig(path.with_suffix(".png"), dpi=160)
        figure.savefig(path.with_suffix(".svg"), metadata={"Date": None})


def save_csv(path: Path, header: list[str], columns: list[Array]) -> None:
    """Write columns under their names, 17 digits, so that nothing is lost."""
    text = [",".join(f'"{name}"' if "," in name else name for name in header)]
    text += [",".join(f"{value:.17g}" for value in row) for row in np.column_stack(columns)]
    path.write_text("\n".join(text) + "\n", encoding="utf-8")
