"""Nonlinear constraints of structures: against the same model as a scene, and what is refused."""

from typing import Any

import numpy as np
import pytest
from scipy import sparse
from substep_derive import Scene, rate
from sympy import Rational, Symbol
from test_constraints import (
    AT_THE_MEAN,
    EXPLICIT,
    HELD_TOGETHER,
    NEXT,
    ONE_OF_EACH,
    PENDULUM,
    TAKEN,
    TOGETHER,
    VERIFY,
)

import substep as ss

Array = np.ndarray
G = 9.81
CHOSEN = [name for name in TAKEN if (VERIFY or name in ONE_OF_EACH) and name not in AT_THE_MEAN]
AHEAD = [name for name in NEXT if VERIFY or name in ("central_difference", "noh_bathe", "beeman", "dormand_prince")]
x, y, z = (Symbol(name) for name in "xyz")


def rod(u: Array) -> tuple[float, Array]:
    """Of a point at unit distance from the origin."""
    return (u[0] ** 2 + u[1] ** 2 - 1.0) / 2.0, np.array([u[0], u[1], *np.zeros(len(u) - 2)])


def second(u: Array) -> tuple[float, Array]:
    """Of a second point at unit distance from the first."""
    d = u[2:] - u[:2]
    return (d @ d - 1.0) / 2.0, np.array([*-d, *d])


def double(**more: Any) -> ss.Structure:
    """The scene rod_double_pendulum as a structure."""
    given = {"u0": [1.0, 0.0, 2.0, 0.0], "constraints": {"rod1": rod, "rod2": second}} | more
    return ss.structure(np.eye(4), np.zeros((4, 4)), load=({1: -G, 3: -G}, np.ones_like), **given)


def same(scene: Any, structure: ss.Structure, name: str, names: tuple[str, ...], dt: float, t_end: float) -> None:
    """Both marches: u, v, a and the multipliers, and constraints are kept."""
    r, s = (ss.march(one, name, dt=dt, t_end=t_end) for one in (scene, structure))
    assert r.status == s.status == "completed"
    pairs = [(r.u, s.u), (r.v, s.v), (r.a, s.a), *((r.memory[one], s.memory[one]) for one in names)]
    for mine, other in pairs:
        assert np.allclose(mine, other, rtol=0.0, atol=2e-8 * max(1.0, float(np.abs(mine).max())))
    assert max(abs(s.gaps[one]).max() for one in names) < 2e-15


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.filterwarnings("ignore:.*energy in play")
@pytest.mark.parametrize("name", [*CHOSEN, *NEXT, *HELD_TOGETHER])
def test_a_structure_is_the_scene(name: str) -> None:
    same(ss.scene("rod_double_pendulum", g=G), double(), name, ("rod1", "rod2"), 0.01, 0.3)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.filterwarnings("ignore:.*energy in play")
@pytest.mark.parametrize("hardening", [0, 50])
@pytest.mark.parametrize("name", [*CHOSEN, *AHEAD, *HELD_TOGETHER])
def test_beside_stiffness_damping_and_an_internal_force(name: str, hardening: int) -> None:
    """A point on a circle, and a second one on a spring to it, which hardens or not."""
    scene = Scene(
        "held_spring", coordinates={x: "m", y: "m", z: "m"},
        kinetic=(rate(x) ** 2 + rate(y) ** 2 + 2 * rate(z) ** 2) / 2,
        potential=20 * (z - x) ** 2 + Rational(hardening, 4) * (z - x) ** 4 - 3 * z,
        dissipation=Rational(1, 4) * rate(z) ** 2, constraints={"rod": (x**2 + y**2 - 1) / 2}, parameters=(),
        start={x: 0, y: 1, z: Rational(1, 2), rate(x): 2, rate(y): 0, rate(z): 0}, length=1,
    )  # fmt: skip
    B = np.array([-1.0, 0.0, 1.0])
    K, M, C = 40.0 * np.outer(B, B), np.diag([1.0, 1.0, 2.0]), np.diag([0.0, 0.0, 0.5])
    start = {
        "u0": [0.0, 1.0, 0.5],
        "v0": [2.0, 0.0, 0.0],
        "constraints": {"rod": rod},
        "load": ({2: 3.0}, np.ones_like),
    }
    if not hardening:
        structure = ss.structure(sparse.csr_array(M), sparse.csr_array(K), C=C, **start)
    else:
        structure = ss.structure(
            M,
            internal_force=lambda u: K @ u + hardening * (B @ u) ** 3 * B,
            tangent=lambda u: K + 3.0 * hardening * (B @ u) ** 2 * np.outer(B, B),
            potential=lambda u: u @ K @ u / 2.0 + hardening * (B @ u) ** 4 / 4.0,
            C=C,
            **start,
        )
    same(ss.scene(scene), structure, name, ("rod",), 0.01, 0.3)


