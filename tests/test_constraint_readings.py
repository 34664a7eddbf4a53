"""Readings of one holonomic constraint: at positions, at velocities, or projected, against steps written by hand."""

from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import constrained_steps
import numpy as np
import pytest
from substep_derive import Constraint, DeclarationError, Scene, rate
from substep_derive import t as time
from substep_derive.declare.scenes.constrained import rod_double_pendulum, rod_pendulum
from sympy import Symbol, cos, sin
from test_constrained_steps import rods
from test_constraints import PENDULUM, G
from test_constraints import pendulum as at_positions

import substep as ss
from substep.marching.scene_lanes import pair_kernels

Array = np.ndarray


def read(scene: Scene, **more: Any) -> Scene:
    """A scene of the catalogue with its constraints read in another way."""
    found = {name: replace(x, **more) for name, x in scene.constraints.items()}
    return replace(scene, name=f"{scene.name}_{'_'.join(map(str, more.values()))}", constraints=found)


@cache
def pendulum(level: str = "velocity", *, projected: bool = False) -> Any:
    return ss.scene(read(rod_pendulum, level=level, projected=projected), L=1.0, m=1.0, v0=0.0, g=G)


def errors(r: Any) -> Array:
    """Of u, of v, of the scheme's own multiplier and of that of the equations of motion, at 2 s."""
    x, y, vx, vy, tension = PENDULUM[2.0]
    found = np.hypot(*(r.u[-1] - (x, y))), np.hypot(*(r.v[-1] - (vx, vy)))
    return np.array([*found, *(abs(x["rod"][-1] - tension) for x in (r.memory, r.multipliers))])


def in_motion(scene: Any, name: str, dt: float, t_end: float = 1.7) -> Any:
    """A run from the exact state at 0.3 s."""
    x, y, vx, vy, _ = PENDULUM[0.3]
    return ss.march(scene, name, dt=dt, t_end=t_end, start={"u": [x, y], "v": [vx, vy]})


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(("beta", "gamma"), [(0.3025, 0.6), (0.0, 0.5)])
def test_steps_at_velocities_are_those_written_by_hand(beta: float, gamma: float) -> None:
    """Of Newmark's scheme, implicit and explicit, on two rods."""
    _, p = rods("rod_double_pendulum")
    scene = ss.scene(read(rod_double_pendulum, level="velocity"))
    scheme = ss.scheme("newmark", beta=beta, gamma=gamma) if beta else "central_difference"
    r = ss.march(scene, scheme, dt=0.02, t_end=0.3)
    state = scene.u0, scene.v0, scene.a0, np.array([r.memory[name][0] for name in r.multipliers])
    for k in range(1, 16):
        state = constrained_steps.newmark(p, 0.02, state, beta, gamma, level="velocity")
        assert np.allclose(r.u[k], state[0], rtol=0.0, atol=1e-9)
        assert np.allclose(r.v[k], state[1], rtol=0.0, atol=1e-8)
        assert np.allclose([r.memory[name][k] for name in r.multipliers], state[3], rtol=1e-6, atol=1e-5)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["newmark", "bathe"])
