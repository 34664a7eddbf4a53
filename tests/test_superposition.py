"""Mode superposition: every scheme against single oscillators and direct steps, static correction, failures, errors."""

from dataclasses import fields
from functools import cache
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from plane_elements import cantilever, shear_building

import substep as ss
from substep.marching import histories
from substep.structures.modes.superposition import coordinates

pytestmark = pytest.mark.filterwarnings("ignore:.* has (dissipated|gained)")  # what a scheme dissipates is its own
PULSE, WAVE = ss.HalfSine(1.5, 0.7), ss.Harmonic(0.8, 9.0, 0.4)


@cache
def building(damped: bool, given: bool = False) -> ss.Structure:
    """Six storeys with frequencies from 4 to 40 rad/s, two loads, and a start."""
    rng = np.random.default_rng(3)
    M, K = shear_building(rng.uniform(1.0, 2.0, 6), rng.uniform(400.0, 800.0, 6))
    u0, v0, p, q, a0 = rng.normal(size=(5, 6))
    return ss.structure(
        M, K, C=ss.Rayleigh(0.1, 0.002) if damped else None, load=[(p, PULSE), (q, WAVE)], u0=0.01 * u0, v0=0.1 * v0,
        a0=a0 if given else None,
    )  # fmt: skip


def relative(found: Any, expected: Any, h: float) -> float:
    """Largest difference of u, h v, h^2 a (rows, 3, ...) relative to the largest of the three."""
    scale = np.array([1.0, h, h * h])[:, None]
    return float(np.abs((found - expected) * scale).max() / np.abs(expected * scale).max())


def accounts_differ(found: Any, expected: Any, stride: int = 1) -> float:
    """Largest difference of kinetic, strain, work and damped energy, the expected at every stride-th row."""
    own, other = (np.array([getattr(r.account, x.name) for x in fields(r.account)]) for r in (found, expected))
    return float(np.abs(own - other[:, ::stride]).max() / np.abs(other).max())


@pytest.mark.usefixtures("plain_marches")
@pytest.mark.filterwarnings("ignore:.* is unstable at omega")  # the equality holds there as well
@pytest.mark.parametrize("scheme", BY_NAME.values(), ids=lambda s: s.name)
def test_every_mode_is_the_single_oscillator_and_all_modes_the_direct_march(scheme: Any) -> None:
    frame, h, n = building(scheme.takes_damping), 0.012, 40
    modes, start = frame.modes(6), frame.modes(6).start
    q = coordinates(modes, scheme.name, h, n * h)
    for i in range(6):
        own = [float(shape @ modes.free_shapes[:, i]) for shape, _ in frame.loads]

        def load(t: Any, own: Any = own) -> Any:
            return own[0] * PULSE(t) + own[1] * WAVE(t)

        scene = ss.scene(
            "linear_oscillator", omega=modes.omega[i], xi=modes.xi[i], u0=start[0, i], v0=start[1, i], load=load
        )
        r = ss.march(scene, scheme.name, h, n * h)
        assert relative(q[:, :, i : i + 1], np.stack([r.u, r.v, r.a], axis=1), h) < 1e-12
    direct = ss.march(frame, scheme.name, h, n * h)
    found = ss.march(modes, scheme.name, h, n * h)
    stacked = [np.stack([r.u, r.v, r.a], axis=1) for r in (found, direct)]
    assert relative(*stacked, h) < 1e-11
    assert accounts_differ(found, direct) < 1e-11
    assert (found.status, found.dofs, found.structure) == ("completed", direct.dofs, frame)


@pytest.mark.parametrize("scheme", ["bathe", "houbolt", "generalized_alpha", "rk4"])
def test_a_given_acceleration_at_the_start_is_that_of_the_direct_march(scheme: str) -> None:
    frame, h, n = building(True, given=True), 0.01, 30
    direct = ss.march(frame, scheme, h, n * h, account=False)
    found = ss.march(frame.modes(6), scheme, h, n * h)
    stacked = [np.stack([r.u, r.v, r.a], axis=1) for r in (found, direct)]
    assert relative(*stacked, h) < 1e-11


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize("scheme", ["average_acceleration", "newmark_bdf2", "park"])
def test_modes_that_damping_couples_are_marched_together(scheme: str) -> None:
    M, K = shear_building([2.0, 1.0, 1.0], [300.0, 200.0, 100.0])
    C = np.diag([0.0, 0.0, 4.0])
    frame = ss.structure(M, K, C=C, load=([0.0, 0.0, 1.0], PULSE), u0=[0.0, 0.1, 0.0])
    modes, h = frame.modes(3), 0.02
    assert not modes.lanes
    direct = ss.march(frame, scheme, h, 50 * h)
    found = ss.march(modes, scheme, h, 50 * h, dofs=[2, 0], stride=5)
    assert accounts_differ(found, direct, 5) < 1e-11
    assert ss.march(modes, scheme, h, 5 * h, account=False).account is None
    stacked = [np.stack([found.u, found.v, found.a], axis=1), np.stack([direct.u, direct.v, direct.a], axis=1)]
    assert relative(stacked[0], stacked[1][::5][:, :, [2, 0]], h) < 1e-11
    alone = ss.march(modes.damped(modes.xi), scheme, h, 50 * h)  # the diagonal alone is another structure
    assert relative(np.stack([alone.u, alone.v, alone.a], axis=1), stacked[1], h) > 1e-3


