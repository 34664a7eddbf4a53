"""Response spectrum analysis: two storeys by hand, the single oscillator, the time history, and wrong input."""

from typing import Any

import numpy as np
import pytest
from plane_elements import shear_building
from scipy.linalg import solve_continuous_lyapunov
from scipy.signal import StateSpace, lsim

import substep as ss
from substep.ground_motion.modal_combination import cqc_correlation
from substep.ground_motion.peaks import refined

m, k = 2.0, 800.0


def two_storeys(xi: float = 0.05) -> ss.Modes:
    """Masses 2m, m on stiffnesses 2k, k: omega^2 = k/(2m) and 2k/m, shapes (1/2, 1) and (-1, 1)."""
    return ss.structure(*shear_building([2 * m, m], [2 * k, k]), names=["first", "roof"]).modes(2).damped(xi)


def flat(period: Any, xi: Any) -> Any:
    """A code's plateau, 3 m/s^2, that falls as 1/T beyond 0.4 s."""
    return 3.0 * np.minimum(1.0, 0.4 / period)


def test_two_storeys_by_hand() -> None:
    """Gamma phi = (2/3, 4/3) and (1/3, -1/3); D = A/omega^2; base shears 8m/3 A_1 and m/3 A_2 (Chopra, 13.2, 13.8)."""
    T = 2 * np.pi / np.sqrt([k / (2 * m), 2 * k / m])
    A = flat(T, 0.05)
    assert T[0] > 0.4 > T[1]
    D = A / np.array([k / (2 * m), 2 * k / m])
    first, roof = np.array([2 / 3, 1 / 3]) * D, np.array([4 / 3, -1 / 3]) * D
    found = ss.response_spectrum_analysis(two_storeys(), flat, 1.0, combine="srss")
    assert np.allclose(found.modal_u, np.stack([first, roof], axis=1), rtol=1e-12)
    assert np.allclose(found.u, [np.hypot(*first), np.hypot(*roof)], rtol=1e-12)
    assert np.isclose(found.shear, np.hypot(8 * m / 3 * A[0], m / 3 * A[1]), rtol=1e-12)
    drift = roof - first
    assert np.isclose(found.combined(found.modal_u[:, 1] - found.modal_u[:, 0]), np.hypot(*drift), rtol=1e-12)
    # CQC with omega_2 = 2 omega_1 and equal ratios: rho = 8 xi^2 (1 + r) r^1.5/((1 - r^2)^2 + 4 xi^2 r (1 + r)^2)
    rho = 8 * 0.05**2 * 3 * 2**1.5 / (9 + 4 * 0.05**2 * 2 * 9)
    cqc = ss.response_spectrum_analysis(two_storeys(), flat, 1.0, combine="cqc", dofs=["roof"])
    assert np.isclose(cqc.correlation[0, 1], rho, rtol=1e-12)
    assert np.isclose(cqc.u[0], np.sqrt(roof[0] ** 2 + roof[1] ** 2 + 2 * rho * roof[0] * roof[1]), rtol=1e-12)
    assert np.isclose(cqc.a[0] ** 2, (A * [4 / 3, -1 / 3]) @ cqc.correlation @ (A * [4 / 3, -1 / 3]), rtol=1e-12)


def test_correlation_tends_to_one_for_equal_modes_and_is_symmetric() -> None:
    omega, xi = np.array([3.0, 3.0, 3.3, 9.0]), np.array([0.02, 0.02, 0.05, 0.1])
    found = cqc_correlation(omega, xi)
    assert np.allclose(found, found.T, rtol=1e-13)
    assert np.allclose(np.diag(found), 1.0)
    assert np.isclose(found[0, 1], 1.0)
    assert 0.3 < found[1, 2] < 0.9
    assert found[0, 3] < 0.05
    assert np.linalg.eigvalsh(found).min() > -1e-12
    assert cqc_correlation(omega[1:], np.zeros(3)).tolist() == np.eye(3).tolist()


