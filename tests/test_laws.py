"""Laws with memory on every scheme: published numbers, exact motions, plain stepping, lanes, going on, energy."""

import os
from dataclasses import replace
from functools import cache
from types import ModuleType
from typing import Any

import committed_steps
import hysteresis
import numpy as np
import pytest
from declared import BY_NAME
from hysteresis import Oscillator, exact, half_sine, integrated, record, sine
from plain_kernels import text_of, uncompiled
from substep_derive.declare.scenes.hysteretic import bilinear
from sympy import Integer

import substep as ss
from substep.core import threads
from substep.derived.modules import uncommitted_pair
from substep.marching import scene_lanes

VERIFY = bool(os.environ.get("SUBSTEP_VERIFY"))
DISCRETE = {"energy_momentum"}  # takes the force of a potential
MARCHED = [name for name in ss.schemes() if name not in DISCRETE]
# the scene for schemes of u'' = g(t, u), which refuse any that declares a damper
UNDAMPED = replace(
    bilinear,
    name="undamped_hysteretic",
    dissipation=Integer(0),
    parameters=tuple(p for p in bilinear.parameters if p.name != "xi"),
)
OMEGA = 2 * np.pi


@cache
def kernels(scheme: str, scene: str) -> ModuleType:
    return uncompiled(text_of(uncommitted_pair(scheme, UNDAMPED if scene == UNDAMPED.name else scene)))


@pytest.fixture
def plainly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels as plain Python functions, made once for each pair."""
    monkeypatch.setattr(scene_lanes, "pair_kernels", lambda scene, scheme: kernels(scheme.name, scene.name))
    monkeypatch.setattr(threads, "cores", lambda: 1)


def scene(of: Oscillator, scheme: str, load: Any = None, u: float = 0.0, v: float = 0.0) -> ss.Scene:
    """The oscillator as a scene that the scheme takes."""
    given = {"omega": of.omega, "strength": of.strength, "hardening": of.alpha, "u0": u, "v0": v, "load": load}
    if not BY_NAME[scheme].takes_damping:
        assert of.xi == 0
        return ss.scene(UNDAMPED, **given)
    return ss.scene("hysteretic_oscillator", xi=of.xi, **given)


def fitting(scheme: str, *of: float) -> Oscillator:
    """An oscillator (omega, xi, strength, alpha), without damping where the scheme takes none."""
    found = Oscillator(*of)
    return found if BY_NAME[scheme].takes_damping else replace(found, xi=0.0)


def stepper(scheme: str, of: Oscillator, load: Any, h: float, **values: float) -> committed_steps.Remembering:
    return committed_steps.Remembering(*declared(scheme, of, load, values), h)


def declared(scheme: str, of: Oscillator, load: Any, values: dict[str, float]) -> tuple[Any, ...]:
    """What plain stepping takes: the declaration, its parameters, the spring, the damper, the load."""
    handle, declaration = ss.scheme(scheme, **values), BY_NAME[scheme]
    parameters = {s: float(handle.parameters[s.name]) for s in declaration.values}
    spring = committed_steps.Spring(of.omega**2, of.strength, of.alpha)
    return declaration, parameters, spring, 2 * of.xi * of.omega, lambda t: float(load(np.array(t)))


# -- published numbers


def chopra() -> ss.Scene:
    m, k, c = 0.2533, 10.0, 0.1592
    omega = float(np.sqrt(k / m))
    return ss.scene(
        "hysteretic_oscillator", omega=omega, xi=c / (2 * m * omega), strength=7.5 / m, load=ss.HalfSine(10 / m, 0.6)
    )


@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scheme", ["average_acceleration"])
def test_examples_5_5_and_5_6_of_chopra(scheme: str) -> None:
    """Chopra, Dynamics of Structures, tables E5.5 and E5.6: displacements to the last digit."""
    r = ss.march(chopra(), scheme, dt=0.1, t_end=0.9)
    published = ["0.0437", "0.2326", "0.6121", "1.1143", "1.6214", "1.9891", "2.0951", "1.9240", "1.5602"]
    assert [f"{u:.4f}" for u in r.u[1:, 0]] == published
    assert np.abs(r.force * 0.2533).max() == pytest.approx(7.5, rel=1e-14)


# -- the exact motion

RANDOM = np.random.default_rng(47).normal(size=20) * 12.0
CASES = [
    (Oscillator(OMEGA, 0.05, 29.6), half_sine(39.5, 0.6), 0.0, 0.0),
    (Oscillator(OMEGA, 0.0, 29.6, 0.1), half_sine(39.5, 0.6), 0.0, 0.0),
    (Oscillator(OMEGA, 0.0, 5.0), hysteresis.constant(3.0), 0.0, 2.0),
    (Oscillator(5.0, 0.02, 5.0, 0.3), record(0.1, list(RANDOM)), 0.5, -2.0),
    (Oscillator(5.0, 0.0, 5.0), record(0.1, list(RANDOM)), 0.5, 2.0),
    (Oscillator(5.0, 1.2, 1.5, 0.2), record(0.1, list(2 * RANDOM)), 0.1, 2.0),
]


@pytest.mark.parametrize(("of", "load", "u", "v"), CASES)
def test_the_exact_motion_is_that_which_scipy_integrates(of: Oscillator, load: Any, u: float, v: float) -> None:
    """Exponentials of matrices from root to root against DOP853 with SciPy's own events."""
    motion, integral = exact(of, load, 3.0, u, v), integrated(of, load, 3.0, u, v)
    found = motion.at(3.0)[:, 0]
    assert len(motion.events) >= 2
    assert found[:3] == pytest.approx(integral[:3], abs=1e-12)
    assert found[3] == pytest.approx(integral[4], rel=1e-12)
    u_, v_, p, _, _, _ = integral
    start = v**2 / 2 + of.stored(u, of.committed(u, 0.0))
    assert v_**2 / 2 + of.stored(u_, p) + integral[3] + integral[4] == pytest.approx(start + integral[5], rel=1e-12)


