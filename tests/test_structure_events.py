"""Structures in chosen steps that end at events: against exact motions and event-driven integration."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from test_constraints import PENDULUM, VERIFY
from test_events import BOUNCING, FALL, G
from test_structure_contacts import by_enumeration

import substep as ss
from substep.structures.examples import plate

Array = np.ndarray


def ball(**more: Any) -> ss.Structure:
    """A mass that falls from 1 m on a floor."""
    given: dict[str, Any] = {"contacts": {"floor": ({0: 1.0}, 0.0)}, "restitution": 0.5, **more}
    return ss.structure(np.eye(1), np.zeros((1, 1)), u0=[1.0], load=([-G], np.ones_like), **given)


def rod(u: Array) -> tuple[float, Array]:
    return (u @ u - 1.0) / 2.0, u.copy()


@pytest.mark.parametrize("name", BOUNCING if VERIFY else BOUNCING[:1])
def test_a_ball_bounces_when_it_should_and_comes_to_rest(name: str) -> None:
    """Each flight lasts half of the one before, until all is over at 1.3546 s."""
    second = min(ss.scheme(name).order or (1,)) > 1
    tol, close = (1e-6, 1e-7) if second else (1e-5, 4e-3)
    r = ss.march(ball(), name, tol=tol, t_end=1.4)
    assert r.status == "completed"
    hits = [x.t for x in r.happenings if x.what == "hits"]
    assert np.allclose(hits[:5], FALL * np.array([1.0, 2.0, 2.5, 2.75, 2.875]), rtol=0.0, atol=close)
    last = r.happenings[-1]
    assert (last.name, last.what) == ("floor", "closes")
    assert last.t == pytest.approx(1.354570922957, abs=2 * close)
    assert abs(r.u[-1, 0]) < 1e-10
    assert r.v[-1, 0] == 0.0
    assert r.memory["floor"][-1] == pytest.approx(G, rel=1e-6)
    if second:
        assert [x.lost for x in r.impacts[:2]] == pytest.approx([0.75 * G, 0.75 * G / 4], rel=1e-5)
        assert r.account.numerical[-1] == pytest.approx(G, rel=1e-5)  # all that impacts have taken


def test_a_chain_of_masses_hits_a_stop_as_event_driven_integration_has_it() -> None:
    """Three masses on springs under a load that jumps; the last hits a stop and gives 0.4 of its speed back."""
    K, e, stop = 30.0 * np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]]), 0.4, 0.21
    P, jump, t_end = np.array([0.0, 1.0, 1.2]), 0.1, 2.0
    t, x, hits = 0.0, np.zeros(6), list[float]()

    def reaches(_: float, x: Array) -> float:
        return float(stop - x[2])

    reaches.terminal, reaches.direction = True, -1  # type: ignore[attr-defined]
    for end in (jump, t_end):
        on = float(end > jump)
        while t < end and len(hits) < 9:
            found = solve_ivp(
                lambda _, x, on=on: np.r_[x[3:], P * on - K @ x[:3]], (t, end), x, rtol=1e-11, atol=1e-13,
                events=reaches, method="DOP853",
            )  # fmt: skip
            t, x = float(found.t[-1]), found.y[:, -1]
            if found.status == 1:
                hits.append(t)
                x[2], x[5] = stop - 1e-14, -e * x[5]
    chain = ss.structure(
        np.eye(3), K, load=(P, ss.Step(1.0, jump)), contacts={"stop": ({2: -1.0}, stop)}, restitution=e,
    )  # fmt: skip
    r = ss.march(chain, "average_acceleration", tol=1e-5, t_end=t_end)
    assert 1 < len(hits) < 9
    seen = [x.t for x in r.happenings if x.what == "hits"]
    assert np.allclose(seen, hits, rtol=0.0, atol=1e-4)
    assert np.allclose(np.r_[r.u[-1], r.v[-1]], x, rtol=0.0, atol=2e-3)
    assert jump in r.t
    assert r.gaps["stop"].min() > -1e-6
    energies = r.energy - r.account.work + r.account.numerical + r.account.residual
    assert np.allclose(energies, 0.0, atol=1e-12)


def test_what_is_held_opens_when_a_load_jumps_or_a_spring_pulls() -> None:
    """At rest on the floor under its weight, lifted by a load from 0.4 s on; and what a spring lifts as it grows."""
    s = ss.structure(
        np.eye(1), np.zeros((1, 1)), load=[([-G], np.ones_like), ([1.0], ss.Step(G + 2.0, 0.4))],
        contacts={"floor": ({0: 1.0}, 0.0)}, restitution=0.0,
    )  # fmt: skip
    r = ss.march(s, "generalized_alpha", tol=1e-6, t_end=1.0)
    assert [(x.t, x.what) for x in r.happenings] == [(pytest.approx(0.4, abs=1e-8), "opens")]
    assert r.u[-1, 0] == pytest.approx(0.6**2, abs=1e-6)
    assert not r.u[r.t < 0.4].any() or abs(r.u[r.t < 0.4]).max() < 1e-9


def test_friction_turns_and_sticks_when_it_should() -> None:
    """About +-0.1 in turn, by half a period of pi each; what friction takes is damped energy."""
    s = ss.structure(np.eye(1), np.eye(1), u0=[1.05], friction={"pad": ([1.0], 0.1)})
    r = ss.march(s, "hht_alpha", tol=1e-4, t_end=16.0)
    turns = [x.t for x in r.happenings if x.what in ("turns", "slides")]
    assert np.allclose(turns, np.pi * np.arange(1, 5), rtol=0.0, atol=5e-3)
    assert r.happenings[-1].what == "sticks"
    assert r.u[-1, 0] == pytest.approx(-0.05, abs=2e-3)
    assert r.account.damped[-1] == pytest.approx(0.5 * (1.05**2 - 0.05**2), rel=5e-3)


@pytest.mark.parametrize("name", ["bathe", "generalized_alpha", "average_acceleration"] if VERIFY else ["bathe"])
def test_a_rod_is_held_in_steps_of_any_length(name: str) -> None:
    s = ss.structure(
        np.eye(2), np.zeros((2, 2)), u0=[1.0, 0.0], load=([0.0, -G], np.ones_like), constraints={"rod": rod}
    )
    r = ss.march(s, name, tol=1e-5, t_end=2.0)
    assert r.status == "completed"
    assert np.abs(r.gaps["rod"]).max() < 1e-14
    assert np.abs(np.sum(r.u * r.v, axis=1)).max() < 1e-13
    assert np.allclose([*r.u[-1], *r.v[-1]], PENDULUM[2.0][:4], rtol=0.0, atol=6e-3)
    assert r.energy[-1] - r.account.work[-1] == pytest.approx(0.0, abs=2e-3 * G)


def test_a_run_goes_on_and_gives_rows_where_they_are_wanted() -> None:
    whole = ss.march(ball(), "average_acceleration", tol=1e-6, t_end=1.2)
    first = ss.march(ball(), "average_acceleration", tol=1e-6, t_end=0.6)
    rest = ss.march(ball(), "average_acceleration", tol=1e-6, t_end=1.2, start=first)
    assert rest.t[0] == first.t[-1]
    assert np.allclose(rest.u[-1], whole.u[-1], rtol=0.0, atol=1e-5)
    assert len(first.happenings) + len(rest.happenings) == len(whole.happenings)
    at = ss.march(ball(), "average_acceleration", tol=1e-6, t_end=1.2, at=[0.5, 0.9])
    flown = 0.5 - FALL
    assert at.u[0, 0] == pytest.approx(G * FALL / 2 * flown - G / 2 * flown**2, abs=1e-4)


def test_what_cannot_be_taken_is_refused_with_the_reason() -> None:
    cases = {
        r"expected a restitution of contact 'floor' of the structure": (ball(restitution=None), "average_acceleration"),
        "which holds those of the next": (ball(), "central_difference"),
        "u, v, a at t_n alone": (ball(contacts={}, restitution=None, friction={"pad": ([1.0], 0.1)}), "bdf2"),
        "expected mass at each degree of freedom": (
            ss.structure(np.diag([1.0, 0.0]), np.eye(2), friction={"pad": ({0: 1.0}, 0.1)}), "average_acceleration",
        ),
    }  # fmt: skip
    for reason, (s, name) in cases.items():
        with pytest.raises(ValueError, match=reason):
            ss.march(s, name, tol=1e-4, t_end=1.0)
    with pytest.raises(ValueError, match="expected no rung"):
        ss.march(ball(), "average_acceleration", tol=1e-4, t_end=1.0, rung=2.0)
    with pytest.raises(ValueError, match="expected stride and save with dt only"):
        ss.march(ball(), "average_acceleration", tol=1e-4, t_end=1.0, save="x")


def test_a_plate_by_scikit_fem_comes_to_rest_on_stops_where_statics_has_it() -> None:
    """Under nodal forces, above two stops of which the nearer one bears: the static problem by trying which do."""
    pytest.importorskip("skfem")
    of = plate(4, side=10.0)
    free = [of.named(k).strip("'") for k in range(of.size)]
    P = np.array([1.0 if name.startswith("w at") else 0.0 for name in free]) * -2e3
    nodes = [free.index(f"w at {at}") for at in ("5 5", "2.5 5")]
    sag, K = np.linalg.solve(of.K.toarray(), P)[nodes], of.K.toarray()
    rows = np.eye(of.size)[nodes]
    gaps = -sag * np.array([0.5, 0.9])
    given: dict[str, Any] = {"load": (P, np.ones_like), "C": ss.rayleigh(0.3, 0.3, at=(15.0, 150.0)), "names": free}
    s = ss.structure(of.M, of.K, contacts={"stops": (rows, gaps)}, **given)
    r = ss.march(s, "backward_euler", dt=0.1, t_end=10.0, account=False)
    W = rows @ np.linalg.solve(K, rows.T)
    p = by_enumeration(gaps + sag, W)
    assert (p > 0.0).sum() == 1
    assert np.allclose(r.memory["stops"][-1], p, rtol=1e-4, atol=1e-4 * p.max())
    assert np.allclose(r.u[-1], np.linalg.solve(K, P + rows.T @ p), rtol=0.0, atol=1e-5 * np.abs(r.u[-1]).max())
    s = ss.structure(of.M, of.K, contacts={"stops": (rows, gaps)}, restitution=0.0, **given)
    hits = ss.march(s, "average_acceleration", tol=1e-2, t_end=0.12)
    free_motion = ss.march(ss.structure(of.M, of.K, **given), "average_acceleration", dt=0.002, t_end=0.12)
    gap = gaps[0] + free_motion.u[:, nodes[0]]
    assert hits.happenings[0].name == "stops"
    assert hits.happenings[0].t == pytest.approx(np.interp(0.0, -gap[:60], free_motion.t[:60]), rel=2e-3)
