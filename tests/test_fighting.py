"""Steps without a solution: contacts without room, Painlevé's rod, masses that end; named, with all rows before."""

from dataclasses import replace

import numpy as np
import pytest
from substep_derive import Contact, Friction, Scene, optional, rate, t
from substep_derive.declare.parameter import NOT_NEGATIVE
from sympy import Rational, Symbol, cos, sin

import substep as ss

x, y, phi, mu, above = (Symbol(name) for name in ("x", "y", "phi", "mu", "above"))
ANGLE, SPEED = 1.2, 5.0
POINT = {"coordinates": {x: "m"}, "kinetic": rate(x) ** 2 / 2, "potential": 0 * x, "parameters": (), "length": 1}
LIMIT = (1 + 3 * np.cos(ANGLE) ** 2) / (3 * np.sin(ANGLE) * np.cos(ANGLE))  # of mu, where the rod no longer slides


def compliance(coefficient: float) -> float:
    """By how much a unit of pressure opens the contact of the rod of mass 1 and length 2, where that slides."""
    return 1 + 3 * np.cos(ANGLE) ** 2 - 3 * coefficient * np.sin(ANGLE) * np.cos(ANGLE)


def rod(restitution: int | None) -> Scene:
    """A rigid rod that slides with its lower end along a rough floor, which it meets from a height above it."""
    return Scene(
        "painleve_rod", coordinates={x: "m", y: "m", phi: "rad"},
        kinetic=(rate(x) ** 2 + rate(y) ** 2 + rate(phi) ** 2 / 3) / 2, potential=9.81 * y,
        contacts={"floor": Contact(y - sin(phi), restitution=restitution)},
        frictions={"drag": Friction(x - cos(phi), mu * Symbol("floor"))},
        parameters=(optional(mu, 2), optional(above, 0, NOT_NEGATIVE)),
        start={x: 0, y: sin(Rational(6, 5)) + above, phi: Rational(6, 5), rate(x): -5, rate(y): 0, rate(phi): 0},
        length=1,
    )  # fmt: skip


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["average_acceleration", "bathe", "generalized_alpha"])
def test_the_painleve_rod_is_named_beyond_its_coefficient_of_friction_and_slides_below(name: str) -> None:
    r = ss.march(ss.scene(rod(None), mu=0.95 * LIMIT), name, dt=1e-3, t_end=5e-3)
    assert (r.status, r.failure) == ("completed", "")
    r = ss.march(ss.scene(rod(None), mu=2, above=0.04905), name, dt=2e-3, t_end=0.2)  # lands after 0.1 s
    assert r.status == "newton_failed"
    assert r.t[-1] == pytest.approx(0.1, abs=5e-3)
    assert np.allclose(r.u[:, 0], -SPEED * r.t)  # what was computed before is there
    assert r.failure.startswith(f"the step to t = {r.t_failed:.6g} s was not solved: friction 'drag' presses contact")
    assert (
        f"'floor' (of y, phi) harder than sliding relieves it, so that G M^-1 (G - mu T)^T is {compliance(2):.3g}"
        in (r.failure)
    )
    assert r.failure in repr(r)


@pytest.mark.usefixtures("uncompiled")
def test_a_rod_that_slides_is_not_lost_where_its_rate_says_which_way() -> None:
    """A pressure that is 0 but for rounding leaves friction without a direction, which the rate has."""
    start = {x: 0, y: sin(Rational(3, 2)), phi: Rational(3, 2), rate(x): -5, rate(y): 0, rate(phi): 0}
    upright = ss.scene(replace(rod(None), name="upright_rod", start=start), mu=1.5)
    for dt in (1e-3, 1e-4):
        r = ss.march(upright, "average_acceleration", dt=dt, t_end=0.22)
        assert (r.status, r.failure) == ("completed", "")
        assert np.allclose(np.abs(r.memory["drag"]), 1.5 * r.memory["floor"], rtol=1e-9, atol=1e-12)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("restitution", [None, 0])
