"""The critical step of a scheme on a structure: exact where it is known, and by stepping 1 % below and above it."""

from typing import Any

import numpy as np
import pytest
from plane_elements import cantilever, shear_building

import substep as ss
from substep.structures.march import critical
from substep.structures.march.critical import critical_step, frequency_bound, largest_mode


def building(C: Any = None, **more: Any) -> ss.Structure:
    return ss.structure(*shear_building([2.0] * 12, [900.0] * 12), C=C, u0=np.cos(np.arange(12.0)), **more)


TOP = 2 * np.sqrt(900.0 / 2.0) * np.sin(23 * np.pi / 50)  # of the uniform shear building


def test_the_largest_frequency_and_its_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    frame = building()
    omega, shape = largest_mode(frame)
    assert np.isclose(omega, TOP, rtol=1e-12)
    assert np.isclose(shape @ frame.M @ shape, 1.0)
    assert frequency_bound(frame) == pytest.approx(2 * np.sqrt(450.0), rel=1e-14)
    M, K, fixed, _ = cantilever(10, 3)
    plane = ss.structure(M, K, fixed=fixed)
    dense = largest_mode(plane)[0]
    monkeypatch.setattr(critical, "DENSE", 10)
    assert np.isclose(largest_mode(plane)[0], dense, rtol=1e-9)


@pytest.mark.parametrize(("scheme", "Omega"), [("central_difference", 2.0), ("linear_acceleration", 2 * np.sqrt(3.0))])
def test_undamped_it_is_the_known_critical_Omega(scheme: str, Omega: float) -> None:
    found = building().critical_step(scheme)
    assert np.isclose(found.dt, Omega / TOP, rtol=1e-12)
    assert (found.xi, found.Omega) == (0.0, pytest.approx(Omega))
    assert np.isclose(building().critical_step(scheme, bound=True).dt, Omega / (2 * np.sqrt(450.0)), rtol=1e-12)


@pytest.mark.parametrize("damping", [None, "rayleigh", "matrix"])
@pytest.mark.parametrize("scheme", ["central_difference", "central_difference_lagged", "noh_bathe", "rk4"])
def test_steps_just_below_it_are_stable_and_just_above_it_are_not(scheme: str, damping: str | None) -> None:
    rayleigh = ss.Rayleigh(0.3, 0.002)
    C = {None: None, "rayleigh": rayleigh, "matrix": building(rayleigh).damping}[damping]
    frame = building(C)
    found = critical_step(frame, scheme)
    assert np.isclose(found.xi, 0.0 if C is None else rayleigh.ratio(TOP), rtol=1e-9)
    largest = {}
    for share in (0.99, 1.01):
        dt = share * found.dt
        r = ss.march(frame, scheme, dt, 3000 * dt, stride=100, account=False)
        largest[share] = np.abs(r.u).max() if r.status == "completed" else np.inf
    assert largest[0.99] < 100.0
    assert largest[1.01] > 1e6


def test_a_mode_below_with_more_damping_may_decide() -> None:
    """The largest mode is damped critically, both its roots are -alpha/2; a slow one has a root near -alpha.

    RK4's interval of stability on the real axis ends at 2.785 (Hairer & Wanner II, IV.2).
    """
    alpha = 50.0
    frame = ss.structure(np.eye(2), np.diag([1e-2, alpha**2 / 4]), C=ss.Rayleigh(alpha, 0.0), u0=1.0)
    found = frame.critical_step("rk4")
    assert (found.Omega or 0.0) / found.omega == pytest.approx(2 * 2.785294 / alpha, rel=1e-6)
    assert found.dt == pytest.approx(2.785294 / alpha, rel=1e-5)
    largest = {}
    for share in (0.99, 1.01):
        r = ss.march(frame, "rk4", share * found.dt, 3000 * share * found.dt, account=False)
        largest[share] = np.abs(r.u).max() if r.status == "completed" else np.inf
    assert largest[0.99] < 10.0
    assert largest[1.01] > 1e6


@pytest.mark.parametrize("dashpot", [300.0, 5000.0])
@pytest.mark.parametrize("scheme", ["central_difference_lagged", "rk4", "noh_bathe", "explicit_generalized_alpha"])
def test_damping_that_couples_modes_is_looked_at_as_a_whole(scheme: str, dashpot: float) -> None:
    """A dashpot at one storey: the limit of the largest mode with its own ratio is far beyond what is stable."""
    C = np.zeros((12, 12))
    C[0, 0] = dashpot
    frame = building(C)
    found = frame.critical_step(scheme)
    assert found.dt < 0.99 * (found.Omega or np.inf) / found.omega
    sizes = []
    for share in (0.995, 1.02):
        h = share * found.dt
        u = ss.march(frame, scheme, dt=h, t_end=4000 * h, account=False).u
        sizes.append(np.abs(u[-200:]).max())
    assert sizes[0] <= 12.0
    assert not sizes[1] <= 1e6


