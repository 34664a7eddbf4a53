"""Sweeps of structures: every point is the march of that point, and load cases are one block."""

from typing import Any

import numpy as np
import pytest
from test_structure_input import RECORD, K, M, frame

import substep as ss

LOADS = [([1.0, 0.0, 0.0], ss.Step(1.0)), [([0.0, 0.0, 1.0], ss.Harmonic(2.0, 1.5)), ([0.0, 1.0, 0.0], RECORD)], ()]


@pytest.mark.parametrize("scheme", ["newmark", "bathe", "houbolt", "kr_alpha", "central_difference_lagged", "rk4"])
def test_load_cases_are_marched_at_once(scheme: str) -> None:
    found = ss.sweep(frame(), scheme, dt=0.1, t_end=2.0, load=LOADS, keep="history", dofs=["roof", "first"])
    for case, load in enumerate(LOADS):
        r = ss.march(frame(load=load), scheme, 0.1, 2.0, dofs=["roof", "first"], account=False)
        for name in ("u", "v", "a") if "a" in found else ("u", "v"):
            assert np.allclose(found[name][case], getattr(r, name), rtol=0, atol=1e-11), name
    assert found.u.dims == ("case", "t", "dof")


def test_one_factorization_serves_all_load_cases() -> None:
    made = []

    def solver(matrix: Any) -> Any:
        made.append(matrix)
        return lambda b: np.linalg.solve(matrix, b)

    ss.sweep(frame(solver=solver, a0=0.0), "newmark", dt=0.1, t_end=2.0, load=LOADS)
    assert len(made) == 1


def test_a_damping_that_the_scheme_does_not_take_is_refused_before_anything_is_marched() -> None:
    with pytest.raises(ValueError, match="rkn43 is a scheme .* without damping"):
        ss.sweep(frame(), "rkn43", dt=0.1, t_end=1.0, C=[None, 0.1 * np.eye(3)])


def test_axes_of_step_scheme_and_damping() -> None:
    dampings = [None, ss.Rayleigh(0.1, 0.01), 0.1 * np.eye(3)]
    found = ss.sweep(
        frame(), "generalized_alpha", dt=[0.1, 0.05], t_end=1.0, rho_inf=[0.0, 0.5, 1.0], C=dampings, keep="peak"
    )
    assert found.peak_u.dims == ("dt", "rho_inf", "damping", "dof")
    assert found.sizes == {"dt": 2, "rho_inf": 3, "damping": 3, "dof": 3}
    for i, j, k in np.ndindex(2, 3, 3):
        scheme = ss.scheme("generalized_alpha", rho_inf=[0.0, 0.5, 1.0][j])
        r = ss.march(frame(C=dampings[k]), scheme, [0.1, 0.05][i], 1.0, account=False)
        assert np.allclose(found.peak_a[i, j, k], np.abs(r.a).max(axis=0), rtol=1e-12, atol=0)


def test_ground_motions_are_cases() -> None:
    records = [RECORD, ss.Record(0.2, np.cos(np.arange(20)))]
    found = ss.sweep(frame(u0=0.0), "bathe", dt=0.1, t_end=2.0, ground=records, direction=np.ones(3))
    for case, record in enumerate(records):
        r = ss.march(frame(u0=0.0).ground_motion(record, np.ones(3)), "bathe", 0.1, 2.0, account=False)
        assert np.allclose(found.u[case], r.u[-1], rtol=0, atol=1e-14)


def test_a_nonlinear_structure_has_cases_too() -> None:
    spring = ss.structure(M, internal_force=lambda u: K @ u + u**3, tangent=lambda u: K + np.diag(3 * u**2))
    found = ss.sweep(spring, "bathe", dt=0.1, t_end=1.0, load=LOADS)
    for case, load in enumerate(LOADS):
        loaded = ss.structure(
            M, internal_force=lambda u: K @ u + u**3, tangent=lambda u: K + np.diag(3 * u**2), load=load
        )
        assert np.allclose(found.u[case], ss.march(loaded, "bathe", 0.1, 1.0).u[-1], rtol=0, atol=1e-13)


def test_what_does_not_fit_is_refused() -> None:
    for arguments, message in (
        ({"load": LOADS, "ground": [RECORD]}, "got both"),
        ({"ground": [RECORD]}, "direction"),
        ({"keep": "all"}, "did you mean|one of: final"),
        ({"dt": [0.1, 0.2], "keep": "history"}, "one dt"),
        ({"dt": None}, "expected dt"),
        ({"dt": None, "tol": 1e-3}, "expected dt"),
        ({"rho_inf": [0.5, 1.5]}, "rho_inf"),
        ({"rho_inf": [[0.5, 0.8]]}, r"rho_inf to be a number or a row of them, got shape \(1, 2\)"),
        ({"dt": [[0.1], [0.05]]}, r"dt to be a number or a row of them, got shape \(2, 1\)"),
        ({"dt": []}, "at least one value on each axis"),
        ({"load": []}, "at least one value on each axis"),
        ({"scheme": ss.scheme("generalized_alpha", rho_inf=[0.5, 0.8])}, "got an array; give it as an axis"),
        ({"load": [([1.0], ss.Step(1.0))]}, "3 components"),
    ):
        with pytest.raises(ValueError, match=message):
            ss.sweep(frame(), **{"scheme": "generalized_alpha", "dt": 0.1, "t_end": 1.0, **arguments})
