"""Modes of structures against closed forms, eigensolvers against each other, damping, participation, errors."""

from typing import Any

import numpy as np
import pytest
from plane_elements import cantilever, shear_building
from scipy import linalg, sparse
from scipy.sparse.linalg import splu

import substep as ss
from substep.structures.modes import eigen


def plane(**more: Any) -> ss.Structure:
    M, K, fixed, _ = cantilever(10, 3)
    return ss.structure(M, K, fixed=fixed, **more)


def test_a_uniform_shear_building_has_the_frequencies_of_its_closed_form() -> None:
    """2 sqrt(k/m) sin((2i - 1) pi/(4n + 2)), Clough & Penzien's uniform shear building."""
    n, k, m = 30, 7e4, 3.0
    found = ss.structure(*shear_building([m] * n, [k] * n)).modes(n)
    exact = 2.0 * np.sqrt(k / m) * np.sin((2.0 * np.arange(1, n + 1) - 1.0) * np.pi / (4.0 * n + 2.0))
    assert np.allclose(found.omega, exact, rtol=1e-12)
    assert np.allclose(found.periods, 2.0 * np.pi / exact, rtol=1e-12)
    assert np.abs(m * found.shapes.T @ found.shapes - np.eye(n)).max() < 1e-12
    assert (found.shapes.max(axis=0) >= -found.shapes.min(axis=0)).all()


def test_two_storeys_by_hand() -> None:
    """Masses 2m, m on stiffnesses 2k, k: omega^2 = k/(2m), 2k/m; Gamma^2 = 8m/3, m/3 (Chopra, Dynamics, ch. 10, 13)."""
    m, k = 5.0, 300.0
    found = ss.structure(*shear_building([2 * m, m], [2 * k, k]), names=["first", "roof"]).modes(2)
    assert np.allclose(found.omega**2, [k / (2 * m), 2 * k / m], rtol=1e-13)
    assert np.allclose(found.shapes[0] / found.shapes[1], [0.5, -1.0], rtol=1e-13)
    p = found.participation(1.0)
    assert np.allclose(p.effective_mass, [8 * m / 3, m / 3], rtol=1e-12)
    assert p.total == 3 * m
    assert np.allclose(p.share, [8 / 9, 1 / 9], rtol=1e-12)
    assert np.allclose(p.factors, found.participation(["first", "roof"]).factors)


