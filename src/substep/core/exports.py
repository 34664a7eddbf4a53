"""A response as a Dataset of xarray's, a DataFrame of pandas', and a figure of Matplotlib's."""

from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .arrays import Array, named
from .errors import unknown_name
from .style import MOST, label_ends, look

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from pandas import DataFrame
    from xarray import Dataset


class History(NamedTuple):
    """A quantity over the rows of a response: values (n+1,), or (n+1, k) with k columns; unit may be empty."""

    values: Array
    unit: str
    meaning: str


class Histories(NamedTuple):
    """All there is to export. columns: names of the k; dimension: what they are; attrs: what all rows share."""

    t: Array
    quantities: Mapping[str, History]
    columns: Sequence[Any]
    dimension: str
    attrs: Mapping[str, Any]


def to_dataset(found: Histories) -> "Dataset":
    """Quantities over t and the columns, with units and meanings as attributes."""
    import xarray  # noqa: PLC0415 (on first use)

    variables = {}
    for name, (values, unit, meaning) in found.quantities.items():
        attrs = {"units": unit, "long_name": meaning} if unit else {"long_name": meaning}
        variables[name] = named(("t", found.dimension)[: values.ndim], values, attrs)
    whole = all(isinstance(x, int | np.integer) for x in found.columns)
    labels = np.array(found.columns, dtype=np.int64 if whole else object)
    coordinates = {
        "t": named("t", found.t, {"units": "s", "long_name": "time"}),
        found.dimension: named(found.dimension, labels, {}),
    }
    return xarray.Dataset(variables, coordinates, dict(found.attrs))


def to_frame(found: Histories) -> "DataFrame":
    """A row for each time, a column for each quantity of each of the k, such as "u x". Raises ImportError."""
    try:
        import pandas  # noqa: PLC0415 (needed here alone)
    except ImportError as error:
        raise ImportError(
            "expected pandas for to_pandas(), which is not installed; pip install pandas, or take to_xarray()"
        ) from error
    columns = {label: values for name in found.quantities for label, values in curves_of(found, name)}
    return pandas.DataFrame(columns, index=pandas.Index(found.t, name="t"))


def curves_of(found: Histories, name: str) -> list[tuple[str, Array]]:
    """A quantity's curves (n+1,) with labels; the quantity's name alone where there is one curve."""
    values = found.quantities[name].values
    if values.ndim == 1:
        return [(name, values)]
    alone = values.shape[1] == 1
    return [(name if alone else f"{name} {c}", values[:, i]) for i, c in enumerate(found.columns)]


def to_figure(
    found: Histories, quantities: Sequence[str], axes: "Axes | Sequence[Axes] | None", title: str
) -> "Figure":
    """One panel over t for each quantity; axes: where to draw them, in place of a new figure.

    Legends lie beside the panels of a new figure, and within axes that are given.

    Raises ValueError for an unknown quantity and for another number of axes than of quantities.
    """
    from matplotlib.figure import Figure  # noqa: PLC0415 (on first use)

    for name in quantities:
        if name not in found.quantities:
            raise unknown_name("a quantity of the response", name, found.quantities)
    if axes is None:
        figure = Figure(figsize=(8, 1.2 + 2.4 * len(quantities)), layout="constrained")
        panels = list(figure.subplots(len(quantities), sharex=True, squeeze=False)[:, 0])
        panels[0].set_title(fill(title, 90), fontsize=10)
    else:
        panels = list(np.atleast_1d(np.asarray(axes, dtype=object)).ravel())
    if len(panels) != len(quantities):
        raise ValueError(f"expected an axes for each of {', '.join(quantities)}, got {len(panels)}; give as many")
    for panel, name in zip(panels, quantities, strict=True):
        curves = curves_of(found, name)
        for i, (label, values) in enumerate(curves):
            colour, style = look(i)
            own = label.removeprefix(f"{name} ")  # the axis says which quantity it is
            panel.plot(found.t, values, color=colour, linestyle=style, linewidth=1.4, label=own)
        panel.set_ylabel(_axis_label(name, found.quantities[name]))
        panel.grid(visible=True, linewidth=0.3, color="0.8")
        panel.margins(x=0)
        if len(curves) > MOST:
            label_ends(panel)
        elif len(curves) > 1:
            beside: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5)} if axes is None else {}
            panel.legend(fontsize=9, frameon=axes is not None, **beside)
    panels[-1].set_xlabel("t (s)")
    return panels[0].get_figure()


def _axis_label(name: str, history: History) -> str:
    """Such as "displacement u (m)" for a symbol, "angular momentum (kg m²/s)" for a name."""
    words = f"{history.meaning} {name}" if len(name) == 1 else name.replace("_", " ")
    return f"{words} ({history.unit.replace('^2', '²')})" if history.unit else words
