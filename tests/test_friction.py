"""Impacts that act in their own step alone, restitution and friction: against steps by hand and exact motions."""

from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from scipy.integrate import solve_ivp
from scipy.special import ellipk
from substep_derive import Contact, DeclarationError, Friction, Scene, rate
from substep_derive.step.step import Step
from substep_derive.step.times import drift_at_rest, impulses_last
from sympy import Rational, Symbol, simplify, sqrt
from test_constraints import SLIDING, TAKEN, VERIFY
from test_contact import H, bathe, newmark

import substep as ss

SOME = ["average_acceleration", "bathe", "bdf2"]
DAMPING = {"backward_euler", "theta_method"}  # of first order: they lose energy between impacts and turning points, too
SECOND = [name for name in SLIDING if name not in DAMPING] if VERIFY else [*SOME, "radau_iia2"]
LASTING = [name for name in SECOND if name != "gholampour" and impulses_last(Step.of(BY_NAME[name]))]
u, v = Symbol("u"), rate(Symbol("u"))
# steps of a unit mass without forces over a floor from u, v, with the acceleration 0; and weights of their pressures
BY_HAND = {
    "average_acceleration": (lambda h, x: newmark(h, x, 0.25, 0.5), 0.5),
    "newmark": (lambda h, x: newmark(h, x, 0.3025, 0.6), 0.6),
    "bathe": (bathe, None),
}


def at_rest_after(position: float, limit: float) -> float:
    """Where a unit mass on a unit spring comes to rest, let go at a position: it swings about +-limit in turn."""
    while abs(position) > limit:
        position = 2 * np.copysign(limit, position) - position
    return position


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", BY_HAND)
def test_steps_are_those_written_by_hand(name: str) -> None:
    step, weight = BY_HAND[name]
    given = {"beta": 0.3025, "gamma": 0.6} if name == "newmark" else {}
    for phase in (0.1, 0.55, 0.9):
        scene = ss.scene("mass_on_floor", u0=0.5 + H * phase)
        r = ss.march(scene, ss.scheme(name, **given), dt=H, t_end=1.5)
        x = np.array([scene.u0[0], -1.0, 0.0, 0.0])
        for k in range(1, len(r.t)):
            x = step(H, [*x[:2], 0.0, 0.0])
            assert np.allclose([r.u[k, 0], r.v[k, 0]], x[:2], rtol=0.0, atol=1e-9)
            if weight is not None:
                assert r.memory["floor"][k] == pytest.approx(weight * x[3], abs=1e-9)
        assert np.abs(r.a).max() < 1e-9  # without that of the floor
        impulse = H * r.memory["floor"].sum()
        assert impulse == pytest.approx(r.v[-1, 0] + 1.0, abs=1e-9)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", [*LASTING, "central_difference"])
def test_a_ball_bounces_as_often_and_as_high_as_it_should(name: str) -> None:
    h = 1e-3
    r = ss.march("bouncing_ball", name, dt=h, t_end=1.6)
    struck = r.t[np.flatnonzero(np.diff((r.memory["floor"] > 0.0).astype(int)) == 1) + 1]
    fall = np.sqrt(2 / 9.81)  # s; every flight lasts half of the one before
    times = fall * np.array([1.0, 2.0, 2.5, 2.75, 2.875])
    assert np.allclose(struck[:5], times, rtol=0.0, atol=12 * h)  # of first order
    between = r.energy[np.searchsorted(r.t, (times[:3] + times[1:4]) / 2)]
    assert np.allclose(between, 9.81 * 0.25 ** np.arange(1, 4), rtol=0.1)  # of first order
    assert abs(r.u[-1, 0]) < 2 * h


@pytest.mark.usefixtures("uncompiled")
def test_velocities_after_an_impact_are_the_share_that_is_declared() -> None:
    for e in (Rational(0), Rational(3, 10), Rational(1)):
        ball = Scene(
            "thrown_ball", coordinates={u: "m"}, kinetic=v**2 / 2, potential=0, contacts={"floor": Contact(u, e)},
            parameters=(), start={u: 0.53, v: -1}, length=1,
        )  # fmt: skip
        r = ss.march(ss.scene(ball), "average_acceleration", dt=H, t_end=1.0)
        assert r.v[-1, 0] == pytest.approx(float(e), abs=1e-12)
        assert H * r.memory["floor"].sum() == pytest.approx(1.0 + float(e), abs=1e-12)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", TAKEN if VERIFY else SOME)
