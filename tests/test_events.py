"""Chosen steps that end at events: against exact motions and event-driven integration, and what is refused."""

from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.special import ellipk
from substep_derive import Constraint, Contact, Friction, Scene, optional, rate, sampled
from substep_derive import t as time
from substep_derive.declare.parameter import REAL
from sympy import Interval, Rational, Symbol, sin
from test_constraints import NEXT, PENDULUM, TAKEN, VERIFY
from test_friction import LASTING

import substep as ss

Array = np.ndarray
G = 9.81
# whose step may change; Lobatto IIIC goes on through the stop in the step of an impact, and rests a little inside
BOUNCING = [name for name in LASTING if name in TAKEN and {*ss.scheme(name).state} <= {"u", "h*v", "h^2*a"}]
FALL = np.sqrt(2 / G)  # s, of the ball's first fall from 1 m; each flight lasts half of the one before
u, v, e, k, b = Symbol("u"), rate(Symbol("u")), Symbol("e"), Symbol("k"), Symbol("b")


def events(r: ss.Response) -> list[tuple[float, str]]:
    return [(x.t, x.what) for x in r.happenings]


def stopped(stiffness: float, stop: float, share: float, load: Any = None) -> Any:
    """A unit mass on a spring, with a stop that gives back a share of the velocity."""
    return ss.scene(STOPPED if load is None else PUSHED, k=stiffness, b=stop, e=share, load=load)


STOPPED, PUSHED = (
    Scene(
        name, coordinates={u: "m"}, kinetic=v**2 / 2, potential=k * u**2 / 2, load=load,
        contacts={"stop": Contact(b - u, e)}, start={u: -1, v: 0}, length=1,
        parameters=(optional(k, 1), optional(b, 0, REAL), optional(e, 0, Interval(0, 1))),
    )
    for name, load in (("stopped", {}), ("pushed", {u: sampled}))
)  # fmt: skip


def by_events(stiffness: float, stop: float, share: float, t_end: float, load: Any = None) -> tuple[list[float], Array]:
    """When the mass hits the stop, and u, v at the end."""
    t, x, hits = 0.0, [-1.0, 0.0], list[float]()

    def at_stop(_: float, x: Array) -> float:
        return float(stop - x[0])

    at_stop.terminal, at_stop.direction = True, -1  # type: ignore[attr-defined]
    while t < t_end and len(hits) < 13:  # the spring may hold the mass to the stop, after more and more of them
        found = solve_ivp(
            lambda s, x: [x[1], -stiffness * x[0] + (load(s) if load else 0.0)], (t, t_end), x, rtol=1e-12, atol=1e-13,
            events=at_stop, max_step=0.1,
        )  # fmt: skip
        t, x = float(found.t[-1]), found.y[:, -1]
        if found.status == 1:
            hits.append(t)
            x = [stop - 1e-15, -share * x[1]]
    return hits, np.array(x)


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize("name", BOUNCING if VERIFY else BOUNCING[:1])
def test_a_ball_bounces_when_it_should_and_comes_to_rest(name: str) -> None:
    """Impacts at 0.4515, 0.9030, 1.1288, ... s, of which there are more and more, until all is over at 1.3546 s."""
    order = min(ss.scheme(name).order or (1,))
    for tol, close in ((1e-4, 3e-6), (1e-6, 1e-7)) if order > 1 else ((1e-5, 4e-3),):
        r = ss.march("bouncing_ball", name, tol=tol, t_end=1.6)
        assert r.status == "completed"
        hits = [t for t, what in events(r) if what == "hits"]
        assert np.allclose(hits[:5], FALL * np.array([1.0, 2.0, 2.5, 2.75, 2.875]), rtol=0.0, atol=close)
        assert events(r)[-1][1] == "closes"
        assert events(r)[-1][0] == pytest.approx(1.354570922957, abs=2 * close)
        assert abs(r.u[-1, 0]) < 1e-12
        assert r.v[-1, 0] == 0.0
        assert r.memory["floor"][-1] == pytest.approx(G, rel=1e-6)
        between = r.energy[np.searchsorted(r.t, np.array([1.5, 2.25]) * FALL)]
        assert np.allclose(between, [G / 4, G / 16], rtol=10 * close)


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize(
    "name", ["average_acceleration", "generalized_alpha", "hht_alpha"] if VERIFY else ["hht_alpha"]
)
def test_a_block_turns_and_stops_where_friction_has_it(name: str) -> None:
    errors = list[float]()
    for tol in (1e-4, 1e-6):
        r = ss.march("friction_oscillator", name, tol=tol, t_end=20.0)
        assert [what for _, what in events(r) if what != "slides"][-1] == "sticks"
        assert sum(what in ("turns", "slides") for _, what in events(r)) == 4
        turns = np.array([t for t, what in events(r) if what in ("turns", "slides")])
        errors.append(float(np.abs(turns - np.pi * np.arange(1, 5)).max()))
        assert r.u[-1, 0] == pytest.approx(-0.05, abs=3 * tol ** (2 / 3))
        assert abs(r.v[-1, 0]) < 1e-15
    assert errors[0] < 5e-3
    assert errors[1] < 0.1 * errors[0]


