"""Friction of structures: against the same model as a scene, stiff springs that yield, and what bounds reactions."""

from itertools import product
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from hypothesis import given, settings
from hypothesis import strategies as st
from substep_derive import Contact, Friction, Scene, rate
from substep_derive.kernels.reactions import why_no_contact
from sympy import Rational, Symbol
from test_constraints import TAKEN, VERIFY
from test_contact import SOME
from test_structure_contacts import same

import substep as ss
from substep.core.kernel_modules import committed
from substep.structures.march.refusals import require_suited
from substep.structures.solvers.complementarity import NotFound, with_friction

Array = np.ndarray
x, y, z = map(Symbol, "xyz")
HELD = ["average_acceleration", "generalized_alpha", "bathe"]


def rubbing(**more: Any) -> ss.Structure:
    """A block on a floor, pressed on it the more the farther it is, beside a spring to a block that a pad holds.

    It stays on the floor: impacts would multiply what the iteration of a scene leaves.
    """
    return ss.structure(
        np.diag([1.0, 1.0, 2.0]), np.array([[50.0, 5.0, -50.0], [5.0, 0.0, 0.0], [-50.0, 0.0, 90.0]]),
        load=([0.0, -10.0, 0.0], np.ones_like), v0=[3.0, 0.0, 0.0],
        **{
            "u0": [0.1, 0.0, -0.2],
            "contacts": {"floor": ({1: 1.0}, 0.0)},
            "friction": {"drag": ({0: 1.0, 2: -0.5}, {"floor": 0.3}), "pad": ({2: 1.0}, 1.5)},
        }
        | more,
    )  # fmt: skip


def scene(restitution: Any = None) -> Any:
    return ss.scene(
        Scene(
            "rubbing", coordinates={x: "m", y: "m", z: "m"},
            kinetic=(rate(x) ** 2 + rate(y) ** 2 + 2 * rate(z) ** 2) / 2,
            potential=25 * (x - z) ** 2 + 20 * z**2 + 10 * y + 5 * x * y, contacts={"floor": Contact(y, restitution)},
            frictions={
                "drag": Friction(x - z / 2, Rational(3, 10) * Symbol("floor")), "pad": Friction(z, Rational(3, 2)),
            },
            parameters=(), length=1,
            start={x: 0.1, y: 0 if restitution is None else 0.02, z: -0.2, rate(x): 3, rate(y): 0, rate(z): 0},
        )
    )  # fmt: skip


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", TAKEN if VERIFY else SOME)
def test_a_structure_is_the_scene(name: str) -> None:
    same(scene(), rubbing(), name, ("floor",), 0.01, 0.18, within=1e-7)  # the scene's step iterates to a tolerance
    r, s = (
        ss.march(of, name, dt=0.01, t_end=0.18, **more) for of, more in ((scene(), {}), (rubbing(), {"account": False}))
    )
    for friction in ("drag", "pad"):
        assert np.allclose(r.memory[friction], s.memory[friction], rtol=1e-7, atol=1e-7)
        assert np.ptp(s.memory[friction]) > 1.0
    assert np.ptp(s.memory["floor"][2:]) > 0.5
    assert s.gaps.keys() == {"floor"}


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["average_acceleration", "central_difference"])
def test_it_is_with_restitution_too(name: str) -> None:
    same(
        scene(Rational(1, 2)), rubbing(restitution=0.5, u0=[0.1, 0.02, -0.2]), name, ("floor",), 0.01, 0.3, within=1e-7
    )


def building(**more: Any) -> ss.Structure:
    """Three stories on a base that shakes."""
    K = 400.0 * np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    s = ss.structure(np.eye(3), K, C=0.3 * np.eye(3) + 1e-4 * K, **more)
    t = 0.01 * np.arange(400)
    return s.ground_motion(ss.Record(0.01, 4.0 * np.sin(9.0 * t) * np.sin(0.8 * t), unit="m/s^2"), 1.0)


