"""A response as a Dataset, as a DataFrame and as a figure."""

import builtins
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import substep as ss

pytestmark = pytest.mark.usefixtures("uncompiled")
FRAME = ss.structure(np.eye(2), np.diag([1.0, 4.0]), u0=1.0, names=("floor", "roof"))
RUNS: dict[str, Any] = {
    "oscillator": lambda: ss.march(ss.scene("linear_oscillator", omega=2.0), "bathe", 0.1, 1.0),
    "pendulum": lambda: ss.march(ss.scene("elastic_pendulum", EA=1e4), ss.scheme("newmark", beta=0.3), 0.01, 0.1),
    "structure": lambda: ss.march(FRAME, "bathe", 0.1, 1.0, dofs=["roof", "floor"]),
    "numbered": lambda: ss.march(ss.structure(np.eye(2), np.eye(2)), "park", 0.1, 1.0, dofs=[1]),
    "modes": lambda: ss.march(FRAME.modes(2), "bathe", 0.1, 1.0),
}
COLUMNS = {
    "oscillator": ["u", "v", "a", "energy"],
    "pendulum": ["u x", "u y", "v x", "v y", "a x", "a y", "energy", "angular_momentum", "strain"],
    "structure": ["u roof", "u floor", "v roof", "v floor", "a roof", "a floor", "energy", "work", "damped"],
    "numbered": ["u", "v", "a", "energy", "work", "damped"],
    "modes": ["u floor", "u roof", "v floor", "v roof", "a floor", "a roof", "energy", "work", "damped"],
}


@pytest.mark.parametrize("run", RUNS)
def test_every_number_arrives_under_its_name(run: str) -> None:
    r = RUNS[run]()
    ds, frame = r.to_xarray(), r.to_pandas()
    assert list(frame.columns) == COLUMNS[run]
    assert frame.index.name == "t"
    assert np.array_equal(frame.index, r.t)
    assert np.array_equal(ds.t, r.t)
    assert ds.t.units == "s"
    for name, values in ds.data_vars.items():
        mine = getattr(r, str(name), None)
        mine = getattr(r.account, str(name)) if mine is None and hasattr(r, "account") else mine
        assert np.array_equal(values, mine)
        assert values.long_name
    (dimension,) = set(ds.u.dims) - {"t"}
    for j, label in enumerate(ds[dimension].to_numpy()):
        key = f"u {label}" if r.u.shape[1] > 1 else "u"
        assert np.array_equal(frame[key], r.u[:, j])
        assert np.array_equal(ds.u.sel({dimension: label}), r.u[:, j])
    assert (ds.attrs["scheme"], ds.attrs["status"]) == (r.scheme.name, "completed")


def test_units_and_settings_are_attributes() -> None:
    ds = RUNS["pendulum"]().to_xarray()
    assert [ds[name].units for name in ("u", "v", "a", "energy", "angular_momentum")] == [
        "m", "m/s", "m/s^2", "J", "kg m^2/s",
    ]  # fmt: skip
    assert (ds.attrs["scene"], ds.attrs["scene_EA"], ds.attrs["scheme_beta"]) == ("elastic_pendulum", 1e4, 0.3)
    failed = ss.march("duffing", "bathe", 0.1, 1.0, energy_bound=0.0)
    assert (failed.to_xarray().attrs["status"], failed.to_xarray().attrs["t_failed"]) == ("energy_bound", 0.1)


def test_without_pandas_the_cure_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    actual = builtins.__import__

    def missing(name: str, *rest: Any, **more: Any) -> Any:
        if name == "pandas":
            raise ImportError(name)
        return actual(name, *rest, **more)

    r = RUNS["oscillator"]()
    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(ImportError, match=r"pip install pandas, or take to_xarray\(\)"):
        r.to_pandas()