@pytest.mark.usefixtures("plain_in_gate")
def test_a_block_rides_on_a_belt_and_slides_when_the_spring_pulls_it_off() -> None:
    r = ss.march(ss.scene("friction_oscillator", belt=0.2, u0=0.0, v0=0.2), "average_acceleration", tol=1e-6, t_end=1.0)
    ((t, what),) = events(r)
    assert what == "slides"
    assert t == pytest.approx(0.5, abs=1e-5)  # 0.1 N of a unit spring at 0.2 m/s
    at = r.t[-1] - 0.5
    assert r.u[-1, 0] == pytest.approx(0.1 + 0.2 * np.sin(at), abs=1e-5)


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize("name", BOUNCING if VERIFY else BOUNCING[:1])
def test_a_pendulum_meets_a_wall_when_elliptic_integrals_say(name: str) -> None:
    """At the lowest point: each swing to it and back has sin(amplitude/2) = 1/2 of the one before."""
    swings = np.sin(0.5) * 0.5 ** np.arange(4)
    quarters = ellipk(swings**2) / np.sqrt(G)
    impacts = quarters[0] + 2 * np.cumsum([0.0, *quarters[1:]])
    first_order = min(ss.scheme(name).order or (1,)) < 2
    r = ss.march("pendulum_at_wall", name, tol=1e-4 if first_order else 1e-7, t_end=3.7)
    assert [what for _, what in events(r)] == ["hits"] * 4
    assert np.allclose([t for t, _ in events(r)], impacts, rtol=0.0, atol=4e-2 if first_order else 5e-5)
    if not first_order:
        assert np.allclose([x.before for x in r.impacts], -2 * np.sqrt(G) * swings, rtol=1e-4)
        assert r.energy[-1] == pytest.approx(G * (2 * (swings[-1] / 2) ** 2 - 1), rel=1e-6)


def test_a_block_rocks_as_housner_has_it() -> None:
    """About corners by pendulum equations; impacts keep 1 - (3/2) sin(alpha)^2 of the rate, when they should."""
    alpha, radius = np.arctan2(0.25, 1.0), np.hypot(0.25, 1.0)
    t, x, impacts = 0.0, [0.1, 0.0], list[float]()
    for side in (1, -1, 1):

        def flat(_: float, x: Array) -> float:
            return float(x[0])

        flat.terminal, flat.direction = True, -side  # type: ignore[attr-defined]
        found = solve_ivp(
            lambda _, x, side=side: [x[1], -3 * G / (4 * radius) * np.sin(side * alpha - x[0])], (t, 3.0), x,
            rtol=1e-11, atol=1e-13, events=flat,
        )  # fmt: skip
        t, x = float(found.t[-1]), [0.0, found.y[1, -1] * (1 - 1.5 * np.sin(alpha) ** 2)]
        impacts.append(t)
    r = ss.march("rocking_block", "average_acceleration", tol=1e-6, t_end=2.0)
    closes = np.array([x.t for x in r.happenings if x.what == "closes"])
    assert [x.name for x in r.happenings if x.what == "closes"] == ["right", "left", "right"]
    assert np.allclose(closes, impacts, rtol=0.0, atol=3e-3)  # reactions of gaps that turn are of first order
    assert min(gap.min() for gap in r.gaps.values()) > -1e-6


