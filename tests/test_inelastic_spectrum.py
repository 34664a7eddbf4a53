"""Inelastic spectra: against the elastic ones and an exact solution from event to event, and what cannot be had."""

from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import hysteresis
import numpy as np
import pytest
from hysteresis import Oscillator, exact
from matplotlib.figure import Figure
from scipy.signal import lfilter
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app
from substep.figures.inelastic_charts import incremental_figure, inelastic_figure
from substep.ground_motion.constant_ductility import RATIO, strengths_of
from substep.ground_motion.inelastic_history import InelasticSpectrum

Array = np.ndarray
DT = 0.02
RECORD = Path(__file__).with_name("el_centro_1940_ns.txt")
PERIODS = (0.3, 0.7, 1.6)
ERRORS = {"displacement_error", "hysteretic_energy_error", "residual_displacement_error"}


@cache
def motion(n: int = 400, seed: int = 1940) -> Array:
    """Ground acceleration (n,) in m/s^2: noise through the soil's resonance at 2.5 Hz, in an envelope; starts at 0."""
    noise = np.random.default_rng(seed).normal(size=n)
    a, b = 2 * np.exp(-0.3 * 16 * DT) * np.cos(16 * DT), -np.exp(-0.6 * 16 * DT)
    return np.sin(np.pi * np.arange(n) / n) ** 2 * lfilter([1.0, -1.0], [1.0, -a, -b], noise)


@cache
def ductile(hardening: float = 0.05, steps: int = 32) -> InelasticSpectrum:
    return ss.inelastic_spectrum(
        motion(), DT, PERIODS, ductility=[1, 1.5, 4], hardening=hardening, steps=steps, tolerance=1e-4
    )


def between_events(T: float, strength: float, hardening: float) -> dict[str, float]:
    """Largest |u| at samples and between them, energy lost, excursions, and the displacement at rest at last."""
    of, end = Oscillator(2 * np.pi / T, 0.05, strength, hardening), DT * (len(motion()) - 1)
    shaken = exact(of, hysteresis.record(DT, (-motion()).tolist()), end + 6 * T)
    turns = [t for t in shaken.events if t < end]  # where it begins to yield, and turns
    u = shaken.at(np.append(np.linspace(0.0, end, 2 * len(motion()) - 1), turns))[0]
    begun = [b.t for a, b in pairwise(shaken.arcs) if b.yields and b.yields != a.yields]
    return {
        "displacement": float(np.abs(u).max()),
        "hysteretic_energy": float(shaken.at(np.array([end]))[3, 0]),
        "yield_excursions": sum(t <= end for t in begun),
        "residual_displacement": (1 - hardening) * float(shaken.at(np.array([end + 6 * T]))[2, 0]),
    }


@pytest.mark.parametrize(("hardening", "ductility"), [(0.05, 1.5), (0.05, 4.0), (0.0, 4.0)])
def test_an_exact_solution_between_events_finds_the_same(hardening: float, ductility: float) -> None:
    at = ductile(hardening).sel(ductility=ductility)
    for j, T in enumerate(PERIODS):
        true = between_events(T, float(at.A_y[j]), hardening)
        peak = true["displacement"]
        assert float(at.displacement[j]) == pytest.approx(peak, rel=2e-4)
        assert peak * (2 * np.pi / T) ** 2 / float(at.A_y[j]) == pytest.approx(ductility, rel=3e-4)
        assert float(at.hysteretic_energy[j]) == pytest.approx(true["hysteretic_energy"], rel=1e-3)
        assert abs(float(at.residual_displacement[j]) - true["residual_displacement"]) < 3e-4 * peak
        assert float(at.yield_excursions[j]) == true["yield_excursions"] > 0


def test_the_error_of_half_the_step_is_three_quarters_of_the_schemes() -> None:
    """Not of every value, as the samples do not meet events evenly: in the mean over those that are not tiny."""
    s = ductile(0.05, 4)
    parts = []
    for i, j in ((1, 0), (1, 1), (1, 2), (2, 2)):
        true = between_events(PERIODS[j], float(s.A_y[i, j]), 0.05)["displacement"]
        parts.append(float(s.displacement_error[i, j]) / (float(s.displacement[i, j]) / true - 1))
    assert 0.6 < np.mean(parts) < 0.9


