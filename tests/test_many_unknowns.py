"""Scenes of many coordinates: masses that move and are solved for, and systems that kernels solve in loops."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from plain_kernels import text_of, uncompiled
from scipy.integrate import solve_ivp
from substep_derive import DeclarationError, Scene, rate, sampled
from substep_derive.declare.catalogue import find, find_scene
from substep_derive.emit.first_use import catalogue_pair
from substep_derive.kernels import linear_system
from substep_derive.motion.equations import EquationsOfMotion
from sympy import Add, Expr, Rational, cos, symbols
from test_lagrange import plainly

import substep as ss
from substep.derived.modules import uncommitted_pair
from substep.marching import scene_lanes

Array = np.ndarray
pytestmark = pytest.mark.usefixtures(plainly.__name__)
GRAVITY = 9.81
LINKS = 8


def chain(n: int, **more: Any) -> Scene:
    """Point masses of 1 kg on n links of 1 m, by the angles of these from the vertical."""
    q = symbols(f"theta1:{n + 1}")
    kinetic, height = list[Expr](), list[Expr]()
    for k in range(1, n + 1):
        kinetic += [cos(a - b) * rate(a) * rate(b) / 2 for a in q[:k] for b in q[:k]]
        height += [-cos(a) for a in q[:k]]
    start: dict[Any, Any] = {a: Rational(3, 2) - Rational(k, 10) for k, a in enumerate(q)}
    return Scene(
        "chain", coordinates=dict.fromkeys(q, "rad"), kinetic=Add(*kinetic), potential=Rational("9.81") * Add(*height),
        parameters=(), start=start | {rate(a): Rational(k, 5) for k, a in enumerate(q)}, length=1, **more,
    )  # fmt: skip


def of_chain(t: float, y: Array, pushed: float = 0.0) -> Array:
    """Rates of the angles and their rates, by hand; pushed: a moment on the first angle."""
    n = len(y) // 2
    q, v, masses = y[:n], y[n:], n - np.maximum.outer(np.arange(n), np.arange(n))
    between = q[:, None] - q
    forces = -(masses * np.sin(between)) @ v**2 - GRAVITY * masses.diagonal() * np.sin(q)
    forces[0] += pushed
    return np.concatenate([v, np.linalg.solve(masses * np.cos(between), forces)])


def exact(scene: ss.Scene, t_end: float, pushed: float = 0.0) -> Array:
    begin = np.concatenate([scene.u0, scene.v0])
    found = solve_ivp(of_chain, (0.0, t_end), begin, method="DOP853", rtol=1e-12, atol=1e-13, args=(pushed,))
    return found.y[:, -1]


@cache
def long_chain() -> tuple[ss.Scene, Array]:
    scene = ss.scene(chain(LINKS))
    return scene, exact(scene, 0.4)


@pytest.mark.parametrize(
    ("scheme", "order"),
    [
        ("generalized_alpha", 2),
        ("central_difference", 2),
        *(
            pytest.param(name, order, marks=pytest.mark.thorough)
            for name, order in (("newmark", 2), ("bathe", 2), ("rk4", 4), ("radau_iia2", 3))
        ),
    ],
)
def test_a_chain_of_eight_links_is_marched(scheme: str, order: int) -> None:
    """Its mass moves with eight coordinates; accelerations of explicit schemes and at known knots are solved for."""
    scene, at_end = long_chain()
    np.testing.assert_allclose(scene.a0, of_chain(0.0, np.concatenate([scene.u0, scene.v0]))[LINKS:], rtol=1e-11)
    errors = []
    for n in (40, 80):
        r = ss.march(scene, scheme, 0.4 / n, 0.4)
        assert r.status == "completed"
        errors.append(np.abs(np.concatenate([r.u[-1], r.v[-1]]) - at_end).max())
    assert errors[1] < 0.01
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.25)


def test_a_chain_takes_steps_of_chosen_length_over_a_jump_of_its_load() -> None:
    q = symbols("theta1:6")
    scene = ss.scene(chain(5, load={q[0]: sampled}), load=ss.Step(20.0, start=0.1))
    before = exact(scene, 0.1)
    after = solve_ivp(of_chain, (0.0, 0.1), before, method="DOP853", rtol=1e-12, atol=1e-13, args=(20.0,))
    errors = []
    for tol in (1e-4, 1e-6):
        r = ss.march(scene, "rk4", tol=tol, t_end=0.2)
        errors.append(np.abs(r.u[-1] - after.y[:5, -1]).max())
    assert errors[0] < 1e-3
    assert errors[1] < 1e-5


@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe"])
def test_steps_are_chosen_where_three_coordinates_are_solved_together(scheme: str) -> None:
    """Errors are filtered by an effective mass of three rows, which is eliminated as the balance's own."""
    fine, errors = ss.march("heavy_top", "rk4", 0.001, 0.5).u[-1], []
    for tol in (1e-3, 1e-5):
        r = ss.march("heavy_top", scheme, tol=tol, t_end=0.5)
        assert r.status == "completed"
        errors.append(np.abs(r.u[-1] - fine).max())
    assert errors[0] < 0.1
    assert errors[1] < errors[0] / 10


