"""Charts of effectivity: who stands in which panel, what is not drawn, and whose error an estimate is divided by."""

from pathlib import Path

import numpy as np
import pytest

import substep as ss
from substep.derived import facade
from substep.studies import estimator_charts as charts


def test_every_scheme_stands_in_one_panel_with_its_like() -> None:
    found = charts.panels(ss.schemes(), charts.MOST)
    names = [name for panel in found for name in panel.names]
    assert sorted(names) == sorted(ss.schemes())
    for panel in found:
        assert 0 < len(panel.names) <= charts.MOST
        orders = [facade.order(name)[0] for name in panel.names]
        assert orders == sorted(orders)
        assert str(orders[0]) in panel.title and str(orders[-1]) in panel.title
    kinds = {name: panel.title.split(",")[0] for panel in found for name in panel.names}
    assert [kinds[name] for name in ("rk4", "newmark", "houbolt", "bathe")] == [
        *("explicit", "one solve a step", "several steps", "sub-steps"),
    ]
    assert not charts.panels([], charts.MOST)


@pytest.mark.parametrize("name", ["bogacki_shampine", "stoermer_extrapolation"])
def test_the_estimate_of_a_pair_is_over_the_error_of_its_second_value(name: str) -> None:
    """Over the error of the first value, of higher order, it would grow as 1/Omega does, or 1/Omega^2."""
    grid = np.array([0.4, 0.8])
    found = charts.effectivity(ss.scheme(name), grid).plain
    assert np.abs(found - 1).max() < 0.6
    assert (np.abs(found[:, 0] - 1) < 0.5 * np.abs(found[:, 1] - 1)).all()


def test_rounding_is_not_drawn() -> None:
    """At Omega = 0.01 the error of the eighth order's sixth-order value is about 1e-16."""
    found = charts.effectivity(ss.scheme("stoermer_extrapolation"), np.array([0.01, 0.5])).plain
    assert np.isnan(found[:, 0]).all()
    assert np.isfinite(found[:, 1]).all()


def test_all_three_figures_and_the_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(charts, "names", lambda: ("bathe", "rkn64", "houbolt"))
    monkeypatch.setattr(charts, "OMEGAS", np.array([0.1, 1.0]))
    charts.effectivity_chart(tmp_path)
    for name in ("effectivity", "effectivity_damped", "effectivity_filtered"):
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000
    header, *rows = (tmp_path / "effectivity.csv").read_text().splitlines()
    assert header.split(",") == ["Omega", *(f"{name} {q}" for name in ("bathe", "rkn64", "houbolt") for q in "uv")]
    own = charts.effectivity(ss.scheme("bathe"), charts.OMEGAS).plain
    assert [float(x) for x in rows[1].split(",")][1:3] == pytest.approx(own[:, 1])