def back_in_time(scheme: str) -> bool:
    """Whether it takes the internal force at a stage before t_n, as found from the declaration alone."""
    at = stepper(scheme, fitting(scheme, OMEGA, 0.05, 10.0, 0.1), ss.Step(0.0), 0.1).instants_of_force
    return min(at) < -1e-12


def test_which_schemes_go_back_in_time() -> None:
    assert [name for name in MARCHED if back_in_time(name)] == ["crouzeix4", "forest_ruth", "yoshida6"]


def error(of: Oscillator, scheme: str, load: Any, pieces: Any, t_end: float, n: int, u: float, v: float) -> Any:
    """Of u, v/omega and what remains, at the end of n steps."""
    r = ss.march(scene(of, scheme, load, u, v), scheme, dt=t_end / n, t_end=t_end)
    assert r.status == "completed"
    found = np.array([r.u[-1, 0], r.v[-1, 0], r.memory["p"][-1]])
    return (found - at_end(of, tuple(pieces), t_end, u, v)) / [1, of.omega, 1]


@cache
def at_end(of: Oscillator, pieces: tuple[hysteresis.Piece, ...], t_end: float, u: float, v: float) -> Any:
    """u, v and what remains in the exact motion."""
    return exact(of, pieces, t_end, u, v).at(t_end)[:3, 0]


def away(scheme: str) -> float:
    """The order observed while the spring yields and nothing happens."""
    of, T = fitting(scheme, OMEGA, 0.05, 20.0, 0.1), 0.4
    assert not exact(of, sine(10.0, 1.5), T, 0.8, 30.0).events
    last = np.inf
    observed = np.nan
    for n in (1, 2, 4, 8, 16, 32, 64):
        e = np.abs(error(of, scheme, ss.Harmonic(10.0, 1.5), sine(10.0, 1.5), T, n, 0.8, 30.0)).max()
        if e < 1e-11:  # rounding
            break
        last, observed = e, np.log2(last / e)
    return observed


def across(scheme: str, steps: tuple[int, ...] = (40, 80, 160, 320, 640)) -> tuple[float, float]:
    """The order observed where the spring yields and ceases to, and the error of the last steps.

    How far an event is from the next end of a step is different for each step: errors are those of several strengths.
    """
    load, pieces = ss.HalfSine(40.0, 0.8), half_sine(40.0, 0.8)
    squares = np.zeros(len(steps))
    for strength in (10.0, 11.0, 13.0, 14.0, 15.0, 16.5, 18.0):
        of = fitting(scheme, OMEGA, 0.05, strength, 0.1)
        assert len(exact(of, pieces, 2.0).events) >= 2
        squares += [(error(of, scheme, load, pieces, 2.0, n, 0.0, 0.0) ** 2).mean() for n in steps]
    return -float(np.polyfit(np.log(steps), np.log(squares), 1)[0]) / 2, float(np.sqrt(squares[-1] / 7))