def test_a_linear_scene_of_many_coordinates_keeps_its_energy() -> None:
    """Relative displacements of eight masses, so that the mass is full: steps are those of the trapezoidal rule."""
    q = symbols("q1:9")
    kinetic = Add(*(Add(*map(rate, q[: k + 1])) ** 2 / 2 for k in range(8))).expand()
    start: dict[Any, Any] = {a: Rational(k + 1, 10) for k, a in enumerate(q)}
    scene = ss.scene(
        Scene(
            "rods", coordinates=dict.fromkeys(q, "m"), kinetic=kinetic, potential=50 * Add(*(a**2 for a in q)),
            parameters=(), start=start | {rate(a): 0 for a in q}, length=1,
        )
    )  # fmt: skip
    r = ss.march(scene, "average_acceleration", 0.01, 1.0)
    M, h, u, v = 8.0 - np.maximum.outer(np.arange(8), np.arange(8)), 0.01, scene.u0, scene.v0
    for _ in range(100):
        ahead = u + h / 2 * v
        new = np.linalg.solve(M + 25 * h**2 * np.eye(8), M @ (ahead + h / 2 * v) - 25 * h**2 * u)
        u, v = new, 2 / h * (new - u) - v
    np.testing.assert_allclose(r.u[-1], u, rtol=0, atol=1e-12)
    np.testing.assert_allclose(r.energy, r.energy[0], rtol=1e-12)


def in_loops(scheme: str, scene: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """The text of a pair all of whose systems of three unknowns or more are solved in loops."""
    with monkeypatch.context() as patch:
        patch.setattr(linear_system, "MOST", 0)
        found = catalogue_pair(find(scheme), EquationsOfMotion(find_scene(scene)))
    assert "_first_of(system_0" in found
    return found


@pytest.mark.parametrize(
    ("scheme", "scene", "dt"),
    [
        ("newmark", "four_bar", 1e-3),
        ("radau_iia2", "rod_pendulum", 1e-2),
        ("newmark", "squeezer", 1e-5),
        ("average_acceleration", "sliding_block", 1e-2),
    ],
)
def test_loops_give_what_is_written_out(scheme: str, scene: str, dt: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """One lane after another, and side by side; of constraints, and of friction, whose branches read the Jacobian."""
    makes, steps = uncompiled(in_loops(scheme, scene, monkeypatch)), 12
    handle, s = ss.scene(scene), ss.scheme(scheme)
    for lanes in (1, scene_lanes.FEW):
        dts, n = dt * np.linspace(1.0, 1.5, lanes), np.full(lanes, steps)
        expected = scene_lanes.march_lanes(handle, s, dts, n)
        with monkeypatch.context() as patch:
            patch.setattr(scene_lanes, "pair_kernels", lambda *_: makes)
            found = scene_lanes.march_lanes(handle, s, dts, n)
        assert (found.status == 0).all()
        scale = np.abs(expected.state).max()
        np.testing.assert_allclose(found.state, expected.state, rtol=1e-9, atol=1e-11 * scale)
        assert np.array_equal(found.newton, expected.newton)


def test_few_unknowns_are_written_out() -> None:
    for scheme, scene in (("radau_iia2", "four_bar"), ("bathe", "squeezer"), ("newmark", "double_pendulum")):
        assert "_first_of" not in text_of(uncommitted_pair(scheme, scene))


def test_a_coordinate_without_mass_is_refused_where_accelerations_are_known() -> None:
    """Of five coordinates: the mass is not inverted in symbols to see it."""
    q = symbols("q1:6")
    start: dict[Any, Any] = {a: 0 for a in q} | {rate(a): 1 if a == q[0] else 0 for a in q}
    kinetic = Add(*(rate(a) ** 2 for a in q[:4])) / 2 + cos(q[1]) * rate(q[0]) * rate(q[1]) / 3
    declared = Scene(
        "light", coordinates=dict.fromkeys(q, "m"), kinetic=kinetic, potential=q[0] ** 2, parameters=(), start=start,
        length=1, constraints={"tie": q[4] - q[1]},
    )  # fmt: skip
    with pytest.raises(DeclarationError, match="a mass matrix of light that is regular, .* got no mass of q5"):
        ss.march(ss.scene(declared), "generalized_alpha", 0.01, 0.1)
    r = ss.march(ss.scene(declared), "bathe", 0.01, 0.02)
    assert r.status == "completed"


def test_loops_are_printed_for_single_precision_too() -> None:
    from substep_derive.emit.single import in_single

    with pytest.MonkeyPatch.context() as patch:
        text = in_loops("newmark", "four_bar", patch)
    single = uncompiled(in_single(text))
    handle, dts, n = ss.scene("four_bar"), np.full(scene_lanes.FEW, 1e-3), np.full(scene_lanes.FEW, 5)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scene_lanes, "TOLERANCE", scene_lanes.single.TOLERANCE)
        patch.setattr(scene_lanes, "pair_kernels", lambda *_: single)
        found = scene_lanes.march_lanes(handle, ss.scheme("newmark"), dts, n)
    expected = scene_lanes.march_lanes(handle, ss.scheme("newmark"), dts, n)
    assert 1e-9 < np.abs(found.state - expected.state)[:, 0].max() < 1e-6  # of u; accelerations are its over dt^2


def test_a_pushed_chain_is_not_the_free_one() -> None:
    """That the load of the test above counts: the pushed chain is another one, by hand."""
    scene = replace(chain(5), name="free")
    free, pushed = (exact(ss.scene(scene), 0.1, push) for push in (0.0, 20.0))
    assert np.abs(free - pushed).max() > 0.01
