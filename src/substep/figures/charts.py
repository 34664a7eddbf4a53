"""Figures of stability functions and response spectra, and how every figure is saved."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..core.schemes import Array
from ..core.style import COLOURS, MOST, REFERENCE, name_curves, styled

if TYPE_CHECKING:
    from xarray import Dataset

RADIUS_RATIOS = np.logspace(-2, 3, 501)  # h/T at which spectral radii are drawn, and errors
ERROR_RATIOS = np.linspace(0.0, 0.2, 201)
ROUNDING = 1e-6  # by which a computed spectral radius exceeds 1 where eigenvalues meet on the circle


def curves(axes: Axes, x: Array, series: Mapping[str, Array], *, x_label: str, y_label: str) -> None:
    """One line for each named series; the last is drawn in black as the reference."""
    *others, reference = series
    for label in others:
        axes.plot(x, series[label], label=label)
    axes.plot(x, series[reference], color=REFERENCE, linestyle="-", label=reference)
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)


def in_rows(series: Mapping[str, Array]) -> list[tuple[str, list[str]]]:
    """Labels in rows of at most `MOST` curves, each of which ends with the last one, as (title, labels)."""
    *labels, last = series
    parts = -(-len(labels) // (MOST - 1)) or 1
    return [("", [*part.tolist(), last]) for part in np.array_split(np.array(labels, dtype=object), parts)]


def _radius_panel(axes: Axes, radii: Iterable[Array]) -> None:
    """A panel of spectral radii over a logarithmic axis, with a line at 1.

    It ends a little above 1, or at 2 where a curve exceeds that: an unstable scheme leaves the panel, since the radius
    of an explicit one grows like a power of Omega, beside which all others would be a flat line at 0.
    """
    axes.set_xscale("log")
    axes.set_ylim(0.0, 1.1 if all(np.nanmax(radius, initial=0.0) < 1.1 for radius in radii) else 2.0)
    axes.axhline(1.0, color="0.5", linewidth=0.6)


def _error_panel(axes: Axes, errors: Mapping[str, Array], radii: Mapping[str, Array]) -> None:
    """A panel that is as high as its curves where they are stable: errors and spectral radii (n,) by label.

    Where a scheme is unstable its curve leaves the panel, since it would flatten those of all others.
    """
    shown = np.concatenate([y[radii[label] <= 1.0 + ROUNDING] for label, y in errors.items()])
    shown = shown[np.isfinite(shown)]
    room = 0.05 * np.ptp(shown) if shown.size else 0.0
    if room > 0.0:
        axes.set_ylim(shown.min() - room, shown.max() + room)


@styled
def stability_figure(
    title: str,
    radius: tuple[Array, Mapping[str, Array]],
    errors: tuple[Array, Mapping[str, Array], Mapping[str, Array]],
    rows: Sequence[tuple[str, Sequence[str]]] = (),
    axes: Sequence[Axes] | None = None,
) -> Figure:
    """Spectral radius over h/T (log), amplitude and period error in per cent over h/T.

    radius: h/T (n,) and the radius of each curve (n,) by label; errors: h/T (n,), then the amplitude and the period
    errors, as fractions, likewise. rows: (title, labels) of each row of panels, by default those of `in_rows`; the last
    curve of a row is black. The legend stands below a single row, and beside each of several. axes: three to draw all
    curves into, in place of a new figure with a title; the first gets the legend.
    """
    if axes is None:
        rows = rows or in_rows(radius[1])
        figure = Figure(figsize=(13, 4.6) if len(rows) == 1 else (14, 3.3 * len(rows) + 0.4))
        panels = figure.subplots(len(rows), 3, sharex="col", sharey="col", squeeze=False)
    else:
        rows, panels = [("", list(radius[1]))], np.reshape(axes, (1, 3))
    x, *values = errors
    percent = [{label: 100 * y for label, y in series.items()} for series in values]
    columns = (radius, (x, percent[0]), (x, percent[1]))
    y_labels = r"spectral radius $\rho$", "amplitude error (%)", "period error (%)"
    for row, (name, labels) in zip(panels, rows, strict=True):
        for panel, (x, series), y_label, letter in zip(row, columns, y_labels, "abc", strict=True):
            curves(panel, x, {label: series[label] for label in labels}, x_label="", y_label=y_label)
            panel.set_title(f"({letter}) {name}" if name and letter == "a" else f"({letter})", loc="left")
        _radius_panel(row[0], radius[1].values())
        if len(rows) > 1:
            row[2].legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=8)
    for panel in panels[-1]:
        panel.set_xlabel("time ratio $h/T$")
    radii = {label: np.interp(x, radius[0], y) for label, y in radius[1].items()}
    for panel, series in zip(panels[0, 1:], percent, strict=True):
        _error_panel(panel, series, radii)
        panel.locator_params(axis="x", nbins=5)
    figure = panels[0, 0].get_figure()
    if axes is not None:
        name_curves(panels[0, 0], beside=False)
        return figure
    figure.suptitle(title)
    if len(rows) == 1:
        handles, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


@styled
def quantity_figure(
    quantity: str,
    over: str,
    x: Array,
    series: Mapping[str, Array],
    xi: float,
    radii: Mapping[str, Array] | None = None,
    axes: Axes | None = None,
) -> Figure:
    """One stability function over h/T or Omega, x (n,), of each curve (n,) by label; errors in per cent.

    radii: the spectral radius of each curve (n,), so that errors of unstable schemes do not flatten those of others.
    More than `MOST` curves are drawn in several panels, each with the last curve in black; or in one with labels at
    their ends, where axes are given to draw into in place of a new figure.
    """
    percent = quantity.endswith("error")
    label = {"spectral_radius": r"spectral radius $\rho$", "numerical_damping": r"numerical damping $\bar\xi$"}.get(
        quantity, f"{quantity.replace('_', ' ')} (%)"
    )
    shown = {name: 100 * y for name, y in series.items()} if percent else series
    if axes is None:
        rows = in_rows(shown)
        figure = Figure(figsize=(9, 1.0 + 4.0 * len(rows)))
        panels = figure.subplots(len(rows), sharex=True, sharey=True, squeeze=False)[:, 0]
        panels[0].set_title(f"$\\xi$ = {xi:g}")
    else:
        rows, panels = [("", list(shown))], np.array([axes])
    for panel, (_, labels) in zip(panels, rows, strict=True):
        curves(panel, x, {name: shown[name] for name in labels}, x_label="", y_label=label)
        if quantity == "spectral_radius":
            _radius_panel(panel, series.values())
        elif radii is not None:
            _error_panel(panel, shown, radii)
        name_curves(panel, beside=axes is None)
    panels[-1].set_xlabel(r"$\Omega = \omega h$" if over == "Omega" else "time ratio $h/T$")
    return panels[0].get_figure()


@styled
def spectrum_figure(spectrum: "Dataset", axes: Sequence[Axes] | None = None) -> Figure:
    """SD, SV and SA of a `response_spectrum` at one xi, dashed the pseudo-quantities, and below the scheme's error.

    A period of 0, the ground itself, is left out, since the axis of periods is logarithmic.
    axes: six to draw into, in place of a new figure with a title: three for the spectra, then three for their errors.
    Raises ValueError for another number of axes.
    """
    s = spectrum.isel(period=spectrum.period.to_numpy() > 0.0)
    T = s.period.to_numpy()
    if axes is None:
        panels = Figure(figsize=(13, 6.2)).subplots(2, 3, sharex=True, height_ratios=(1.7, 1))
    elif np.size(axes) == 6:
        panels = np.reshape(axes, (2, 3))
    else:
        raise ValueError(f"expected six axes, of three spectra and their errors, got {np.size(axes)}; give six")
    top, bottom = panels
    symbols = {"displacement": "SD", "velocity": "SV", "acceleration": "SA"}
    for value, error, (name, symbol), colour in zip(top, bottom, symbols.items(), COLOURS, strict=False):
        unit = {"m": "m", "m s-1": "m/s", "m s-2": "m/s$^2$"}[s[name].units]
        value.loglog(T, s[name], color=colour, label=symbol)
        if f"pseudo_{name}" in s:
            value.loglog(T, s[f"pseudo_{name}"], color=REFERENCE, linewidth=0.8, linestyle="--", label=f"P{symbol}")
            value.legend()
        value.set_ylabel(f"{name} {symbol} ({unit})")
        error.loglog(T, 100 * np.abs(s[f"{name}_error"]), color=colour, linewidth=1.0)
        error.set_ylabel(f"error of {symbol} (%)")
        error.set_xlabel("period $T$ (s)")
    figure = panels[0, 0].get_figure()
    if axes is not None:
        return figure
    settings = f"$\\xi$ = {float(s.xi):g}, {s.scheme}, $h$ = {s.dt:g} s"
    figure.suptitle(f"Response spectrum: {Path(s.source).name}, {settings}; below: the scheme's own error")
    return figure


@styled
def save(figure: Figure, path: Path, section: str, caption: str) -> None:
    """Write path.png and path.svg; their metadata hold the caption and the section of the page of results.

    caption: what is drawn, of which scene and parameters, what to see in it and where it comes from, in plain words.
    A process that is ended meanwhile leaves a file of the name with .part at most, and none that is not whole.
    """
    metadata = {"Description": " ".join(caption.split())}
    _save_whole(figure, path, "png", metadata=metadata | {"Keywords": section})
    figure.set_layout_engine("none")  # it has been laid out: doing so again takes as long as drawing
    _save_whole(figure, path, "svg", metadata=metadata | {"Keywords": [section], "Date": None})


def _save_whole(figure: Figure, path: Path, kind: str, **options: Any) -> None:
    part = Path(f"{path}.{kind}.part")
    figure.savefig(part, format=kind, **options)
    part.replace(f"{path}.{kind}")


def save_csv(path: Path, header: list[str], columns: list[Array]) -> None:
    """Write columns under their names, with the 17 digits from which every double is read back exactly."""
    text = [",".join(f'"{name}"' if "," in name else name for name in header)]
    text += [",".join(f"{value:.17g}" for value in row) for row in np.column_stack(columns)]
    path.write_text("\n".join(text) + "\n", encoding="utf-8")