def test_steps_at_both_levels_are_those_written_by_hand(name: str) -> None:
    """After Gear, Gupta & Leimkuhler, on two rods: g and its rate are 0 at each knot, by two multipliers each."""
    _, p = rods("rod_double_pendulum")
    scene = ss.scene(read(rod_double_pendulum, level="both"))
    scheme = ss.scheme("newmark", beta=0.3025, gamma=0.6) if name == "newmark" else ss.scheme(name)
    r = ss.march(scene, scheme, dt=0.02, t_end=0.3)
    state = scene.u0, scene.v0, scene.a0, np.array([r.memory[rod][0] for rod in r.multipliers])
    for k in range(1, 16):
        if name == "newmark":
            state = constrained_steps.newmark(p, 0.02, state, 0.3025, 0.6, level="both")
        else:
            state = constrained_steps.bathe(p, 0.02, state, both=True)
        assert np.allclose(r.u[k], state[0], rtol=0.0, atol=1e-9)
        assert np.allclose(r.v[k], state[1], rtol=0.0, atol=1e-8)
        assert np.allclose([r.memory[rod][k] for rod in r.multipliers], state[3], rtol=1e-6, atol=1e-5)
        assert max(np.abs(p.g(r.u[k])).max(), np.abs(p.G(r.u[k]) @ r.v[k]).max()) < 1e-12


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["average_acceleration", "generalized_alpha", "bathe", "bdf2", "houbolt"])
def test_at_both_levels_all_is_of_second_order(name: str) -> None:
    """The multiplier of Bathe's scheme, which is of first order at positions, as well."""
    runs = [in_motion(pendulum("both"), name, dt) for dt in (0.01, 0.005)]
    assert all(np.abs((r.u**2).sum(axis=1) - 1.0).max() < 1e-13 for r in runs)
    assert all(np.abs((r.u * r.v).sum(axis=1)[3:]).max() < 1e-12 for r in runs)  # after what starts Houbolt's
    coarse, fine = map(errors, runs)
    assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("name", ["central_difference", "noh_bathe"])
def test_explicit_schemes_do_not_hold_both_levels(name: str) -> None:
    with pytest.raises(
        DeclarationError, match=f"{name}: expected implicit balances that are solved one after.* projected=True"
    ):
        ss.march(pendulum("both"), name, dt=0.01, t_end=0.1)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["average_acceleration", "bathe", "central_difference", "energy_momentum"])
def test_at_velocities_all_is_of_second_order_and_the_length_drifts_with_it(name: str) -> None:
    """The velocity is along the constraint to rounding, the multiplier of Bathe's scheme of second order as well."""
    found, drift = [], []
    for dt in (0.01, 0.005):
        r = ss.march(pendulum(), name, dt=dt, t_end=2.0)
        assert np.abs((r.u * r.v).sum(axis=1)).max() < 1e-13
        found.append(
            errors(r)[[0, 1, 3] if name == "energy_momentum" else slice(None)]
        )  # its reaction is that of the mean
        drift.append(np.abs((r.u**2).sum(axis=1) - 1.0).max())
    assert np.log2(found[0] / found[1]) == pytest.approx(2.0, abs=0.15)
    assert np.log2(drift[0] / drift[1]) == pytest.approx(2.0, abs=0.15)


@pytest.mark.usefixtures("uncompiled")
def test_the_derivative_that_is_held_is_the_total_one() -> None:
    """A pivot that is moved: the same motion where its derivative, worked out by hand, is what is declared."""
    x, y = Symbol("x"), Symbol("y")
    given: dict[str, Any] = {
        "coordinates": {x: "m", y: "m"}, "kinetic": (rate(x) ** 2 + rate(y) ** 2) / 2, "potential": G * y,
        "parameters": (), "start": {x: 0, y: -1, rate(x): 0.1, rate(y): 0}, "length": 1,
    }  # fmt: skip
    g = ((x - sin(time) / 10) ** 2 + y**2 - 1) / 2
    by_hand = (x - sin(time) / 10) * (rate(x) - cos(time) / 10) + y * rate(y)
    runs = [
        ss.march(ss.scene(Scene(name, **given, constraints={"rod": of})), "bathe", dt=0.02, t_end=0.5)
        for name, of in (("derived", Constraint(g, level="velocity")), ("by_hand", by_hand))
    ]
    assert np.allclose(runs[0].u, runs[1].u, rtol=0.0, atol=1e-12)
    assert np.allclose(runs[0].memory["rod"], runs[1].memory["rod"], rtol=0.0, atol=1e-9)