def test_several_rows_springs_with_a_memory_and_fixed_supports() -> None:
    """Both rods as one constraint, between springs that yield: what is held stays held, and energy is only lost."""

    def rods(u: Array) -> tuple[Array, Array]:
        pairs = rod(u[2:]), second(u[2:])
        zero = np.zeros((2, 2))
        return np.array([g for g, _ in pairs]), np.hstack([zero, np.array([row for _, row in pairs])])

    steel = ss.law("bilinear", k=50.0, q_y=2.0, alpha=0.1)
    b = ss.structure(
        np.eye(6), springs=[({0: -1.0, 4: 1.0}, steel)], fixed=[0, 1], constraints={"rods": rods},
        load=({3: -G, 5: -G}, np.ones_like), u0=[0, 0, 1, 0, 2, 0],
    )  # fmt: skip
    r = ss.march(b, "generalized_alpha", dt=0.005, t_end=1.0)
    assert r.status == "completed"
    assert r.memory["rods"].shape == r.multipliers["rods"].shape == (201, 2)
    own = r.memory["rods"][1:]  # of second order too, but for the steps in which the spring yields or does no more
    assert np.median(np.abs(r.multipliers["rods"][1:] - own)) < 1e-3 * np.abs(own).max()
    assert abs(r.gaps["rods"]).max() < 1e-14
    assert r.energy_dissipated[-1] > 0.1
    finer = ss.march(b, "generalized_alpha", dt=0.0025, t_end=1.0)
    assert np.abs(r.u[-1] - finer.u[-1]).max() < 0.02


@pytest.mark.parametrize("name", ["bathe", "generalized_alpha", *AHEAD, *HELD_TOGETHER])
def test_a_run_goes_on_to_the_bit(name: str) -> None:
    whole = ss.march(double(), name, dt=0.01, t_end=0.4, account=False)
    first = ss.march(double(), name, dt=0.01, t_end=0.2, account=False)
    rest = ss.march(double(), name, dt=0.01, t_end=0.4, start=first, account=False)
    assert np.array_equal(rest.u, whole.u[20:])
    assert np.array_equal(rest.memory["rod1"], whole.memory["rod1"][20:])


def test_an_explicit_run_goes_on_in_other_steps() -> None:
    """The first of these keeps the constraints as the first one of a run does."""
    first = ss.march(double(), "central_difference", dt=0.02, t_end=0.2, account=False)
    rest = ss.march(double(), "central_difference", dt=0.01, t_end=0.4, start=first, account=False)
    assert max(abs(rest.gaps[name]).max() for name in ("rod1", "rod2")) < 2e-15
    error = np.abs(rest.u[-1] - ss.march(double(), "radau_iia3", dt=0.01, t_end=0.4, account=False).u[-1]).max()
    assert error < 2e-4  # 3.3e-4 in steps of 0.02 to the end