def test_el_centro_of_the_textbook() -> None:
    """Chopra, Dynamics of Structures, section 7.4: period 0.5 s, damping ratio 5 %, elastic-perfectly plastic.

    Of strengths 1, 1/2, 1/4, 1/8 of the elastic one the book prints the largest displacements in inches, and the
    ductilities; both here within one unit of their last digit.
    """
    g, inch = 386.1, 0.0254
    ground = np.append(0.0, np.loadtxt(RECORD).ravel()) * g * inch
    s = ss.inelastic_spectrum(ground, DT, [0.5], R_y=[1, 2, 4, 8], steps=16, errors=False)
    assert np.allclose(s.displacement.squeeze() / inch, [2.25, 1.62, 1.75, 2.07], rtol=0.0, atol=0.007)
    assert np.allclose(s.ductility_demand.squeeze(), [1.0, 1.44, 3.11, 7.36], rtol=0.0, atol=0.011)


def test_ductility_1_and_a_huge_strength_are_the_elastic_spectrum() -> None:
    T = np.geomspace(0.05, 5.0, 20)
    elastic = ss.response_spectrum(motion(), DT, T)
    s = ss.inelastic_spectrum(motion(), DT, T, ductility=1.0)
    assert s.A_y.dims == ("period",)
    assert np.allclose(s.A_y, elastic.pseudo_acceleration, rtol=1e-14)
    huge = ss.inelastic_spectrum(motion(), DT, T, strength=1e6)
    for found in (s, huge):
        assert np.allclose(found.displacement, elastic.displacement, rtol=1e-10, atol=0.0)
        for name in ("residual_displacement", "hysteretic_energy", "yield_excursions"):
            assert not found[name].any()
    assert np.allclose(huge.R_y, elastic.pseudo_acceleration / 1e6, rtol=1e-10)
    assert "solutions" not in huge


def test_the_three_that_can_be_constant_agree() -> None:
    s = ductile()
    by_R = ss.inelastic_spectrum(motion(), DT, PERIODS[:1], R_y=s.R_y[:, 0], hardening=0.05, steps=32, errors=False)
    by_strength = ss.inelastic_spectrum(motion(), DT, PERIODS[:1], strength=s.A_y[:, 0], hardening=0.05, steps=32)
    for found in (by_R, by_strength):
        assert np.allclose(found.displacement[:, 0], s.displacement[:, 0], rtol=1e-6)
        assert np.allclose(found.ductility_demand[:, 0], s.ductility, rtol=1.1e-4)
    assert np.allclose(by_R.A_y[:, 0], s.A_y[:, 0], rtol=1e-12)
    assert by_R.R_y.dims == ("R_y",)
    assert not ERRORS & set(by_R)
    assert set(by_strength) >= ERRORS


def test_a_dataset_tells_units_and_how_it_was_made() -> None:
    s = ductile()
    assert dict(s.sizes) == {"ductility": 3, "period": 3}
    assert {name: s[name].units for name in s.variables} == {
        "A_y": "m s-2", "displacement": "m", "ductility_demand": "1", "R_y": "1", "residual_displacement": "m",
        "hysteretic_energy": "J kg-1", "yield_excursions": "1", "solutions": "1", "ductility": "1", "period": "s",
        "xi": "1", **dict.fromkeys(ERRORS, "1"),
    }  # fmt: skip
    assert all("long_name" in s[name].attrs for name in s.variables)
    assert {name: s.attrs[name] for name in ("scheme", "dt", "samples", "steps", "law", "hardening", "unstable")} == {
        "scheme": "average_acceleration", "dt": DT, "samples": 400, "steps": 32, "law": "bilinear", "hardening": 0.05,
        "unstable": 0,
    }  # fmt: skip


