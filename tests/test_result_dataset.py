"""What is computed prints in ten lines: Datasets by their axes, and what went wrong in them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy import stats

import substep as ss

SHAKEN = np.sin(0.05 * np.arange(400.0))
RUNS: dict[str, Callable[[], Any]] = {
    "response": lambda: ss.march("duffing", "bathe", dt=0.1, t_end=1.0).to_xarray(),
    "sweep": lambda: ss.sweep("linear_oscillator", "newmark", omega=[1.0, 2.0], dt=0.1, t_end=1.0, keep="history"),
    "peaks": lambda: ss.sweep("duffing", "bathe", eps=np.linspace(0.1, 1.0, 9), dt=0.1, t_end=1.0, keep="peak"),
    "spectrum": lambda: ss.response_spectrum(SHAKEN, dt=0.02, xi=[0.02, 0.05]),
    "inelastic": lambda: ss.inelastic_spectrum(SHAKEN, dt=0.02, periods=[0.5, 1.0], ductility=[2.0, 4.0]),
    "rotated": lambda: ss.response_spectrum_rotated(SHAKEN, SHAKEN[::-1], dt=0.02),
    "design": lambda: ss.design_spectrum("ec8", a_g=2.0, ground="B"),
}


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize("name", RUNS)
def test_it_prints_in_ten_lines_with_all_its_variables(name: str) -> None:
    found = RUNS[name]()
    rows = repr(found).splitlines()
    assert len(rows) <= 10
    assert max(map(len, rows)) <= 100
    words = set(repr(found).replace(",", " ").replace(":", " ").split())
    assert {*map(str, found.data_vars), *map(str, found.sizes)} <= words
    assert len(repr(found.isel(dict.fromkeys(found.sizes, 0))).splitlines()) <= 10


def test_ten_lines_are_all_there_is_of_many_variables() -> None:
    many = RUNS["response"]().assign({f"a_long_name_of_variable_{k}": ("t", np.zeros(11)) for k in range(99)})
    rows = repr(many).splitlines()
    assert len(rows) == 10
    assert rows[-1] == "  ..."
    assert len(repr(xr.Dataset(many.data_vars)).splitlines()) > 10  # xarray's own


@pytest.mark.usefixtures("plain_in_gate")
def test_it_says_how_many_runs_have_completed_and_where_axes_go() -> None:
    """Central differences are unstable beyond Omega = 2: at the largest of three frequencies energy grows."""
    call: dict[str, Any] = {"omega": [1.0, 2.0, 9.0], "dt": 0.25, "t_end": 50.0, "keep": "final", "energy_bound": 1e6}
    lines = repr(ss.sweep("linear_oscillator", "central_difference", **call)).splitlines()
    assert lines[0].startswith("<ResultDataset central_difference on linear_oscillator, 2 of 3 runs completed, ")
    assert lines[1] == "axes: omega 3 (1, 2, 9), coordinate 1 (u), balance 1 (1)"
    lines = repr(RUNS["peaks"]()).splitlines()
    assert lines[1] == "axes: eps 9 (0.1 ... 1), coordinate 1 (u), balance 2 (1, 2)"
    one = RUNS["sweep"]().isel(omega=0, t=-1)
    assert f"energy = {float(one.energy):.5g} J" in repr(one)
    assert "besides: omega = 1, t = 1 s" in repr(one)


FRAME = ss.structure(np.eye(2), [[50.0, -20.0], [-20.0, 20.0]], C=ss.modal_damping(0.05, modes=2), names=("a", "b"))
RESULTS: dict[str, Callable[[], Any]] = RUNS | {
    "incremental": lambda: ss.incremental_dynamic_analysis(
        [SHAKEN, SHAKEN], dt=0.02, periods=[1.0], intensity=[0.1, 0.2], strength=0.5
    ),
    "uncertainty": lambda: ss.uncertainty(
        ss.sweep("duffing", "bathe", eps=stats.norm(1.0, 0.1), samples=16, dt=0.1, t_end=1.0)
    ),
    "asce7": lambda: ss.design_spectrum("asce7", S_DS=1.0, S_D1=0.6, T_L=8.0),
    "nbcc": lambda: ss.design_spectrum("nbcc", S_a=[0.85, 0.75, 0.42, 0.26, 0.08, 0.03]),
    "intensity": lambda: ss.intensity(SHAKEN, dt=0.02),
    "record": lambda: ss.Record(0.02, SHAKEN, unit="g", source="a sine"),
    "modes": lambda: ss.response_spectrum_analysis(FRAME.modes(2), SHAKEN, [1.0, 1.0], dt=0.02),
    "participation": lambda: FRAME.modes(2).participation([1.0, 1.0]),
    "critical": lambda: FRAME.critical_step("central_difference"),
    "drift": lambda: ss.energy_drift(ss.scene("duffing", k=1.0, eps=0.1, u0=1.0), "bathe", t_end=9.0),
    "own": lambda: ss.own_energy(ss.march(ss.scene("linear_oscillator", omega=2.0), "bathe", dt=0.2, t_end=1.0)),
}


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize("name", RESULTS)
def test_every_result_is_saved_and_comes_back(name: str, tmp_path: Path) -> None:
    made = RESULTS[name]()
    made.save(tmp_path / "made.nc")
    assert ss.load(tmp_path / "made.nc").identical(made if isinstance(made, xr.Dataset) else made.to_xarray())


def test_what_is_saved_of_a_result_are_its_numbers_arrays_and_texts() -> None:
    peaks, drift, record = (RESULTS[name]().to_xarray() for name in ("modes", "drift", "record"))
    assert dict(peaks.modal_u.sizes) == {"mode": 2, "dofs": 2}
    assert peaks.u.sel(dofs="b") == RESULTS["modes"]().u[1]
    assert np.array_equal(drift.lost.sel(power_lost=3), RESULTS["drift"]().lost[3])
    assert (float(record.dt), record["values"].size, record.unit, record.source) == (0.02, 400, "g", "a sine")


@pytest.mark.parametrize("turned", [False, True])
def test_a_file_and_a_folder_print_alike(turned: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In whatever order a folder lists its arrays."""
    opened = xr.open_zarr

    def listed(*given: Any, **options: Any) -> xr.Dataset:
        found = opened(*given, **options)
        kept, coords = (dict(sorted(x.items(), reverse=turned)) for x in (found.data_vars, found.coords))
        return xr.Dataset({name: x.variable for name, x in kept.items()}, coords, found.attrs)

    monkeypatch.setattr(xr, "open_zarr", listed)
    r = ss.march("duffing", "bathe", dt=0.1, t_end=1.0)
    r.save(tmp_path / "r.nc")
    assert repr(ss.load(tmp_path / "r.nc")) == repr(r.to_xarray())
    call: dict[str, Any] = {"omega": [1.0, 2.0], "dt": 0.1, "t_end": 1.0}
    here, there = (ss.sweep("linear_oscillator", "newmark", **call, save=at) for at in (None, tmp_path / "kept"))
    rows, expected = repr(there).splitlines(), repr(here).splitlines()
    assert rows[1:] == expected[1:]
    assert "on linear_oscillator, 2 of 2 runs completed" in rows[0]  # labels take other room in a folder