def test_a_start_off_the_constraint_and_another_level_are_refused() -> None:
    with pytest.raises(ValueError, match=r"got u off by -0.0202.*across 'rod'"):
        ss.march(pendulum(), "bathe", dt=0.01, t_end=0.1, start={"u": [0.98, 0.0], "v": [0.0, 0.0]})
    with pytest.raises(DeclarationError, match="level of a constraint among position, velocity, both, got 'force'"):
        Constraint(Symbol("x"), level="force")


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["rod_pendulum", "rod_double_pendulum"])
def test_central_differences_are_shake_and_along_the_constraints_rattle(name: str) -> None:
    """The displacements are those of both, velocities and multipliers those of SHAKE, projected velocities RATTLE's."""
    h, (scene, p) = 0.02, rods(name)
    r = ss.march(scene, "central_difference", dt=h, t_end=0.6)
    state = scene.u0, scene.v0
    for k in range(1, 30):
        before, (u, v) = state[0], constrained_steps.rattle(p, h, state)
        state = u, v
        assert np.allclose(r.u[k], u, rtol=0.0, atol=1e-11)
        assert np.allclose(scene.allowed(r.u[k], r.v[k]).v, v, rtol=0.0, atol=1e-8)
        after, multipliers = constrained_steps.shake(p, h, before, u)
        assert np.allclose(r.v[k], (after - before) / (2 * h), rtol=0.0, atol=1e-8)
        assert np.allclose([r.memory[rod][k] for rod in r.multipliers], multipliers, rtol=1e-6, atol=1e-6)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(
    ("name", "orders"), [("central_difference", (2, 2, 2)), ("noh_bathe", (2, 2, 1)), ("forest_ruth", (4, 2, 2))]
)
def test_explicit_schemes_hold_the_next_displacement_at_every_step(name: str, orders: tuple[int, ...]) -> None:
    """From a start in motion: to rounding, from the first step on; orders of u, v and the scheme's own multiplier."""
    runs = [in_motion(at_positions(), name, dt) for dt in (0.01, 0.005)]
    assert all(np.abs((r.u**2).sum(axis=1) - 1.0).max() < 1e-14 for r in runs)
    coarse, fine = map(errors, runs)
    assert np.log2(coarse / fine)[:3] == pytest.approx(orders, abs=0.3)


@pytest.mark.usefixtures("uncompiled")
def test_lanes_and_runs_that_go_on_begin_with_the_reaction_that_holds_their_first_step() -> None:
    whole, first = (ss.march(at_positions(), "central_difference", dt=0.01, t_end=t_end) for t_end in (0.4, 0.2))
    assert np.array_equal(
        ss.march(at_positions(), "central_difference", dt=0.01, t_end=0.4, start=first).u, whole.u[20:]
    )
    ds = ss.sweep("rod_pendulum", "central_difference", dt=0.02, t_end=0.4, keep="final", v0=[5.0, 6.0], L=1.0, g=G)
    for v0, u, kept in zip((5.0, 6.0), ds.u.values, ds.memory.values, strict=True):
        one = ss.march(ss.scene("rod_pendulum", v0=v0, L=1.0, g=G), "central_difference", dt=0.02, t_end=0.4)
        assert np.allclose(u, one.u[-1], rtol=0.0, atol=1e-12)
        assert kept[0] == pytest.approx(one.memory["rod"][-1], rel=1e-9)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("level", ["position", "velocity"])
def test_projected_steps_are_those_written_by_hand(level: str) -> None:
    """Of Newmark's scheme on two rods: it goes on from the projected state."""
    _, p = rods("rod_double_pendulum")
    scene = ss.scene(read(rod_double_pendulum, level=level, projected=True))
    r = ss.march(scene, ss.scheme("newmark", beta=0.3025, gamma=0.6), dt=0.02, t_end=0.3)
    state = scene.u0, scene.v0, scene.a0, np.array([r.memory[name][0] for name in r.multipliers])
    for k in range(1, 16):
        u, v, *rest = constrained_steps.newmark(p, 0.02, state, 0.3025, 0.6, level=level)
        state = *constrained_steps.projected(p, u, v), *rest
        assert np.allclose(r.u[k], state[0], rtol=0.0, atol=1e-9)
        assert np.allclose(r.v[k], state[1], rtol=0.0, atol=1e-8)


