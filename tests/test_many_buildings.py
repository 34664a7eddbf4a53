"""Sweeps over structures and over scales of records: every point is the march of that point."""

from typing import Any

import numpy as np
import pytest
from test_compiled_steps import DT, RECORD, STEEL, B, K, M

import substep as ss
from substep.sweeps import structure_plan, structure_points

T_END, SCALES = 1.0, [0.5, 2.0]
RECORDS = [RECORD, ss.Record(0.1, 3.0 * np.cos(np.arange(12)))]
MASSES, STRENGTHS = [M, 1.2 * M, 0.8 * M], [[4.0, 3.0, 2.0], [3.0, 3.0, 1.5], [8.0, 1.0, 2.0]]


def buildings(**options: Any) -> list[ss.Structure]:
    damper = B[:1], ss.law("power_damper", c=0.3, exponent=0.5)
    return [
        ss.structure(np.diag(m), springs=[(B, ss.law("bilinear", k=K, q_y=q, alpha=0.03)), damper], **options)
        for m, q in zip(MASSES, STRENGTHS, strict=True)
    ]


@pytest.fixture
def apart(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Points go side by side, however few their steps are, and some of these at a time; here are those that do not."""
    monkeypatch.setattr(structure_points, "WORTH", 0.0)
    monkeypatch.setattr(structure_points, "ROWS", 37)
    marched, found = structure_points.marched, list[Any]()

    def seen(run: Any, *given: Any) -> Any:
        found.append(run)
        return marched(run, *given)

    for module in (structure_plan, structure_points):
        monkeypatch.setattr(module, "marched", seen)
    return found


def scaled(s: ss.Structure, record: ss.Record, scale: float) -> ss.Structure:
    return s.ground_motion(ss.Record(record.dt, scale * record.samples), 1.0)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("scheme", "own_solver", "t_end"),
    [
        ("average_acceleration", False, 1.0), ("bathe", False, 1.0), ("central_difference", False, 0.3),
        ("houbolt", False, 1.0), ("rk4", True, 0.2),
    ],
)  # fmt: skip
def test_every_point_is_its_march(scheme: str, own_solver: bool, t_end: float, apart: list[Any]) -> None:
    """By the kernel, side by side, with steps of a starter before it, and with a solver of the user's, step by step."""
    of = buildings(**({"solver": lambda A: lambda b: np.linalg.solve(A, b)} if own_solver else {}))
    options: dict[str, Any] = {"dt": DT, "t_end": t_end}
    axes: dict[str, Any] = {"ground": RECORDS, "direction": 1.0, "scale": SCALES, "dofs": [2, 0]}
    found = {keep: ss.sweep(of, scheme, **options, **axes, keep=keep) for keep in ("final", "peak", "history")}
    assert len(apart) == (36 if own_solver or scheme == "houbolt" else 0)
    assert found["peak"].peak_force.dims == ("structure", "case", "scale", "spring")
    assert found["peak"].scale.values.tolist() == SCALES
    for i, j, k in np.ndindex(3, 2, 2):
        r = ss.march(scaled(of[i], RECORDS[j], SCALES[k]), scheme, **options, dofs=[2, 0], account=False)
        at = {"structure": i, "case": j, "scale": k}
        for name, history in (("u", r.u), ("elongation", r.springs.elongations), ("force", r.springs.forces)):
            assert np.array_equal(found["history"][name][at], history), name
            assert np.array_equal(found["final"][name][at], history[-1]), name
            assert np.array_equal(found["peak"]["peak_" + name][at], np.abs(history).max(axis=0)), name
        assert np.array_equal(found["peak"].elongation[at], r.springs.elongations[-1])
    for ds in found.values():
        assert (ds.status == 0).all()


@pytest.mark.thorough
def test_threads_change_nothing() -> None:
    call: dict[str, Any] = {"dt": [DT, 0.5 * DT], "t_end": T_END, "ground": RECORDS, "direction": 1.0, "keep": "peak"}
    one, two = (ss.sweep(buildings(), "bathe", **call, workers=n) for n in (1, 2))
    assert one.identical(two)
    assert two.sizes["dt"] == 2


def test_dampings_of_many_structures_and_scales_of_linear_ones() -> None:
    linear = [ss.structure(np.diag(m), B.T @ np.diag(K) @ B, C=np.eye(3)) for m in MASSES]
    call: dict[str, Any] = {"dt": DT, "t_end": T_END, "ground": RECORDS, "direction": 1.0}
    found = ss.sweep(linear, "bathe", **call, C=[None, 0.5 * np.eye(3)], scale=SCALES)
    assert found.u.dims == ("structure", "damping", "case", "scale", "dof")
    assert np.allclose(found.u.sel(scale=2.0), 4.0 * found.u.sel(scale=0.5), rtol=1e-12, atol=0)
    larger = ss.sweep(linear, "bathe", **call, scale=[0.5, 1e4])  # a record that is scaled is in m/s^2, however large
    assert np.allclose(larger.u.sel(scale=1e4), 2e4 * larger.u.sel(scale=0.5), rtol=1e-12, atol=0)
    undamped = ss.structure(np.diag(M), B.T @ np.diag(K) @ B).ground_motion(RECORD, 1.0)
    r = ss.march(undamped, "bathe", DT, T_END, account=False)
    assert np.allclose(found.u[0, 0, 0, 0], 0.5 * r.u[-1], rtol=0, atol=1e-13)


@pytest.mark.parametrize("points", [2, pytest.param(7, marks=pytest.mark.thorough)])
def test_how_points_ended(points: int, apart: list[Any]) -> None:
    """A structure that overflows beside others that do not, in one chunk, one after another and side by side."""
    factors = np.array([1.0, 1e8, 1.1, 1.2, 0.9, 1e8, 0.8])[:points]
    stiff = [ss.structure(np.diag(M), springs=[(B, ss.law("linear", k=x * K))], v0=1.0) for x in factors]
    found, ended = ss.sweep(stiff, "central_difference", dt=0.05, t_end=3.0, keep="peak"), factors > 2.0
    assert len(apart) == 2
    assert np.array_equal(found.status, np.where(ended, 2, 0))
    assert np.isfinite(found.peak_u[~ended]).all()
    assert np.isnan(found.elongation[ended]).any(axis=1).all()
    for k in np.flatnonzero(~ended):
        r = ss.march(stiff[k], "central_difference", dt=0.05, t_end=3.0, account=False)
        assert np.array_equal(found.peak_u[k], np.abs(r.u).max(axis=0))


def test_what_is_not_alike_is_marched_apart(apart: list[Any]) -> None:
    """Points whose steps, springs' rows or parts of the force differ, among others."""
    column, law = 0.1 * B.T @ np.diag(K) @ B, ss.law("bilinear", k=K, q_y=STRENGTHS[0], alpha=0.03)
    every = [ss.structure(np.diag(M), K, springs=[(x * B, law)], v0=1.0) for K in (None, column) for x in (1.0, 1.1)]
    found = ss.sweep(every, "bathe", dt=[DT, 0.5 * DT], t_end=0.5, keep="peak")
    for i, j in np.ndindex(2, 4):
        r = ss.march(every[j], "bathe", (DT, 0.5 * DT)[i], 0.5, account=False)
        assert np.array_equal(found.peak_u[i, j], np.abs(r.u).max(axis=0))


@pytest.mark.parametrize("C", [None, np.array([[0.1, 0.3, 0.0], [-0.3, 0.1, 0.0], [0.0, 0.0, 0.1]])])
def test_lanes_whose_matrices_are_not_positive_definite(C: np.ndarray | None, apart: list[Any]) -> None:
    """Some of them, of which weight takes more than yielding springs give; and matrices that are not symmetric."""
    weight, steel = -B.T @ np.diag(K) @ B, [ss.law("bilinear", k=K, q_y=q, alpha=0.2) for q in ([9.0] * 3, [0.5] * 3)]
    every = [
        ss.structure(np.diag(M), x * weight, C=C, springs=[(B, law)], v0=1.0) for x in (0.0, 0.5) for law in steel * 2
    ]
    found = ss.sweep(every, "average_acceleration", dt=0.4, t_end=4.0, keep="peak")
    assert not apart
    for k, s in enumerate(every):
        r = ss.march(s, "average_acceleration", 0.4, 4.0, account=False)
        assert np.array_equal(found.peak_u[k], np.abs(r.u).max(axis=0)), k


@pytest.mark.parametrize(
    ("of", "axes", "why"),
    [
        ([], {}, "as many springs, got none"),
        ([ss.shear_building(M, STEEL), ss.shear_building(M[:2], ss.law("linear", k=K[:2]))], {}, "got others"),
        ([ss.shear_building(M, STEEL), 3.0], {}, "got others"),
        ([ss.shear_building(M, STEEL)], {"scale": [1.0, 2.0]}, "scale as a row of factors .* got no ground"),
        (
            ss.shear_building(M, STEEL),
            {"scale": [[1.0]], "ground": RECORDS, "direction": 1.0},
            r"scale as a row .* shape \(1, 1\)",
        ),
        (ss.shear_building(M, STEEL), {"scale": [], "ground": RECORDS, "direction": 1.0}, "at least one value"),
        (ss.shear_building(M, STEEL), {"scale": [np.nan], "ground": RECORDS, "direction": 1.0}, "scale"),
    ],
)
def test_what_does_not_fit_is_refused(of: Any, axes: dict[str, Any], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        ss.sweep(of, "bathe", dt=DT, t_end=T_END, **axes)
