"""What is said of a run that has gained energy which nothing gave it, and what is not."""

import warnings
from typing import Any

import numpy as np
import pytest
from substep_derive import Contact, Friction, Scene, rate, t
from sympy import Rational, S, sin, symbols
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app
from substep.marching.run import marched

OMEGA = 10.0
x = symbols("x")
FREE = ss.scene("linear_oscillator", omega=OMEGA)


def said(scene: Any, scheme: Any, **run: Any) -> str:
    """The warning of a march, empty without one."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        ss.march(scene, scheme, **run)
    return " ".join(str(w.message) for w in found)


def test_central_difference_beyond_its_limit_is_unstable() -> None:
    """At omega*dt = 10 the eigenvalues solve x^2 + 98 x + 1 = 0: the larger is 49 + sqrt(49^2 - 1) = 97.9898."""
    text = said(FREE, "central_difference", dt=1.0, t_end=40.0)
    assert "central_difference is unstable at omega*dt = 10, xi = 0: its spectral radius is 97.9898" in text
    assert "stable up to omega*dt = 2: take dt up to 0.2 s" in text
    assert said(FREE, "central_difference", dt=1.0, t_end=100.0)  # where squares overflow


def test_the_step_that_is_named_is_stable_with_damping_too() -> None:
    """Of central differences with damping at the half step the limit is 2 (sqrt(1 + xi^2) - xi)."""
    damped = ss.scene("linear_oscillator", omega=OMEGA, xi=0.1)
    text = said(damped, "central_difference_lagged", dt=0.5, t_end=40.0)
    named = float(text.split("omega*dt = ")[2].split(":")[0])
    assert named == pytest.approx(2.0 * (np.sqrt(1.01) - 0.1), rel=0.02)
    assert said(damped, "central_difference_lagged", dt=0.9 * named / OMEGA, t_end=40 * 0.9 * named / OMEGA) == ""


@pytest.mark.filterwarnings("ignore:hht_alpha is not A-stable")
@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("newmark", {"gamma": 0.4}),  # |lambda| = 1 + Omega (1/2 - gamma)/2 + ...
        ("hht_alpha", {"alpha": 0.1}),  # the sign of those who count alpha from the other end
        ("rk2", {}),  # |lambda|^2 = 1 + Omega^4/4
    ],
)
def test_a_scheme_that_gains_energy_at_every_step_is_not_helped_by_a_shorter_one(
    name: str, given: dict[str, float]
) -> None:
    assert "above 1 at shorter steps too; take another scheme, or other parameters" in said(
        FREE, ss.scheme(name, **given), dt=0.1, t_end=100.0
    )


def test_under_a_load_an_unstable_step_is_told_from_resonance() -> None:
    """At rest under a load that swells it for four hundred radians, energy grows without bound in the motion itself."""
    driven = ss.scene("linear_oscillator", omega=OMEGA, u0=0.0, load=ss.Harmonic(1.0, omega=OMEGA))
    assert said(driven, "bathe", dt=0.01, t_end=40.0) == ""
    assert said(driven, "central_difference", dt=0.01, t_end=40.0) == ""
    assert "is unstable at omega*dt = 2.5" in said(driven, "central_difference", dt=0.25, t_end=10.0)


def test_a_bounce_in_too_long_steps_gains_energy() -> None:
    """Central differences by hand: u += dt v + dt^2 a/2, v += dt (a before + a after)/2, a = 1e6 max(-u, 0)."""
    dt, u, v, a = 3e-3, 1e-3, -1.0, 0.0
    for _ in range(100):
        u, before = u + dt * v + 0.5 * dt**2 * a, a
        a = 1e6 * max(-u, 0.0)
        v += 0.5 * dt * (before + a)
    end = 0.5 * v**2 + 0.5e6 * min(u, 0.0) ** 2
    assert end > 10 * 0.5  # of v = 1 at the start
    text = said("penalty_bounce", "central_difference", dt=dt, t_end=0.3)
    assert "central_difference has gained energy on penalty_bounce, which conserves it" in text
    assert f"{end:.3g} J at t = 0.3 from 0.5 J; take a smaller step, or another scheme" in text
    assert said("penalty_bounce", "central_difference", dt=1e-4, t_end=0.3) == ""


@pytest.mark.usefixtures("uncompiled")
def test_friction_only_takes_energy_but_for_a_belt() -> None:
    """At omega*dt = 3 central differences gain beside a small friction; a belt brings energy that none is warned of."""
    spring: dict[str, Any] = {"coordinates": {x: "m"}, "kinetic": rate(x) ** 2 / 2, "parameters": (), "length": 1}
    spring |= {"potential": 50 * x**2, "start": {x: Rational(1, 10), rate(x): 0}}
    rubbed = Scene("rubbed", frictions={"drag": Friction(x, Rational(1, 100))}, **spring)
    text = said(rubbed, "central_difference", dt=0.3, t_end=3.0)
    assert "central_difference has gained energy on rubbed, whose friction only takes it" in text
    assert said(rubbed, "central_difference", dt=0.01, t_end=3.0) == ""
    at_rest = spring | {"potential": 0 * x, "start": {x: 0, rate(x): Rational(1, 10)}}
    belt = Scene("belt", frictions={"drag": Friction(x - 9 * t, 1)}, **at_rest)
    assert said(belt, "average_acceleration", dt=0.01, t_end=3.0) == ""


@pytest.mark.usefixtures("plain_in_gate")
def test_energy_that_a_prescribed_motion_brings_is_nothing_to_warn_of() -> None:
    """The spring of Bathe and Noh is at rest, and what it hangs from moves."""
    assert said("bathe_noh", "bathe", dt=0.1, t_end=10.0) == ""


def own(name: str, potential: Any, force: Any, x0: float) -> Scene:
    return Scene(
        name=name, coordinates={x: "m"}, kinetic=rate(x) ** 2 / 2, potential=potential, forces={x: force},
        parameters=(), start={x: x0, rate(x): 0}, length=1,
    )  # fmt: skip


@pytest.mark.usefixtures("plain_in_gate")
def test_an_energy_that_cancels_at_the_start_does_not_count() -> None:
    """From near the top between two wells, where it counts as 0: errors of 1e-3 of what is in play are far above it."""
    wells = own("wells", -50 * x**2 + x**4 / 4, S.Zero, 1e-4)
    r = marched(wells, "central_difference", 0.005, 2.5)
    energy = r.energy
    assert r.status == "completed"
    assert np.abs(energy).max() > 10 * abs(energy[0])
    ends = [0.005 * int(k) for k in np.flatnonzero(energy > 10 * abs(energy[0]))[::50]]
    assert ends
    assert [said(wells, "central_difference", dt=0.005, t_end=t) for t in ends] == [""] * len(ends)


@pytest.mark.usefixtures("plain_in_gate")
def test_damping_that_is_negative_is_the_motion_s_own() -> None:
    """u'' - u' + u = 0 swells by e^t in energy."""
    swelling = own("swelling", x**2 / 2, rate(x), 1.0)
    r = marched(swelling, "rk4", 0.05, 10.0)
    assert r.energy[-1] > 1e3 * r.energy[0]
    assert said(swelling, "rk4", dt=0.05, t_end=10.0) == ""