@pytest.mark.parametrize("scheme", ["average_acceleration", "houbolt", "park"])
@pytest.mark.parametrize("stride", [1, 2, 7, 64, 300, 1000])
def test_rows_do_not_depend_on_stride_and_blocks(scheme: str, stride: int, monkeypatch: pytest.MonkeyPatch) -> None:
    frame, h, n = building(True), 0.01, 1000
    modes = frame.modes(4)
    every = ss.march(modes, scheme, h, n * h, dofs=[5, 1])
    monkeypatch.setattr(histories, "NEAR", 3 * 4 * 50)
    some = ss.march(modes, scheme, h, n * h, dofs=[5, 1], stride=stride)
    assert len(some.u) == n // stride + 1
    assert np.allclose(some.t, every.t[::stride])
    assert accounts_differ(some, every, stride) < 1e-13
    bare = ss.march(modes, scheme, h, n * h, dofs=[5, 1], stride=stride, account=False)
    assert bare.account is None
    assert np.abs(bare.a - some.a).max() <= 1e-13 * np.abs(every.a).max()
    for found, all_rows in ((some.u, every.u), (some.v, every.v), (some.a, every.a)):
        assert np.abs(found - all_rows[::stride]).max() <= 1e-13 * np.abs(all_rows).max()


def test_five_modes_and_static_correction_of_a_corner_load() -> None:
    """Beside the load a plane body gives way in a way that no few modes show."""
    M, K, fixed, corner = cantilever(30, 12, length=3.0)
    P = np.zeros(M.shape[0])
    P[corner - 1] = 1.0  # along the axis, at the corner
    body = ss.structure(M, K, fixed=fixed, C=ss.rayleigh(0.02, 0.02, at=(8.0, 60.0)), load=(P, ss.HalfSine(1.0, 2.0)))
    run: dict[str, Any] = {"dt": 0.02, "t_end": 3.0, "dofs": [corner - 1, corner]}
    exact = ss.march(body, "bathe", account=False, **run)
    modes = body.modes(40)
    error = {}
    for n, correction in ((5, False), (40, False), (5, True)):
        r = ss.march(modes.first(n), "bathe", static_correction=correction, **run)
        error[n, correction] = np.abs(r.u - exact.u).max() / np.abs(exact.u).max()
    assert error[5, True] < 0.01
    assert error[5, False] > 0.1
    assert error[40, False] > 0.05


def test_static_correction_of_a_free_body() -> None:
    """A free beam pushed at a corner: rigid motion exact, its deformation from few modes and residual flexibility."""
    M, K, _, corner = cantilever(16, 4)
    P = np.zeros(M.shape[0])
    P[corner] = 1.0
    body = ss.structure(M, K, load=(P, ss.HalfSine(1.0, 4.0)))
    modes = body.modes(8)
    assert modes.rigid == 3
    run: dict[str, Any] = {"dt": 0.02, "t_end": 2.0, "dofs": [corner, 0]}
    exact = ss.march(body, "average_acceleration", account=False, **run)
    found = ss.march(modes, "average_acceleration", static_correction=True, **run)
    rigid = ss.march(modes.first(3), "average_acceleration", **run)
    deformation = exact.u - rigid.u
    assert np.abs(found.u - exact.u).max() < 1e-3 * np.abs(deformation).max()
    assert np.abs(ss.march(modes, "average_acceleration", **run).u - exact.u).max() > 0.01 * np.abs(deformation).max()
    with pytest.raises(ValueError, match="all rigid modes among those computed, got 2 of more"):
        ss.march(modes.first(2), "average_acceleration", static_correction=True, **run)


