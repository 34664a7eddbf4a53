"""Schemes whose balances are solved together, on scenes: orders, energy, SciPy's Radau; what is refused by name."""

import os

import numpy as np
import pytest
from declared import BY_NAME, TOGETHER
from scipy.integrate import solve_ivp
from scipy.integrate._ivp import radau
from substep_derive import DeclarationError, Scene, rate
from substep_derive.kernels.scalar_step import ScalarStep
from substep_derive.motion.plan import Plan
from substep_kernels.facts import CATALOGUE
from sympy import sin, symbols

import substep as ss

VERIFY = os.environ.get("SUBSTEP_VERIFY")
Array = np.ndarray
EA, L, M, V0 = 1e4, 3.0443, 10.0, 7.72


def bar(x: Array, stiffness: float) -> tuple[Array, Array]:
    """Force and tangent of a bar of Green-Lagrange strain, at the place of its end."""
    strain = (x @ x - L**2) / (2 * L**2)
    return stiffness / L * strain * x, stiffness / L * (strain * np.eye(2) + np.outer(x, x) / L**2)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", TOGETHER)
def test_observed_order_on_the_pendulum(name: str) -> None:
    """Against SciPy's DOP853 at a tight tolerance; the derived order, on a nonlinear equation."""

    def rate(t: float, y: Array) -> Array:
        return np.concatenate([y[2:], -bar(y[:2], EA)[0] / M])

    exact = solve_ivp(rate, (0.0, 0.5), [L, 0.0, 0.0, V0], method="DOP853", rtol=1e-13, atol=1e-13).y[:2, -1]
    scene = ss.scene("elastic_pendulum", EA=EA)
    errors = [np.abs(ss.march(scene, name, dt=0.5 / n, t_end=0.5).u[-1] - exact).max() for n in (10, 20)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(CATALOGUE[name]["nonlinear_order"][0], abs=0.6)


@pytest.mark.usefixtures("uncompiled")
def test_radau_iia3_is_scipys_formula_at_the_same_steps() -> None:
    """On the stiff pendulum: stages by the transformation that SciPy prints, by Newton's iteration in first order."""
    stiff, h, n = 1e8, 0.01, 30
    pair = [[radau.MU_COMPLEX.real, -radau.MU_COMPLEX.imag], [radau.MU_COMPLEX.imag, radau.MU_COMPLEX.real]]
    inverse = np.zeros((3, 3))
    inverse[0, 0], inverse[1:, 1:] = radau.MU_REAL, pair
    A = np.linalg.inv(radau.T @ inverse @ radau.TI)
    assert np.allclose(A.sum(axis=1), radau.C, atol=1e-13)
    y, found = np.array([L, 0.0, 0.0, V0]), []
    for _ in range(n):
        z = np.zeros((3, 4))
        for _ in range(40):
            stages, wrong, slopes = y + z, np.empty((3, 4)), np.zeros((3, 4, 4))
            for i, stage in enumerate(stages):
                force, tangent = bar(stage[:2], stiff)
                wrong[i] = np.concatenate([stage[2:], -force / M])
                slopes[i, :2, 2:], slopes[i, 2:, :2] = np.eye(2), -tangent / M
            J = np.eye(12) - h * np.einsum("ij,jkl->ikjl", A, slopes).reshape(12, 12)
            change = np.linalg.solve(J, (z - h * A @ wrong).ravel()).reshape(3, 4)
            z -= change
            if np.abs(change).max() < 1e-14:
                break
        y = y + z[-1]
        found.append(y)
    r = ss.march(ss.scene("elastic_pendulum", EA=stiff), "radau_iia3", dt=h, t_end=n * h)
    assert r.status == "completed"
    assert np.abs(r.u[1:] - np.array(found)[:, :2]).max() < 1e-9 * L
    assert np.abs(r.v[1:] - np.array(found)[:, 2:]).max() < 1e-7 * V0


@pytest.mark.parametrize("periods", [1000, pytest.param(100_000, marks=pytest.mark.thorough)])
def test_the_energy_error_of_gauss_is_bounded(periods: int) -> None:
    """Symplectic: over many periods of a pendulum at 2 rad it is no more than over the first ten; of Radau it grows."""
    scene = ss.scene("simple_pendulum", g_over_L=1.0, u0=2.0, v0=0.0)
    dt, steps = 0.5, round(periods * 8.3495 / 0.5)
    energy = ss.march(scene, "gauss2", dt=dt, t_end=steps * dt, stride=max(1, steps // 10_000)).energy
    first = ss.march(scene, "gauss2", dt=dt, t_end=10 * 8.5).energy
    size = np.abs(first - first[0]).max()
    assert size > 1e-5
    assert np.abs(energy - energy[0]).max() < 1.05 * size
    if periods == 1000:
        lost = ss.march(scene, "radau_iia2", dt=dt, t_end=steps * dt, stride=steps // 1000).energy
        assert lost[0] - lost[-1] > 10 * size


STILL = {"radau_iia2": "u_1", "radau_iia3": "u_1", "lobatto_iiia3": "u_1", "weighted_residual_p2": "u_1"}
STILL |= {"discontinuous_galerkin_p1": "u_1", "lobatto_iiic2": "u_p", "lobatto_iiic3": "u_p"}


@pytest.mark.parametrize("name", TOGETHER)
def test_contacts_are_refused_by_name_where_a_pressure_does_not_open_its_gap(name: str) -> None:
    """Accelerations at the end of a step move the velocity there, and no displacement: b_s (1 - c_s) is 0."""
    assert ss.scheme(name).info.together
    reason = "expected a state|at the end of its steps"
    if name in STILL:
        reason = f"one does not move the displacement {STILL[name]} .* expected a pressure that opens the gap"
    with pytest.raises(ValueError, match=rf"{name}[: ].*({reason})"):
        ss.march(ss.scene("mass_on_floor"), BY_NAME[name], dt=0.01, t_end=0.1)


@pytest.mark.thorough
def test_a_kernel_of_many_blocks_is_compiled() -> None:
    """Rows that are exchanged, for a coordinate without mass, have more blocks than Python allows calls by default."""
    x, y, z, t = symbols("x y z t")
    given = Scene(
        "massless_third", coordinates={x: "m", y: "m", z: "m"}, kinetic=(rate(x) ** 2 + rate(y) ** 2) / 2,
        potential=3 * z**2 + 2 * y + x**2, dissipation=rate(y) ** 2 / 5, length=1, parameters=(),
        constraints={"surface": z - x * y / 2 - x**2 / 3 - sin(2 * t) / 4, "edge": rate(y) - rate(x) * sin(x)},
        start={x: 0, y: 1, z: 0, rate(x): 1, rate(y): 0, rate(z): 1},
    )  # fmt: skip
    r = ss.march(ss.scene(given), "radau_iia2", dt=0.01, t_end=1.0)
    fine = ss.march(ss.scene(given), "bdf4", dt=0.001, t_end=1.0)
    assert np.abs(r.u[-1] - fine.u[-1]).max() < 1e-5


def test_no_file_of_another_language_is_printed() -> None:
    plan = Plan.of(BY_NAME["radau_iia2"])
    with pytest.raises(DeclarationError, match=r"radau_iia2 solves balances together: .* in a file of one language"):
        ScalarStep.of(plan)
