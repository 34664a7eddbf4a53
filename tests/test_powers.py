"""The power of what gives energy to a scene or takes it, and what is left for the scheme: against fine steps."""

import numpy as np
import pytest
from substep_derive import Scene, optional, rate, t
from sympy import Symbol, cos, sin

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
    assert found - {"hysteretic_oscillator"} == EXPECTED.keys()  # whose law has a memory: see below


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