def test_the_history_is_of_the_spectrums_oscillator() -> None:
    s = ductile()
    r = s.history(T=PERIODS[1], ductility=4)
    assert np.abs(r.u).max() == pytest.approx(float(s.displacement[2, 1]), rel=1e-12)
    assert r.energy_dissipated[-1] == pytest.approx(float(s.hysteretic_energy[2, 1]), rel=1e-12)
    for text, options in {
        "one of [1.0, 1.5, 4.0] or any other": {},
        "expected ductility, which is constant in this spectrum, got R_y": {"R_y": 2.0},
        "expected ductility >= 1, got 0.5": {"ductility": 0.5},
        "expected T > 0": {"T": 0.0, "ductility": 2.0},
    }.items():
        with pytest.raises(ValueError, match=text.replace("[", r"\[").replace("]", r"\]")):
            s.history(**{"T": 1.0, **options})
    with pytest.raises(ValueError, match="got one made from it"):
        s.isel(period=0).history(T=1.0)


def test_of_several_strengths_the_largest_is_found_and_all_are_counted() -> None:
    """A ductility that rises to 4 at R = e, falls below 2 and rises again; and one that never reaches 2."""

    def ductility(i: Array, R: Array) -> Array:
        x = np.log(R)
        wave = np.where(x < 1, 1 + 3 * x, np.where(x < 2, 4 - 3 * (x - 1), 1 + 3 * (x - 2)))
        return np.where(i == 0, np.maximum(wave, 1.0), 1.5)

    r = strengths_of(ductility, np.array([2.0, 3.0, 20.0]), 2, 1e-6)
    assert np.allclose(np.log(r.reduction[:, 0]), [1 / 3, 2 / 3, 2 + 19 / 3], rtol=1e-5)
    assert r.solutions.tolist() == [[3, 0], [3, 0], [1, 0]]
    assert np.isnan(r.reduction[:, 1]).all()
    assert np.log(RATIO) < 1 / 3  # else the grid would not see the wave


def test_a_march_that_fails_and_a_jump_give_no_strength() -> None:
    def ductility(i: Array, R: Array) -> Array:
        return np.where(i == 0, np.where(R < 3, 1.0, 5.0), np.where(R < 3, R, np.nan))

    r = strengths_of(ductility, np.array([2.0, 4.0]), 2, 1e-3)
    assert np.isnan(r.reduction[:, 0]).all()
    assert r.reduction[0, 1] == pytest.approx(2.0, rel=1e-3)
    assert np.isnan(r.reduction[1, 1])


def test_what_no_strength_gives_is_nan_and_not_an_error() -> None:
    silent = ss.inelastic_spectrum(ss.Record(DT, np.zeros(50), unit="m/s^2"), periods=[0.5, 1.0], ductility=[1, 2])
    assert np.isnan(silent.A_y).all()
    assert np.isnan(silent.residual_displacement).all()
    assert not silent.solutions.any()
    idle = ss.inelastic_spectrum(ss.Record(DT, np.zeros(50), unit="m/s^2"), periods=[0.5, 1.0], strength=1.0)
    assert not idle.displacement.any()
    assert not idle.residual_displacement_error.any()


@pytest.mark.thorough
@pytest.mark.parametrize("scheme", ["bathe", "houbolt", "central_difference", "wilson_theta"])
def test_every_kind_of_scheme_has_its_own_elastic_spectrum(scheme: str) -> None:
    T = [0.04, 0.3, 1.0]
    elastic = ss.response_spectrum(motion(), DT, T, scheme=scheme)
    s = ss.inelastic_spectrum(motion(), DT, T, scheme=scheme, ductility=[1, 4])
    huge = ss.inelastic_spectrum(motion(), DT, T, scheme=scheme, strength=1e6)
    found = np.isfinite(elastic.displacement.to_numpy())
    for each in (s.isel(ductility=0), huge):
        assert np.array_equal(np.isfinite(each.displacement), found)
    assert s.unstable == huge.unstable == np.count_nonzero(~found)
    assert np.allclose(huge.displacement[found], elastic.displacement[found], rtol=1e-10)
    assert np.allclose(s.A_y[0, found], elastic.pseudo_acceleration[found], rtol=1e-10)
    assert np.allclose(s.ductility_demand[1, found], 4.0, rtol=0.01)
    assert np.isnan(s.A_y[:, ~found]).all()


