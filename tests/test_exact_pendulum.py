"""The exact elastic pendulum against published positions, against DOP853, and against its conserved quantities."""

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from substep.exact import pendulum
from substep.exact import pendulum as exact_pendulum_module
from substep.exact.pendulum import ElasticPendulum

# to 18 decimals, for EA = 1e4 and the scene of Kuhl & Crisfield 1999
PUBLISHED = {
    1.0: ("-2.345787427742993774", "1.942727611562980947"),
    10.0: ("2.514413002570302655", "-1.877031467598446057"),
}
OTHERS = [ElasticPendulum(1e4), ElasticPendulum(20.0), ElasticPendulum(500.0, L=2.0, m=3.0, v0=5.0)]
STIFF = ElasticPendulum(1e10)


def radius(position: np.ndarray) -> np.ndarray:
    return np.hypot(position[..., 0], position[..., 1])


def stretched(p: ElasticPendulum) -> float:
    """The greatest length, where all energy but that of rotation is in the strain, by bisection."""

    def excess(length: float) -> float:
        # (energy - rotation - strain energy)/(length^2 - L^2), which is not 0 at L
        return p.m * p.v0**2 / 2 / length**2 - p.EA * p.L / 2 * (length - p.L) * (length + p.L) / (2 * p.L**2) ** 2

    low, high = p.L, 100 * p.L
    while high - low > 2 * np.spacing(high):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) > 0 else (low, middle)
    return low


@pytest.mark.parametrize("t", PUBLISHED)
def test_published_positions(t: float) -> None:
    with mpmath.workdps(30):
        for found, published in zip(ElasticPendulum(1e4).position(t).tolist(), PUBLISHED[t], strict=True):
            assert abs(mpmath.mpf(found) - mpmath.mpf(published)) <= 2.3e-16  # half a unit in the last place


@pytest.mark.parametrize("p", OTHERS, ids=str)
def test_equation_of_motion_integrated(p: ElasticPendulum) -> None:
    def rate(_: float, z: np.ndarray) -> np.ndarray:
        u, v = z[:2], z[2:]
        force = p.EA * p.L * (u @ u - p.L**2) / (2 * p.L**2) * u / p.L**2
        return np.concatenate([v, -force / p.m])

    times = np.array([0.05, 0.3, 1.0, 2.7, 6.1, 10.0])
    found = solve_ivp(rate, (0, 10), [p.L, 0, 0, p.v0], "DOP853", times, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(p.position(times), found.y[:2].T, rtol=0, atol=1e-9)


@pytest.mark.parametrize("p", [*OTHERS, STIFF], ids=str)
def test_radius_between_turning_points(p: ElasticPendulum) -> None:
    times = np.linspace(0, 3 * p.radial_period, 241)
    radii, ulp = radius(p.position(times)), 4 * np.spacing(stretched(p))
    assert radii.min() >= p.L - ulp
    assert radii.max() <= stretched(p) + ulp
    np.testing.assert_allclose(radii[[0, 80, 160, 240]], p.L, rtol=1e-14)
    np.testing.assert_allclose(radii[[40, 120, 200]], stretched(p), rtol=1e-14)
    x, y = p.position(p.radial_period)
    assert np.arctan2(y, x) == pytest.approx(p.angle_per_period, rel=1e-11)


@pytest.mark.parametrize("p", [*OTHERS, STIFF], ids=str)
def test_energy_and_angular_momentum_are_kept(p: ElasticPendulum) -> None:
    t, h = np.linspace(0, 2.3 * p.radial_period, 57), p.radial_period / 400
    weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}  # central difference of order 8
    u, v = p.position(t), sum(w * (p.position(t + k * h) - p.position(t - k * h)) for k, w in weights.items()) / h
    strain = (radius(u) - p.L) * (radius(u) + p.L) / (2 * p.L**2)
    energy = p.m * (v**2).sum(axis=-1) / 2 + p.EA * p.L * strain**2 / 2
    np.testing.assert_allclose(energy, p.m * p.v0**2 / 2, rtol=1e-11)
    np.testing.assert_allclose(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], p.L * p.v0, rtol=1e-11)


def test_a_stiff_bar_turns_like_a_rigid_one() -> None:
    frequency = np.sqrt(STIFF.EA / (STIFF.m * STIFF.L))
    assert 2 * np.pi / STIFF.radial_period == pytest.approx(frequency, rel=1e-6)
    times = np.linspace(0, 30, 301)
    angle = STIFF.v0 / STIFF.L * times
    rigid = STIFF.L * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    np.testing.assert_allclose(radius(STIFF.position(times)), STIFF.L, rtol=0, atol=1e-5)
    np.testing.assert_allclose(STIFF.position(times), rigid, rtol=0, atol=1e-4)


@pytest.mark.parametrize("p", [*OTHERS, STIFF], ids=str)
def test_digits_hold_after_many_periods(p: ElasticPendulum) -> None:
    """At other digits, truncation and starts of Newton's method the rounded position is the same."""
    times = np.array([0.7, -3.1, 1e4, 1e9])
    with pytest.MonkeyPatch.context() as patch:
        finer = mpmath.MPContext()
        finer.dps = 60
        near = pendulum._Motion._near
        patch.setattr(pendulum._Motion, "_near", lambda *args: near(*args).round(10))
        patch.setattr(exact_pendulum_module, "_MP", finer)
        patch.setattr(exact_pendulum_module, "_NEGLIGIBLE", finer.mpf(10) ** -50)
        expected = pendulum._motion.__wrapped__(p.EA, p.L, p.m, p.v0).states(times)[:, :2]
    np.testing.assert_array_equal(p.position(times), expected)


def test_shapes_and_symmetry() -> None:
    p, times = OTHERS[0], np.array([[0.1, 0.2, 5.0], [0.0, -1.0, 29.0]])
    assert p.position(times).shape == (2, 3, 2)
    assert p.position([]).shape == (0, 2)
    assert p.position(0).tolist() == [p.L, 0.0]
    np.testing.assert_array_equal(p.position(times)[1, 2], p.position(29))
    np.testing.assert_array_equal(p.position(-times), p.position(times) * [1, -1])


def test_parameters() -> None:
    assert ElasticPendulum(np.float32(1e4), m=10) == OTHERS[0]
    for name in ("EA", "L", "m", "v0"):
        with pytest.raises(ValueError, match=f"expected {name} > 0"):
            ElasticPendulum(**{"EA": 1e4, name: 0.0})
    with pytest.raises(ValueError, match="expected t to be finite"):
        OTHERS[0].position([0.0, np.nan])
    with pytest.raises(ValueError, match=r"stretches to 29\.8 L; give a larger EA"):
        ElasticPendulum(1e-3).position(1.0)
    digits = mpmath.mp.dps
    ElasticPendulum(1e4).position(1.0)
    assert mpmath.mp.dps == digits