@pytest.mark.parametrize("run", RUNS)
def test_plot_draws_the_histories_with_units(run: str) -> None:
    r = RUNS[run]()
    figure = r.plot("u", "v")
    assert isinstance(figure, Figure)
    above, below = figure.axes
    assert np.array_equal(np.transpose([line.get_ydata() for line in above.lines]), r.u)
    assert np.array_equal(np.transpose([line.get_ydata() for line in below.lines]), r.v)
    assert below.get_xlabel() == "t (s)"
    if run == "pendulum":
        assert (above.get_ylabel(), below.get_ylabel()) == ("displacement u (m)", "velocity v (m/s)")
        assert [line.get_label() for line in above.lines] == ["x", "y"]
        assert above.get_title() == "newmark at beta = 0.3 on elastic_pendulum"
    figure.draw_without_rendering()
    inside = figure.bbox
    for panel in figure.axes:
        legend, title = panel.get_legend(), panel.title.get_window_extent()
        assert (legend is not None) == (r.u.shape[1] > 1)
        assert inside.x0 <= title.x0 <= title.x1 <= inside.x1
        if legend is not None:
            box = legend.get_window_extent()
            assert panel.get_window_extent().x1 <= box.x0 < box.x1 <= inside.x1  # covers no curve, and is not cut


def test_plot_draws_into_given_axes_and_refuses_what_does_not_fit() -> None:
    r = RUNS["oscillator"]()
    own = Figure()
    axes = own.subplots(2)
    assert r.plot("u", "energy", axes=axes) is own
    assert [len(x.lines) for x in axes] == [1, 1]
    assert r.plot(axes=axes[0]) is own
    with pytest.raises(ValueError, match="expected an axes for each of u, v, got 1"):
        r.plot("u", "v", axes=axes[0])
    with pytest.raises(ValueError, match="did you mean 'energy'"):
        r.plot("enrgy")


@pytest.mark.parametrize("name", RUNS)
def test_what_is_saved_comes_back(name: str, tmp_path: Path) -> None:
    r, path = RUNS[name](), tmp_path / "response.nc"
    r.save(path)
    found = ss.load(path)
    assert found.identical(r.to_xarray())
    assert found.state.to_xarray().identical(r.state.to_xarray())
    found.save(tmp_path / "again.nc")
    assert ss.load(tmp_path / "again.nc").state.to_xarray().identical(r.state.to_xarray())


def test_what_a_choice_has_tried_is_saved(tmp_path: Path) -> None:
    """Of a scene and of a structure: each candidate's numbers, and the text."""
    choices = {
        "work": ss.choose(FRAME, 1e-2, t_end=1.0, quantity="roof", among=["bathe", "central_difference"]),
        "operations": ss.choose("duffing", 1e-2, t_end=0.5, among=["bathe", "newmark"]),
    }
    for name, choice in choices.items():
        choice.save(tmp_path / "choice.nc")
        found = ss.load(tmp_path / "choice.nc")
        assert found.identical(choice.to_xarray()) and found.attrs["text"] == choice.text
        assert found.error.values.tolist() == [c.error for c in choice.candidates]
        good = found.where(found.error <= choice.accuracy, drop=True)
        assert choice.best is not None
        assert float(good[name].min()) == float(good[name][int(np.argmin(abs(good.error.values - choice.best.error)))])
    none = ss.choose("duffing", 1e-9, t_end=0.3, among=["bathe"], chosen=[])
    assert none.to_xarray().attrs["text"] == none.text


def test_what_is_saved_without_a_state_is_not_gone_on_from(tmp_path: Path) -> None:
    """A march to an event of which not all degrees of freedom were kept, and Datasets that know nothing of a run."""
    ss.march(FRAME, "bathe", 0.1, 1.0, dofs=["roof"], until=lambda t, u, v: u[0]).save(tmp_path / "ended.nc")
    one = RUNS["oscillator"]()
    for start in (ss.load(tmp_path / "ended.nc"), one.to_xarray(), one.to_xarray().isel(t=slice(3))):
        with pytest.raises(
            ValueError, match=r"what ss.load reads of a file by r.save or r.state.save, .* got <ResultD"
        ):
            ss.march(one.scene, "bathe", 0.1, 2.0, start=start)


def test_what_cannot_be_loaded(tmp_path: Path) -> None:
    (tmp_path / "no.nc").write_text("no netCDF")
    with pytest.raises(ValueError, match=r"expected a netCDF file, got .*no.nc"):
        ss.load(tmp_path / "no.nc")
    with pytest.raises(OSError, match=r"nowhere.nc"):
        ss.load(tmp_path / "nowhere.nc")
