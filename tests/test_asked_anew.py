"""Functions of the user's that read what changes between two marches: what they answered before is not taken again."""

from typing import Any

import numpy as np
import pytest

import substep as ss

SCHEMES = ("newmark", "central_difference", "bathe", "energy_momentum", "kr_alpha", "houbolt", "lsrt2", "alpha_os")


def soft(stiffness: list[float], **more: Any) -> ss.Structure:
    return ss.structure(
        np.eye(2),
        internal_force=lambda u: stiffness[0] * (u + u**3),
        tangent=lambda u: stiffness[0] * np.diag(1.0 + 3.0 * u**2),
        potential=lambda u: stiffness[0] * float(u @ u / 2.0 + (u**4).sum() / 4.0),
        u0=[1.0, -0.5],
        **more,
    )


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_force_that_has_changed_is_asked_anew_at_the_start(scheme: str) -> None:
    stiffness = [100.0]
    before = soft(stiffness)
    ss.march(before, scheme, dt=0.01, t_end=0.2)
    stiffness[0] = 200.0
    again, fresh = (ss.march(s, scheme, dt=0.01, t_end=0.2) for s in (before, soft(stiffness)))
    assert np.allclose(again.a[0], -200.0 * np.array([2.0, -0.625]), rtol=1e-14)
    assert np.array_equal(again.u, fresh.u)


@pytest.mark.parametrize("call", [{"tol": 1e-5}, {"dt": 0.01}])
def test_rayleigh_damping_and_chosen_steps_take_the_tangent_as_it_is(call: dict[str, float]) -> None:
    stiffness = [100.0]
    damping = ss.rayleigh(0.05, 0.05, at=(5.0, 20.0))
    before = soft(stiffness, C=damping)
    ss.march(before, "bathe", t_end=0.2, **call)
    stiffness[0] = 200.0
    again, fresh = (ss.march(s, "bathe", t_end=0.2, **call) for s in (before, soft(stiffness, C=damping)))
    assert np.array_equal(again.u, fresh.u)


def test_modes_are_those_of_the_tangent_as_it_is() -> None:
    stiffness = [100.0]
    s = soft(stiffness)
    stiffness[0] = 200.0
    assert np.allclose(s.modes(2).omega, np.sqrt([350.0, 800.0]), rtol=1e-12)


def test_an_equilibrium_with_another_force_is_refused() -> None:
    stiffness = [100.0]
    s = ss.structure(
        np.eye(1), internal_force=lambda u: stiffness[0] * u, tangent=lambda _: np.array([[stiffness[0]]]),
        load=([1.0], ss.Step(1.0)), u0="static",
    )  # fmt: skip
    assert np.allclose(ss.march(s, "newmark", dt=0.01, t_end=0.1).u, 0.01, rtol=1e-12)
    stiffness[0] = 200.0
    assert ss.march(s, "newmark", dt=0.01, t_end=0.1, start={"u": 0.01, "v": 0.0}).a[0, 0] == pytest.approx(-1.0)
    with pytest.raises(ValueError, match="u0='static' in equilibrium with internal_force as it is"):
        ss.march(s, "newmark", dt=0.01, t_end=0.1)


def test_a_sweep_asks_anew() -> None:
    stiffness = [100.0]
    before = soft(stiffness)
    call: dict[str, Any] = {"dt": [0.01, 0.02], "t_end": 0.2, "keep": "peak"}
    ss.sweep(before, "newmark", **call)
    stiffness[0] = 200.0
    again, fresh = (ss.sweep(s, "newmark", **call) for s in (before, soft(stiffness)))
    assert np.array_equal(again.peak_a, fresh.peak_a)


def test_a_load_of_a_structure_that_has_changed_gives_the_start_its_acceleration() -> None:
    size = [1.0]
    K = np.array([[6.0, -2.0], [-2.0, 4.0]])
    frame = ss.structure(np.eye(2), K, load=([1.0, 0.0], lambda t: size[0] * np.cos(t)))
    ss.march(frame, "newmark", dt=0.05, t_end=1.0)
    size[0] = 2.0
    twice = ss.march(frame, "newmark", dt=0.05, t_end=1.0)
    exact = ss.march(ss.structure(np.eye(2), K, load=([2.0, 0.0], np.cos)), "newmark", dt=0.05, t_end=1.0)
    assert np.allclose(twice.u, exact.u, rtol=1e-12, atol=1e-15)


def test_a_scene_whose_load_has_changed_at_the_start_is_to_be_made_anew() -> None:
    size = [1.0]
    scene = ss.scene("linear_oscillator", omega=3.0, u0=0.0, load=lambda t: size[0] * np.cos(t))
    ss.march(scene, "newmark", dt=0.05, t_end=1.0)
    size[0] = 2.0
    with pytest.raises(ValueError, match=r"a0 = \[2\.\], got \[1\.\].*make it anew where what its load reads"):
        ss.march(scene, "newmark", dt=0.05, t_end=1.0)
    r = ss.march(scene, "newmark", dt=0.05, t_end=1.0, start={"u": 0.0, "v": 0.0})
    assert r.a[0, 0] == pytest.approx(2.0, rel=1e-12)