@pytest.mark.thorough
@settings(max_examples=10)
@given(st.floats(0.5, 30.0), st.floats(-0.3, 0.6), st.floats(0.05, 0.9))
def test_impacts_of_any_oscillator_are_those_of_event_driven_integration(w: float, stop: float, share: float) -> None:
    hits, end = by_events(w, stop, share, 3.0)
    found = [b - a for a, b in pairwise(hits)]
    if len(hits) > 12 or min(found, default=1.0) < 0.05:  # rather at rest: the ball has that
        return
    r = ss.march(stopped(w, stop, share), "average_acceleration", tol=1e-7, t_end=3.0)
    assert r.status == "completed"
    seen = [t for t, what in events(r) if what in ("hits", "closes")]
    assert len(seen) == len(hits)
    slower = share ** np.arange(len(hits))  # each flight, by which an error of u is a longer error of time
    assert (np.abs(np.array(seen) - hits) * slower < 2e-5).all()
    assert np.allclose([r.u[-1, 0], r.v[-1, 0]], end, rtol=0.0, atol=1e-3)
    assert (stop - r.u[:, 0]).min() > -1e-7


@pytest.mark.thorough
@pytest.mark.parametrize("load", [ss.Step(0.6, 0.7), ss.HalfSine(2.0, 1.3), ss.Record(0.25, np.sin(np.arange(9.0)))])
def test_steps_end_where_a_load_jumps_or_bends_as_well(load: Any) -> None:
    hits, end = by_events(4.0, 0.3, 0.6, 2.5, lambda t: float(load(np.array([t]))[0]))
    scene = stopped(4.0, 0.3, 0.6, load)
    for name in ("average_acceleration", "generalized_alpha"):
        r = ss.march(scene, name, tol=1e-7, t_end=2.5)
        assert np.allclose([t for t, what in events(r) if what == "hits"], hits, rtol=0.0, atol=1e-4)
        assert np.allclose([r.u[-1, 0], r.v[-1, 0]], end, rtol=0.0, atol=2e-4)
        jumps = [0.7] if isinstance(load, ss.Step) else [1.3] if isinstance(load, ss.HalfSine) else [0.25, 1.75]
        assert set(jumps) <= set(np.round(r.t, 12))


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize(
    "name",
    ["generalized_alpha", "bathe", "newmark_bdf2", "rho_inf_bathe", "average_acceleration"] if VERIFY else ["bathe"],
)
def test_a_rod_is_held_in_steps_of_any_length(name: str) -> None:
    errors = list[float]()
    for tol in (1e-4, 1e-5):
        r = ss.march(ss.scene("rod_pendulum", L=1.0, m=1.0, v0=0.0, g=G), name, tol=tol, t_end=2.0)
        assert r.status == "completed"
        assert r.happenings == ()
        assert np.abs(np.hypot(*r.u.T) - 1.0).max() < 1e-13
        errors.append(float(np.abs([*(r.u[-1] - PENDULUM[2.0][:2]), *(r.v[-1] - PENDULUM[2.0][2:4])]).max()))
        assert r.statistics is not None
        assert r.statistics.accepted == len(r.t) - 1
        assert r.multipliers["rod"][-1] == pytest.approx(PENDULUM[2.0][4], abs=6 * errors[-1])
    assert errors[0] < 15e-3
    assert errors[1] < 0.3 * errors[0]  # tol to the 2/3