def test_an_explicit_scheme_names_the_painleve_rod_a_step_ahead(restitution: int | None) -> None:
    """Its reactions hold the displacement of the step after the one that fails."""
    r = ss.march(ss.scene(rod(restitution), mu=2, above=0.05), "central_difference", dt=1e-3, t_end=0.2)
    assert r.status == "newton_failed"
    assert np.allclose(r.u[:, 0], -SPEED * r.t)
    assert "friction 'drag' presses contact 'floor' (of y, phi)" in r.failure
    assert f"is {compliance(2):.3g}" in r.failure


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("restitution", [None, 0])
def test_an_explicit_scheme_names_the_painleve_rod_that_starts_on_the_floor(restitution: int | None) -> None:
    """The reactions that hold its first step do not exist; nearly beyond the coefficient of friction they do."""
    r = ss.march(ss.scene(rod(restitution), mu=2), "central_difference", dt=1e-3, t_end=0.02)
    assert (r.status, len(r.u)) == ("newton_failed", 1)
    assert "friction 'drag' presses contact 'floor' (of y, phi)" in r.failure
    close = ss.march(ss.scene(rod(restitution), mu=0.99 * LIMIT), "central_difference", dt=1e-5, t_end=2e-5)
    assert close.memory["floor"][0] == pytest.approx(9.81 / compliance(0.99 * LIMIT), rel=1e-2)
    assert close.memory["drag"][0] == pytest.approx(-0.99 * LIMIT * close.memory["floor"][0])


@pytest.mark.usefixtures("uncompiled")
def test_chosen_steps_name_the_painleve_rod_too() -> None:
    r = ss.march(ss.scene(rod(0), mu=2), "average_acceleration", tol=1e-4, t_end=0.1)
    assert r.status == "step_too_small"
    assert "friction 'drag' presses contact 'floor'" in r.failure


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("restitution", [None, 0])
@pytest.mark.parametrize("name", ["average_acceleration", "backward_euler", "central_difference"])
def test_walls_that_leave_no_room_are_named(name: str, restitution: int | None) -> None:
    gaps = {"left": x + 1 - t, "right": 1 - t - x, "far": x + 9}
    scene = Scene(
        "closing_walls", **POINT, contacts={key: Contact(gap, restitution=restitution) for key, gap in gaps.items()},
        start={x: 0, rate(x): 0.3},
    )  # fmt: skip
    r = ss.march(ss.scene(scene), name, dt=0.01, t_end=1.5)
    assert r.status == "newton_failed"
    assert r.t_failed == pytest.approx(1.0, abs=0.021)
    assert r.t_failed is not None
    assert len(r.t) == round(r.t_failed / 0.01)
    assert "contact 'left' and contact 'right' leave no room in x" in r.failure
    assert ("rates" in r.failure) == (restitution == 0)


@pytest.mark.usefixtures("uncompiled")
def test_walls_with_room_are_not_blamed_where_friction_is() -> None:
    """The rod between a floor and a ceiling, which are opposed, too."""
    between = replace(
        rod(None),
        name="rod_below_a_ceiling",
        contacts={"floor": rod(None).contacts["floor"], "ceiling": Contact(2 - y + sin(phi))},
    )
    r = ss.march(ss.scene(between), "average_acceleration", dt=1e-3, t_end=0.1)
    assert r.status == "newton_failed"
    assert "friction 'drag' presses contact 'floor'" in r.failure


@pytest.mark.parametrize("name", ["average_acceleration", "central_difference"])
def test_a_structure_names_them_alike(name: str) -> None:
    """Where its reactions are not found; those of the rod are, by sticking, so that the failure is put there."""
    c, s = np.cos(ANGLE), np.sin(ANGLE)
    model = ss.structure(
        np.diag([1.0, 1.0, 1 / 3]), np.zeros((3, 3)), names=["x", "y", "phi"], v0=[-SPEED, 0.0, 0.0],
        contacts={"floor": ({"y": 1.0, "phi": -c}, 0.0)}, friction={"drag": ({"x": 1.0, "phi": s}, {"floor": 2.0})},
    )  # fmt: skip
    r = ss.march(model, name, dt=1e-3, t_end=1e-3)
    assert r.failure == ""
    found = replace(r, status="newton_failed", t_failed=2e-3).failure
    assert "contact 'floor' (of 'y', 'phi') harder than sliding relieves it, so that G M^-1 (G - mu T)^T is " in found
    assert f"{compliance(2):.3g}" in found