def test_correlation_is_that_of_oscillators_under_white_noise() -> None:
    """The covariance of displacements from Lyapunov's equation, of modes with different damping ratios."""
    omega, xi = np.array([3.0, 3.6, 8.0]), np.array([0.02, 0.08, 0.15])
    A = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.diag(omega**2), -np.diag(2 * xi * omega)]])
    b = np.concatenate([np.zeros(3), np.ones(3)])
    covariance = solve_continuous_lyapunov(A, -np.outer(b, b))[:3, :3]
    deviation = np.sqrt(np.diag(covariance))
    assert np.allclose(cqc_correlation(omega, xi), covariance / np.outer(deviation, deviation), rtol=1e-10)


def quake() -> ss.Record:
    rng = np.random.default_rng(1)
    t = np.arange(0.0, 30.0, 0.01)
    noise = np.convolve(rng.normal(size=len(t)), np.hanning(9) / 4, mode="same")
    samples = 4.0 * noise * (t / 3) ** 2 * np.exp(2 - 2 * t / 3)
    samples[0] = 0.0
    return ss.Record(0.01, samples)


def test_one_mode_is_the_peak_of_its_history() -> None:
    frame = ss.structure([[2.0]], [[300.0]])
    modes = frame.modes(1).damped(0.03)
    found = ss.response_spectrum_analysis(modes, quake(), 1.0)
    ground = frame.ground_motion(quake(), 1.0).modes(1).damped(0.03)
    r = ss.march(ground, "average_acceleration", dt=0.01, t_end=29.99)
    assert np.isclose(found.u[0], np.abs(r.u).max(), rtol=1e-10)
    assert np.isclose(found.a[0], np.abs(300.0 / 2.0 * r.u).max(), rtol=1e-10)
    assert np.isclose(found.shear, 300.0 * np.abs(r.u).max(), rtol=1e-10)


def test_beside_the_time_history() -> None:
    """The history's peaks are those of direct steps, the others those of the analyses; CQC is within a fifth."""
    M, K = shear_building(np.full(10, 1.0), np.full(10, 1500.0))
    frame = ss.structure(M, K, load=(np.ones(10), ss.Step(5.0)), u0=0.1, a0=1.0)
    modes = frame.modes(10).damped(0.05)
    found = ss.spectrum_beside_history(modes, quake(), 1.0, dofs=[9, 0])
    bare = ss.structure(M, K, C=ss.modal_damping(0.05, 10)).ground_motion(quake(), 1.0)
    r = ss.march(bare, "average_acceleration", dt=0.01, t_end=29.99, account=False)
    assert np.allclose(found.u.sel(way="history"), np.abs(r.u).max(axis=0)[[9, 0]], rtol=1e-9)
    assert np.allclose(found.a.sel(way="history"), np.abs(r.absolute_a).max(axis=0)[[9, 0]], rtol=1e-9)
    base = np.abs((r.u @ K).sum(axis=1))  # what springs take to the base
    assert np.isclose(found["shear"].sel(way="history"), base.max(), rtol=1e-9)
    for rule in ("srss", "cqc"):
        own = ss.response_spectrum_analysis(modes, quake(), 1.0, combine=rule, dofs=[9, 0])
        for name in ("u", "a", "shear"):
            one = found.sel(way=rule)
            assert np.allclose(one[name], getattr(own, name), rtol=1e-12)
            assert np.allclose(one[f"{name}_difference"], one[name] / found[name].sel(way="history") - 1.0, rtol=1e-9)
    assert np.abs(found.u_difference.sel(way="cqc")).max() < 0.2
    assert (found.u_difference.sel(way="history") == 0.0).all()
    assert (own.u <= np.abs(own.modal_u).sum(axis=0)).all()


def test_one_mode_differs_from_its_history_by_nothing() -> None:
    modes = ss.structure([[2.0]], [[300.0]], names=["roof"]).modes(1).damped(0.03)
    found = ss.spectrum_beside_history(modes, quake().samples, 1.0, dt=0.01)
    assert found.dof.values.tolist() == ["roof"]
    assert np.abs(found.u_difference).max() < 1e-10
    assert np.abs(found.shear_difference).max() < 1e-10
    with pytest.raises(ValueError, match="expected dt of the record"):
        ss.spectrum_beside_history(modes, quake().samples, 1.0)


