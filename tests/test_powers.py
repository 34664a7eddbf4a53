"""The power of what gives energy to a scene or takes it, and what is left for the scheme: against fine steps."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import simpson
from substep_derive import Scene, optional, rate, t
from substep_derive.declare.scenes import declared
from sympy import Abs, Rational, Symbol, cos, lambdify, sin

import substep as ss

theta, x, y = Symbol("theta"), Symbol("x"), Symbol("y")
GIVEN = {
    "linear_oscillator": {"omega": 6.0, "xi": 0.05}, "rotating_hoop": {"c": 0.5},
    "cart_pole": {"gain_x": 1.0, "gain_v": 2.0, "gain_angle": 30.0, "gain_spin": 5.0},
}  # fmt: skip
RUNS = {"bathe_noh": ("rkn64", 1e-4, 0.2, 1e-3)}  # a stiff spring, whose vibration the steps have to resolve
EXPECTED = {
    "linear_oscillator": {"dissipation", "load"}, "rotating_hoop": {"dissipation"}, "cart_pole": {"forces"},
    "kapitza": {"time"}, "van_der_pol": {"forces"}, "quadratic_drag": {"dissipation"},
    "driven_duffing": {"dissipation", "load"}, "bathe_noh": {"time"},
}  # fmt: skip


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", EXPECTED)
def test_what_the_powers_leave_is_the_error_of_the_scheme(name: str) -> None:
    """Which falls with its order: of fifth under Dormand and Prince's, to the rounding of the quadrature."""
    scheme, dt, t_end, close = RUNS.get(name, ("dormand_prince", 2e-3, 1.0, 1e-6))
    r = ss.march(ss.scene(name, **GIVEN.get(name, {})), scheme, dt=dt, t_end=t_end)
    assert r.powers.keys() == EXPECTED[name]
    given = np.abs(np.trapezoid(sum(r.powers.values()), r.t)) + np.ptp(r.energy)
    assert np.abs(r.numerical).max() < close * given


def test_every_scene_with_powers_is_here() -> None:
    needed = {"elastic_pendulum": {"EA": 1e4}, "hysteretic_oscillator": {"omega": 6.0, "strength": 1.0}} | GIVEN
    made = {name: ss.scene(name, **needed.get(name, {})) for name in ss.scenes()}
    found = {name for name, scene in made.items() if hasattr(scene.module, "powers")}
    others = {
        "hysteretic_oscillator",
        "impact_oscillator",
    }  # a law with a memory, see below; contacts, which are refused
    assert found - others == EXPECTED.keys()


@pytest.mark.usefixtures("uncompiled")
def test_laws_dissipate_by_themselves() -> None:
    """Beside the damping ratio, what the law says that it has dissipated is no loss of the scheme."""
    swinging = ss.scene("hysteretic_oscillator", omega=6.0, strength=1.0, xi=0.02, v0=3.0)
    r = ss.march(swinging, "average_acceleration", dt=1e-3, t_end=2.0)
    assert r.energy_dissipated[-1] > 1.0
    assert np.abs(r.numerical).max() < 2e-3 * r.energy[0]


@pytest.mark.usefixtures("uncompiled")
def test_a_pendulum_whose_pivot_is_moved() -> None:
    """In its angle, where the kinetic energy holds time, and on a rod, whose constraint moves: the same powers."""
    pivot = sin(3 * t) / 5
    at = {x: pivot + sin(theta), y: -cos(theta)}
    speeds = {rate(q): e.diff(t) + e.diff(theta) * rate(theta) for q, e in at.items()}
    kinetic, potential = (rate(x) ** 2 + rate(y) ** 2) / 2, 10 * y
    angle = Scene(
        "by_angle", coordinates={theta: "rad"}, kinetic=kinetic.subs(speeds).expand(), potential=potential.subs(at),
        parameters=(), start={theta: 1, rate(theta): 0}, length=1,
    )  # fmt: skip
    first = {s: e.subs({t: 0, theta: 1, rate(theta): 0}) for s, e in (at | speeds).items()}
    rod = Scene(
        "by_rod", coordinates={x: "m", y: "m"}, kinetic=kinetic, potential=potential,
        constraints={"rod": ((x - pivot) ** 2 + y**2 - 1) / 2}, parameters=(), start=first, length=1,
    )  # fmt: skip
    one = ss.march(ss.scene(angle), "dormand_prince", dt=2e-3, t_end=2.0)
    assert one.powers.keys() == {"time"}
    assert np.abs(one.numerical).max() < 1e-8
    two = ss.march(ss.scene(rod), "generalized_alpha", dt=2e-3, t_end=2.0)
    assert two.powers.keys() == {"constraints"}
    assert np.allclose(two.energy, one.energy, rtol=0.0, atol=1e-3)
    assert np.ptp(one.energy) > 1.0
    assert np.abs(two.numerical).max() < 1e-3