@pytest.mark.filterwarnings("ignore:central_difference has gained 100%")
def test_a_structure_names_them_where_it_has_gained_energy() -> None:
    c, s = np.cos(ANGLE), np.sin(ANGLE)
    model = ss.structure(
        np.diag([1.0, 1.0, 1 / 3]), np.zeros((3, 3)), names=["x", "y", "phi"], v0=[-SPEED, 0.0, 0.0],
        load=({"y": -9.81}, np.ones_like), contacts={"floor": ({"y": 1.0, "phi": -c}, 0.0)},
        friction={"drag": ({"x": 1.0, "phi": s}, {"floor": 2.0})},
    )  # fmt: skip
    with pytest.warns(UserWarning, match=r"has gained energy: in the step to t = 0.001 s, friction 'drag' presses"):
        ss.march(model, "central_difference", dt=1e-3, t_end=0.02)


@pytest.mark.usefixtures("uncompiled")
def test_a_mass_that_ends_is_named() -> None:
    scene = Scene(
        "ending_mass", coordinates={x: "m", y: "m"}, kinetic=x**2 * rate(x) ** 2 / 2 + rate(y) ** 2 / 2, potential=y,
        parameters=(), start={x: 1, y: 0, rate(x): -1, rate(y): 0}, length=1,
    )  # fmt: skip
    r = ss.march(ss.scene(scene), "central_difference", dt=0.01, t_end=0.7)
    assert (r.status, len(r.t)) == ("newton_failed", 50)
    assert f"the step to t = 0.5 s was not solved: the mass of 'x' has fallen to {r.u[-1, 0] ** 2:.2g} of" in r.failure


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["rk4", "dormand_prince"])
def test_a_mass_that_ends_is_named_where_a_scheme_has_passed_over_it(name: str) -> None:
    """(1 - x) x' = 1 until (1 - x)^2 = 1 - 2 t is 0 at t = 1/2; an explicit scheme goes on, and blows up."""
    scene = Scene(
        "vanishing_mass", coordinates={x: "m", y: "m"}, kinetic=(1 - x) ** 2 * rate(x) ** 2 / 2 + rate(y) ** 2 / 2,
        potential=y, parameters=(), start={x: 0, y: 0, rate(x): 1, rate(y): 0}, length=1,
    )  # fmt: skip
    r = ss.march(ss.scene(scene), name, dt=0.01, t_end=0.7)
    assert r.status == "non_finite"
    assert r.t_failed is not None
    assert (
        f"the step to t = {r.t_failed:.6g} s was not solved: the mass of 'x' has fallen to {(1 - r.u[50, 0]) ** 2:.2g}"
        in (r.failure)
    )
    assert "of that at the start at t = 0.5 s, and is about to be singular" in r.failure
    with pytest.warns(UserWarning, match="noh_bathe has gained energy on vanishing_mass, which conserves it"):
        ss.march(ss.scene(scene), "noh_bathe", dt=0.01, t_end=0.7)


def test_a_coordinate_without_mass_that_constraints_leave_free_is_named() -> None:
    scene = Scene(
        "massless", coordinates={x: "m", y: "m"}, kinetic=rate(x) ** 2 / 2, potential=y**2, constraints={"held": x},
        parameters=(), start={x: 0, y: 0, rate(x): 0, rate(y): 0}, length=1,
    )  # fmt: skip
    with pytest.raises(ValueError, match="that constraints leave free, got none for 'y'; give it one"):
        ss.scene(scene)


def test_a_failure_without_contacts_says_what_to_do() -> None:
    r = replace(ss.march("duffing", "average_acceleration", dt=0.1, t_end=1.0), status="newton_failed", t_failed=1.1)
    assert r.failure == "the step to t = 1.1 s was not solved: take a smaller step"