def test_the_multiplier_is_of_the_second_order_for_one_balance() -> None:
    """Of a pendulum from its state at 0.3, whose tension is 3 g cos(theta): tests/test_constraints.py, to 20 digits."""
    start = {"u0": [0.905342850921633, -0.424681436237906], "v0": [-1.22587000207992, -2.613329775781903]}
    errors = []
    for n in (200, 400):
        b = ss.structure(
            np.eye(2), np.zeros((2, 2)), load=({1: -G}, np.ones_like), constraints={"rod": rod},
            u0=np.array(start["u0"]) / np.hypot(*start["u0"]), v0=start["v0"],
        )  # fmt: skip
        r = ss.march(b, "generalized_alpha", dt=0.7 / n, t_end=0.7, account=False)
        errors.append(abs(r.memory["rod"][-1] - 4.8562694074846764964))
    assert 3.5 < errors[0] / errors[1] < 4.5


def test_multipliers_of_the_equations_of_motion_are_of_second_order_where_the_own_ones_are_of_first() -> None:
    """Of a pendulum from the horizontal, whose tension at 2 s is known to 15 digits."""
    given = {"load": ({1: -G}, np.ones_like), "constraints": {"rod": rod}, "u0": [1.0, 0.0]}
    b, tension, errors = ss.structure(np.eye(2), np.zeros((2, 2)), **given), PENDULUM[2.0][-1], []
    for n in (400, 800):
        r = ss.march(b, "bathe", dt=2.0 / n, t_end=2.0, account=False)
        assert r.multipliers["rod"].shape == (n + 1,)
        errors.append([abs(x["rod"][-1] - tension) for x in (r.multipliers, r.memory)])
    assert errors[0][0] < 0.01
    assert np.log2(np.divide(*errors)) == pytest.approx([2.0, 1.0], abs=0.1)
    assert np.array_equal(r.to_xarray()["rod_multiplier"], r.multipliers["rod"])
    part = ss.march(b, "bathe", dt=0.01, t_end=0.1, dofs=[0], account=False)
    with pytest.raises(ValueError, match=r"all degrees of freedom for the multipliers of constraints, got 1 of 2"):
        print(part.multipliers)
    assert "rod_multiplier" not in part.to_xarray()
    assert ss.march(ss.structure(np.eye(1), np.eye(1), u0=1.0), "bathe", dt=0.01, t_end=0.1).multipliers == {}


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e6])
def test_displacements_from_the_place_at_the_start_in_any_unit(unit: float) -> None:
    """As of finite elements: g is of places, u of what is left of them at rest; lengths in mm, m or um."""

    def rod_from(u: Array) -> tuple[float, Array]:
        place = np.array([0.6, -0.8]) * unit + u[:2]
        return (place @ place - unit**2) / 2.0, np.array([*place, 0.0])

    B = np.array([0.0, -1.0, 1.0])
    given = {"u0": 0.0, "v0": np.array([0.8, 0.6, 0.0]) * 1e-3 * unit, "constraints": {"rod": rod_from}}
    linear = ss.structure(np.eye(3), 50.0 * np.outer(B, B), **given)
    nonlinear = ss.structure(
        np.eye(3), internal_force=lambda u: 50.0 * (B @ u) * B, tangent=lambda u: 50.0 * np.outer(B, B), **given
    )
    runs = [ss.march(one, "bathe", dt=0.05, t_end=2.0, account=False) for one in (linear, nonlinear)]
    for r in runs:
        assert r.status == "completed"
        assert abs(r.gaps["rod"]).max() < 1e-15 * unit**2
    assert np.allclose(runs[0].u, runs[1].u, rtol=0.0, atol=1e-12 * unit)