def test_a_block_slides_to_where_friction_stops_it(name: str) -> None:
    """v falls with mu g exactly, also where reactions are not remembered; it stops at v0^2/(2 mu g)."""
    h = 0.01
    r = ss.march(ss.scene("sliding_block", g=10.0), name, dt=h, t_end=1.5)
    assert r.status == "completed"
    close = 1e-9 if name in SOME else 0.01
    assert np.allclose(r.v[:90, 0], 3.0 - 3.0 * r.t[:90], rtol=0.0, atol=3 * close)
    assert r.u[-1, 0] == pytest.approx(1.5, abs=2 * h)
    assert np.abs(r.v[-1]).max() < (1e-9 if name in SOME else 10.0 * h)
    assert np.median(r.memory["floor"][1:]) == pytest.approx(10.0, rel=close if name in SOME else 0.1)
    if name in SOME:
        assert np.abs(r.memory["drag"]).max() <= 3.0 + 1e-9


def test_friction_that_does_not_hold_the_velocity_at_the_end_of_a_step_is_refused() -> None:
    """Of Lobatto IIIA the acceleration at the end is that of the start, which is not remembered, and no friction."""
    with pytest.raises(DeclarationError, match=r"^lobatto_iiia3 takes nothing of a constant force at the end.* take "):
        ss.march("friction_oscillator", "lobatto_iiia3", dt=0.05, t_end=1.0)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", [*SECOND, "central_difference"])
def test_an_oscillator_with_friction_comes_to_rest_where_it_should(name: str) -> None:
    found = []
    for h in (0.05, 0.025):
        r = ss.march("friction_oscillator", name, dt=h, t_end=20.0)
        assert np.abs(r.v[-40:]).max() < 1e-3  # it sticks
        assert r.memory["pad"][-1] == pytest.approx(-r.u[-1, 0], abs=2e-3)  # what holds it against the spring
        found.append(abs(r.u[-1, 0] - at_rest_after(1.05, 0.1)))
    assert found[1] < 0.2 * 0.025  # of first order


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["average_acceleration", "generalized_alpha", "central_difference"])
def test_a_pendulum_swings_against_a_wall(name: str) -> None:
    """Its rod is a constraint: it meets the wall below its pivot after a quarter of its period, and then every half."""
    x, y = Symbol("x"), Symbol("y")
    scene = Scene(
        "pendulum_at_a_wall", coordinates={x: "m", y: "m"}, kinetic=(rate(x) ** 2 + rate(y) ** 2) / 2,
        potential=10 * y, constraints={"rod": (x**2 + y**2 - 1) / 2}, contacts={"wall": Contact(x, 1)},
        parameters=(), start={x: sqrt(3) / 2, y: -Rational(1, 2), rate(x): 0, rate(y): 0}, length=1,
    )  # fmt: skip
    quarter = ellipk(np.sin(np.pi / 6) ** 2) / np.sqrt(10)
    r = ss.march(ss.scene(scene), name, dt=2e-3, t_end=3.0)
    assert np.allclose([x.t for x in r.impacts], quarter * np.array([1, 3, 5]), rtol=0.0, atol=6e-3)
    assert np.allclose((r.u**2).sum(axis=1), 1.0, rtol=0.0, atol=1e-14)
    assert r.gaps["wall"].min() > -2e-3 * np.sqrt(10)
    assert r.energy[-1] == pytest.approx(-5.0, abs=1e-4 if name == "central_difference" else 0.3)


@pytest.mark.usefixtures("uncompiled")
def test_a_velocity_of_0_is_not_a_displacement_of_0() -> None:
    """What rests is lifted, by what is derived, where gamma < 2 beta; schemes that let it sink are refused."""
    beta, gamma = Symbol("beta"), Symbol("gamma")
    assert simplify(drift_at_rest(Step.of(BY_NAME["newmark"])) - (2 * beta - gamma) / (2 * gamma)) == 0
    for name in ("average_acceleration", "backward_euler", "energy_momentum"):
        assert drift_at_rest(Step.of(BY_NAME[name])) == 0
    lifts = drift_at_rest(Step.of(BY_NAME["generalized_alpha"])).subs(BY_NAME["generalized_alpha"].typical)
    scene = ss.scene("bouncing_ball", u0=0.0, g=10.0)
    r = ss.march(scene, "generalized_alpha", dt=0.01, t_end=0.01)
    assert r.u[-1, 0] == pytest.approx(float(lifts) * 10.0 * 0.01**2, rel=1e-9)
    with pytest.raises(ValueError, match=r"gholampour lets what rests .* sink into it, by 0.0556 dt\^2 times"):
        ss.march(scene, "gholampour", dt=0.01, t_end=0.1)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("mass", [1e-4, 1e4])