@pytest.mark.usefixtures("plain_in_gate")
def test_what_does_not_damp_errors_along_a_constraint_is_held_there() -> None:
    """The trapezoidal rule multiplies what a constraint's velocity has wrong by the number of steps."""
    r = ss.march(ss.scene("rod_pendulum", L=1.0, m=1.0, v0=0.0, g=G), "average_acceleration", tol=1e-6, t_end=2.0)
    assert np.allclose([*r.u[-1], *r.v[-1]], PENDULUM[2.0][:4], rtol=0.0, atol=1e-3)
    assert np.abs(np.sum(r.u * r.v, axis=1)).max() < 1e-13
    ends = list[Any]()
    for m in (1.0, 1e-8, 1e8):  # which moves nothing here
        one = ss.scene("rod_pendulum", L=1.0, m=m, v0=0.0, g=G)
        ends.append(ss.march(one, "average_acceleration", tol=1e-3, t_end=0.5).u[-1])
    assert np.allclose(ends, ends[0], rtol=0.0, atol=1e-9)
    x, y = Symbol("x"), Symbol("y")
    swing = Scene(
        "swing", coordinates={x: "m", y: "m"}, kinetic=(rate(x) ** 2 + rate(y) ** 2) / 2, potential=G * y,
        constraints={"rod": Constraint((x**2 + y**2 - 1) / 2, level="velocity", projected=True)}, parameters=(),
        start={x: 1, y: 0, rate(x): 0, rate(y): 0}, length=1,
    )  # fmt: skip
    r = ss.march(ss.scene(swing), "average_acceleration", tol=1e-6, t_end=2.0)
    assert np.allclose([*r.u[-1], *r.v[-1]], PENDULUM[2.0][:4], rtol=0.0, atol=1e-3)  # tol to the 2/3


@pytest.mark.usefixtures("plain_in_gate")
def test_rows_where_they_are_wanted_and_runs_that_go_on() -> None:
    times = np.array([0.1, 0.5, 0.9, 1.2])
    whole = ss.march("bouncing_ball", "average_acceleration", tol=1e-7, t_end=1.2)
    gridded = ss.march("bouncing_ball", "average_acceleration", tol=1e-7, t_end=1.2, grid=times)
    assert np.array_equal(gridded.t, times)
    assert len(gridded.happenings) == len(whole.happenings)
    flown = times[1] - FALL
    assert gridded.u[1, 0] == pytest.approx(G * FALL / 2 * flown - G / 2 * flown**2, abs=1e-6)
    first = ss.march("bouncing_ball", "average_acceleration", tol=1e-7, t_end=0.6)
    rest = ss.march("bouncing_ball", "average_acceleration", tol=1e-7, t_end=1.2, start=first)
    assert rest.t[0] == first.t[-1]
    assert np.allclose(rest.u[-1], whole.u[-1], rtol=0.0, atol=1e-6)
    until = ss.march("bouncing_ball", "average_acceleration", tol=1e-7, t_end=1.2, until=lambda _t, u, _v: u[0] - 0.5)
    assert until.t[-1] == pytest.approx(np.sqrt(1.0 / G), abs=1e-6)
    late = {"t": 1e6, "u": [1.0], "v": [0.0]}
    falls = ss.march("bouncing_ball", "average_acceleration", tol=1e-7, t_end=1e6 + 1.2, start=late)
    assert np.allclose([x.t - 1e6 for x in falls.happenings], [x.t for x in whole.happenings], rtol=0.0, atol=1e-6)
    bounded = ss.march("bouncing_ball", "average_acceleration", tol=1e-7, t_end=1.2, energy_bound=5.0)
    assert (bounded.status, len(bounded.t)) == ("energy_bound", 1)


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize("keep", ["final", "peak", "history"])
def test_sweeps_in_steps_that_end_at_events_are_the_runs_one_by_one(keep: Any) -> None:
    """Of balls that have bounced once or not at all, from several heights."""
    heights, back, grid = [0.5, 1.0, 2.5], [0.0, 0.6], np.linspace(0.0, 0.5, 6)
    more = {"grid": grid} if keep == "history" else {}
    found = ss.sweep(
        "bouncing_ball", "average_acceleration", tol=1e-8, t_end=0.5, keep=keep, u0=heights, restitution=back, **more
    )
    for h0, e0 in product(heights, back):
        run = found.sel(u0=h0, restitution=e0)
        r = ss.march(
            ss.scene("bouncing_ball", u0=h0, restitution=e0), "average_acceleration", tol=1e-8, t_end=0.5, **more
        )
        assert run["status"] == 0
        assert r.statistics is not None
        counts = r.statistics.accepted, r.statistics.rejected
        assert (run["accepted"].item(), run["rejected"].item()) == counts
        fall = np.sqrt(2 * h0 / G)
        bounced = [
            h0 - G * t**2 / 2 if t < fall else e0 * G * fall * (t - fall) - G * (t - fall) ** 2 / 2 for t in grid
        ]
        height = np.maximum(bounced, 0.0)
        if keep == "history":
            np.testing.assert_array_equal(run["u"], r.u)
            np.testing.assert_allclose(run["u"][:, 0], height, atol=1e-6)
            np.testing.assert_array_equal(run["memory"], r.memories)
        elif keep == "final":
            np.testing.assert_array_equal(run["u"], r.u[-1])
            np.testing.assert_allclose(run["u"][0], height[-1], atol=1e-6)
        else:
            np.testing.assert_allclose(run["peak_v"][0], G * min(fall, 0.5), rtol=1e-6)
            np.testing.assert_allclose(run["peak_energy"], G * h0, rtol=1e-6)