def test_the_command_says_it_on_stderr() -> None:
    run = ["run", "linear_oscillator", "central_difference", "--omega", "10", "--dt", "1", "--t-end", "30"]
    result = CliRunner().invoke(app, run)
    assert result.exit_code == 0
    assert "warning: central_difference is unstable at omega*dt = 10" in result.stderr
    assert "unstable" not in result.stdout


def test_studies_march_without_a_word() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        r = marched(FREE, "central_difference", 1.0, 40.0)
    assert r.energy[-1] > 1e80


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize("scheme", ["central_difference", "bathe", "houbolt"])  # the last starts by another one
@pytest.mark.parametrize("name", ["penalty_bounce", "duffing"])
def test_the_growth_by_which_most_runs_are_passed_over_bounds_every_row(name: str, scheme: str) -> None:
    whole = ss.scene(name)
    r = marched(whole, scheme, 1e-4, 0.02)
    assert r.growth == pytest.approx(r.energy.max() / r.energy[0], rel=1e-12)
    assert marched(whole, scheme, 1e-4, 0.02, 10).growth == r.growth  # also of rows that are not kept
    on = marched(whole, scheme, 1e-4, 0.03, start=r)
    assert on.growth == pytest.approx(on.energy.max() / on.energy[0], rel=1e-12)


@pytest.mark.usefixtures("uncompiled")
def test_what_forces_and_what_moves_give_is_no_gain_of_the_scheme() -> None:
    """A constant force, a constraint and a stop that move; and a contact whose pressure is remembered, under a load."""
    y = symbols("y")
    one: dict[str, Any] = {"coordinates": {x: "m"}, "kinetic": rate(x) ** 2 / 2, "parameters": (), "length": 1}
    one["start"] = {x: 0, rate(x): Rational(1, 10)}
    two = one | {"coordinates": {x: "m", y: "m"}, "kinetic": (rate(x) ** 2 + rate(y) ** 2) / 2}
    two["start"] = {x: Rational(1, 10), rate(x): 0, y: Rational(1, 10), rate(y): 0}
    for declared in (
        Scene("pulled", potential=0 * x, forces={x: 1}, **one),
        Scene("turned", potential=0 * x, forces={x: 2 * y, y: -2 * x}, **two),
        Scene("moved", potential=x**2 / 2, constraints={"rail": y - Rational(1, 10) - t**2}, **two),
        Scene("driven", potential=0 * x, constraints={"rail": rate(y) - t}, **two),
        Scene("met", potential=0 * x, contacts={"wall": Contact(x + Rational(3, 10) - t, Rational(1, 2))}, **one),
        Scene("lifted", potential=0 * x, load={x: 8 * sin(3 * t) - 3}, contacts={"stop": Contact(x, remembered=True)},
              **one | {"start": {x: 1, rate(x): 0}}),
    ):  # fmt: skip
        assert said(declared, "average_acceleration", dt=0.01, t_end=0.6 if declared.name == "lifted" else 3.0) == ""