def test_pads_are_stiff_springs_that_yield() -> None:
    """Whatever holds a story sticks elastically in the law, and not at all as friction: they meet as it stiffens."""
    rows, limit = np.array([[1.0, 0.0, 0.0], [-1.0, 1.0, 0.0]]), np.array([6.0, 3.0])
    pads = ss.march(building(friction={"pads": (rows, limit)}), "average_acceleration", dt=1e-3, t_end=4.0)
    off = []
    for k in (1e5, 1e6):
        law = ss.law("bilinear", k=k, q_y=limit, alpha=0.0)
        r = ss.march(building(springs=[(rows, law)]), "average_acceleration", dt=1e-3, t_end=4.0, account=False)
        off.append(np.abs(r.u - pads.u).max() / np.abs(r.u).max())
    assert off[1] < 0.4 * off[0] < 0.01  # what sticks rings, with an amplitude like 1/sqrt(k)
    slides = np.diff(pads.u @ rows.T, axis=0)
    assert (np.abs(slides).max(axis=0) > 1e-4).all()
    assert (np.abs(slides).min(axis=0) < 1e-12).all()  # it sticks
    assert (np.abs(pads.memory["pads"]) <= limit * (1.0 + 1e-12)).all()


@pytest.mark.parametrize("name", HELD)
def test_what_friction_takes_is_damped_energy(name: str) -> None:
    s = building(friction={"pad": ([1.0, 0.0, 0.0], 6.0)})
    r = ss.march(s, name, dt=0.01, t_end=6.0)
    assert r.account is not None
    by_friction = float((r.memory["pad"][1:] * np.diff(r.u[:, 0])).sum())
    by_damping = float(r.account.damped[-1]) - by_friction
    assert by_friction > 2.0 * by_damping > 0.0
    assert np.abs(r.account.numerical).max() < (1e-12 if name == "average_acceleration" else 0.02) * by_friction


@pytest.mark.parametrize("name", HELD)
def test_what_a_friction_bears_does_not_move(name: str) -> None:
    for load, slides in ((0.99, False), (1.01, True)):
        s = ss.structure([[2.0]], [[0.0]], load=([load], np.ones_like), friction={"pad": ([1.0], 1.0)})
        r = ss.march(s, name, dt=0.01, t_end=1.0)
        assert bool(np.abs(r.u).max() > 1e-3) == slides
        assert r.memory["pad"][-1] == pytest.approx(min(load, 1.0), rel=1e-9)
        if slides:
            assert r.u[-1, 0] == pytest.approx(0.01 / 4.0, rel=0.03)  # (load - limit) t^2/(2 m)


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize("name", ["average_acceleration", "newmark"])
def test_springs_of_laws_rub_too(name: str) -> None:
    """A hardening spring beside a pad: Newton's iteration, with the friction in each of its steps."""
    hardening = Scene(
        "hardening", coordinates={x: "m"}, kinetic=rate(x) ** 2 / 2, potential=5 * x**2 + 50 * x**4,
        frictions={"pad": Friction(x, Rational(2))}, parameters=(), start={x: 0.6, rate(x): 0}, length=1,
    )  # fmt: skip
    s = ss.structure(
        [[1.0]], internal_force=lambda u: 10.0 * u + 200.0 * u**3, tangent=lambda u: np.diag(10.0 + 600.0 * u**2),
        u0=0.6, friction={"pad": ([1.0], 2.0)},
    )  # fmt: skip
    r, own = (ss.march(of, name, dt=0.01, t_end=6.0) for of in (ss.scene(hardening), s))
    assert np.allclose(r.u, own.u, rtol=0.0, atol=1e-9)
    assert np.abs(own.v[-20:]).max() < 1e-9


def test_a_run_goes_on_exactly() -> None:
    s = rubbing()
    whole, first = (ss.march(s, "generalized_alpha", dt=0.01, t_end=t, account=False) for t in (1.0, 0.37))
    on = ss.march(s, "generalized_alpha", dt=0.01, t_end=1.0, start=first, account=False)
    assert np.array_equal(on.u, whole.u[len(first.t) - 1 :])
    assert np.array_equal(on.memory["pad"][1:], whole.memory["pad"][len(first.t) :])


def test_schemes_take_friction_as_they_do_on_scenes() -> None:
    """The gate asks every fourth scheme."""
    known = [name for name in ss.schemes() if not ss.scheme(name).info.together][:: 1 if VERIFY else 4]
    s = rubbing(contacts=None, friction={"pad": ({2: 1.0}, 1.5)})
    for name in known:
        one = ss.scheme(name)
        every = [one, *([one.starter] if one.starter else [])]
        if not VERIFY and not all(committed(f"plans.{x.kernels.NAME}") for x in every):
            continue
        if any(why_no_contact(BY_NAME[x.kernels.NAME], friction=True) for x in every):
            with pytest.raises(ValueError, match="expected"):
                require_suited(s, one, 0.01)
        else:
            require_suited(s, one, 0.01)
    with pytest.raises(ValueError, match="rk4: expected each balance to move the velocity"):
        ss.march(s, "rk4", dt=0.001, t_end=0.1)