def test_branches_are_found_in_any_unit_of_mass(mass: float) -> None:
    """Accelerations and forces are compared in the choice of a branch: the mass makes them alike."""
    for mu in (0.3, 3.0):
        one, other = (
            ss.march(ss.scene("sliding_block", m=m, mu=mu, w0=0.3), "average_acceleration", dt=0.01, t_end=1.5)
            for m in (1.0, mass)
        )
        assert other.status == "completed"
        assert np.allclose(other.u, one.u, rtol=0.0, atol=1e-9)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("h", [1e-2, 1e-5, 1e-6, 1e-8, 1e-10])
def test_branches_are_found_in_steps_of_any_length(h: float) -> None:
    """In a short step a wrong branch moves u by less than Newton's tolerance, and the velocity of each step by more."""
    pulled = {"u": [0.5], "v": [0.0]}  # by 0.5 N, of which friction holds 0.1
    one = ss.march("friction_oscillator", "average_acceleration", dt=h, t_end=h, start=pulled)
    assert one.v[-1, 0] / h == pytest.approx(-0.4, rel=1e-3)
    assert one.memory["pad"][-1] == pytest.approx(-0.1, rel=1e-12)
    rocking = ss.march("rocking_block", "average_acceleration", dt=h, t_end=h)
    assert rocking.v[-1, 2] / h == pytest.approx(-1.031210, rel=1e-3)
    lanes = ss.sweep(
        "friction_oscillator", "average_acceleration", dt=h, t_end=h, u0=[0.5, 0.05, -0.3], keep="final", progress=False
    )
    assert np.allclose(lanes.v.values[:, 0] / h, [-0.4, 0.0, 0.2], rtol=0.0, atol=1e-3)


@pytest.mark.usefixtures("uncompiled")
def test_a_block_that_rocks_keeps_housners_share_of_its_rate_in_each_impact() -> None:
    """Each impact multiplies the rate by 1 - (3/2) sin(alpha)^2, and between impacts the block turns about a corner."""
    found, g, b, c, phi0 = {}, 9.81, 0.25, 1.0, 0.1
    alpha, radius = np.arctan2(b, c), np.hypot(b, c)
    share = 1 - 1.5 * np.sin(alpha) ** 2
    fall = solve_ivp(
        lambda _, x: [x[1], -3 * g / (4 * radius) * np.sin(alpha - x[0])], (0.0, 2.0), [phi0, 0.0], rtol=1e-11,
        events=lambda _, x: x[0], dense_output=True,
    )  # fmt: skip
    (first,), (before,) = fall.t_events[0], fall.y_events[0][:, 1]
    for h in (0.004, 0.001):
        r = ss.march("rocking_block", "average_acceleration", dt=h, t_end=0.6)
        assert r.status == "completed"
        early = r.t < first - h
        angle = np.abs(r.u[early, 2] - fall.sol(r.t[early])[0]).max()
        left = r.memory["left"] > 0
        after = r.v[np.flatnonzero(r.u[:, 2] < 0)[0] + 1, 2]
        found[h] = angle, abs(after / before / share - 1)
        assert left[3 : np.flatnonzero(early)[-1]].all()
        assert np.abs(r.memory["left_drag"]).max() < r.memory["left"].max()
    coarse, fine = found.values()
    assert fine[0] < 0.3 * coarse[0] < 0.6e-4  # of first order: reactions of gaps that bend are so
    assert fine[1] < 0.5 * coarse[1] < 0.0125


@pytest.mark.usefixtures("uncompiled")
def test_a_block_rides_on_a_belt_until_the_spring_pulls_it_off() -> None:
    r = ss.march(ss.scene("friction_oscillator", limit=0.3, belt=0.2, u0=0.0, v0=0.2), "bathe", dt=0.01, t_end=10.0)
    exact = np.where(r.t < 1.5, 0.2 * r.t, 0.3 + 0.2 * np.sin(r.t - 1.5))
    assert np.abs(r.u[:, 0] - exact).max() < 2e-3


