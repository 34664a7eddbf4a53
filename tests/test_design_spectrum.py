"""Design spectra: the clauses branch by branch, values at their corners, and wrong input."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plane_elements import shear_building

import substep as ss
from substep.core.units import STANDARD_GRAVITY

TABLE_3_2 = "A 1.0 0.15 0.4 2.0; B 1.2 0.15 0.5 2.0; C 1.15 0.20 0.6 2.0; D 1.35 0.20 0.8 2.0; E 1.4 0.15 0.5 2.0"
TABLE_3_3 = "A 1.0 0.05 0.25 1.2; B 1.35 0.05 0.25 1.2; C 1.5 0.10 0.25 1.2; D 1.8 0.10 0.30 1.2; E 1.6 0.05 0.25 1.2"
SITES = [(i, *row.split()) for i, table in enumerate((TABLE_3_2, TABLE_3_3), start=1) for row in table.split(";")]
T = np.array([0.0, 0.01, 0.05, 0.12, 0.2, 0.25, 0.3, 0.45, 0.6, 0.8, 1.0, 1.2, 1.7, 2.0, 3.0, 4.0])


@pytest.mark.parametrize(("type", "ground", "S", "T_B", "T_C", "T_D"), SITES)
@pytest.mark.parametrize("xi", [0.0, 0.05, 0.1, 0.4])
def test_eurocode_8_branch_by_branch(type: int, ground: str, S: str, T_B: str, T_C: str, T_D: str, xi: float) -> None:
    a_g, b, c, d = 2.5 * float(S), float(T_B), float(T_C), float(T_D)
    eta = max(math.sqrt(10 / (5 + 100 * xi)), 0.55)

    def S_e(t: float) -> float:
        if t <= b:
            return a_g * (1 + t / b * (eta * 2.5 - 1))
        if t <= c:
            return a_g * eta * 2.5
        if t <= d:
            return a_g * eta * 2.5 * c / t
        return a_g * eta * 2.5 * c * d / t**2

    found = ss.design_spectrum("ec8", T, a_g=2.5, ground=ground, type=type, xi=xi)
    assert found.acceleration.to_numpy() == pytest.approx([S_e(t) for t in T.tolist()], rel=1e-13)
    assert found.attrs == {
        "code": "EN 1998-1:2004, 3.2.2.2", "a_g": 2.5, "unit": "m/s^2", "ground": ground, "type": type, "S": float(S),
        "T_B": b, "T_C": c, "T_D": d, "eta": pytest.approx(eta),
    }  # fmt: skip
    assert float(found.xi) == xi


def test_asce_7_branch_by_branch() -> None:
    S_DS, S_D1, T_L = 1.1, 0.66, 3.0
    T_S = S_D1 / S_DS

    def S_a(t: float) -> float:
        if t < 0.2 * T_S:
            return S_DS * (0.4 + 0.6 * t / (0.2 * T_S))
        if t <= T_S:
            return S_DS
        return S_D1 / t if t <= T_L else S_D1 * T_L / t**2

    periods = [*T, 0.2 * T_S, T_S, T_L, 7.0, 20.0]
    found = ss.design_spectrum("asce7", periods, S_DS=S_DS, S_D1=S_D1, T_L=T_L)
    assert found.acceleration.to_numpy() / STANDARD_GRAVITY == pytest.approx([S_a(t) for t in periods], rel=1e-13)
    expected = {"code": "ASCE 7-16, 11.4.6", "S_DS": 1.1, "S_D1": 0.66, "T_L": 3.0, "unit": "g"}
    assert found.attrs == expected | {"T_0": pytest.approx(0.12), "T_S": pytest.approx(0.6)}
    assert float(found.xi) == 0.05


S_A, F = (0.85, 0.9, 0.425, 0.257, 0.08, 0.029), (0.9, 1.1, 1.24, 1.3, 1.35, 1.4)


def test_nbcc_2015_branch_by_branch() -> None:
    """Up to 0.2 s the larger of two values, that of 0.5 s with these F, that of 0.2 s in the last one."""
    at_02, at_05, at_1, at_2, at_5, at_10 = (f * s for f, s in zip(F, S_A, strict=True))

    def S(t: float) -> float:
        if t <= 0.2:
            return max(at_02, at_05)
        if t <= 0.5:
            return max(at_02, at_05) + (at_05 - max(at_02, at_05)) * (t - 0.2) / 0.3
        if t <= 1.0:
            return at_05 + (at_1 - at_05) * (t - 0.5) / 0.5
        if t <= 2.0:
            return at_1 + (at_2 - at_1) * (t - 1.0)
        if t <= 5.0:
            return at_2 + (at_5 - at_2) * (t - 2.0) / 3.0
        return at_5 + (at_10 - at_5) * (t - 5.0) / 5.0 if t <= 10.0 else at_10

    periods = [*T, 5.0, 7.0, 10.0, 12.0]
    found = ss.design_spectrum("nbcc", periods, S_a=S_A, F=F)
    assert found.acceleration.to_numpy() / STANDARD_GRAVITY == pytest.approx([S(t) for t in periods], rel=1e-13)
    assert (found.code, found.unit, float(found.xi)) == ("NBCC 2015, 4.1.8.4.(9)", "g", 0.05)
    assert (found.S_a.tolist(), found.F.tolist()) == (list(S_A), list(F))
    hard = ss.design_spectrum("nbcc", [0.0, 0.35, 0.5], S_a=(0.9, 0.7, 0.4, 0.2, 0.1, 0.05)).acceleration
    assert hard.to_numpy() / STANDARD_GRAVITY == pytest.approx([0.9, 0.8, 0.7], rel=1e-13)


def test_a_spectrum_of_a_code_is_saved_with_its_parameters(tmp_path: Path) -> None:
    for code, given in GIVEN.items():
        found = ss.design_spectrum(code, T, **given)
        found.to_netcdf(tmp_path / f"{code}.nc", engine="scipy")
        assert ss.load(tmp_path / f"{code}.nc").identical(found)


@pytest.mark.parametrize(("code", "scaled"), [("ec8", ["a_g"]), ("asce7", ["S_DS", "S_D1"]), ("nbcc", ["S_a"])])
def test_accelerations_in_any_unit(code: str, scaled: list[str]) -> None:
    given, default = GIVEN[code], 1.0 if code == "ec8" else STANDARD_GRAVITY
    expected = ss.design_spectrum(code, T, **given).acceleration
    for unit, factor in (("g", STANDARD_GRAVITY), ("m/s^2", 1.0), ("cm/s^2", 0.01), (2.0, 2.0)):
        other = given | {name: np.multiply(given[name], default / factor) for name in scaled}
        found = ss.design_spectrum(code, T, **other, unit=unit)
        assert np.allclose(found.acceleration, expected, rtol=1e-13, equal_nan=True)
        assert found.unit == (unit if isinstance(unit, str) else "2 m/s^2")


GIVEN: dict[str, dict[str, Any]] = {
    "ec8": {"a_g": 1.0, "ground": "A"},
    "asce7": {"S_DS": 1.0, "S_D1": 0.6, "T_L": 8.0},
    "nbcc": {"S_a": S_A},
}
CALLS: dict[str, Callable[..., Any]] = {
    "ec8": lambda T, scale=1.0: ss.design_spectrum("ec8", T, a_g=2.0 * scale, ground="D", xi=0.03),
    "asce7": lambda T, scale=1.0: ss.design_spectrum("asce7", T, S_DS=scale, S_D1=0.7 * scale, T_L=2.5),
    "nbcc": lambda T, scale=1.0: ss.design_spectrum("nbcc", T, S_a=scale * np.array(S_A), F=F),
}


@pytest.mark.parametrize("code", CALLS)
def test_a_curve_without_jumps_that_scales(code: str) -> None:
    fine = np.linspace(0.0, 4.0, 40_001)
    curve = CALLS[code](fine).acceleration
    rise, corners = np.abs(np.diff(curve)), np.argmax(curve.to_numpy())
    assert rise.max() < 0.002 * float(curve.max())
    assert (np.diff(curve)[corners + 1 :] <= 1e-12).all()
    assert np.allclose(CALLS[code](fine, 3.0).acceleration, 3.0 * curve, rtol=1e-13)
    assert curve.units == "m s-2"
    assert curve.dims == ("period",)


def test_beyond_4_s_eurocode_8_has_its_annex() -> None:
    found = ss.design_spectrum("ec8", [4.0, 4.01, 10.0], a_g=1.0, ground="A").acceleration
    assert np.isnan(found).to_numpy().tolist() == [False, True, True]
    drawn = ss.response_spectrum(np.sin(np.arange(100.0)), 0.02)
    beside = ss.design_spectrum("ec8", drawn.period, a_g=1.0, ground="A")
    assert beside.period.equals(drawn.period)
    assert ss.design_spectrum("ec8", a_g=1.0, ground="A").identical(beside)


def test_a_structure_under_a_code() -> None:
    """The shear of one mode is its mass times the spectral acceleration."""
    modes = ss.structure(*shear_building([2.0], [300.0])).modes(1).damped(0.05)
    found = ss.response_spectrum_analysis(
        modes, lambda T, xi: ss.design_spectrum("ec8", T, a_g=2.5, ground="B").acceleration, 1.0
    )
    period = 2 * math.pi * math.sqrt(2.0 / 300.0)
    assert 0.5 < period < 2.0
    assert found.shear == pytest.approx(2.0 * 2.5 * 1.2 * 2.5 * 0.5 / period, rel=1e-10)


@pytest.mark.parametrize(
    ("code", "change", "message"),
    [
        ("nbc", {}, "expected a code, one of: ec8, asce7, nbcc; got 'nbc'; did you mean 'nbcc'?"),
        ("ec8", {"ground": "F"}, "expected a type of ground, one of: A, B, C, D, E; got 'F'"),
        ("ec8", {"type": 3}, "expected a type of spectrum, one of: 1, 2; got '3'"),
        ("ec8", {"a_g": 0.0}, "expected a_g > 0"),
        ("ec8", {"xi": -0.1}, "expected xi >= 0"),
        ("ec8", {"periods": [-1.0]}, "expected periods >= 0"),
        ("asce7", {"S_DS": -1.0}, "expected S_DS > 0"),
        ("asce7", {"T_L": math.nan}, "expected T_L to be finite"),
        ("ec8", {"a_g": 0.25}, 'expected a_g in m/s.2, got 0.25, which is very low seismicity; give unit="g" or'),
        (
            "ec8",
            {"a_g": 250.0},
            "a_g in m/s.2, got 250, which is 25.5 g in m/s.2, 250 g in g, 0.255 g in cm/s.2, 2.5 g",
        ),
        ("asce7", {"S_DS": 9.81}, 'expected S_DS and S_D1 in g, got 9.81, which is 1 g in m/s.2, .*give unit="m/s.2"'),
        ("asce7", {"S_D1": 60.0}, 'S_D1 in g, got 60, which .*, 0.6 g in % of g; give unit=.* or "%g"$'),
        ("nbcc", {"S_a": [8.3, 7.4, 4.1, 2.5, 0.8, 0.3]}, "S_a in g, got 8.3, which is 0.846 g in m/s.2, 8.3 g in g"),
        (
            "nbcc",
            {"S_a": S_A[:5]},
            r"expected S_a > 0 at the periods 0.2, 0.5, 1, 2, 5, 10 s, got \[0.85, .*; give six",
        ),
        ("nbcc", {"F": 0.0}, "expected F > 0 at the periods"),
        ("nbcc", {"unit": "kg"}, "expected unit as one of m/s.2, cm"),
        ("asce7", {"T_L": 0.5}, "expected T_L >= T_S = S_D1/S_DS = 0.6 s, got 0.5 s"),
    ],
)
def test_what_is_refused(code: str, change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ss.design_spectrum(code, **{"periods": T, **GIVEN.get(code, {}), **change})


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: ss.design_spectrum("ec8", T, a_g=2.5), ['"ec8", periods, a_g=2.5, ground="B"', "'ground'"]),
        (
            lambda: ss.design_spectrum("ec8", T, a_g=2.5, ground="A", S_DS=1.0),
            ["'S_DS'", "a_g, ground, type, xi, unit"],
        ),
        (lambda: ss.design_spectrum("asce7", T, S_DS=1.0, S_D1=0.6), ['"asce7", periods, S_DS=1.0', "'T_L'"]),
        (ss.design_spectrum, ['"ec8", periods', "'code'"]),
    ],
)
def test_a_call_that_does_not_fit_is_answered_with_one_that_does(call: Callable[[], Any], words: list[str]) -> None:
    with pytest.raises(TypeError, match=r"expected a call such as design_spectrum\(") as raised:
        call()
    assert all(word in str(raised.value) for word in words), raised.value