def test_a_matrix_of_rayleigh_damping_is_known_as_that() -> None:
    damping = ss.Rayleigh(0.3, 2e-4)
    M, K = shear_building([2.0] * 12, [900.0] * 12)
    found, asked = (building(C).critical_step("rk4") for C in (damping.matrix(M, K), damping))
    assert found.dt == pytest.approx(asked.dt, rel=1e-8)
    large = ss.structure(
        np.eye(200), 2 * np.eye(200) - np.eye(200, k=1) - np.eye(200, k=-1), C=np.diag([1.0] + [0.0] * 199)
    )
    with pytest.raises(ValueError, match="more than 120 degrees of freedom, got another damping matrix of 200"):
        large.critical_step("rk4")


@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "houbolt", "kr_alpha"])
def test_rigid_motions_take_no_step_from_a_scheme_without_limit(scheme: str) -> None:
    """A free chain with a dashpot between two masses; what is left of the rigid motion is a double eigenvalue 1."""
    K = 900.0 * (2 * np.eye(12) - np.eye(12, k=1) - np.eye(12, k=-1))
    K[0, 0] = K[-1, -1] = 900.0
    C = np.zeros((12, 12))
    C[4:6, 4:6] = [[4.0, -4.0], [-4.0, 4.0]]
    assert ss.structure(2 * np.eye(12), K, C=C).critical_step(scheme).dt == np.inf


@pytest.mark.parametrize("C", [ss.Rayleigh(100.0, 0.0), [[100.0]]])
def test_damping_alone_has_a_critical_step(C: Any) -> None:
    """u'' = -100 u': that of a scheme of Runge and Kutta ends where its interval on the negative axis does."""
    drag = ss.structure([[1.0]], [[0.0]], C=C)
    assert drag.critical_step("rk4").dt == pytest.approx(2.785293563405282 / 100, rel=1e-6)
    assert drag.critical_step("bathe").dt == np.inf
    assert ss.structure([[1.0]], [[0.0]]).critical_step("rk4").dt == np.inf


def test_two_degrees_of_freedom_are_not_taken_for_rayleigh_damping() -> None:
    """Two numbers fit any product with two entries; an oscillator apart that is slow changes nothing."""
    two = ss.structure(2 * np.eye(2), [[1800.0, -900.0], [-900.0, 900.0]], C=np.diag([5000.0, 0.0]))
    three = ss.structure(
        2 * np.eye(3), [[1800.0, -900.0, 0.0], [-900.0, 900.0, 0.0], [0.0, 0.0, 100.0]], C=np.diag([5000.0, 0.0, 0.0])
    )
    assert two.critical_step("rk4").dt == pytest.approx(three.critical_step("rk4").dt, rel=1e-5)
    assert two.critical_step("rk4").dt == pytest.approx(2.785 / 2500, rel=1e-3)


def test_instability_below_a_limit_is_found() -> None:
    """forest_ruth steps back and forth, so that damping makes it unstable in steps that are shorter than others."""
    M, K = shear_building([2.0] * 8, [900.0] * 8)
    frame = ss.structure(M, K, C=ss.modal_damping([0.0] * 6 + [0.9]))
    found, modes = frame.critical_step("forest_ruth"), frame.modes(8)
    steps = np.linspace(0.002, 0.999, 300) * found.dt
    radius = ss.scheme("forest_ruth").spectral_radius(steps[:, None] * modes.omega, np.maximum(modes.xi, 0.0))
    assert found.dt < 0.6 * found.Omega / found.omega
    assert radius.max() <= 1 + 1e-5