@pytest.mark.usefixtures("uncompiled")
def test_central_differences_projected_are_rattle() -> None:
    _, p = rods("rod_double_pendulum")
    scene = ss.scene(read(rod_double_pendulum, projected=True))
    r, state = ss.march(scene, "central_difference", dt=0.02, t_end=0.6), (scene.u0, scene.v0)
    for k in range(1, 31):
        state = constrained_steps.rattle(p, 0.02, state)
        assert np.allclose(r.u[k], state[0], rtol=0.0, atol=1e-11)
        assert np.allclose(r.v[k], state[1], rtol=0.0, atol=1e-9)
    half = ss.march(scene, "central_difference", dt=0.02, t_end=0.3)
    assert np.array_equal(ss.march(scene, "central_difference", dt=0.02, t_end=0.6, start=half).u, r.u[15:])


@pytest.mark.usefixtures("uncompiled")
def test_the_trapezoidal_rule_does_not_gain_energy_once_velocities_are_projected() -> None:
    """Unprojected it gains 1 % within 4 s: see test_constraints.py."""
    r = in_motion(pendulum("position", projected=True), "average_acceleration", 0.02, 6.0)
    assert np.abs(r.energy - r.energy[0]).max() < 0.01 * G


def test_what_cannot_be_projected_is_refused() -> None:
    with pytest.raises(
        DeclarationError, match="houbolt: expected steps that begin with the displacement and the velocity"
    ):
        ss.march(pendulum("position", projected=True), "houbolt", dt=0.01, t_end=0.1)
    with pytest.raises(DeclarationError, match="no contacts where constraints are projected"):
        touching = read(rod_pendulum, projected=True)
        floor = replace(touching, name="touching", contacts={"floor": Symbol("y") + 2 * Symbol("L")})
        ss.march(ss.scene(floor), "bathe", dt=0.01, t_end=0.1)


def row(scheme: str, level: str, *, projected: bool) -> tuple[str, float]:
    """A line of the table of readings, measured in steps of 1/200 s, and its last number."""
    scene = pendulum(level, projected=projected)
    coarse, r = (in_motion(scene, scheme, dt) for dt in (0.01, 0.005))
    u, v, own, tension = np.log2(errors(coarse) / errors(r))
    drifts = np.abs((r.u**2).sum(axis=1) - 1.0).max() / 2, np.abs((r.u * r.v).sum(axis=1)).max()
    held = ["rounding" if x < 1e-13 else f"{x:.1e}" for x in drifts]
    energy = np.abs(r.energy - r.energy[0]).max() / G
    reading = f"{level}{', projected' * projected}"
    orders = f"{u:.1f}, {v:.1f} | {tension:.1f}, {own:.1f}".replace("-0.0", "0.0")
    cost = work(scene, scheme, r) / work(at_positions(), scheme, in_motion(at_positions(), scheme, 0.005))
    return f"| `{scheme}` | {reading} | {orders} | {held[0]} | {held[1]} | {energy:.1e}", cost


def work(scene: Any, scheme: str, r: Any) -> float:
    """Arithmetic operations of a step, with the iterations that it takes."""
    operations = pair_kernels(scene, ss.scheme(scheme)).OPERATIONS
    iterations = r.newton_iterations.reshape(len(r.t) - 1, -1).mean(axis=0)
    return operations["step"] + iterations[: len(operations["iteration"])] @ operations["iteration"]


BOTH = ("average_acceleration", "generalized_alpha", "bathe")


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(
    "scheme",
    [
        "central_difference",
        *(pytest.param(s, marks=pytest.mark.thorough) for s in (*BOTH, "radau_iia2", "radau_iia3")),
    ],
)
def test_the_table_of_readings_is_what_is_measured(scheme: str) -> None:
    """Its text but for the cost, of which iterations may differ by a few."""
    page = (Path(__file__).parents[1] / "docs" / "constraints_and_contact.md").read_text()
    said = dict(line.removesuffix(" |").rsplit(" | ", 1) for line in page.splitlines() if line.count(" | ") == 7)
    both = [("both", False)] if scheme in BOTH else []
    for level, projected in (*product(("position", "velocity"), (False, True)), *both):
        start, cost = row(scheme, level, projected=projected)
        assert start in said
        assert float(said[start]) == pytest.approx(cost, abs=0.06)