@pytest.mark.usefixtures("uncompiled")
def test_numerical_damping_is_what_is_left() -> None:
    """Of an oscillator without damping all of its loss; with a law, what the law has not dissipated."""
    r = ss.march(ss.scene("linear_oscillator", omega=6.0), "backward_euler", dt=0.02, t_end=2.0)
    assert np.allclose(r.numerical, r.energy[0] - r.energy, rtol=0.0, atol=1e-12)
    assert r.numerical[-1] > 0.5 * r.energy[0]


@pytest.mark.usefixtures("plain_in_gate")
def test_contacts_and_friction_are_left_to_impacts() -> None:
    r = ss.march("bouncing_ball", "average_acceleration", dt=0.01, t_end=0.1)
    with pytest.raises(ValueError, match="got floor, which act within a step; r.impacts says"):
        r.numerical
    with pytest.raises(ValueError, match="powers"):
        Scene(
            "named", coordinates={x: "m"}, kinetic=rate(x) ** 2, potential=x, parameters=(optional(Symbol("k"), 1),),
            start={x: 0, rate(x): 0}, length=1, outputs={"powers": x},
        )  # fmt: skip


wind, motor = Symbol("wind"), Symbol("motor")
# a cart whose motor is slowed by a drag, and on it a pendulum in a wind; a load pushes both
DRIVEN = Scene(
    "driven_cart", coordinates={x: "m", theta: "rad"},
    kinetic=rate(x) ** 2 + rate(x) * rate(theta) * cos(theta) / 2 + rate(theta) ** 2 / 2,
    potential=5 * x**2 - 5 * cos(theta), dissipation=Abs(rate(theta)) ** 3 / 30,
    forces={x: motor - Abs(rate(x)) * rate(x), theta: wind * (cos(theta) - rate(theta)) * cos(t)},
    load={x: sin(3 * t), theta: t / 4}, parameters=(optional(wind, Rational(3, 2)), optional(motor, 2)),
    start={x: 0, theta: 1, rate(x): 0, rate(theta): 0}, length=1, outputs={"drag": -Abs(rate(x)) ** 3},
)  # fmt: skip
DECLARED = {s.name: s for s in (*declared(), DRIVEN)}


def declared_powers(r: Any) -> dict[str, np.ndarray]:
    """Of each force and load, the expression that is declared times the rate, evaluated in the rows."""
    scene = DECLARED[r.scene.name]
    symbols = [t, *scene.coordinates, *scene.rates, *(p.symbol for p in scene.parameters)]
    values = [r.t, *r.u.T, *r.v.T, *r.scene.parameters.values()]
    given = {"forces": scene.forces, "load": scene.load}
    on = {f"{kind} {q}": e * rate(q) for kind, forces in given.items() for q, e in forces.items()}
    return {name: lambdify(symbols, e)(*values) for name, e in on.items()}


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["van_der_pol", "cart_pole", "driven_duffing", "driven_cart"])
def test_each_force_has_the_power_that_its_declaration_says(name: str) -> None:
    """And together with what is dissipated they are the change of energy, by Simpson's rule over fine steps."""
    scene = ss.scene(DRIVEN) if name == "driven_cart" else ss.scene(name, **GIVEN.get(name, {}))
    r = ss.march(scene, "dormand_prince", dt=1e-3, t_end=1.0)
    expected = declared_powers(r)
    dissipated = {"dissipation"} if DECLARED[name].dissipation != 0 else set()
    assert r.power_of_each.keys() == expected.keys() | dissipated
    assert expected
    for part, power in expected.items():
        assert np.ptp(power) > 0.01
        np.testing.assert_allclose(r.power_of_each[part], power, rtol=1e-12, atol=1e-12)
    work = {part: float(simpson(power, x=r.t)) for part, power in r.power_of_each.items()}
    assert sum(work.values()) == pytest.approx(r.energy[-1] - r.energy[0], abs=1e-7)
    assert all(abs(w) > 1e-4 for w in work.values())  # each counts in the balance


@pytest.mark.usefixtures("uncompiled")
def test_powers_are_the_sums_of_the_parts() -> None:
    """An effect within the force on a coordinate is had as an output: here the drag, beside which the motor is left."""
    r = ss.march(DRIVEN, "bathe", dt=0.01, t_end=1.0)
    each = r.power_of_each
    assert list(r.powers) == ["dissipation", "forces", "load"]
    for kind in ("forces", "load"):
        np.testing.assert_array_equal(r.powers[kind], each[f"{kind} x"] + each[f"{kind} theta"])
    np.testing.assert_allclose(each["forces x"] - r.outputs["drag"], 2.0 * r.v[:, 0], rtol=0, atol=1e-14)


