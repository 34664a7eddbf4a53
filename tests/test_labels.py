"""Whatever a knot is labelled, its symbols have names of their own in Python, or the label is refused."""

import itertools

import numpy as np
import pytest
from by_hand import SCENES
from nonlinear_oracle import System
from substep_derive import Balance, DeclarationError, Scheme
from substep_derive.declare.names import entry_name, python_name
from substep_derive.declare.symbols import N, f, h, knot
from sympy import Rational, Symbol

import substep as ss
from substep.marching import scene_lanes
from substep.marching.scene_lanes import march_lanes

Array = np.ndarray
u0, v0, a0 = knot(0)
u1, v1, a1 = knot(1)


def with_a_stage(label: str) -> Scheme:
    """Two balances, the first at the middle of the step, the second with a mixed displacement, and u_-1."""
    stage, before, z = knot(label), knot(-1).u, knot("e").a
    return Scheme(
        "staged",
        relations={
            stage.u: u0 + (u0 - before) / 2,
            stage.v: (u0 - before) / h,
            u1: u0 + (h * v0 + u0 - before) / 2 + h**2 / 4 * (stage.a + z),
            v1: v0 + h / 2 * (stage.a + z),
        },
        balances=(Balance.at(stage, Rational(1, 2)), Balance(z, v1, N((u1 + stage.u) / 2), f(1))),
        start={before: u0 - h * v0 + h**2 / 2 * a0},
        report={v1: 2 * v1},
    )


def end_of_step(s: System, h: float, t: float, u: Array, before: Array, v: Array, middle: Array) -> tuple[Array, ...]:
    """Displacement, velocity and acceleration at the end of a step up to t, from the acceleration at its middle."""
    a, end, v_start = middle, u, v
    for _ in range(60):
        end = u + (h * v_start + u - before) / 2 + h**2 / 4 * (middle + a)
        v = v_start + h / 2 * (middle + a)
        a = a - correction(s, h, t, (end + u + (u - before) / 2) / 2, v, a)
    return end, v, a


def correction(s: System, h: float, t: float, mixed: Array, v: Array, a: Array) -> Array:
    """What Newton's iteration takes from the acceleration, with the force at a mixed displacement."""
    residual = s.mass @ a + s.damping @ v + s.force(mixed) - s.load(t)
    return np.linalg.solve(s.mass + h / 2 * s.damping + h**2 / 8 * s.tangent(mixed), residual)


def stepped(s: System, h: float, n: int, u: Array, v: Array, a: Array) -> Array:
    """History (n + 1, 2, d) of u and twice v of the scheme of `with_a_stage`, stepped without the code under test."""
    rows, before = [np.stack([u, v])], u - h * v + h**2 / 2 * a
    for i in range(n):
        middle = s.acceleration(u + (u - before) / 2, (u - before) / h, (i + 0.5) * h)
        (u, v, _), before = end_of_step(s, h, (i + 1) * h, u, before, v, middle), u
        rows.append(np.stack([u, 2 * v]))
    return np.array(rows)


LABELS = [
    "g",
    "m1",
    "1o1",
    "star",
    "star1",
    "mix0",
    "reported",
    "s1",
    "a b",
    "x.y",
    "1/2_",
    "½",
    "'",
    "\\",
    "0_x",
    "Zg",
    "j",
]


@pytest.mark.matrix
@pytest.mark.usefixtures("plain_pairs")
@pytest.mark.parametrize("label", LABELS)
@pytest.mark.parametrize("scene", ["duffing", "elastic_pendulum"])
def test_a_stage_steps_the_same_whatever_its_label(scene: str, label: str) -> None:
    hand, n = SCENES[scene], 12
    mine = ss.scene(scene, **hand.parameters)
    start = (hand.u0, hand.v0, hand.system.acceleration(hand.u0, hand.v0, 0.0) if hand.a0 is None else hand.a0)
    given = tuple(x[None] for x in start)
    for lanes in (1, scene_lanes.FEW):
        of_lanes = tuple(np.repeat(x, lanes, axis=0) for x in given)
        found = march_lanes(
            mine,
            ss.scheme(with_a_stage(label)),
            np.full(lanes, hand.dt),
            np.full(lanes, n),
            start=of_lanes,
            history=True,
        )
        expected = stepped(hand.system, hand.dt, n, *start)
        # Newton's tolerance of 1e-12 of the scene's length, n steps
        np.testing.assert_allclose(found.out[-1, :, :2], expected, rtol=0, atol=1e-10 * np.abs(expected).max())


def test_no_two_knots_share_a_name() -> None:
    labels = [
        *LABELS,
        "0",
        "1",
        "-1",
        "1/2",
        "-1/2",
        "2",
        "1.0",
        "01",
        "-0",
        "+1",
        "١",
        "m1o2",
        "1o2",
        "Z",
        "ZZ",
        "Z20Z",
    ]
    labels += [
        " ",
        "  ",
        "_",
        "__",
        "0_",
        "x",
        "x_j",
        "ß",
        "β",
        "ϐ",
        "star01",
        "mix",
        "mix00",
        "*star",
        "*1",
        "*mix0",
        "*reported",
    ]
    labels += ["".join(c) for k in (1, 2, 3) for c in itertools.product("Z2_a", repeat=k)]
    symbols_ = {s for label in labels for s in knot(label)}
    names = {python_name(s) for s in symbols_}
    assert len(names) == len(symbols_)
    assert all(name.isidentifier() and name.isascii() and name.count("_") == 1 for name in names)


def test_names_of_the_catalogue_are_as_their_papers_have_them() -> None:
    printed = {"u_-1": "u_m1", "v_1/2": "v_1o2", "v_-1/2": "v_m1o2", "a_*1": "a_s1", "u_*star": "u_star", "a_g": "a_g"}
    assert {name: python_name(Symbol(name)) for name in printed} == printed


def test_no_two_entries_share_a_name() -> None:
    names = [entry_name("N", i, j) for i in range(13) for j in range(13)]
    assert len(set(names)) == len(names)
    assert names[:3] == ["N00", "N01", "N02"]


@pytest.mark.parametrize("label", ["*", "*1"])
def test_labels_of_kernels_own_are_refused(label: str) -> None:
    with pytest.raises(DeclarationError, match="rename") as raised:
        with_a_stage(label)
    assert f"'a_{label}'" in str(raised.value)
