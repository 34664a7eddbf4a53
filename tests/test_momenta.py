"""Noether's momenta: which there are is counted in numbers, and they stay where nothing else acts."""

from typing import Any

import numpy as np
import pytest
from scipy.linalg import null_space
from substep_derive import Scene, optional, rate
from substep_derive.declare.catalogue import find_law
from substep_derive.declare.law import Element
from substep_derive.declare.scenes import declared
from substep_derive.motion.equations import EquationsOfMotion
from sympy import Expr, Matrix, Rational, Symbol, cos, lambdify, sqrt, symbols

import substep as ss

x1, y1, x2, y2, phi = PLACES = symbols("x1 y1 x2 y2 phi")
k, m1, m2, L = symbols("k m1 m2 L")


def in_plane(coordinates: dict[Symbol, str], potential: Expr, mass: dict[Symbol, Any], **more: Any) -> Scene:
    start = {q: Rational(3 * i + 2, 5) for i, q in enumerate(coordinates)}
    start |= {rate(q): Rational(1 - 2 * (i % 2), 3 + i) for i, q in enumerate(coordinates)}
    return Scene(
        name="in_plane",
        coordinates=coordinates,
        parameters=tuple(optional(s, value) for s, value in ((k, 7), (m1, 1), (m2, 2), (L, 1))),
        kinetic=sum(of * rate(q) ** 2 / 2 for q, of in mass.items()),
        potential=potential,
        start=start,
        length=L,
        reference="a test",
        **more,
    )


LENGTHS = dict.fromkeys((x1, y1, x2, y2), "m")
MASSES = {x1: m1, y1: m1, x2: m2, y2: m2}
DISTANCE = sqrt((x2 - x1) ** 2 + (y2 - y1) ** 2)
PAIR = in_plane(LENGTHS, k * (DISTANCE - L) ** 2 / 2, MASSES)
POINT = {x1: "m", y1: "m"}
OWN = {
    "two points and a spring": (PAIR, ["x1 y1 + x2 y2", "x1 + x2", "y1 + y2"]),
    "with a weight": (in_plane(LENGTHS, k * DISTANCE**2 + m1 * y1, MASSES), ["x1 + x2"]),
    "around a pivot elsewhere": (
        in_plane(POINT, k * ((x1 - 2) ** 2 + y1**2) ** 2, {x1: m1, y1: m1}), ["x1 y1 - 2 y1"]
    ),
    "a lopsided mass": (in_plane(POINT, k * (x1**2 + y1**2), {x1: m1, y1: m2}), []),
    "a lopsided spring": (in_plane(POINT, k * (x1**2 + 2 * y1**2), {x1: m1, y1: m1}), []),
    "a field along a line": (in_plane(POINT, k * cos(x1 - 3 * y1), {x1: m1, y1: m1}), ["3 x1 + y1"]),
    "a field that turns with an angle": (
        in_plane({**POINT, phi: "rad"}, k * (x1 * cos(phi) + y1 * cos(phi - 2)), {x1: m1, y1: m1, phi: m2}), []
    ),
    "a law between two": (
        in_plane({x1: "m", x2: "m"}, 0 * k, {x1: m1, x2: m2},
                 laws={"link": Element(find_law("linear"), x2 - x1, {"k": k})}), ["x1 + x2"]
    ),
    "a law to the ground": (
        in_plane({x1: "m", x2: "m"}, 0 * k, {x1: m1, x2: m2},
                 laws={"link": Element(find_law("linear"), x1, {"k": k})}), ["x2"]
    ),
}  # fmt: skip


