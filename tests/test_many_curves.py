"""Charts of more curves than a legend tells apart: several panels, or labels at the curves' ends."""

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import rcParams, style
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Annotation
from substep_thesis import catalogue_charts

import substep as ss
from substep.core.style import MOST, label_ends
from substep.figures import charts
from substep.studies.precision import charts as precision
from substep.studies.precision.measure import Cost, Errors, Run

X = np.linspace(0.0, 1.0, 11)
ENDS = (0.5, 0.0, 0.01, 0.02, 0.03, 0.99, 1.0, 0.4, 0.41, 0.2)  # crowded


def named(axes: Axes) -> list[str]:
    return [str(line.get_label()) for line in axes.lines if not str(line.get_label()).startswith("_")]


def labels_of(axes: Axes) -> list[Annotation]:
    return [text for text in axes.texts if isinstance(text, Annotation)]


def assert_apart(axes: Axes) -> None:
    figure: Any = axes.get_figure()
    figure.draw_without_rendering()
    boxes = sorted((text.get_window_extent() for text in labels_of(axes)), key=lambda box: box.y0)
    assert all(low.y1 <= high.y0 + 1.0 for low, high in pairwise(boxes))  # to a pixel


@pytest.mark.parametrize("left", [False, True])
def test_labels_at_the_ends_are_apart_in_the_order_and_colour_of_their_curves(left: bool) -> None:
    figure = Figure(figsize=(8, 6), layout="constrained")
    axes = figure.subplots()
    for i, end in enumerate(ENDS):
        x = X if i % 2 else X[::-1]  # the end on the right need not be the last point
        axes.plot(x, end * (1 - x if left else x), color=f"C{i}", label=f"curve {i}")
    axes.axhline(2.0)  # has no label
    label_ends(axes, left=left)
    texts = labels_of(axes)
    assert [text.get_text() for text in texts] == [f"curve {i}" for i in np.argsort(ENDS)]
    assert [text.get_color() for text in texts] == [f"C{i}" for i in np.argsort(ENDS)]
    assert [text.xy for text in texts] == [(0.0 if left else 1.0, end) for end in sorted(ENDS)]
    assert_apart(axes)
    alone = texts[np.argsort(ENDS).tolist().index(9)]
    assert alone.xyann[1] == pytest.approx(0.0)  # nothing is near


