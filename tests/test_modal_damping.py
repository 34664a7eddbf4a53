"""Damping ratios of modes as a matrix of low rank: every scheme against the same full matrix, and what uses it."""

from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from dense_steps import march as dense_march
from plane_elements import cantilever, shear_building
from scipy import sparse
from scipy.sparse.linalg import LinearOperator
from sympy import Symbol
from test_structure_cases import LOADS
from test_structures import PULSE, STEPS, system

import substep as ss
from substep.structures.solvers.low_rank import LowRank
from substep.structures.structure import Modes

RATIOS = [0.05, 0.3, 0.0, 0.02, 0.1]


def make(C: Any, **more: Any) -> ss.Structure:
    s = system()
    return ss.structure(s["M"], s["K"], C=C, load=(s["p"], PULSE), u0=s["u"], v0=s["v"], **more)


def by_hand(ratios: list[float]) -> Any:
    """The full matrix, from LAPACK's modes by way of `Modes.damping_matrix`."""
    modes = make(None).modes(len(ratios))
    return modes.damped(ratios).damping_matrix()


def test_its_matrix_is_the_full_one() -> None:
    C = make(ss.modal_damping(RATIOS)).C
    assert isinstance(C, LowRank)
    assert C.B.shape == (8, 4)  # a mode without damping takes no room
    full = by_hand(RATIOS)
    assert np.abs(C.toarray() - full).max() < 1e-13 * np.abs(full).max()
    assert np.abs(make(ss.modal_damping(0.02, 5)).damping.toarray() - by_hand([0.02] * 5)).max() < 1e-13


@pytest.mark.parametrize("mass", ["full", "lumped"])
@pytest.mark.parametrize("scheme", BY_NAME.values(), ids=lambda s: s.name)
def test_every_scheme_marches_it_as_the_full_matrix(scheme: Any, mass: str) -> None:
    """u, h v, h^2 a to 1e-11 of the largest, against the scheme's own equations; a lumped mass needs no factors."""
    s, h = system(), 0.5 / 30.0
    M = s["M"] if mass == "full" else np.diag(np.diag(s["M"]))
    frame = ss.structure(M, s["K"], C=ss.modal_damping(RATIOS), load=(s["p"], PULSE), u0=s["u"], v0=s["v"])
    if not scheme.takes_damping:
        with pytest.raises(ValueError, match="without damping"):
            ss.march(frame, scheme.name, h, STEPS * h)
        return
    modes = ss.structure(M, s["K"]).modes(5)
    C = modes.damped(RATIOS).damping_matrix()
    handle = ss.scheme(scheme.name)
    values = {Symbol(name): float(x) for name, x in handle.parameters.items()}

    def load(t: float) -> Any:
        return s["p"] * PULSE(np.array([t]))[0]

    rows = dense_march(scheme, values, M, C, s["K"], load, h, STEPS, s["u"], s["v"])
    expected = np.array(rows) * np.array([1.0, h, h * h])[:, None]
    r = ss.march(frame, handle, h, STEPS * h, account=False)
    found = np.stack([r.u, h * r.v, h * h * r.a], axis=1)
    assert np.abs(found - expected).max() <= 1e-11 * np.abs(expected).max()


def test_the_account_of_energy_counts_it() -> None:
    """The average acceleration scheme keeps the balance exactly."""
    account = ss.march(make(ss.modal_damping(RATIOS)), "average_acceleration", 0.01, 1.0).account
    expected = ss.march(make(by_hand(RATIOS)), "average_acceleration", 0.01, 1.0).account
    assert account is not None
    assert expected is not None
    assert account.share <= 1e-12
    assert np.allclose(account.damped, expected.damped, rtol=1e-10, atol=0)