def count(motion: EquationsOfMotion) -> int:
    """How many rotations and translations change neither the Lagrangian nor reactions, from values at random places."""
    scene, rng = motion.scene, np.random.default_rng(3)
    q = list(scene.coordinates)
    planes = [(a, b) for i, a in enumerate(q) for b in q[i + 1 :]]
    planes = [(a, b) for a, b in planes if scene.coordinates[a] == scene.coordinates[b] != "rad"]
    lagrangian = (scene.kinetic - scene.potential).subs(scene.invariants)
    kept = [lagrangian, *motion.held.expressions, *(element.elongation for element in scene.laws.values())]
    moved = [*q, *map(rate, q)]
    slopes = Matrix(kept).jacobian(moved)
    others = sorted(slopes.free_symbols - set(moved), key=str)
    of_numbers = lambdify(
        [moved, others], slopes, [{"is_negative": lambda x: x < 0, "negative_part": lambda x: min(x, 0)}, "numpy"]
    )
    rows = []
    for _ in range(3 * (len(planes) + len(q))):
        place = rng.uniform(-1.7, 1.7, len(moved))
        at = dict(zip(moved, place, strict=True))
        for row in of_numbers(place, rng.uniform(0.3, 1.7, len(others))):
            slope = dict(zip(moved, row, strict=True))
            turn = [at[s(a)] * slope[s(b)] - at[s(b)] * slope[s(a)] for a, b in planes for s in (lambda z: z, rate)]
            rows.append([*np.reshape(turn, (-1, 2)).sum(1), *(slope[a] for a in q)])
    return null_space(np.array(rows), rcond=1e-9).shape[1]


@pytest.mark.parametrize(
    "scene", [s for s in declared() if not any(EquationsOfMotion(s).held.of_rates)], ids=lambda s: s.name
)
def test_a_scene_has_as_many_as_it_has_symmetries(scene: Scene) -> None:
    motion = EquationsOfMotion(scene)
    assert len(motion.momenta) == count(motion)


@pytest.mark.parametrize("name", OWN)
def test_they_have_the_names_of_what_is_moved(name: str) -> None:
    scene, names = OWN[name]
    motion = EquationsOfMotion(scene)
    assert [p.name for p in motion.momenta] == names
    assert len(names) == count(motion)


def test_a_constraint_of_rates_leaves_none() -> None:
    skate = in_plane(
        {**POINT, phi: "rad"}, 0 * k, {x1: m1, y1: m1, phi: m2}, constraints={"edge": rate(x1) - phi * rate(y1)}
    )
    assert EquationsOfMotion(skate).momenta == []


@pytest.mark.parametrize("scheme", ["average_acceleration", "generalized_alpha", "bathe", "rk4", "gauss2"])
def test_every_scheme_keeps_what_is_linear(scheme: str, plainly: None) -> None:
    """And the angular one to its order: halving the step leaves at most a third of its change."""
    changes = []
    for dt in (0.04, 0.02):
        r = ss.march(ss.scene(PAIR), scheme, dt, 1.0)
        for name, start in (("x1 + x2", r.v[0, 0] + 2 * r.v[0, 2]), ("y1 + y2", r.v[0, 1] + 2 * r.v[0, 3])):
            np.testing.assert_allclose(r.momenta[name], start, rtol=0, atol=1e-13)
        J = r.u[:, 0] * r.v[:, 1] - r.u[:, 1] * r.v[:, 0] + 2 * (r.u[:, 2] * r.v[:, 3] - r.u[:, 3] * r.v[:, 2])
        np.testing.assert_allclose(r.angular_momentum, J, rtol=1e-13)
        changes.append(np.ptp(J))
    assert changes[1] < max(changes[0] / 3, 1e-13)
    assert {"angular_momentum", "momentum_x1_x2", "momentum_y1_y2"} <= set(r.to_xarray())


def test_a_law_between_two_keeps_their_momentum(plainly: None) -> None:
    """Which does not depend on what the law remembers."""
    steel = Element(find_law("bilinear"), x2 - x1, {"k": k, "q_y": k / 10, "alpha": Rational(1, 20)})
    scene = in_plane({x1: "m", x2: "m"}, 0 * k, {x1: m1, x2: m2}, laws={"link": steel})
    r = ss.march(ss.scene(scene), "average_acceleration", 0.01, 1.0)
    assert np.ptp(r.memory["link_p"] if "link_p" in r.memory else r.memory["p"]) > 0.1
    np.testing.assert_allclose(r.momenta["x1 + x2"], r.v[0] @ [1.0, 2.0], rtol=0, atol=1e-13)


@pytest.mark.usefixtures("plain_in_gate")
def test_the_top_has_two() -> None:
    r = ss.march("heavy_top", "dormand_prince", 0.005, 1.0)
    for momentum in r.momenta.values():
        np.testing.assert_allclose(momentum, momentum[0], rtol=1e-9)
    assert list(r.momenta) == ["phi", "psi"]