WRONG: dict[str, dict[str, Any]] = {
    r"expected ductility >= 1, got 0.5; 1 is the elastic": {"ductility": [2, 0.5]},
    r"expected strength > 0, got 0; give positive": {"strength": [0.0, 1.0]},
    r"expected strength > 0, got -1": {"strength": -1.0},
    r"expected R_y > 0, got 0": {"R_y": 0.0},
    r"expected one of ductility, strength and R_y, got ductility and R_y": {"ductility": 2, "R_y": 2},
    r"expected hardening in \[0.0, 1.0\), got 1.0": {"hardening": 1.0},
    r"expected ductility to be finite, got nan": {"ductility": [1, np.nan]},
    r"expected ductility to be a number or a row of them, got none": {"ductility": []},
    r"expected strength to be finite": {"strength": np.inf},
    r"expected periods > 0, got 0, the ground itself": {"periods": [0.0, 1.0]},
    r"expected a law, .*bilinear.*got 'bouc_wen'": {"law": "bouc_wen"},
    r"expected xi as a ratio, at most 1, got 5": {"xi": 5.0},
    r"expected steps to be a whole number >= 1, got 1.5": {"steps": 1.5},
    r"expected tolerance in \(0.0, 1.0\), got 0": {"tolerance": 0.0},
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_input_says_what_was_expected(text: str) -> None:
    with pytest.raises(ValueError, match=text):
        ss.inelastic_spectrum(motion(), DT, **{"periods": [1.0], **WRONG[text]})


def test_an_incremental_analysis_scales_records_until_they_collapse() -> None:
    records = [motion(), motion(seed=1), motion(seed=2)]
    levels, T, strength = [0.5, 2.0, 4.0, 20.0], [0.5, 1.0], [2.0, 1.5]
    s = ss.incremental_dynamic_analysis(records, T, levels, strength, dt=DT, collapse=6.0)
    for r, record in enumerate(records):
        for p in range(2):
            for k in range(4):
                factor = float(s.scale[r, p, k])
                one = ss.inelastic_spectrum(
                    ss.Record(DT, factor * record, unit="m/s^2"),
                    periods=T[p : p + 1],
                    strength=strength[p],
                    errors=False,
                )
                mu = float(one.ductility_demand[0])
                assert float(one.R_y[0]) * strength[p] == pytest.approx(levels[k], rel=1e-10)
                assert float(s.displacement[r, p, k]) == pytest.approx(float(one.displacement[0]), rel=1e-9)
                assert bool(s.collapsed[r, p, k]) == (mu >= 6.0)
                assert float(s.ductility[r, p, k]) == (pytest.approx(mu, rel=1e-9) if mu < 6.0 else np.inf)
    assert np.isclose(s.ductility[:, :, 0], 0.5 / np.array(strength), rtol=1e-10).all()  # elastic
    assert np.array_equal(s.ductility_fractile[1], np.median(s.ductility, axis=0))
    assert np.array_equal(s.collapse_fraction, s.collapsed.to_numpy().mean(axis=0))
    assert s.collapsed.any()
    assert not s.collapsed.all()
    by_scale = ss.incremental_dynamic_analysis(
        records, T, s.scale[0, 0], strength, measure="scale", dt=DT, collapse=6.0
    )
    assert np.allclose(by_scale.displacement[0, 0], s.displacement[0, 0], rtol=1e-12)
    drawn = incremental_figure(s)
    assert len(drawn.axes) == 2
    assert [len(axes.lines) for axes in drawn.axes] == [6, 6]


def test_what_one_record_leaves_unknown_is_no_part_that_stands() -> None:
    """Central differences are unstable at T = 0.1 s in the steps of the second record."""
    times = {0.02: np.arange(0.0, 5.0, 0.02), 0.1: np.arange(0.0, 5.0, 0.1)}
    records = [ss.Record(dt, 3.0 * np.sin(5.0 * t)) for dt, t in times.items()]
    s = ss.incremental_dynamic_analysis(records, [0.1, 1.0], [1.0, 1e6], 2.0, scheme="central_difference")
    assert s.unstable == 1
    assert np.isnan(s.collapse_fraction[0]).all()
    assert np.isnan(s.ductility_fractile[:, 0]).all()
    assert s.collapse_fraction[1].to_numpy().tolist() == [0.0, 1.0]


@pytest.mark.parametrize(
    ("text", "options"),
    [
        ("expected a list of records", {"records": motion()}),
        ("expected a list of records", {"records": []}),
        ("expected a list of records", {"records": 5}),
        ("records that move an oscillator, to be scaled, got record 2 of 2", {"records": [motion(), 0.0 * motion()]}),
        ("expected intensity > 0, got -1", {"intensity": [1.0, -1.0]}),
        ("expected strength > 0, got 0", {"strength": 0.0}),
        ("expected strength as one number or 1", {"strength": [1.0, 2.0]}),
        ("expected collapse in", {"collapse": 1.0}),
        ("expected a measure of intensity", {"measure": "PGA"}),
    ],
)
def test_a_wrong_analysis_says_what_was_expected(text: str, options: dict[str, Any]) -> None:
    given: dict[str, Any] = {"records": [motion()], "periods": [1.0], "intensity": 1.0, "strength": 1.0, **options}
    with pytest.raises(ValueError, match=text):
        ss.incremental_dynamic_analysis(dt=DT, **given)


def test_the_figure_has_a_curve_for_each_value() -> None:
    drawn = inelastic_figure(ductile())
    assert [len(axes.lines) for axes in drawn.axes] == [3, 3, 3]
    assert np.allclose(drawn.axes[0].lines[2].get_ydata(), ductile().A_y[2])
    one = ss.inelastic_spectrum(motion(), DT, [0.5, 1.0], strength=2.0)
    panels = list(Figure().subplots(1, 3))
    assert inelastic_figure(one, panels) is panels[0].get_figure()
    assert np.allclose(panels[0].lines[0].get_ydata(), one.ductility_demand)
    with pytest.raises(ValueError, match="three axes"):
        inelastic_figure(one, panels[:2])


def test_the_command_prints_writes_and_draws(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    file, out = tmp_path / "motion.txt", tmp_path / "out.csv"
    np.savetxt(file, np.column_stack([DT * np.arange(400), motion()]))
    options = ["spectrum", str(file), "--periods", "0.3,0.7,1.6", "--ductility", "1,4", "--hardening", "0.05"]
    result = CliRunner().invoke(app, [*options, "--csv", str(out), "--chart", str(tmp_path / "s")])
    assert result.exit_code == 0, result.output
    s = ss.inelastic_spectrum(motion(), DT, PERIODS, ductility=[1, 4], hardening=0.05)
    assert "3 of 3" in result.output
    assert f"{float(s.A_y[1].max()):.4g}" in result.output
    header, *rows = out.read_text(encoding="utf-8").splitlines()
    assert header.startswith("ductility (1),period (s),A_y (m s-2),displacement (m)")
    assert [float(row.split(",")[2]) for row in rows] == pytest.approx(s.A_y.to_numpy().ravel().tolist())
    assert (tmp_path / "s.png").stat().st_size > 10_000
    for more, text in ((["--refine", "auto"], "without --ductility"), (["--ductility", "x"], "for --ductility")):
        wrong = CliRunner().invoke(app, [*options, *more])
        assert wrong.exit_code == 2
        assert text in " ".join(wrong.output.replace("│", " ").split())
    alone = CliRunner().invoke(app, ["spectrum", str(file), "--hardening", "0.05"])
    assert "expected --hardening with --ductility" in " ".join(alone.output.replace("│", " ").split())