def test_large_structures_under_modal_damping(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beyond those whose whole step is looked at, every damped mode is: with the same result."""
    for scheme in ("rk4", "central_difference_lagged", "forward_euler", "forest_ruth"):
        for ratios in ([0.05] * 12, [0.0] * 10 + [0.8]):
            frame = building(ss.modal_damping(ratios))
            whole = frame.critical_step(scheme).dt
            with monkeypatch.context() as patched:
                patched.setattr(critical, "WHOLE", 5)
                assert frame.critical_step(scheme).dt == pytest.approx(whole, rel=2e-5, abs=1e-10)


def test_modal_damping_of_a_lower_mode_may_decide() -> None:
    """The highest mode is undamped; central differences with lagged damping are unstable where xi Omega is large."""
    M, K = shear_building([2.0] * 12, [900.0] * 12)
    ratios = np.zeros(11)
    ratios[-1] = 0.8
    frame = ss.structure(M, K, C=ss.modal_damping(ratios), u0=np.cos(np.arange(12.0)))
    same = ss.structure(M, K, C=frame.damping.toarray())
    found, whole = (s.critical_step("central_difference_lagged") for s in (frame, same))
    omega = frame.modes(12).omega
    assert found.Omega == 2.0
    assert found.dt == pytest.approx(2 * (np.sqrt(1.64) - 0.8) / omega[-2], rel=1e-6)
    assert whole.dt == pytest.approx(found.dt, rel=1e-5)


def test_an_unconditionally_stable_scheme_has_none() -> None:
    found = building(ss.Rayleigh(0.1, 0.001)).critical_step("bathe")
    assert found.Omega is None
    assert found.dt == np.inf
    alpha = ss.scheme("generalized_alpha", rho_inf=0.7)
    assert building().critical_step(alpha).dt == np.inf


def test_parameters_of_the_scheme_count() -> None:
    found = building().critical_step(ss.scheme("newmark", beta=0.1, gamma=0.5))
    assert np.isclose(found.Omega, 1 / np.sqrt(0.15), rtol=1e-12)  # 1/sqrt(gamma/2 - beta), Hughes (9.1.13)


def test_what_has_no_critical_step_is_refused_by_name() -> None:
    massless = ss.structure(np.diag([1.0, 0.0]), [[2.0, -1.0], [-1.0, 1.0]], names=["first", "joint"])
    with pytest.raises(ValueError, match="expected mass at each degree of freedom, got none at 'joint'"):
        massless.critical_step("central_difference")
    M, K, fixed, _ = cantilever(4, 2)
    with pytest.raises(ValueError, match="lumped .* for Gershgorin's bound"):
        ss.structure(M, K, fixed=fixed).critical_step("rk4", bound=True)
    with pytest.raises(ValueError, match="Rayleigh damping, or none, with bound=True"):
        building(0.1 * np.eye(12)).critical_step("rk4", bound=True)
    with pytest.raises(ValueError, match="rkn43 is a scheme for .*: expected a structure without damping"):
        building(ss.Rayleigh(0.1, 0.0)).critical_step("rkn43")
    with pytest.raises(ValueError, match="one value for gamma_t .* got an array"):
        building().critical_step(ss.scheme("newmark_bdf2", gamma_t=[0.2, 0.4]))


@pytest.mark.parametrize("bound", [True, False])
@pytest.mark.parametrize(
    ("C", "change", "message"),
    [
        ("drives", 0.0, "expected damping without negative .* degree of freedom .*no step is stable"),
        (ss.Rayleigh(-0.5, 0.0), 0.0, "expected damping without negative eigenvalues"),
        (ss.Rayleigh(-0.5, 1e-4), 0.0, "expected damping without negative eigenvalues"),
        (None, -20.0, "expected a stiffness matrix K without negative eigenvalues.*no step is stable"),
    ],
)
def test_what_grows_by_itself_has_no_stable_step(C: Any, change: float, message: str, bound: bool) -> None:
    """The lowest omega^2 of the building is 7.1; -20 is added to K = 900 times that of a chain, in units of M."""
    M, K = shear_building([2.0] * 12, [900.0] * 12)
    driven = ss.structure(M, K + change * M, C=-0.5 * M if C == "drives" else C)
    if C == "drives" and bound:
        message = "expected Rayleigh damping, or none, with bound=True"
    with pytest.raises(ValueError, match=message):
        driven.critical_step("central_difference", bound=bound)


def test_what_does_no_work_or_little_is_not_refused() -> None:
    """A free body, gyroscopic coupling beside damping, and damping of one storey alone."""
    M, K = shear_building([2.0] * 12, [900.0] * 12)
    free = K - np.diag([900.0, *[0.0] * 11])
    turn = np.triu(np.ones((12, 12)), 1)
    for stiffness, C in ((free, None), (K, 0.1 * M + turn - turn.T), (K, np.diag([5.0, *[0.0] * 11]))):
        assert ss.structure(M, stiffness, C=C).critical_step("central_difference").dt > 0.0


def test_negative_damping_is_told_from_coupling() -> None:
    M, K = shear_building([2.0] * 12, [900.0] * 12)
    couples, drives, carries = (
        ss.structure(M, k, C=C).modes(3).together
        for k, C in ((K, np.diag([5.0, *[0.0] * 11])), (K, -0.5 * M), (K - np.diag([900.0, *[0.0] * 11]), 0.1 * M))
    )
    assert couples.startswith("damping couples the modes (")
    assert drives.startswith("damping is negative and drives modes (xi = -0.0")
    assert carries.startswith("damping acts on a rigid mode")
    assert not ss.structure(M, K, C=0.1 * M).modes(3).together