@pytest.mark.usefixtures("uncompiled")
def test_each_constraint_has_its_own_power() -> None:
    """A drive moves a cart, on which a rod holds a point: the drive gives all energy, the rod passes it on."""
    drive, mass = Symbol("s"), Rational(1, 2)
    carried = Scene(
        "carried", coordinates={drive: "m", x: "m", y: "m"},
        kinetic=rate(drive) ** 2 / 2 + mass * (rate(x) ** 2 + rate(y) ** 2) / 2, potential=mass * 10 * y,
        constraints={"drive": drive - sin(2 * t) / 2, "rod": ((x - drive) ** 2 + y**2 - 1) / 2}, parameters=(),
        start={drive: 0, x: Rational(3, 5), y: Rational(-4, 5), rate(drive): 1, rate(x): 1, rate(y): 0}, length=1,
    )  # fmt: skip
    r = ss.march(carried, "generalized_alpha", dt=1e-3, t_end=1.0)
    each = r.power_of_each
    assert each.keys() == {"constraints drive", "constraints rod"}
    np.testing.assert_allclose(each["constraints drive"], -r.multipliers["drive"] * np.cos(2 * r.t), rtol=0, atol=1e-4)
    assert np.abs(each["constraints rod"]).max() < 1e-4
    assert np.ptp(r.energy) > 1.0
    assert simpson(each["constraints drive"], x=r.t) == pytest.approx(r.energy[-1] - r.energy[0], abs=1e-4)
    np.testing.assert_array_equal(r.powers["constraints"], sum(each.values()))


@pytest.mark.usefixtures("uncompiled")
def test_forces_that_do_no_work_together_are_seen_apart() -> None:
    """A gyroscopic force passes energy from one coordinate to the other; both have their power, and the sum is 0."""
    turning = Scene(
        "turning", coordinates={x: "m", y: "m"}, kinetic=(rate(x) ** 2 + rate(y) ** 2) / 2,
        potential=2 * (x**2 + y**2), forces={x: 3 * rate(y), y: -3 * rate(x)}, parameters=(),
        start={x: 1, y: 0, rate(x): 0, rate(y): 0}, length=1,
    )  # fmt: skip
    r = ss.march(turning, "rk4", dt=0.01, t_end=1.0)
    assert np.ptp(r.power_of_each["forces x"]) > 1.0
    np.testing.assert_allclose(r.power_of_each["forces y"], -3 * r.v[:, 0] * r.v[:, 1], rtol=1e-14, atol=1e-14)
    assert np.abs(r.powers["forces"]).max() < 1e-14


def test_what_has_no_powers_says_what_there_is_instead() -> None:
    r = ss.march(ss.structure([[1.0]], K=[[4.0]]), "bathe", dt=0.1, t_end=0.5, start={"u": [1.0], "v": [0.0]})
    with pytest.raises(AttributeError, match="expected a response of a scene for powers .* got one of a structure"):
        r.power_of_each


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("driven", ["potential", "invariant", "kinetic", "load"])
def test_what_drives_a_turning_frame_may_be_declared_in_any_place(driven: str) -> None:
    """Its kinetic energy has terms without rates, and one of first degree: the scheme dissipates next to nothing."""
    spin, r, (v, w) = Rational(2), Symbol("r"), (rate(x), rate(y))
    given: dict[str, Any] = {
        "potential": {"potential": 2 * x**2 + 3 * y**2 + x * sin(3 * t)},
        "invariant": {"potential": 2 * r + 3 * y**2, "invariants": {r: (x - sin(3 * t)) ** 2}},
        "kinetic": {"potential": 2 * x**2 + 3 * y**2},
        "load": {"potential": 2 * x**2 + 3 * y**2, "load": {x: -sin(3 * t)}},
    }[driven]
    if driven == "kinetic":
        spin *= cos(t)
    turning = Scene(
        "turning", {x: "m", y: "m"}, kinetic=((v - spin * y) ** 2 + (w + spin * x) ** 2) / 2, parameters=(),
        start={x: 1, y: Rational(1, 2), v: Rational(1, 2), w: -1}, length=1, **given,
    )  # fmt: skip
    r1, r2 = (ss.march(ss.scene(turning), "rk4", dt=dt, t_end=1.0) for dt in (0.02, 0.01))
    assert np.abs(r1.numerical).max() < 1e-4
    assert np.abs(r2.numerical).max() < np.abs(r1.numerical).max() / 10.0
    T2 = (r2.v**2).sum(axis=1) / 2
    one, own = 2.0 * (np.cos(r2.t) if driven == "kinetic" else 1.0), r2.u[:, 0]
    T1 = one * (own * r2.v[:, 1] - r2.u[:, 1] * r2.v[:, 0])
    T0 = one**2 * (r2.u**2).sum(axis=1) / 2
    moved = own - (np.sin(3 * r2.t) if driven == "invariant" else 0.0)
    V = 2 * moved**2 + 3 * r2.u[:, 1] ** 2 + (own * np.sin(3 * r2.t) if driven == "potential" else 0.0)
    assert r2.energy == pytest.approx(T2 - T0 + V if driven == "load" else T2 + T1 + T0 + V, rel=1e-12)