@pytest.mark.parametrize("count", [1, 2, MOST, MOST + 1, 20])
def test_every_curve_stands_in_a_panel_of_at_most_eight_beside_the_last(count: int) -> None:
    series: Mapping[str, np.ndarray] = {f"curve {i}": X * i for i in range(count)}
    last = f"curve {count - 1}"
    three = charts.stability_figure("title", (X + 1, series), (X, series, series))
    one = charts.quantity_figure("period_error", "h/T", X, series, 0.0)
    for figure, columns in ((three, 3), (one, 1)):
        drawn = [named(axes) for axes in figure.axes]
        assert all(len(names) <= MOST and names[-1] == last for names in drawn)
        assert len(drawn) == columns * (1 if count <= MOST else -(-(count - 1) // (MOST - 1)))
        of_a_column = [name for names in drawn[::columns] for name in names[:-1]]
        assert of_a_column == [f"curve {i}" for i in range(count - 1)]
        assert all(axes.get_xlabel() for axes in figure.axes[-columns:])
        legends = [axes.get_legend() for axes in figure.axes if axes.get_legend()]
        figure.draw_without_rendering()
        for legend in [*legends, *figure.legends]:
            assert legend is not None
            assert not any(legend.get_window_extent().overlaps(axes.get_window_extent()) for axes in figure.axes)


@pytest.mark.parametrize(("others", "top"), [((), 1.1), ((6.5e13,), 2.0), ((1.5, 6.5e13) * 6, 2.0)])
def test_an_unstable_scheme_leaves_the_panel_of_spectral_radii_and_the_others_stay(
    others: tuple[float, ...], top: float
) -> None:
    series = {f"curve {i}": 1.0 + X * growth for i, growth in enumerate((-1.0, *others, -0.5))}
    three = charts.stability_figure("title", (X + 1, series), (X, series, series))
    one = charts.quantity_figure("spectral_radius", "h/T", X + 1, series, 0.0)
    for axes in (*three.axes[::3], *one.axes):
        assert axes.get_ylim() == (0.0, top)
        assert axes.get_xscale() == "log"


def test_errors_where_a_scheme_is_unstable_do_not_flatten_those_of_the_others() -> None:
    wide, x = np.geomspace(1e-2, 10.0, 400), np.linspace(0.0, 0.3, 61)  # h/T
    drawn = {name: ss.scheme(name) for name in ("forward_euler", "rk2", "newmark", "bathe")}
    radius = {name: s.spectral_radius(2 * np.pi * wide) for name, s in drawn.items()}
    radii = {name: s.spectral_radius(2 * np.pi * x) for name, s in drawn.items()}
    amplitude = {name: s.amplitude_error(2 * np.pi * x) for name, s in drawn.items()}
    damping = {name: s.numerical_damping(2 * np.pi * x) for name, s in drawn.items()}
    three = charts.stability_figure("title", (wide, radius), (x, amplitude, amplitude))
    one = charts.quantity_figure("numerical_damping", "h/T", x, damping, 0.0, radii)
    for axes, found in ((three.axes[1], 100 * amplitude["bathe"]), (one.axes[0], damping["bathe"])):
        low, high = axes.get_ylim()
        assert -0.1 * found.max() < low < 0.0 < found.max() < high < 1.1 * found.max()
    alone = charts.quantity_figure(
        "numerical_damping", "h/T", x, {"rk2": damping["rk2"]}, 0.0, {"rk2": radii["rk2"] + 1}
    )
    assert alone.axes[0].get_ylim()[0] < damping["rk2"].min()


def test_charts_are_drawn_into_given_axes_and_leave_the_users_style() -> None:
    before = {key: rcParams[key] for key in ("axes.grid", "axes.prop_cycle", "lines.linewidth", "savefig.dpi")}
    labels = [f"curve {i}" for i in range(MOST)]
    series = {label: X * i for i, label in enumerate(labels)}
    figure = Figure()
    first, *three = figure.subplots(1, 4)
    assert charts.quantity_figure("period_error", "h/T", X, series, 0.0, axes=first) is figure
    assert charts.stability_figure("title", (X + 1, series), (X, series, series), axes=three) is figure
    assert [named(axes) for axes in figure.axes] == [labels] * 4
    assert [axes.get_legend() is not None for axes in figure.axes] == [True, True, False, False]
    assert all(axes.get_xlabel() for axes in figure.axes)
    assert {key: rcParams[key] for key in before} == before
    with style.context("substep.charts"):
        own = Figure().subplots()
    drawn = charts.quantity_figure("period_error", "h/T", X, series, 0.0).axes[0]
    for axes in (own, drawn):
        line = axes.xaxis.get_gridlines()[0]
        assert (line.get_linewidth(), line.get_visible()) == (0.3, True)
    curves = [own.plot(X)[0] for _ in labels[:-1]]  # the last of the chart is black
    looks = [[(line.get_color(), line.get_linestyle()) for line in some] for some in (curves, drawn.lines)]
    assert looks[0] == looks[1][: len(curves)]


def test_spectra_are_drawn_into_given_axes() -> None:
    found = ss.response_spectrum(np.sin(np.arange(20.0)), dt=0.1, periods=[0.5, 1.0])
    figure = Figure()
    axes = figure.subplots(2, 3).ravel()
    assert charts.spectrum_figure(found, axes=axes) is figure
    for given, own in zip(figure.axes, charts.spectrum_figure(found).axes, strict=True):
        assert given.get_ylabel() == own.get_ylabel() != ""
        for mine, line in zip(given.lines, own.lines, strict=True):
            assert np.array_equal(mine.get_xydata(), line.get_xydata())
    with pytest.raises(ValueError, match="expected six axes, of three spectra and their errors, got 5"):
        charts.spectrum_figure(found, axes=axes[:5])


def test_the_ground_itself_has_no_place_on_an_axis_of_log_periods() -> None:
    with_ground = ss.response_spectrum(np.sin(np.arange(20.0)), dt=0.1, periods=[0.0, 0.5, 1.0])
    for panel in charts.spectrum_figure(with_ground).axes:
        assert all(np.array_equal(line.get_xdata(), [0.5, 1.0]) for line in panel.get_lines())


def test_a_response_of_many_coordinates_is_labelled_at_the_ends() -> None:
    K = 50.0 * (2 * np.eye(MOST + 1) - np.eye(MOST + 1, k=1) - np.eye(MOST + 1, k=-1))
    many = ss.march(ss.structure(np.eye(MOST + 1), K, u0=np.arange(MOST + 1.0)), "bathe", dt=0.05, t_end=0.5)
    (axes,) = many.plot("u").axes
    assert axes.get_legend() is None
    assert sorted(text.get_text() for text in labels_of(axes)) == sorted(named(axes))
    assert_apart(axes)
    inside = axes.get_window_extent()
    assert all(text.get_window_extent().x0 >= inside.x1 for text in labels_of(axes))


def test_errors_at_equal_cost_are_labelled_at_the_curves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(catalogue_charts, "save", lambda figure, *_: drawn.append(figure))
    catalogue_charts.trade_off(tmp_path)
    (axes,) = drawn[0].axes
    assert len(labels_of(axes)) == len(named(axes)) == len(catalogue_charts.EQUAL_COST) + 1
    assert_apart(axes)
    inside = axes.get_window_extent()
    assert all(text.get_window_extent().x0 >= inside.x0 for text in labels_of(axes))


def test_rows_of_the_work_precision_chart_have_few_curves() -> None:
    every = {name: [run(1, 1.0, name)] for name in ss.schemes()}
    rows = precision._rows(every, every)
    assert all(len(row.curves) <= MOST for row in rows)
    constant = [name for row in rows for name in row.methods if not row.label.startswith("steps")]
    assert sorted(constant) == sorted(ss.schemes())
    for row in rows:
        looks = [(style["color"], style["linestyle"]) for *_, style in row.curves]
        assert len(set(looks)) == len(looks)


def run(cost: int, error: float, method: str = "bathe") -> Run:
    return Run(method, 0.1, 1, "completed", Cost(cost, cost, cost), 0.0, {"u": Errors(error, error, error)})


def test_the_least_error_for_a_cost() -> None:
    runs = [run(4, 1e-3), run(1, 0.5), run(2, 0.6), run(8, 2e-3), run(16, 0.0), run(1, 0.4), run(1, 3.0), run(0, 1e-9)]
    found = precision.best(runs, lambda r: r.cost.solves, lambda r: r.errors["u"].maximum)
    assert found == ([1, 4, 16], [0.4, 1e-3, 1e-16])
    assert precision.best([run(1, np.inf)], lambda r: r.cost.solves, lambda r: r.errors["u"].maximum) == ([], [])
