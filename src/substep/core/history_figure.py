"""A response as a figure of Matplotlib's."""

from collections.abc import Sequence
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .errors import unknown_name
from .exports import Histories, History, curves_of
from .style import name_curves, styled


@styled
def to_figure(found: Histories, quantities: Sequence[str], axes: Axes | Sequence[Axes] | None, title: str) -> Figure:
    """One panel over t for each quantity; axes: where to draw them, in place of a new figure.

    Legends lie beside the panels of a new figure, and within axes that are given, whose own colours are taken.

    Raises ValueError for an unknown quantity and for another number of axes than of quantities.
    """
    for name in quantities:
        if name not in found.quantities:
            raise unknown_name("a quantity of the response", name, found.quantities)
    if axes is None:
        figure = Figure(figsize=(8, 1.2 + 2.4 * len(quantities)))
        panels = list(figure.subplots(len(quantities), sharex=True, squeeze=False)[:, 0])
        panels[0].set_title(fill(title, 90))
    else:
        panels = list(np.atleast_1d(np.asarray(axes, dtype=object)).ravel())
    if len(panels) != len(quantities):
        raise ValueError(f"expected an axes for each of {', '.join(quantities)}, got {len(panels)}; give as many")
    for panel, name in zip(panels, quantities, strict=True):
        curves = curves_of(found, name)
        for label, values in curves:
            own = label.removeprefix(f"{name} ")  # the axis says which quantity it is
            panel.plot(found.t, values, label=own)
        panel.set_ylabel(_axis_label(name, found.quantities[name]))
        panel.margins(x=0)
        if len(curves) > 1:
            name_curves(panel, beside=axes is None)
    panels[-1].set_xlabel("t (s)")
    return panels[0].get_figure()


def _axis_label(name: str, history: History) -> str:
    """Such as "displacement u (m)" for a symbol, "angular momentum (kg m²/s)" for a name."""
    words = f"{history.meaning} {name}" if len(name) == 1 else name.replace("_", " ")
    return f"{words} ({history.unit.replace('^2', '²')})" if history.unit else words