def test_a_spectrum_that_was_computed_before_is_interpolated() -> None:
    modes = two_storeys(0.05)
    own = ss.response_spectrum_analysis(modes, quake(), 1.0)
    at_periods = ss.response_spectrum(quake(), periods=modes.periods, xi=0.05)
    assert np.allclose(ss.response_spectrum_analysis(modes, at_periods, 1.0).u, own.u, rtol=1e-12)
    with_ground = ss.response_spectrum(quake(), periods=[0.0, *modes.periods, 0.0], xi=0.05)
    assert np.allclose(ss.response_spectrum_analysis(modes, with_ground, 1.0).u, own.u, rtol=1e-12)
    fine = ss.response_spectrum(quake(), periods=np.geomspace(0.05, 2.0, 2000), xi=0.05)
    assert np.allclose(ss.response_spectrum_analysis(modes, fine, 1.0).u, own.u, rtol=1e-2)


def test_what_cannot_be_combined_is_refused_by_name() -> None:
    modes, S = two_storeys(), ss.response_spectrum(quake(), periods=[0.1, 0.2], xi=0.05)
    analyse = ss.response_spectrum_analysis
    with pytest.raises(ValueError, match="a rule of combination, one of: srss, cqc; got 'sum'"):
        analyse(modes, flat, 1.0, combine="sum")  # pyright: ignore
    with pytest.raises(ValueError, match="expected a spectrum from .* got one from 0.1 to 0.2 s"):
        analyse(modes, S, 1.0)
    with pytest.raises(ValueError, match="expected a spectrum from .* got one of the ground alone"):
        analyse(modes, ss.response_spectrum(quake(), periods=[0.0], xi=0.05), 1.0)
    with pytest.raises(ValueError, match=r"at the modes' damping ratios, 0.02 .* got one at \[0.05\]"):
        analyse(modes.damped(0.02), S, 1.0)
    with pytest.raises(ValueError, match="pseudo-acceleration >= 0 for each of 2 modes"):
        analyse(modes, lambda T, xi: -T, 1.0)
    with pytest.raises(ValueError, match="stable for all modes at the record's step of 0.5 s"):
        analyse(modes, [0.0, 1.0, 0.0], 1.0, dt=0.5, scheme="central_difference")
    with pytest.raises(ValueError, match="got 1 rigid"):
        analyse(ss.structure(np.eye(2), [[1.0, -1.0], [-1.0, 1.0]]).modes(2), flat, 1.0)
    dashpot = ss.structure(*shear_building([1.0, 1.0], [9.0, 4.0]), C=[[0.0, 0.0], [0.0, 1.0]])
    with pytest.raises(ValueError, match="damping that does not couple the modes"):
        analyse(dashpot.modes(2), flat, 1.0)
    with pytest.raises(ValueError, match="expected a direction in which mass moves that is free"):
        analyse(modes, flat, [0.0, 0.0])
    with pytest.raises(ValueError, match="a peak of each of 2 modes"):
        analyse(modes, flat, 1.0).combined([1.0, 2.0, 3.0])


def test_a_mode_that_damps_more_than_critically_has_its_peak_too() -> None:
    """Two oscillators that know nothing of each other, the second overdamped; each by SciPy."""
    K, C = (4.0 * np.pi**2, 400.0), (0.6, 60.0)
    modes = ss.structure(np.eye(2), np.diag(K), C=np.diag(C)).modes(2)
    assert modes.xi.max() == pytest.approx(1.5)
    record = refined(quake(), 8)
    found = ss.response_spectrum_analysis(modes, record, [1.0, 1.0], scheme="fox_goodwin")
    for j, (k, c) in enumerate(zip(K, C, strict=True)):
        system = StateSpace([[0.0, 1.0], [-k, -c]], [[0.0], [-1.0]], [[1.0, 0.0]], [[0.0]])
        _, u, _ = lsim(system, record.samples, record.dt * np.arange(len(record.samples)))
        assert found.u[j] == pytest.approx(np.abs(u).max(), rel=2e-4)