@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scheme", MARCHED)
def test_order(scheme: str) -> None:
    """Away from events a scheme has its own order, across them at most 2, since the force bends there.

    A scheme with a stage before t_n has order 1 while the spring yields. It has to have: what the spring remembers at
    t_n makes its force bend at u_n itself, where it unloads on the way back to the stage and would yield on the way on,
    so that the force at the stage is wrong by the stiffness times the way, O(h). No rule of when to commit changes it.
    """
    own = min(ss.scheme(scheme).order[:2])
    expected = 1 if back_in_time(scheme) else own
    observed = away(scheme)
    assert expected - 0.15 < observed < expected + 0.45
    steps = (40, 80, 160, 320, 640, 1280, 2560) if VERIFY else (40, 80, 160, 320)
    observed, last = across(scheme, steps)
    assert min(expected, 2) - 0.25 < observed < min(expected, 2) + 0.45
    assert last < (0.3 if min(expected, 2) == 1 else 2e-2) * (80 / steps[-1]) ** min(expected, 2)


@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scheme", ["crouzeix4", "forest_ruth", "yoshida6"])
def test_order_of_schemes_that_go_back_in_time_while_the_spring_is_elastic(scheme: str) -> None:
    of, T, e = fitting(scheme, OMEGA, 0.05, 200.0, 0.1), 0.8, []
    for n in (32, 64):
        e.append(np.abs(error(of, scheme, ss.Harmonic(10.0, 1.5), sine(10.0, 1.5), T, n, 0.2, 1.0)).max())
    assert np.log2(e[0] / e[1]) > ss.scheme(scheme).order[0] - 0.3


@pytest.mark.usefixtures("plainly")
def test_residual_displacement() -> None:
    """What remains after a pulse to 1e-8 of a displacement of 2, by steps of a 20 000th of it."""
    of = Oscillator(OMEGA, 0.05, 15.0, 0.1)
    motion = exact(of, half_sine(40.0, 0.8), 4.0)
    assert motion.events[-1] < 2.0
    r = ss.march(scene(of, "central_difference", ss.HalfSine(40.0, 0.8)), "central_difference", dt=4e-5, t_end=2.0)
    assert r.memory["p"][-1] == pytest.approx(motion.at(4.0)[2, 0], abs=1e-8)
    assert r.energy_dissipated[-1] == pytest.approx(motion.at(4.0)[3, 0], rel=1e-8)


# -- the rule of committing

GUST = np.random.default_rng(3).normal(size=40) * 12.0


def compare(scheme: str, of: Oscillator, u: float, v: float, h: float = 0.05, n: int = 40, **values: float) -> float:
    """The largest difference between the kernels and plain stepping of the declaration, in u, v, a and memory."""
    load = ss.Record(0.1, GUST)
    r = ss.march(scene(of, scheme, load, u, v), ss.scheme(scheme, **values), dt=h, t_end=n * h)
    rows = committed_steps.history(*declared(scheme, of, load, values), h, n, u, v)
    own = ~np.isnan(rows[1:, 2])
    assert np.ptp(rows[:, 3]) > 0.5 * of.at_yield  # it has yielded
    found = np.stack([r.u[:, 0], r.v[:, 0] / of.omega, r.a[:, 0] / of.omega**2, r.memory["p"]])
    expected = rows.T / np.array([1, of.omega, of.omega**2, 1])[:, None]
    return max(np.abs(found - expected)[[0, 1, 3]].max(), np.abs(found - expected)[2, 1:][own].max(initial=0.0))


@pytest.mark.usefixtures("plainly")
@pytest.mark.every_scheme
@pytest.mark.parametrize("scheme", MARCHED)
def test_a_step_is_that_of_the_declaration_with_memory_committed_by_the_rule(scheme: str) -> None:
    assert compare(scheme, fitting(scheme, 5.0, 0.04, 4.0, 0.1), 0.1, 1.5) < 1e-11
    assert compare(scheme, fitting(scheme, 8.0, 0.0, 3.0, 0.0), 0.0, 0.0) < 1e-11