reals = st.floats(-3.0, 3.0).map(lambda value: round(value, 3))


@given(st.integers(0, 2), st.integers(1, 3), st.data())
@settings(max_examples=300 if VERIFY else 60)
def test_reactions_are_within_their_bounds(g: int, f: int, data: st.DataObject) -> None:
    """Random gaps and frictions on a mass matrix: what is found is right; where nothing is, nothing is right."""
    d = g + f
    rows, q = (np.array(data.draw(st.lists(reals, min_size=n, max_size=n))) for n in (d * (d + 1), d))
    least = np.abs(data.draw(st.lists(reals, min_size=f, max_size=f)))
    shares = np.abs(np.reshape(data.draw(st.lists(reals, min_size=f * g, max_size=f * g)), (f, g)))
    B = rows.reshape(d, d + 1) + 0.2 * np.eye(d, d + 1)
    W = B @ B.T + 1e-6 * np.eye(d)
    try:
        p = with_friction(q, W, np.zeros(d), least, shares)
    except NotFound:
        assert not any(
            _right(q, W, _at(q, W, least, shares, sides), least, shares) for sides in product((-1, 0, 1), repeat=d)
        )
        return
    assert _right(q, W, p, least, shares)


def _at(q: Array, W: Array, least: Array, shares: Array, sides: tuple[int, ...]) -> Array:
    """Reactions on sides by elimination, written again: p = c + E p, or w = 0, row by row."""
    d, g = len(q), len(q) - len(least)
    A, right = np.eye(d), np.zeros(d)
    for i, side in enumerate(sides):
        if side == 0:
            A[i], right[i] = W[i], -q[i]
        elif i >= g:
            A[i, :g] -= side * shares[i - g]
            right[i] = side * least[i - g]
    return np.linalg.lstsq(A, right, rcond=None)[0]


def _right(q: Array, W: Array, p: Array, least: Array, shares: Array) -> bool:
    g, w, near = len(q) - len(least), q + W @ p, 1e-7 * (1.0 + np.abs(q) + np.abs(W) @ np.abs(p))
    most, small = least + shares @ p[:g], 1e-7 * (1.0 + np.abs(p).max())
    gaps = (p[:g] >= -small) & (w[:g] >= -near[:g]) & ((p[:g] <= small) | (w[:g] <= near[:g]))
    r, v, close = p[g:], w[g:], near[g:]
    rubs = (np.abs(r) <= most + small) & ((v <= close) | (r <= small - most)) & ((v >= -close) | (r >= most - small))
    return bool(gaps.all() and rubs.all())


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({"friction": [({0: 1.0}, 1.0)]}, r"a mapping of names to pairs \(row of B, limit\), got list"),
        ({"friction": {"pad": ({0: 1.0}, -1.0)}}, "expected a limit of 0 or more of friction 'pad', got -1.0"),
        ({"friction": {"pad": ({0: 1.0}, {"floor": -0.1})}}, "expected a limit of 0 or more of friction 'pad'"),
        ({"friction": {"pad": ({0: 1.0}, {"flor": 0.1})}}, "a contact as the limit of friction 'pad'.*floor"),
        ({"friction": {"pad": ({0: 1.0}, np.nan)}}, "the limit of friction 'pad' to be finite"),
        ({"friction": {"pad": (np.eye(3), [1.0, 2.0])}}, "expected one limit of friction 'pad' or 3, one for each row"),
        ({"friction": {"floor": ({0: 1.0}, 1.0)}}, "names of frictions that no contact has, got 'floor' twice"),
        ({"friction": {"a": ({0: 1.0}, 1.0), "b": ({0: 2.0}, 1.0)}}, "got one of contact 'b' that those before"),
        ({"friction": {"a": ({0: 0.0}, 1.0)}}, "a row of contact 'a' that is 0"),
        ({"remembered": True}, "expected remembered=True without friction"),
        (
            {"contacts": {"two": (np.eye(3)[:2], 1.0)}, "friction": {"pad": ({2: 1.0}, {"two": 0.1})}},
            "expected friction 'pad' of 2 rows, as many as contact 'two' has, got 1",
        ),
    ],
)  # fmt: skip
def test_what_is_no_friction_is_refused(given: dict[str, Any], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        rubbing(**given)


def test_what_does_not_know_friction_refuses_it() -> None:
    s = building(friction={"pad": ([1.0, 0.0, 0.0], 6.0)})
    with pytest.raises(ValueError, match="without contacts for a critical step, got contacts pad"):
        s.critical_step("central_difference")