@pytest.mark.usefixtures("plain_in_gate")
def test_sweeps_that_cannot_end_at_events_are_refused_before_any_run() -> None:
    with pytest.raises(ValueError, match="expected no rung on bouncing_ball"):
        ss.sweep("bouncing_ball", "average_acceleration", tol=1e-6, t_end=0.5, rung=1.5, restitution=[0.2, 0.4])
    with pytest.raises(ValueError, match="whose state is u, v, a at t_n alone"):
        ss.sweep("rod_pendulum", "bdf2", tol=1e-6, t_end=0.5, L=[1.0, 2.0])
    with pytest.raises(ValueError, match="expected grid="):
        ss.sweep("bouncing_ball", "average_acceleration", tol=1e-6, t_end=0.5, keep="history", restitution=[0.2, 0.4])


@pytest.mark.usefixtures("plain_in_gate")
def test_what_cannot_be_taken_is_refused_with_the_reason() -> None:
    with pytest.raises(ValueError, match=r"expected a restitution of contact 'floor' of mass_on_floor"):
        ss.march("mass_on_floor", "average_acceleration", tol=1e-4, t_end=1.0)
    for name in ("bdf2", "park"):
        with pytest.raises(ValueError, match=r"expected a scheme whose state is u, v, a at t_n alone"):
            ss.march("rod_pendulum", name, tol=1e-4, t_end=1.0)
    assert "central_difference" in NEXT
    with pytest.raises(ValueError, match="which holds those of the next"):
        ss.march("rod_pendulum", "central_difference", tol=1e-4, t_end=1.0)
    with pytest.raises(ValueError, match="expected no rung on bouncing_ball"):
        ss.march("bouncing_ball", "average_acceleration", tol=1e-4, t_end=1.0, rung=2.0)