def test_a_moving_base_gives_relative_and_absolute_results() -> None:
    M, K = shear_building([2.0, 2.0, 1.0], [900.0, 700.0, 500.0])
    t = np.arange(0.0, 4.0, 0.01)
    record = ss.Record(0.01, np.sin(9.0 * t) * np.exp(-t))
    quake = ss.structure(M, K, C=ss.Rayleigh(0.2, 0.001), names=["1", "2", "roof"]).ground_motion(record, 1.0)
    direct = ss.march(quake, "bathe", 0.01, 3.0, account=False)
    found = ss.march(quake.modes(3), "bathe", 0.01, 3.0, dofs=["roof"])
    for ours, theirs in ((found.u, direct.u), (found.absolute_a, direct.absolute_a)):
        assert np.abs(ours - theirs[:, 2:]).max() < 1e-11 * np.abs(theirs).max()
    assert np.abs(found.at("roof")[0] - found.u[:, 0]).max() == 0.0


@pytest.mark.parametrize("stride", [1, 3])
@pytest.mark.filterwarnings("ignore:dt = 0.5 s is longer than half the period")  # it is meant to be unstable
def test_a_run_that_overflows_keeps_what_is_good(stride: int) -> None:
    frame, h = building(True), 0.5  # ten times the critical step, so that a step multiplies by hundreds
    direct = ss.march(frame, "central_difference", h, 40 * h, account=False)
    found = ss.march(frame.modes(6), "central_difference", h, 2000 * h, stride=stride)
    assert found.status == "non_finite"
    assert np.isfinite(found.u).all()
    assert np.isfinite(found.a).all()
    done = len(found.newton_iterations)
    assert found.t_failed == (done + 1) * h
    assert len(found.u) == len(found.account.work) == done // stride + 1
    assert np.abs(found.a[-1]).max() > 1e308 / 1e3**stride
    same = direct.u[:40:stride]
    assert np.abs(found.u[: len(same)] - same).max() < 1e-10 * np.abs(same).max()


def test_the_account_of_a_few_modes_closes_and_what_a_scheme_dissipates_brings_a_warning() -> None:
    """Average acceleration keeps the balance exactly, also of some modes; the warning names the line that marched."""
    modes = building(True).modes(3)
    account = ss.march(modes, "average_acceleration", 0.02, 4.0, dofs=[]).account  # of all, whatever is kept
    assert account is not None
    assert np.abs(account.numerical).max() < 1e-12 * account.damped.max()
    assert account.work.max() > 0.1 * account.damped.max()
    with pytest.warns(UserWarning, match="backward_euler has dissipated .* at dt = 0.02") as warned:
        lossy = ss.march(modes, "backward_euler", 0.02, 4.0, stride=4)
    assert [x.filename for x in warned] == [__file__]
    assert len(lossy.account.work) == len(lossy.u) == 51
    M, K = shear_building([2.0, 1.0], [300.0, 200.0])
    coupled = ss.structure(M, K, C=np.diag([0.0, 0.1]), u0=[0.0, 0.1]).modes(2)
    with pytest.warns(UserWarning, match="backward_euler has dissipated") as warned:
        ss.march(coupled, "backward_euler", 0.02, 1.0)
    assert [x.filename for x in warned] == [__file__]


def test_what_modes_cannot_do_is_refused_by_name() -> None:
    modes = building(True).modes(2)
    with pytest.raises(ValueError, match="expected dt, a constant step, for modes, got none"):
        ss.march(modes, "bathe", t_end=1.0)
    with pytest.raises(ValueError, match="an argument of march for modes, .*; got 'tol'"):
        ss.march(modes, "bathe", t_end=1.0, tol=1e-3)
    with pytest.raises(ValueError, match="multiple of dt"):
        ss.march(modes, "bathe", 0.3, 1.0)
    with pytest.raises(ValueError, match="degree of freedom from 0 to 5"):
        ss.march(modes, "bathe", 0.1, 1.0, dofs=[6])
    with pytest.raises(ValueError, match="stride to be a whole number of steps >= 1"):
        ss.march(modes, "bathe", 0.1, 1.0, stride=0)
    with pytest.raises(ValueError, match="one value for gamma_t .* got an array"):
        ss.march(modes, ss.scheme("newmark_bdf2", gamma_t=[0.2, 0.4]), 0.1, 1.0)
    with pytest.raises(ValueError, match="without damping"):
        ss.march(modes, "rkn43", 0.1, 1.0)
