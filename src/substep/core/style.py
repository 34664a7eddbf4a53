"""Colours, line styles and direct labels of every chart.

Colours are Okabe and Ito's, which the colour-blind can tell apart; line styles differ too, for print in black.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 8  # curves of one panel that a legend tells apart; more are labelled directly or drawn in several panels
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7")
REFERENCE = "#000000"
STYLES = ("-", "--", "-.", (0, (1, 1)), (0, (8, 2)))


def look(i: int) -> tuple[str, str | tuple[int, tuple[int, ...]]]:
    """Colour and line style of the i-th curve; no two of the first 25 share both."""
    return COLOURS[i % 5], STYLES[(i + i // 5) % 5]


def label_ends(axes: "Axes", *, left: bool = False, size: float = 8.0) -> None:
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