@pytest.mark.parametrize("scheme", ["newmark", "bathe", "houbolt", "kr_alpha", "noh_bathe", "rk4"])
def test_load_cases_and_dampings_are_swept(scheme: str) -> None:
    M, K = shear_building([2.0, 1.0, 3.0], [6.0, 4.0, 3.0])
    full = ss.structure(M, K).modes(2).damped([0.1, 0.2]).damping_matrix()
    frame = ss.structure(M, K, names=["first", "second", "roof"])
    found = ss.sweep(frame, scheme, dt=0.1, t_end=2.0, load=LOADS, C=[ss.modal_damping([0.1, 0.2]), full])
    assert found.u.dims == ("damping", "case", "dof")
    assert np.allclose(found.u[0], found.u[1], rtol=0, atol=1e-12 * abs(found.u).max())
    assert float(abs(found.u[0]).max()) > 0.1


@pytest.mark.parametrize("solver", ["pardiso", "superlu"])
def test_a_sparse_structure_factorizes_without_it(solver: Any) -> None:
    if solver == "pardiso":
        pytest.importorskip("pypardiso")
    M, K, fixed, corner = cantilever(40, 6)
    P = np.zeros(M.shape[0])
    P[corner] = 1.0
    given: dict[str, Any] = {"fixed": fixed, "load": (P, ss.HalfSine(1.0, 2.0)), "solver": solver}
    modes = ss.structure(M, K, **given).modes(12)
    assert modes.structure.size > 400
    frame = ss.structure(M, K, C=ss.modal_damping(0.05, modes), **given)
    full = ss.structure(M, K, C=modes.damped(0.05).damping_matrix(), **given)
    r, expected = (ss.march(x, "generalized_alpha", 0.05, 2.0, dofs=[corner]) for x in (frame, full))
    assert np.abs(r.u - expected.u).max() < 1e-10 * np.abs(expected.u).max()


@pytest.mark.usefixtures("plain_in_gate")
def test_modes_find_the_ratios_and_superposition_marches_them_one_by_one() -> None:
    storeys = shear_building([3.0, 2.0, 1.0, 1.0], [500.0, 400.0, 300.0, 200.0])
    for M, K, fixed in ((*storeys, []), cantilever(40, 6)[:3]):
        frame = ss.structure(M, K, C=ss.modal_damping([0.02, 0.05, 0.1]), fixed=fixed)
        modes = frame.modes(4)
        assert np.allclose(modes.xi, [0.02, 0.05, 0.1, 0.0], rtol=1e-9, atol=0)
        assert modes.lanes
    frame = ss.structure(*storeys, C=ss.modal_damping(0.05, 4), load=([0, 0, 0, 1.0], ss.HalfSine(1.0, 0.5)))
    direct, superposed = (ss.march(x, "bathe", 0.01, 1.0) for x in (frame, frame.modes(4)))
    assert np.abs(direct.u - superposed.u).max() < 1e-11 * np.abs(direct.u).max()
    chosen = ss.choose(frame, 1e-3, t_end=1.0, quantity=3, among=["bathe", "average_acceleration"])
    assert "damping couples" not in chosen.text
    assert chosen.best is not None


@pytest.mark.parametrize("scheme", ["bathe", "average_acceleration", "energy_momentum", "gholampour", "rk4"])
@pytest.mark.parametrize("matrix_free", [False, True], ids=["tangent", "operator"])
def test_a_nonlinear_structure_has_the_modes_of_its_tangent_at_the_start(scheme: str, matrix_free: bool) -> None:
    M, K = shear_building([2.0, 1.0, 3.0], [60.0, 40.0, 30.0])

    def tangent(u: Any) -> Any:
        A = K + np.diag(30.0 * u**2)
        return LinearOperator((3, 3), matvec=lambda x: A @ x, rmatvec=lambda x: A @ x) if matrix_free else A

    given: dict[str, Any] = {
        "internal_force": lambda u: K @ u + 10.0 * u**3,
        "potential": lambda u: 0.5 * u @ K @ u + 2.5 * np.sum(u**4),
        "v0": [1.0, 0.0, -1.0],
    }
    linear = ss.structure(M, K).modes(2)
    modal = ss.modal_damping([0.05, 0.1], linear) if matrix_free else ss.modal_damping([0.05, 0.1])
    full = linear.damped([0.05, 0.1]).damping_matrix()
    if matrix_free:
        full = LinearOperator((3, 3), matvec=lambda x, A=full: A @ x, rmatvec=lambda x, A=full: A @ x)
    found, expected = (
        ss.march(ss.structure(M, C=C, tangent=tangent, **given), scheme, 0.02, 0.4, account=False)
        for C in (modal, full)
    )  # fmt: skip
    assert np.abs(found.u - expected.u).max() < 1e-9 * np.abs(expected.u).max()


