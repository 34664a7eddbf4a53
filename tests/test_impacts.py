"""Impacts that a response lists: against the exact ball, balances of momentum and energy, and the same by tol."""

from typing import Any

import numpy as np
import pytest
from scipy import sparse
from test_contact import remembered
from test_structure_contacts import falling

import substep as ss

DT, G, E = 0.001, 9.81, 0.5
FIRST = float(np.sqrt(2 / G))  # s, the first impact of a ball from 1 m
BOUNCING = ("average_acceleration", "newmark", "generalized_alpha")
MOMENTUM = {  # bdf2 has v by differences; central differences end in the middle of a pressure's step
    "average_acceleration": 1e-9, "generalized_alpha": 1e-9, "bathe": 1e-9, "bdf2": 1e-3, "central_difference": 4e-3,
}  # fmt: skip


def exact(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Times of the first n impacts, and the velocities with which the ball meets the floor."""
    speeds = G * FIRST * E ** np.arange(n)
    return FIRST + np.concatenate([[0.0], np.cumsum(2 * speeds[1:] / G)]), speeds


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", BOUNCING)
def test_impacts_of_a_ball_are_the_exact_ones(name: str) -> None:
    r = ss.march("bouncing_ball", name, dt=DT, t_end=3.0)
    found, (times, speeds) = r.impacts[:5], exact(5)
    assert found[0].begin < times[0] <= found[0].t == found[0].end == pytest.approx(found[0].begin + DT)
    assert np.abs(np.array([x.t for x in found]) - times).max() < 5 * DT
    for one, speed in zip(found, speeds, strict=True):
        assert one.name == "floor"
        assert one.row is None
        assert one.before == pytest.approx(-speed, abs=4 * G * DT)
        assert one.after == pytest.approx(-E * one.before)
        assert one.impulse == pytest.approx((1 + E) * speed, abs=8 * G * DT)
        assert one.lost == pytest.approx((1 - E**2) * speed**2 / 2, abs=8 * G * DT * speed)
    assert (r.impacts[-1].end, r.impacts[-1].after) == (pytest.approx(3.0), pytest.approx(0.0, abs=1e-9))
    assert sum(x.impulse for x in r.impacts) == pytest.approx(G * 3.0 + r.v[-1, 0], rel=1e-12)
    assert len(r.impacts) <= 10  # at rest the gap opens and closes by rounding


@pytest.mark.usefixtures("uncompiled")
def test_what_impacts_lose_is_all_that_a_ball_loses_in_a_scheme_that_keeps_energy() -> None:
    r = ss.march("bouncing_ball", "average_acceleration", dt=DT, t_end=1.6)
    assert sum(x.lost for x in r.impacts) == pytest.approx(r.energy[0] - r.energy[-1], rel=1e-9)
    assert str(r.impacts[0]) == (
        "floor: hit within (0.451, 0.452] s, rate of the gap -4.42431 to 2.21215, impulse 6.64627, energy lost 7.3513"
    )


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", MOMENTUM)
def test_impulses_are_what_gravity_and_momentum_say_under_every_scheme(name: str) -> None:
    r = ss.march(ss.scene("two_masses_on_floor", g=10.0), name, dt=0.01, t_end=0.7)
    s = ss.march(falling(), name, dt=0.01, t_end=0.7)
    assert len(r.impacts) > 1
    at_rest = 2 * 10.0 * r.t[-1] + r.v[-1].sum() - r.v[0].sum()
    assert sum(x.impulse for x in r.impacts) == pytest.approx(at_rest, rel=MOMENTUM[name])
    for mine, other in zip(r.impacts, s.impacts, strict=True):  # what is lost differs by numerical damping alone
        assert (mine.t, mine.end) == pytest.approx((other.t, other.end))
        assert np.allclose(mine[5:8], other[5:8], rtol=0.0, atol=1e-8)


@pytest.mark.usefixtures("uncompiled")
def test_an_impact_ends_with_what_a_mass_point_leaves_with() -> None:
    """A pressure that is remembered acts in the step behind its last row too."""
    for scene in (remembered("mass_on_floor"), "mass_on_floor"):
        for phase in (0.0, 0.3, 0.7):
            r = ss.march(ss.scene(scene, u0=0.5 + 0.1 * phase), "average_acceleration", dt=0.1, t_end=1.5)
            (one,) = r.impacts
            assert (one.before, one.after) == (pytest.approx(-1.0), pytest.approx(r.v[-1, 0]))
            assert one.lost == pytest.approx(0.5 - r.v[-1, 0] ** 2 / 2)


@pytest.mark.parametrize("elements", [50, 100])
def test_a_bar_on_a_wall_has_one_impact(elements: int) -> None:
    """Doyen, Ern & Piperno (2011): in contact from 0.5 s to 7/6 s with the pressure 300."""
    n, k, dt = elements, 90.0 * elements, 0.1 / elements
    K = sparse.diags_array((np.r_[k, np.full(n - 1, 2 * k), k], *(np.full(n, -k),) * 2), offsets=(0, 1, -1)).tocsr()
    M = sparse.diags_array(np.r_[0.5, np.ones(n - 1), 0.5] * 10.0 / n).tocsr()
    light = ss.redistributed_mass(M, [0], np.column_stack([np.ones(n + 1), np.linspace(0.0, 10.0, n + 1)]))
    given: dict[str, Any] = {"v0": -10.0, "contacts": {"wall": ({0: 1.0}, 5.0)}}
    r = ss.march(ss.structure(light, K, **given, remembered=True), "average_acceleration", dt=dt, t_end=1.25)
    (one,) = r.impacts
    assert (one.t, one.end) == (pytest.approx(0.5, abs=2 * dt), pytest.approx(7 / 6, abs=0.012))
    assert one.impulse == pytest.approx(200.0, rel=0.012)
    assert abs(one.lost) < 0.05
    r = ss.march(ss.structure(M, K, **given), "average_acceleration", dt=dt, t_end=1.25)
    moved = (M @ (r.v[-1] - r.v[0])).sum()
    assert sum(x.impulse for x in r.impacts) == pytest.approx(moved, rel=1e-9)
    assert r.account is not None
    assert sum(x.lost for x in r.impacts) == pytest.approx(r.account.numerical[-1], rel=1e-6)


def test_rows_of_a_contact_and_contacts_that_are_hit_together() -> None:
    given: dict[str, Any] = {"load": ([-G, -2 * G, -4 * G], np.ones_like), "restitution": 0.5}
    contacts = {"lone": ({2: 1.0}, 0.5), "pair": ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [0.5, 0.8])}
    s = ss.structure(np.diag([1.0, 2.0, 4.0]), np.zeros((3, 3)), contacts=contacts, **given)
    r = ss.march(s, "average_acceleration", dt=0.001, t_end=0.45)
    assert [(x.name, x.row, x.beside) for x in r.impacts] == [
        ("lone", None, ("pair, row 0",)), ("pair", 0, ("lone",)), ("pair", 1, ()),
    ]  # fmt: skip
    lone, first, last = r.impacts
    assert lone.lost == first.lost == pytest.approx(0.75 * 5 / 2 * lone.before**2, rel=0.01)
    assert last.lost == pytest.approx(0.75 * last.before**2, rel=0.01)
    assert lone.impulse == pytest.approx(4 * first.impulse)
    some = ss.march(s, "average_acceleration", dt=0.001, t_end=0.45, dofs=[0], account=False).impacts
    assert [x.impulse for x in some] == [x.impulse for x in r.impacts]
    assert all(np.isnan([x.before, x.after, x.lost]).all() for x in some)


@pytest.mark.usefixtures("plain_in_gate")
def test_a_body_at_rest_on_a_stop_has_no_impact_and_one_thrown_at_it_from_there_has_one() -> None:
    scene = ss.scene("bouncing_ball", u0=0.0, restitution=0.5)
    assert ss.march(scene, "average_acceleration", dt=0.01, t_end=1.0).impacts == ()
    thrown = ss.march(scene, "average_acceleration", dt=0.01, t_end=0.1, start={"t": 0.0, "u": [0.0], "v": [-2.0]})
    assert [(x.begin, x.before) for x in thrown.impacts] == [(0.0, -2.0)]
    scene = ss.scene("bouncing_ball", u0=0.01, restitution=0.9)
    rests = ss.march(scene, "generalized_alpha", dt=0.001, t_end=2.0).impacts  # 0.86 s after its start
    assert [len(rests), *(x.end for x in rests[44:])] == [45, 2.0]
    assert ss.march("duffing", "average_acceleration", dt=0.1, t_end=1.0).impacts == ()


def test_chosen_steps_have_the_impacts_that_happen() -> None:
    r = ss.march("bouncing_ball", "average_acceleration", tol=1e-6, t_end=1.3)
    times, speeds = exact(5)
    assert [x.end for x in r.impacts] == [x.t for x in r.happenings if x.what == "hits"]
    assert np.allclose([x.t for x in r.impacts], times, rtol=0.0, atol=1e-6)
    assert np.allclose([x.lost for x in r.impacts], 0.375 * speeds**2, rtol=1e-5)


def test_rows_that_are_not_of_each_step_are_refused() -> None:
    for given, cure in (
        ({"dt": DT, "stride": 2}, "stride=1"), ({"dt": DT, "at": [0.3, 0.9]}, "without at="),
        ({"tol": 1e-4, "at": [0.3, 0.9]}, "r.happenings"),
    ):  # fmt: skip
        r = ss.march("bouncing_ball", "average_acceleration", t_end=1.0, **given)
        with pytest.raises(ValueError, match=f"expected a row for each step.*{cure}"):
            r.impacts