def test_all_effective_masses_sum_up_to_the_mass_that_moves() -> None:
    frame = plane()
    up = np.tile([0.0, 1.0], frame.T.shape[0] // 2)
    p = frame.modes(frame.size).participation(up)
    moved = frame.T.T @ (frame.full_mass @ up)
    assert np.isclose(p.effective_mass.sum(), moved @ linalg.solve(frame.M.toarray(), moved), rtol=1e-10)
    assert 0.9 < p.share.sum() < 1.0 + 1e-12


@pytest.mark.parametrize("supports", ["clamped", "free"])
@pytest.mark.parametrize("solver", [lambda A: splu(A.tocsc()).solve, "auto"], ids=["own", "auto"])
def test_lanczos_finds_the_modes_that_lapack_finds(supports: str, solver: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    M, K, fixed, _ = cantilever(10, 3)
    frame = ss.structure(M, K, fixed=fixed if supports == "clamped" else (), solver=solver)
    dense = frame.modes(9)
    monkeypatch.setattr(eigen, "DENSE", 10)
    found = frame.modes(9)
    rigid = 0 if supports == "clamped" else 3
    assert found.rigid == dense.rigid == rigid
    assert (found.omega[:rigid] == 0.0).all()
    assert np.allclose(found.omega, dense.omega, rtol=1e-10)
    assert np.abs(found.shapes[:, rigid:] - dense.shapes[:, rigid:]).max() < 1e-8 * np.abs(dense.shapes).max()
    assert np.abs(found.free_shapes.T @ (frame.M @ found.free_shapes) - np.eye(9)).max() < 1e-10


def twins(**more: Any) -> ss.Structure:
    """Two cantilevers that do not touch: every mode twice."""
    M, K, fixed, _ = cantilever(10, 3)
    pair = (sparse.block_diag([A, A], format="csr") for A in (M, K))
    return ss.structure(*pair, fixed=[*fixed, *(x + M.shape[0] for x in fixed)], **more)


@pytest.mark.parametrize("missing", [1, 2])
def test_a_mode_that_lanczos_misses_is_counted_and_found(missing: int, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pypardiso")
    monkeypatch.setattr(eigen, "DENSE", 10)
    exact, asked = twins().modes(9), []
    from scipy.sparse import linalg as found

    whole = found.eigsh

    def misses(K: Any, n: int, **more: Any) -> Any:
        asked.append(n)
        values, shapes = whole(K, n + 2, **more)
        order = np.argsort(values)
        left = [*order[: 2 * missing : 2], *order[2 * missing :]][:n] if len(asked) <= limit else order[:n]
        return values[left], shapes[:, left]

    monkeypatch.setattr(found, "eigsh", misses)
    limit = 1
    again = twins().modes(9)
    assert len(asked) == 2
    assert asked[1] > asked[0]
    assert np.allclose(again.omega, exact.omega, rtol=1e-10)
    assert np.allclose(again.omega[0:8:2], again.omega[1:8:2], rtol=1e-10)
    limit, asked = 1000, []
    with pytest.raises(ValueError, match=f"got {missing} fewer than the factors .* count"):
        twins().modes(9)
    asked = []
    blind = twins(solver="superlu").modes(9)  # which does not tell its pivots
    assert len(asked) == 1
    assert not np.allclose(blind.omega, exact.omega, rtol=1e-3)


def test_rigid_modes_alone_are_not_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(eigen, "DENSE", 10)
    M, K, _, _ = cantilever(10, 3)
    assert ss.structure(M, K).modes(3).rigid == 3
    assert ss.structure(M, K).modes(4).rigid == 3


def test_degrees_of_freedom_without_mass_follow_statically(monkeypatch: pytest.MonkeyPatch) -> None:
    M, K, fixed, _ = cantilever(10, 3)
    lumped = np.asarray(M.sum(axis=1)).ravel()
    lumped[1::3] = 0.0
    frame = ss.structure(sparse.diags_array(lumped).tocsr(), K, fixed=fixed)
    s, full = frame.massless, frame.K.toarray()
    assert len(s) > 20
    m = np.setdiff1d(np.arange(frame.size), s)
    condensed = full[np.ix_(m, m)] - full[np.ix_(m, s)] @ linalg.solve(full[np.ix_(s, s)], full[np.ix_(s, m)])
    exact = np.sqrt(linalg.eigvalsh(condensed, np.diag(frame.M.diagonal()[m])))
    for smallest in (eigen.DENSE, 10):
        monkeypatch.setattr(eigen, "DENSE", smallest)
        found = frame.modes(6)
        assert np.allclose(found.omega, exact[:6], rtol=1e-9)
        assert np.abs((frame.K @ found.free_shapes)[s]).max() < 1e-9 * np.abs(frame.K @ found.free_shapes).max()
    with pytest.raises(ValueError, match=f"from 1 to {len(m)} modes.*got {len(m) + 1}"):
        frame.modes(len(m) + 1)


def test_constraints_hold_in_every_shape() -> None:
    """A rigid floor: two columns' heads move together, so that the frame is an oscillator of both stiffnesses."""
    T = np.array([[1.0], [1.0]])
    found = ss.structure(np.diag([2.0, 3.0]), np.diag([40.0, 5.0]), constraints=T).modes(1)
    assert np.allclose(found.omega, [3.0])
    assert np.allclose(found.shapes, T / np.sqrt(5.0))


def test_damping_ratios() -> None:
    rayleigh = ss.rayleigh(0.02, 0.03, at=(5.0, 40.0))
    frame = plane(C=rayleigh)
    found = frame.modes(6)
    assert np.allclose(found.xi, [rayleigh.ratio(w) for w in found.omega], rtol=1e-12)
    assert found.classical
    given = plane_full(frame.damping).modes(6)
    assert np.allclose(given.xi, found.xi, rtol=1e-8)


def plane_full(C: Any) -> ss.Structure:
    """The cantilever's free degrees of freedom as a structure of their own, with a damping matrix."""
    free = plane()
    return ss.structure(free.M, free.K, C=C)


def test_whether_damping_couples_the_modes() -> None:
    free = plane()
    K_M = free.K.toarray() @ linalg.inv(free.M.toarray())
    caughey = 0.05 * free.M + 1e-4 * free.K + 1e-9 * K_M @ free.K
    assert plane_full(caughey).modes(5).classical
    dashpot = np.zeros((free.size,) * 2)
    dashpot[-1, -1] = 3.0
    coupled = plane_full(dashpot).modes(5)
    assert not coupled.classical
    assert coupled.coupling > 0.1
    assert np.allclose(coupled.xi, 1.5 * coupled.shapes[-1] ** 2 / coupled.omega, rtol=1e-10)
    assert plane_full(None).modes(5).xi.tolist() == [0.0] * 5


def test_damping_ratios_of_ones_own_and_their_matrix() -> None:
    M, K = shear_building([3.0, 2.0, 1.0], [500.0, 400.0, 300.0])
    found = ss.structure(M, K).modes(3)
    ratios = np.array([0.02, 0.05, 0.1])
    damped = found.damped(ratios)
    assert np.allclose(damped.xi, ratios, rtol=1e-14)
    again = ss.structure(M, K, C=damped.damping_matrix()).modes(3)
    assert again.classical
    assert np.allclose(again.xi, ratios, rtol=1e-12)
    with pytest.raises(ValueError, match="xi >= 0, got -0.1"):
        found.damped(-0.1)
    with pytest.raises(ValueError, match=r"one number or 3, .* got shape \(2,\)"):
        found.damped([0.1, 0.2])


def test_what_has_no_modes_is_refused_by_name() -> None:
    M, K = shear_building([1.0, 1.0], [9.0, 4.0])
    unsymmetric = K.copy()
    unsymmetric[0, 1] *= 1.1
    with pytest.raises(ValueError, match="symmetric K for modes"):
        ss.structure(M, unsymmetric).modes(1)
    with pytest.raises(ValueError, match="symmetric M for modes"):
        ss.structure([[1.0, 0.1], [0.0, 1.0]], K).modes(1)
    with pytest.raises(ValueError, match="positive semidefinite K, got a mode with omega.2 = -1"):
        ss.structure(M, np.diag([-1.0, 4.0])).modes(2)
    with pytest.raises(ValueError, match="positive definite M"):
        ss.structure([[1.0, 1.0], [1.0, 1.0]], K).modes(1)
    modes = ss.structure(M, K).modes(2)
    for n in (0, 3, 1.5, True):
        with pytest.raises(ValueError, match="from 1 to 2 modes"):
            ss.structure(M, K).modes(n)
        with pytest.raises(ValueError, match=f"from 1 to 2 modes, got {n}"):
            modes.first(n)