def test_degrees_of_freedom_without_mass_beside_constraints() -> None:
    """A point on a circle, a spring from it to a joint without mass, and one from there to a support: two in series."""
    M, B = np.diag([1.0, 1.0, 0.0]), np.array([[1.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    given = {"v0": [0.0, 2.0, 0.0], "constraints": {"rod": rod}}
    whole = ss.structure(M, B.T @ np.diag([30.0, 60.0]) @ B, u0=[1.0, 0.0, 1.0 / 3.0], **given)
    condensed = ss.structure(np.eye(2), np.diag([20.0, 0.0]), u0=[1.0, 0.0], v0=[0.0, 2.0], constraints={"rod": rod})
    for name in ("generalized_alpha", "bathe", "bdf2"):
        a, b = (ss.march(one, name, dt=0.01, t_end=1.0) for one in (whole, condensed))
        assert np.abs(a.u[:, :2] - b.u).max() < 1e-12
        for mine, other in ((a.multipliers, b.multipliers), (a.memory, b.memory)):
            assert np.abs(mine["rod"] - other["rod"]).max() < 1e-8
        assert np.abs(a.a[0, :2] - b.a[0]).max() < 1e-12
    with pytest.raises(ValueError, match="central_difference is explicit: expected mass"):
        ss.march(whole, "central_difference", dt=0.01, t_end=1.0)


def test_wrong_constraints_are_refused() -> None:
    for given, expected in (
        ({"rod": 3.0}, "a name with a function of the displacements, got float"),
        ({"rod": lambda u: u @ u - 1.0}, "to return its value and its gradient"),
        ({"rod": lambda u, t: (u @ u - t, 2.0 * u)}, "of the displacements, got one of 2 arguments"),
        ({"rod": lambda u: (u @ u - 1.0, u[:2])}, r"got shapes \(\) and \(2,\)"),
        ({"rod": lambda u: (np.nan, u)}, "finite values"),
        ({"rod": lambda u: (u[0] ** 2 + u[1] ** 2 - 1.0, u)}, "the gradient of its value"),
        ({"rod": lambda u: (u[0] - 0.5, np.eye(4)[0])}, r"g\(u0\) = 0 of constraint 'rod', got 0.5"),
        ({"rod1": rod, "again": rod}, "independent constraints, got 'again'"),
    ):
        with pytest.raises(ValueError, match=expected):
            double(constraints=given)
    with pytest.raises(ValueError, match="G v0 = 0 of constraint 'rod1', got 1"):
        double(v0=[1.0, 0.0, 1.0, 0.0])
    with pytest.raises(ValueError, match="without contacts, got both"):
        double(contacts={"floor": ({3: 1.0}, 5.0)})
    with pytest.raises(
        ValueError, match="expected mass at the degrees of freedom of nonlinear constraints, got none at 1"
    ):
        ss.structure(np.diag([1.0, 0.0, 1.0]), np.eye(3), constraints={"rod": rod}, u0=[1.0, 0.0, 0.0])


def test_what_takes_no_constraints_says_so() -> None:
    for name in (*EXPLICIT.difference(NEXT), *TOGETHER.difference(HELD_TOGETHER)):
        with pytest.raises(ValueError, match="is explicit: expected|solves balances together that do not hold"):
            ss.march(double(), name, dt=0.01, t_end=0.1)
    with pytest.raises(ValueError, match="at the displacements of its own step where steps change, got central_differ"):
        ss.march(double(), "central_difference", tol=1e-4, t_end=0.5)
    with pytest.raises(
        ValueError, match="in the first of which central_difference can keep the constraints, got dt = 2"
    ):
        ss.march(double(), "central_difference", dt=2.0, t_end=4.0)
    with pytest.raises(ValueError, match="without constraints"):
        double().modes(2)


def test_where_a_gradient_vanishes_the_march_ends_with_what_it_has() -> None:
    def lost(u: Array) -> tuple[float, Array]:
        value, gradient = rod(u)
        return (value, gradient) if u[1] < 0.5 else (value, 0.0 * gradient)

    b = ss.structure(np.eye(2), np.zeros((2, 2)), constraints={"rod": lost}, u0=[1.0, 0.0], v0=[0.0, 1.0])
    r = ss.march(b, "bathe", dt=0.01, t_end=1.0, account=False)
    assert r.status == "newton_failed"
    assert 50 < len(r.t) < 60
    assert abs(r.u[-1, 1]) < 0.5


@pytest.mark.parametrize("name", AT_THE_MEAN)
def test_forces_at_a_mean_are_refused(name: str) -> None:
    with pytest.raises(ValueError, match="takes forces at a mean of two displacements"):
        ss.march(double(), name, dt=0.01, t_end=0.1)
