"""Constraints beside contacts: a rod pendulum, driven and damped, near a wall, and against one."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from substep_derive import Contact, DeclarationError, Scene, rate, sampled, t
from sympy import Abs, Rational, Symbol, sin
from test_constraints import TAKEN

import substep as ss

x, y = Symbol("x"), Symbol("y")
G = 9.81
LOAD = ss.Harmonic(5.0, 7.0)
# what its forces of rates, or coefficients with M, refuse whether there is a contact or not
REFUSED = {"oess", "gholampour"}


def pendulum(contacts: dict[str, Any]) -> ss.Scene:
    """A point on a rod whose length changes in time, under a load, drag and damping, from (3, -4)/5."""
    length, out = 1 + sin(3 * t) / 10, Rational(3, 10)
    declared = Scene(
        "driven_rod", coordinates={x: "m", y: "m"}, kinetic=(rate(x) ** 2 + rate(y) ** 2) / 2, potential=G * y,
        dissipation=(rate(x) ** 2 + rate(y) ** 2) / 4, forces={x: -rate(x) * Abs(rate(x)) / 3},
        constraints={"rod": (x**2 + y**2 - length**2) / 2}, contacts=contacts, parameters=(), length=1,
        load={x: sampled, y: sampled},
        start={x: Rational(3, 5), y: -Rational(4, 5), rate(x): out * Rational(3, 5), rate(y): -out * Rational(4, 5)},
    )  # fmt: skip
    return ss.scene(declared, load=LOAD)


def exact(t_end: float) -> np.ndarray:
    """Where it is then, by polar coordinates in which the length is given."""

    def rates(time: float, state: np.ndarray) -> list[float]:
        q, w = state
        r, r1 = 1 + math.sin(3 * time) / 10, 0.3 * math.cos(3 * time)
        along, across = np.array([math.sin(q), -math.cos(q)]), np.array([math.cos(q), math.sin(q)])
        v = r1 * along + r * w * across
        load = float(LOAD(np.array([time]))[0])
        force = np.array([load - v[0] / 2 - v[0] * abs(v[0]) / 3, load - v[1] / 2 - G])
        return [w, (force @ across - 2 * r1 * w) / r]

    q = solve_ivp(rates, (0.0, t_end), [math.asin(0.6), 0.0], "DOP853", rtol=1e-13, atol=1e-13).y[0, -1]
    return (1 + math.sin(3 * t_end) / 10) * np.array([math.sin(q), -math.cos(q)])


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("scheme", sorted(set(TAKEN) - REFUSED))
def test_a_wall_that_is_never_met_costs_no_scheme_its_accuracy(scheme: str) -> None:
    """At two steps, so that its order is that without the wall, too."""
    end = exact(1.0)
    for dt in (0.01, 0.005):
        alone, beside = (ss.march(pendulum(c), scheme, dt=dt, t_end=1.0) for c in ({}, {"wall": Contact(x + 5)}))
        off, off_beside = (np.abs(r.u[-1] - end).max() for r in (alone, beside))
        assert off < 1.3 * dt
        assert off_beside < 1.2 * off + 2e-8


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("scheme", ["average_acceleration", "generalized_alpha", "bathe", "three_substep"])
def test_what_is_remembered_of_a_constraint_is_its_multiplier(scheme: str) -> None:
    r = ss.march(pendulum({"wall": Contact(x + 5)}), scheme, dt=0.01, t_end=0.5)
    assert np.allclose(r.memory["rod"], r.multipliers["rod"], rtol=1e-9, atol=1e-9)


def swinging(restitution: Any) -> ss.Scene:
    """A pendulum from (3, -4)/5 at rest that meets a wall at x = -1/5."""
    return ss.scene(Scene(
        "swinging", coordinates={x: "m", y: "m"}, kinetic=(rate(x) ** 2 + rate(y) ** 2) / 2, potential=G * y,
        constraints={"rod": (x**2 + y**2 - 1) / 2}, parameters=(), length=1,
        contacts={"wall": Contact(x + Rational(1, 5), restitution=restitution)},
        start={x: Rational(3, 5), y: -Rational(4, 5), rate(x): 0, rate(y): 0},
    ))  # fmt: skip


def by_events(e: float, t_end: float) -> tuple[list[float], np.ndarray]:
    """When it is hit, and where it is at the end, by its angle from event to event."""
    at, state, times = 0.0, [math.asin(0.6), 0.0], list[float]()

    def gap(_: float, s: np.ndarray) -> float:
        return math.sin(s[0]) + 0.2

    gap.terminal, gap.direction = True, -1  # type: ignore[attr-defined]
    while True:
        found = solve_ivp(lambda _, s: [s[1], -G * math.sin(s[0])], (at, t_end), state, "DOP853", events=gap,
                          rtol=1e-12, atol=1e-13)  # fmt: skip
        q, w = found.y[:, -1]
        if not found.t_events[0].size:
            return times, np.array([math.sin(q), -math.cos(q)])
        at, state = float(found.t[-1]), [math.asin(-0.2), -e * w]
        times.append(at)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("e", [1.0, 0.5])
@pytest.mark.parametrize("scheme", ["average_acceleration", "generalized_alpha"])
def test_impacts_on_a_rod_are_those_of_the_angle(scheme: str, e: float) -> None:
    times, end = by_events(e, 4.0)
    r = ss.march(swinging(Rational(e)), scheme, tol=1e-5, t_end=4.0)
    hits = [h.t for h in r.happenings if h.what == "hits"]
    assert np.allclose(hits, times, rtol=0.0, atol=2e-3)
    assert np.allclose(r.u[-1], end, rtol=0.0, atol=4e-3)
    assert r.statistics is not None
    assert r.statistics.accepted < 1000  # what an impact leaves along the rod does not go on from step to step
    errors = [np.abs(ss.march(swinging(Rational(e)), scheme, dt=4.0 / n, t_end=4.0).u[-1] - end).max()
              for n in (400, 3200)]  # fmt: skip
    assert errors[1] < 0.3 * errors[0] < 0.03  # an impact is known to within a step


@pytest.mark.usefixtures("uncompiled")
def test_no_impact_on_a_rod_gains_energy() -> None:
    """With the pair by default, whatever the phase of the impact in a step."""
    for n in range(80, 112):
        r = ss.march(swinging(Rational(1, 2)), "average_acceleration", dt=1.6 / n, t_end=1.6)
        assert len(r.impacts) == 1
        assert r.energy.max() < r.energy[0] + 1e-9


def test_a_scheme_whose_velocities_leave_what_is_held_is_refused() -> None:
    with pytest.raises(DeclarationError, match=r"gholampour: expected velocities .* multiplied by 1.25 in each step"):
        ss.march(swinging(0), "gholampour", dt=0.01, t_end=0.1)