def test_what_cannot_be_taken_is_refused_with_the_reason() -> None:
    given: dict[str, Any] = {
        "coordinates": {u: "m"}, "kinetic": v**2 / 2, "potential": u, "parameters": (), "start": {u: 1, v: 0},
        "length": 1,
    }  # fmt: skip
    for name in ("bathe", "bdf2", "rho_inf_bathe"):
        with pytest.raises(DeclarationError, match="does not keep the velocity that an impact leaves"):
            ss.march("bouncing_ball", name, dt=H, t_end=1.0)
    with pytest.raises(DeclarationError, match="rk4: expected each balance to move the velocity"):
        ss.march("friction_oscillator", "rk4", dt=H, t_end=1.0)
    with pytest.raises(DeclarationError, match="takes no force at the end of its steps"):
        ss.march("friction_oscillator", "wilson_theta", dt=H, t_end=1.0)
    with pytest.raises(DeclarationError, match="restitution from 0 to 1 for contact floor, got 2"):
        Scene("springy", **given, contacts={"floor": Contact(u, 2)})
    with pytest.raises(DeclarationError, match="got both; an impact acts once"):
        Scene("both", **given, contacts={"floor": Contact(u, 1, remembered=True)})
    with pytest.raises(DeclarationError, match="that are all remembered, without friction"):
        Scene("mixed", **given, contacts={"floor": Contact(u, remembered=True)}, frictions={"pad": Friction(u, 1)})
    with pytest.raises(DeclarationError, match="limit of friction pad that is linear in pressures"):
        Scene("square", **given, contacts={"floor": u}, frictions={"pad": Friction(u, Symbol("floor") ** 2)})
    with pytest.raises(DeclarationError, match="friction pad to depend on coordinates"):
        Scene("nothing", **given, frictions={"pad": Friction(Symbol("t"), 1)})
    with pytest.raises(DeclarationError, match="limit of friction pad holds 'wall'"):
        Scene("unknown", **given, frictions={"pad": Friction(u, Symbol("wall"))})


def test_what_friction_takes_is_accounted_for() -> None:
    """A block with 4.5 J slides until they are gone, against 0.3*9.81 N; a swing on a pad loses its energy there."""
    block = ss.march("sliding_block", "average_acceleration", dt=1e-3, t_end=2.0)
    power = block.power_of_each["friction drag"]
    slides = block.v[:, 0] > 1e-3
    assert np.allclose(power[slides], -0.3 * 9.81 * block.v[slides, 0], rtol=1e-9)
    assert np.trapezoid(power, block.t) == pytest.approx(-4.5, abs=1e-5)
    with pytest.raises(ValueError, match=r"without contacts .* got floor, .* r.impacts says .* r.powers"):
        _ = block.numerical
    swing = ss.march("friction_oscillator", "average_acceleration", dt=1e-3, t_end=4.0)
    assert list(swing.powers) == ["friction"]
    limit, way = 0.1, np.abs(np.diff(swing.u[:, 0])).sum()
    lost = swing.energy[0] - swing.energy[-1]
    assert lost == pytest.approx(limit * way, abs=1e-6)
    assert -np.trapezoid(swing.powers["friction"], swing.t) == pytest.approx(lost, rel=2e-4)
    assert np.abs(swing.numerical).max() < 2e-4 * lost


def test_a_belt_gives_power_to_what_it_drags() -> None:
    """A block at rest on a belt that moves at 2 m/s is dragged by 0.5 N until it has come along."""
    belt = Scene(
        "belt", coordinates={u: "m"}, kinetic=v**2 / 2, potential=0, parameters=(), start={u: 0, v: 0}, length=1,
        frictions={"belt": Friction(along=u - 2 * Symbol("t"), limit=Rational(1, 2))},
    )  # fmt: skip
    r = ss.march(ss.scene(belt), "average_acceleration", dt=1e-3, t_end=3.0)
    assert np.allclose(r.power_of_each["friction belt"], 0.5 * r.v[:, 0], atol=1e-12)
    assert np.abs(r.numerical).max() < 1e-9