@pytest.mark.usefixtures("plain_in_gate")
def test_a_sliding_block_with_a_restitution_of_0_stops_where_it_should() -> None:
    x, y = Symbol("x"), Symbol("y")
    block = Scene(
        "thrown_block", coordinates={x: "m", y: "m"}, kinetic=(rate(x) ** 2 + rate(y) ** 2) / 2, potential=10 * y,
        contacts={"floor": Contact(y, 0)}, frictions={"drag": Friction(x, Symbol("floor") * 3 / 10)}, parameters=(),
        start={x: 0, y: 0.05, rate(x): 3, rate(y): 0}, length=1,
    )  # fmt: skip
    r = ss.march(ss.scene(block), "average_acceleration", tol=1e-6, t_end=1.5)
    after = 3.0 - 0.3  # of an impact at 1 m/s, whose friction takes 0.3 of the impulse
    assert r.u[-1, 0] == pytest.approx(0.3 + after**2 / 6, abs=1e-5)
    assert [what for _, what in events(r) if what in ("closes", "sticks")] == ["closes", "sticks"]
    assert r.happenings[0].t == pytest.approx(0.1, abs=1e-6)
    assert r.happenings[-1].t == pytest.approx(0.1 + after / 3, abs=1e-5)


@pytest.mark.usefixtures("plain_in_gate")
def test_what_lets_go_within_a_step_is_not_passed_over() -> None:
    """A mass on a stop under a load that lifts it for a part of each period, and on a floor that vibrates under it.

    What is held moves as it should in steps of any length: only its reaction says that they are too long.
    """
    lifted = Scene(
        "lifted", coordinates={u: "m"}, kinetic=v**2 / 2, potential=0 * u, parameters=(), start={u: 0, v: 0}, length=1,
        load={u: 10 * sin(20 * time) - 8}, contacts={"stop": Contact(u, restitution=0)},
    )  # fmt: skip
    begin = np.arcsin(0.8) / 20  # of each period; it comes down before the next, and is where the last began 0.75 s on
    last = begin + 4 * np.pi / 20
    t = 0.75
    expected = (np.cos(20 * last) / 2) * (t - last) - (np.sin(20 * t) - np.sin(20 * last)) / 40 - 4 * (t - last) ** 2
    for tol, within in ((1e-3, 2e-4), (1e-5, 1e-5), (1e-8, 2e-7)):
        r = ss.march(ss.scene(lifted), "average_acceleration", tol=tol, t_end=t)
        assert [what for _, what in events(r)] == ["opens", "closes", "opens", "closes", "opens"]
        assert r.u[-1, 0] == pytest.approx(expected, abs=within)
    shaken = Scene(
        "shaken", coordinates={u: "m"}, kinetic=v**2 / 2, potential=Rational(981, 100) * u, parameters=(),
        start={u: 0, v: 1}, length=1, contacts={"floor": Contact(u - sin(20 * time) / 20, restitution=0)},
    )  # fmt: skip
    r = ss.march(ss.scene(shaken), "average_acceleration", tol=1e-4, t_end=1.5)
    opens = [at for at, what in events(r) if what == "opens"]
    lifts = np.arcsin(9.81 / 20) / 20 + np.pi / 10 * np.arange(5)  # where the floor begins to fall by more than g
    assert np.allclose(opens, lifts, rtol=0.0, atol=1e-4)


@pytest.mark.usefixtures("plain_in_gate")
def test_what_friction_holds_at_rest_is_marched() -> None:
    """A structure that nothing moves, whose velocities have no scale of their own; then one that a load drags along."""
    pad = {"pad": ({0: 1.0}, 8.0)}
    for K in (100.0, 0.0):
        held = ss.structure([[1.0]], [[K]], load=({0: 3.0}, np.ones_like), friction=pad)
        r = ss.march(held, "average_acceleration", tol=1e-4, t_end=1.0)
        assert r.status == "completed"
        assert np.abs(r.u).max() < 1e-15
    dragged = ss.structure([[1.0]], [[0.0]], load=({0: 10.0}, lambda t: np.sin(20 * t)), friction=pad)
    r = ss.march(dragged, "average_acceleration", tol=1e-5, t_end=0.3)
    assert [what for _, what in events(r)][:3] == ["slides", "sticks", "slides"]
    assert events(r)[0][0] == pytest.approx(np.arcsin(0.8) / 20, abs=1e-5)
