"""The look of every chart: the sheet `substep/charts.mplstyle`, and what a sheet cannot say.

A function that draws is decorated with `styled`, so that the sheet holds within it and nowhere else.
"""

# pyright: standard
# Matplotlib's and SciPy's types are partly unknown

from typing import Any

import numpy as np
from matplotlib import rcParams, style
from matplotlib.axes import Axes

MOST = 8  # curves of one panel that a legend tells apart; more are labelled directly or drawn in several panels
REFERENCE = "#000000"

styled = style.context("substep.charts")  # as a decorator, entered anew at each call
with style.context("substep.charts"):
    LOOKS = [(one["color"], one["linestyle"]) for one in rcParams["axes.prop_cycle"]]
COLOURS = tuple(dict.fromkeys(colour for colour, _ in LOOKS))


def look(i: int) -> tuple[str, str | tuple[int, tuple[int, ...]]]:
    """Colour and line style of the i-th curve, for one that is drawn in several pieces or apart from its panel."""
    return LOOKS[i % len(LOOKS)]


def name_curves(axes: Axes, *, beside: bool) -> None:
    """Name the curves of a panel in a legend, beside it or within it, or at their ends where they exceed `MOST`."""
    if len(axes.get_legend_handles_labels()[1]) > MOST:
        label_ends(axes)
    elif beside:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    else:
        axes.legend(frameon=True)


def label_ends(axes: Axes, *, left: bool = False, size: float = 8.0) -> None:
    """Write the label of every curve at its right or left end, in its colour; labels that would overlap move apart.

    To be called when limits and scales are set. The labels lie beside the curves, so that they need room there.
    """
    from scipy.optimize import isotonic_regression  # noqa: PLC0415 (on first use)

    figure: Any = axes.get_figure()
    figure.draw_without_rendering()  # lays the figure out, so that data have places
    ends = []
    for line in axes.lines:
        xy = np.asarray(line.get_xydata())
        xy = xy[np.isfinite(xy).all(axis=1)]
        if len(xy) and not str(line.get_label()).startswith("_"):  # so Matplotlib names lines without a label
            end = xy[xy[:, 0].argmin() if left else xy[:, 0].argmax()]
            ends.append((float(axes.transData.transform(end)[1]) * 72 / figure.dpi, end, line))
    ends.sort(key=lambda found: found[0])
    heights = np.array([height for height, *_ in ends])
    apart = 1.25 * size * np.arange(len(ends))
    moved = isotonic_regression(heights - apart).x + apart - heights if ends else heights  # the least moves, in points
    for (_, end, line), up in zip(ends, moved, strict=True):
        axes.annotate(
            str(line.get_label()), end, (-6 if left else 6, float(up)), textcoords="offset points", fontsize=size,
            color=line.get_color(), ha="right" if left else "left", va="center", annotation_clip=False,
        )  # fmt: skip
