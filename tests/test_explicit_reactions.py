"""Contacts and friction under explicit schemes: what rests stays, the bar neither gains nor rings; by hand in NumPy."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from substep_derive import Contact, Friction, Scene, rate
from sympy import Rational, Symbol
from test_constraints import VERIFY
from test_structure_contacts import bar, by_enumeration

import substep as ss

Array = np.ndarray
u, v = Symbol("u"), rate(Symbol("u"))
x, y = Symbol("x"), Symbol("y")


def leapfrog(M: Array, K: Array, f: Array, x: Array, w: Array, h: float, n: int, held: Any) -> tuple[Array, Array]:
    """Displacements and reactions of n steps from x, which w, the mean velocity before, has led to; held: rows, gaps
    and shares of the velocity, nan where a gap itself is kept open."""
    B, gaps, e = held
    found, reactions = [x], [np.zeros(len(gaps))]
    compliance = h * B @ np.linalg.solve(M, B.T)
    for _ in range(n):
        free = w + h * np.linalg.solve(M, f - K @ x)
        opens = np.where(np.isnan(e), B @ free + (gaps + B @ x) / h, B @ free + np.nan_to_num(e) * (B @ w))
        acts = np.isnan(e) | (gaps + B @ (x + h * w) <= 1e-12)
        p = np.zeros(len(gaps))
        if acts.any():
            p[acts] = by_enumeration(opens[acts], compliance[np.ix_(acts, acts)])
        w = free + h * np.linalg.solve(M, B.T @ p)
        x = x + h * w
        found.append(x)
        reactions.append(p)
    return np.array(found), np.array(reactions)


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_random_structures_are_those_by_hand(seed: int, bouncing: bool) -> None:
    """Up to four masses and two stops, thrown at these, under central differences."""
    rng = np.random.default_rng(seed)
    n, d, h, steps = int(rng.integers(2, 5)), int(rng.integers(1, 3)), 0.01, 200
    root, M = rng.normal(size=(n, n)), np.diag(rng.uniform(0.5, 2.0, n))
    K, B = 20.0 * root @ root.T, rng.normal(size=(d, n))
    gaps, v0 = rng.uniform(0.05, 0.3, d), -2.0 * B.T @ rng.uniform(0.3, 1.0, d)
    share = float(rng.uniform(0.0, 1.0)) if bouncing else None
    s = ss.structure(M, K, v0=v0, contacts={"stops": (B, gaps)}, restitution=share)
    r = ss.march(s, "central_difference", dt=h, t_end=h * steps, account=False)
    e = np.full(d, np.nan if share is None else share)
    u, p = leapfrog(M, K, np.zeros(n), r.u[1], r.u[1] / h, h, steps - 1, (B, gaps, e))
    scale = np.abs(u).max()
    assert np.allclose(r.u[1:], u, rtol=0.0, atol=1e-8 * scale)
    assert np.allclose(r.memory["stops"][1:-1], p[1:], rtol=0.0, atol=1e-6 * max(1.0, float(p.max())))


@pytest.mark.parametrize("restitution", [None, 0.0])
@pytest.mark.parametrize("courant", [0.5, 0.9])
def test_central_differences_hold_the_bar_without_energy_and_without_noise(
    restitution: float | None, courant: float
) -> None:
    """Doyen, Ern & Piperno (2011): the pressure is 300; what an explicit scheme holds is its next displacement."""
    n, gap = 100, 5.0
    h = courant * 10.0 / n / 30.0
    struck = bar(n, gap) if restitution is None else bar(n, gap, restitution=restitution)
    r = ss.march(struck, "central_difference", dt=h, t_end=h * round(1.25 / h), dofs=[0, n])
    held = (r.t > 0.55) & (r.t < 1.1)
    assert r.energy.max() <= 500.0 * (1.0 + 1e-9)
    assert r.energy[-1] > 500.0 * (1 - 2 / n)  # the node at the floor loses its own, of two steps where it is entered
    assert r.memory["floor"][held].mean() == pytest.approx(300.0, rel=1e-4)
    assert r.memory["floor"][held].std() < 1.0
    assert r.gaps["floor"].min() >= (-1e-12 if restitution is None else -10.0 * h)  # held itself, or by its rate


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("restitution", [None, 0, Rational(1, 2)])
def test_what_rests_stays_in_central_differences(restitution: Any) -> None:
    """What is held is the mean velocity with which the next displacement is reached; v at t_n moves nothing."""
    ball = Scene(
        "resting_ball", coordinates={u: "m"}, kinetic=v**2 / 2, potential=10 * u,
        contacts={"floor": Contact(u, restitution)}, parameters=(), start={u: 0, v: 0}, length=1,
    )  # fmt: skip
    for name in ("central_difference", "average_acceleration"):
        if name == "central_difference" or restitution is not None:
            r = ss.march(ss.scene(ball), name, dt=0.01, t_end=1.0)
            assert np.abs(r.u).max() < 1e-12
            assert np.allclose(r.memory["floor"][1:], 10.0, rtol=0.0, atol=1e-9)
    falling = ss.scene(replace(ball, name="falling_ball", start={u: 1, v: 0}))
    r = ss.march(falling, "central_difference", dt=0.001, t_end=3.0)
    assert r.u.min() > -10 * 0.001**2
    assert abs(r.u[-1, 0]) < 10 * 0.001**2


@pytest.mark.usefixtures("uncompiled")
def test_a_pad_that_sticks_does_not_creep_under_explicit_schemes() -> None:
    """A block on a slope, at rest, and pulled by less than its friction; and by more, under a constant resultant."""
    for pull, end in ((2, 0.0), (5, 0.5 * 2.0 * 1.5**2)):
        pad = Scene(
            f"pulled_{pull}", coordinates={u: "m"}, kinetic=v**2 / 2, potential=-pull * u,
            frictions={"pad": Friction(u, 3)}, parameters=(), start={u: 0, v: 0}, length=1,
        )  # fmt: skip
        for name in ("central_difference", "beeman", "noh_bathe"):
            r = ss.march(ss.scene(pad), name, dt=0.01, t_end=1.5)
            assert r.u[-1, 0] == pytest.approx(end, rel=1e-12, abs=1e-12)
            assert r.v[-1, 0] == pytest.approx(2 * end / 1.5, rel=1e-12, abs=1e-12)
            assert np.abs(r.memory["pad"]).max() <= 3.0


@pytest.mark.parametrize("phase", np.arange(32) / 32 if VERIFY else [0.0, 0.6])
@pytest.mark.parametrize("name", ["average_acceleration", "central_difference"])
def test_a_bar_bounces_under_gravity_and_never_gains(name: str, phase: float) -> None:
    """Dropped from rest, 5 above the floor, with g = 10 (Doyen, Ern & Piperno 2011): it meets the floor after 1 s."""
    n = 50
    h = 0.9 * 10.0 / n / 30.0
    weights = -10.0 * np.r_[0.5, np.ones(n - 1), 0.5] * 10.0 / n
    dropped = bar(n, 5.0 + 10.0 * h * phase, load=(weights, np.ones_like), v0=0.0)
    r = ss.march(dropped, name, dt=h, t_end=h * round(10.0 / h), dofs=[0, n])
    assert r.account is not None
    assert r.account.numerical.min() > -1e-9
    assert r.account.numerical[-1] < 0.1 * 500.0  # of four impacts
    assert r.impacts[0].t == pytest.approx(np.sqrt(1.0 + 2.0 * h * phase), abs=1.5 * h)
    t, impulses = np.array([(x.t, x.impulse) for x in r.impacts]).T
    bounces = np.add.reduceat(impulses, np.flatnonzero(np.diff(t, prepend=-2.0) > 1.0))  # a bar that still swings ...
    assert len(bounces) == 4  # ... may open and close again within one
    assert (bounces > 220.0).all()  # 200 turn the velocity of 10 round, while 100 N of weight act for 2/3 s
    assert (bounces < 200.0 + 100.0 * 0.72).all()


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["average_acceleration", "central_difference"])
def test_what_rests_under_restitution_stays_closed(name: str) -> None:
    """Two bodies on each other: whether a gap that is 0 closes does not hang on the rounding of its last digit."""
    contacts = {"floor": Contact(x, 0.5), "bodies": Contact(y - x - 0.3, 0.5)}
    scene = Scene(
        "stack", coordinates={x: "m", y: "m"}, kinetic=(rate(x) ** 2 + 2 * rate(y) ** 2) / 2,
        potential=9.81 * (x + 2 * y), contacts=contacts, parameters=(), start={x: 0, y: 0.3, rate(x): 0, rate(y): 0},
        length=1,
    )  # fmt: skip
    stack = ss.structure(
        np.diag([1.0, 2.0]), np.zeros((2, 2)), load=([-9.81, -19.62], np.ones_like), u0=[0.0, 0.3],
        contacts={"floor": ({0: 1.0}, 0.0), "bodies": ({0: -1.0, 1: 1.0}, -0.3)}, restitution=0.5,
    )  # fmt: skip
    for r in (ss.march(ss.scene(scene), name, dt=0.01, t_end=2.0), ss.march(stack, name, dt=0.01, t_end=2.0)):
        assert np.abs(r.u - [0.0, 0.3]).max() < 1e-12
        assert np.allclose(r.memory["floor"][1:], 3 * 9.81, rtol=0.0, atol=1e-9)
        assert np.allclose(r.memory["bodies"][1:], 2 * 9.81, rtol=0.0, atol=1e-9)


@pytest.mark.usefixtures("uncompiled")
def test_friction_acts_from_the_start_on() -> None:
    """A block is thrown along a floor: it stops where it should, to second order, as a scene and as a structure."""
    way = 3.0**2 / (2 * 0.3 * 9.81)
    thrown = ss.structure(
        np.eye(2), np.zeros((2, 2)), v0=[3.0, 0.0], load=([0.0, -9.81], np.ones_like),
        contacts={"floor": ({1: 1.0}, 0.0)}, friction={"drag": ({0: 1.0}, {"floor": 0.3})},
    )  # fmt: skip
    for model in ("sliding_block", thrown):
        r = ss.march(model, "central_difference", dt=0.01, t_end=1.6)
        assert abs(r.u[-1, 0] - way) < 2e-5
        assert r.gaps["floor"].min() == 0.0
        assert abs(r.memory["drag"][0]) == pytest.approx(0.3 * 9.81)