def test_a_march_on_disk_knows_it(tmp_path: Any) -> None:
    r = ss.march(make(ss.modal_damping(RATIOS)), "bathe", 0.01, 0.2, save=tmp_path / "run")
    again = ss.march(make(ss.modal_damping(RATIOS)), "bathe", 0.01, 0.2, save=tmp_path / "run")
    assert np.array_equal(r.u, again.u)
    with pytest.raises(ValueError, match="another path"):
        ss.march(make(ss.modal_damping(0.01, 5)), "bathe", 0.01, 0.2, save=tmp_path / "run")


def test_constraints_free_bodies_and_critical_steps() -> None:
    """Rigid modes are not damped; the largest mode's ratio is that of the critical step."""
    body = ss.structure(
        np.eye(3), [[5.0, -5.0, 0.0], [-5.0, 10.0, -5.0], [0.0, -5.0, 5.0]], C=ss.modal_damping(0.1, 3), v0=1.0
    )
    r = ss.march(body, "bathe", 0.05, 5.0)
    assert np.allclose(r.v, 1.0, rtol=0, atol=1e-12)
    assert body.damping.B.shape == (3, 2)
    assert body.critical_step("central_difference_lagged").xi == pytest.approx(0.1, rel=1e-10)
    tied = ss.structure(
        np.diag([2.0, 3.0]), np.diag([40.0, 5.0]), constraints=[[1.0], [1.0]], C=ss.modal_damping([0.2])
    )
    assert np.allclose(tied.damping.toarray(), [[2.0 * 0.2 * 3.0 * 5.0]])
    with pytest.raises(ValueError, match="Rayleigh damping, or none, with bound=True"):
        body.critical_step("central_difference", bound=True)


def test_what_does_not_fit_is_refused() -> None:
    M, K = shear_building([1.0, 1.0, 1.0], [9.0, 4.0, 2.0])
    modes = ss.structure(M, K).modes(2)
    for arguments, message in (
        ((0.05,), r"got xi of shape \(\) and modes = None"),
        (([0.05, 0.02], 3), "as many ratios as modes"),
        (([0.05, 0.02, 0.1], modes), "as many ratios as modes"),
        ((-0.05, 2), "xi >= 0"),
        ((0.05, 0), "as many ratios as modes"),
        ((0.05, True), "as many ratios as modes"),
        (([[0.05, 0.02]],), "as many ratios as modes"),
    ):
        with pytest.raises(ValueError, match=message):
            ss.modal_damping(*arguments)
    with pytest.raises(ValueError, match="from 1 to 3 modes, .* got 4"):
        ss.structure(M, K, C=ss.modal_damping(0.05, 4))
    for other in (np.diag([1.0, 1.0, 2.0]), np.eye(4)):
        with pytest.raises(ValueError, match="modes of this structure"):
            ss.structure(other, np.eye(len(other)), C=ss.modal_damping(0.05, modes))
    assert isinstance(modes, Modes)
    sparse_frame = ss.structure(sparse.csr_array(M), sparse.csr_array(K), C=ss.modal_damping(0.05, modes))
    assert np.allclose(sparse_frame.modes(2).xi, 0.05)
