"""Contacts of a scene: against steps by hand, and what impacts do to energy, over the phase of the impact in a step."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from substep_derive import Contact, DeclarationError, Friction, Scene, optional, rate
from substep_derive import t as time
from substep_derive.declare.scenes import impact
from sympy import Rational, Symbol
from test_constraints import TAKEN, VERIFY

import substep as ss

Array = np.ndarray
H, PHASES = 0.1, 32
SOME = ("generalized_alpha", "bathe", "energy_momentum")
NEVER_GAIN = {"backward_euler", "energy_momentum", "houbolt"}
u, v, w = Symbol("u"), rate(Symbol("u")), Symbol("w")


def remembered(name: str) -> Scene:
    """The scene with contacts whose acceleration a scheme keeps for its next step."""
    (scene,) = (scene for scene in impact.ALL if scene.name == name)
    kept = {x: replace(contact, remembered=True) for x, contact in scene.contacts.items()}
    return replace(scene, name=f"{name}_remembered", contacts=kept)


def leaving(scheme: Any, scene: Any = "mass_on_floor") -> Array:
    """Velocities with which a mass point leaves a floor that it meets with 1, by phases of the impact in a step."""
    starts = 1 + H * np.arange(PHASES) / PHASES
    ds = ss.sweep(scene, scheme, dt=H, t_end=3.0, keep="final", u0=starts, progress=False)
    assert not ds.status.values.any()
    return ds.v.values[:, 0]


def newmark(h: float, x: Array, beta: float, gamma: float) -> Array:
    """u, v, a, pressure of a unit mass without forces over a floor, a step later: open, or else closed."""
    u, v, a, _ = x
    free = u + h * v + h**2 * (0.5 - beta) * a
    new = 0.0 if free >= 0.0 else -free / (beta * h**2)
    return np.array([free + beta * h**2 * new, v + h * ((1 - gamma) * a + gamma * new), new, new])


def generalized_alpha(h: float, x: Array, rho: float) -> Array:
    """The same: inertia and pressures at both ends are mixed."""
    m, f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    beta, gamma = (1 - m + f) ** 2 / 4, 0.5 - m + f
    u, v, a, old = x
    free, at_zero = (
        u + h * v + h**2 * (0.5 - beta) * a,
        (f * old - m * a) / (1 - m),
    )  # the acceleration without pressure
    if free + beta * h**2 * at_zero >= 0.0:
        new, pressure = at_zero, 0.0
    else:
        new = -free / (beta * h**2)
        pressure = ((1 - m) * new + m * a - f * old) / (1 - f)
    return np.array([free + beta * h**2 * new, v + h * ((1 - gamma) * a + gamma * new), new, pressure])


def bathe(h: float, x: Array) -> Array:
    """Both sub-steps, the second of three-point backward Euler."""
    u, v, _, _ = x
    um, vm, _, _ = newmark(h / 2, x, 0.25, 0.5)
    at_rest = (4 * vm - v) / 3
    free = (at_rest * h - u + 4 * um) / 3
    new = 0.0 if free >= 0.0 else -9 * free / h**2
    return np.array([free + h**2 * new / 9, at_rest + h * new / 3, new, new])


BY_HAND = {
    "newmark": ({"beta": 0.3025, "gamma": 0.6}, lambda h, x: newmark(h, x, 0.3025, 0.6)),
    "average_acceleration": ({}, lambda h, x: newmark(h, x, 0.25, 0.5)),
    "generalized_alpha": ({"rho_inf": 0.8}, lambda h, x: generalized_alpha(h, x, 0.8)),
    "bathe": ({}, bathe),
}


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", [name for name in BY_HAND if VERIFY or name in SOME])
def test_steps_are_those_written_by_hand(name: str) -> None:
    parameters, step = BY_HAND[name]
    for phase in (0.0, 0.3, 0.55, 0.9):
        scene = ss.scene(remembered("mass_on_floor"), u0=0.5 + H * phase)
        r = ss.march(scene, ss.scheme(name, **parameters), dt=H, t_end=1.5)
        x = np.array([scene.u0[0], -1.0, 0.0, 0.0])
        for k in range(1, len(r.t)):
            x = step(H, x)
            assert np.allclose([r.u[k, 0], r.v[k, 0], r.memory["floor"][k]], x[[0, 1, 3]], rtol=0.0, atol=1e-9)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", TAKEN if VERIFY else SOME)
def test_of_gap_and_pressure_one_is_0_and_none_is_negative(name: str) -> None:
    r = ss.march(ss.scene(remembered("two_masses_on_floor"), g=10.0), name, dt=0.01, t_end=1.5)
    gap, pressure = r.gaps["floor"], r.memory["floor"]
    assert r.status == "completed"
    assert pressure.max() > 20.0  # it has met the floor, and weighs more than on it
    if name not in ("energy_momentum", "hht_alpha_mixed_displacement", "generalized_alpha_mixed_displacement"):
        assert np.abs(np.minimum(gap, pressure)).max() < 1e-9
    assert gap.min() > -1e-12


@pytest.mark.usefixtures("uncompiled")
def test_what_a_mass_point_leaves_with_depends_on_the_phase_of_the_impact() -> None:
    """From an independent prototype: the trapezoidal rule 0.35 to 2.95, BDF2 0.37 to 1.23, Newmark of 1/2 exactly 1."""
    scene = remembered("mass_on_floor")
    trapezoidal, bdf2 = leaving("average_acceleration", scene), leaving("bdf2", scene)
    assert (trapezoidal.min(), trapezoidal.max()) == (pytest.approx(0.375, abs=0.03), pytest.approx(3.0, abs=0.07))
    assert (bdf2.min(), bdf2.max()) == (pytest.approx(0.36, abs=0.02), pytest.approx(1.25, abs=0.03))
    assert np.allclose(leaving(ss.scheme("newmark", beta=0.5, gamma=0.5), scene), 1.0, rtol=0.0, atol=1e-12)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", sorted(NEVER_GAIN) if VERIFY else ["backward_euler"])
def test_some_never_gain_energy(name: str) -> None:
    assert leaving(name, remembered("mass_on_floor")).max() <= 1.0 + 1e-9


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.thorough
def test_all_others_do() -> None:
    scene = remembered("mass_on_floor")
    assert {name for name in TAKEN if leaving(name, scene).max() <= 1.0 + 1e-9} == NEVER_GAIN


@pytest.mark.usefixtures("uncompiled")
def test_a_mass_at_rest_stays_and_the_floor_bears_its_weight() -> None:
    at_rest = {"m": 2.0, "u0": 0.0, "v0": 0.0, "g": 9.81}
    scene = ss.scene(remembered("mass_on_floor"), **at_rest)
    assert scene.a0[0] == 0.0
    for name in ("bathe", "generalized_alpha"):
        r = ss.march(scene, name, dt=0.01, t_end=0.5)
        assert np.abs(r.u).max() < 1e-14
        assert np.allclose(r.memory["floor"], 19.62, rtol=1e-9)
    for name in ("average_acceleration", "bathe"):
        r = ss.march(ss.scene("mass_on_floor", **at_rest), name, dt=0.01, t_end=0.5)
        assert np.abs(r.u).max() < 1e-14
        assert np.allclose(r.memory["floor"][1:], 19.62, rtol=1e-9)
        assert np.allclose(r.a, -9.81)


@pytest.mark.usefixtures("plain_in_gate")
def test_a_rod_that_meets_a_wall() -> None:
    """A constraint and a contact together: the pendulum swings to x = -0.5 at most, and its rod keeps its length."""
    x, y, L = Symbol("x"), Symbol("y"), 1
    walled = Scene(
        "walled_pendulum", coordinates={x: "m", y: "m"}, kinetic=(rate(x) ** 2 + rate(y) ** 2) / 2, potential=9.81 * y,
        constraints={"rod": (x**2 + y**2 - L**2) / 2}, contacts={"wall": x + 0.5}, parameters=(),
        start={x: 1, y: 0, rate(x): 0, rate(y): 0}, length=1,
    )  # fmt: skip
    r = ss.march(ss.scene(walled), "bdf2", dt=0.005, t_end=2.0)
    assert r.status == "completed"
    assert r.gaps["wall"].min() > -1e-12
    assert r.memory["wall"].max() > 1.0
    assert np.abs((r.u**2).sum(axis=1) - 1.0).max() < 1e-12
    assert np.abs(r.u[:, 0]).max() > 0.999


@pytest.mark.usefixtures("uncompiled")
def test_lanes_are_single_runs_and_a_run_goes_on() -> None:
    starts = np.linspace(0.4, 0.6, 20)
    ds = ss.sweep("two_masses_on_floor", "bdf2", dt=0.01, t_end=1.0, keep="final", u0=starts, g=10.0, progress=False)
    for u0, end in zip(starts[::7], ds.u.values[::7], strict=True):
        one = ss.march(ss.scene("two_masses_on_floor", u0=u0, g=10.0), "bdf2", dt=0.01, t_end=1.0)
        assert np.allclose(end, one.u[-1], rtol=0.0, atol=1e-10)
    scene = ss.scene("two_masses_on_floor", g=10.0)
    whole, first = (ss.march(scene, "bdf2", dt=0.01, t_end=t) for t in (1.0, 0.4))
    assert np.array_equal(ss.march(scene, "bdf2", dt=0.01, t_end=1.0, start=first).u, whole.u[40:])


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["average_acceleration", "bathe", "rk4", "central_difference", "energy_momentum"])
def test_a_penalty_is_an_elastic_stop_for_every_scheme(name: str) -> None:
    """A ball falls on one: half a period of the spring about where that bears the weight, at 1400 N and the speed."""
    stiff, g = 10000, 9.81
    ball = Scene(
        "penalised", coordinates={u: "m"}, kinetic=v**2 / 2, potential=g * u,
        contacts={"floor": Contact(u, penalty=Symbol("k"))}, parameters=(optional(Symbol("k"), stiff),),
        start={u: 0, v: -2}, length=1,
    )  # fmt: skip
    omega, rest = np.sqrt(stiff), -g / stiff
    end = 2 * (np.pi / 2 + np.arctan(g / (2 * omega))) / omega  # when it leaves, as it came
    r = ss.march(ss.scene(ball), name, dt=end / 400, t_end=end)
    assert r.v[-1, 0] == pytest.approx(2.0, rel=1e-3)
    assert r.outputs["floor"].max() == pytest.approx(stiff * (np.hypot(2 / omega, rest) - rest), rel=1e-3)
    assert r.energy == pytest.approx(2.0, rel=1e-3)
    assert not r.gaps and not r.multipliers and not r.impacts  # of rigid stops and constraints


@pytest.mark.usefixtures("uncompiled")
def test_friction_is_bounded_by_the_pressure_of_a_penalty() -> None:
    x, y = Symbol("x"), Symbol("y")
    block = Scene(
        "penalised_block", coordinates={x: "m", y: "m"}, kinetic=(rate(x) ** 2 + rate(y) ** 2) / 2, potential=9.81 * y,
        contacts={"floor": Contact(y, penalty=10**5)},
        frictions={"drag": Friction(x, Symbol("floor") * Rational(3, 10))},
        parameters=(), start={x: 0, y: -9.81e-5, rate(x): 3, rate(y): 0}, length=1,
    )  # fmt: skip
    r = ss.march(ss.scene(block), "average_acceleration", dt=1e-3, t_end=1.5)
    assert r.u[-1, 0] == pytest.approx(3**2 / (2 * 0.3 * 9.81), abs=1e-4)
    assert np.allclose(r.outputs["floor"], 9.81, rtol=0.0, atol=1e-6)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("stiff", [1e5, 1e7])
def test_an_augmented_lagrangian_ends_at_the_pressures_that_are_found(stiff: float) -> None:
    """Two masses on a spring over a floor, and a stop between them: penalties, augmented in each step until they hold.

    By the trapezoidal rule, whose acceleration goes on without the pressures: a step's are halved by its impulse.
    """
    w, h, k = Symbol("w"), 0.005, 500.0
    fall = Scene(
        "augmented", coordinates={u: "m", w: "m"}, kinetic=(v**2 + rate(w) ** 2) / 2,
        potential=k * (w - u - Rational(1, 2)) ** 2 / 2 + 10 * (u + w), parameters=(),
        contacts={"floor": u, "stop": w - u - Rational(9, 20)},
        start={u: Rational(1, 10), w: Rational(3, 5), v: -1, rate(w): -3}, length=1,
    )  # fmt: skip
    r = ss.march(ss.scene(fall), "average_acceleration", dt=h, t_end=0.15)
    B, K, f = np.array([[1.0, 0.0], [-1.0, 1.0]]), k * np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([-260.0, 240.0])
    A = np.eye(2) + h**2 / 4 * K
    x, rates, a, most = r.u[0], r.v[0], r.a[0], 0

    def balanced(start: Array, pressures: Array) -> tuple[Array, Array]:
        """z, and the pressures with the penalties of what they leave of the gaps."""
        free, z, more = B @ start - np.array([0.0, 0.45]), start, np.ones(2)
        for _ in range(3):  # which penalties act is known after two
            active = more > 0.0
            left = A + h**2 / 4 * stiff * (B.T * active) @ B
            z = np.linalg.solve(left, f - K @ start + B.T @ (active * (pressures - stiff * free)))
            more = pressures - stiff * (free + h**2 / 4 * B @ z)
        return z, np.maximum(0.0, more)

    for n in range(30):  # impacts multiply rounding: by 1e7 in 60 steps
        start, before, rounds = x + h * rates + h**2 / 4 * a, np.full(2, np.inf), 0
        z, pressures = balanced(start, np.zeros(2))
        while np.abs(pressures - before).max() > 1e-14 * stiff:
            before, rounds = pressures, rounds + 1
            z, pressures = balanced(start, before)
        most = max(most, rounds)
        x, rates = start + h**2 / 4 * z, rates + h / 2 * (a + z)
        a = f - K @ x
        found = [r.memory[name][n + 1] for name in ("floor", "stop")]
        for mine, other, within in (
            (x, r.u[n + 1], 1e-10), (rates, r.v[n + 1], 1e-8), (a, r.a[n + 1], 1e-7), (pressures / 2, found, 1e-6)
        ):  # fmt: skip
            assert np.allclose(mine, other, rtol=0.0, atol=within)
    assert most > 3
    assert all((r.memory[name] > 0).any() for name in ("floor", "stop"))


def test_penalties_that_mean_nothing_are_refused() -> None:
    with pytest.raises(DeclarationError, match="penalty above 0 of a contact, got -1"):
        Contact(u, penalty=-1)
    for more in ({"restitution": 0}, {"remembered": True}):
        with pytest.raises(DeclarationError, match="without restitution and remembered=True, got both"):
            Contact(u, penalty=1, **more)
    with pytest.raises(DeclarationError, match="got 'floor' twice"):
        Scene(
            "named_twice", coordinates={u: "m"}, kinetic=v**2 / 2, potential=u, parameters=(), start={u: 1, v: 0},
            length=1, contacts={"floor": Contact(u, penalty=1)}, outputs={"floor": u},
        )  # fmt: skip


def test_bad_starts_and_declarations_are_refused() -> None:
    with pytest.raises(ValueError, match="gaps of 0 or more in impact_oscillator, got -0.5 of 'stop'"):
        ss.scene("impact_oscillator", u0=0.5)
    lifted = Scene(
        "lifted", coordinates={u: "m", w: "m"}, kinetic=(v**2 + rate(w) ** 2) / 2, potential=u, parameters=(), length=1,
        contacts={"floor": u - time, "wall": 5 - w}, start={u: 1, v: 0, w: 0, rate(w): 0},
    )  # fmt: skip
    with pytest.raises(ValueError, match=r"got -2 of 'floor' \(of u\) at t = 3 s; start outside"):
        ss.march(ss.scene(lifted), "bathe", dt=H, t_end=4.0, start={"t": 3.0, "u": [1.0, 0.0], "v": [0.0, 0.0]})
    with pytest.raises(ValueError, match="rk4 is explicit and does not move on with the velocity"):
        ss.march("mass_on_floor", "rk4", dt=H, t_end=1.0)
    with pytest.raises(ValueError, match="expected a restitution of contact 'floor' of mass_on_floor"):
        ss.march("mass_on_floor", "bathe", tol=1e-3, t_end=1.0)
    given: dict[str, Any] = {
        "coordinates": {u: "m"}, "kinetic": v**2 / 2, "potential": u, "parameters": (), "start": {u: 1, v: 0},
        "length": 1,
    }  # fmt: skip
    with pytest.raises(DeclarationError, match="contact floor to depend on coordinates"):
        Scene("still", **given, contacts={"floor": Symbol("t")})
    with pytest.raises(DeclarationError, match="got 'floor' twice"):
        Scene("twice", **given, contacts={"floor": u}, constraints={"floor": u - 1})
