"""Starts in equilibrium with the loads: u0="static"."""

from typing import Any

import numpy as np
import pytest
from small_frame import NAMES, RECORD, K, M, frame

import substep as ss

WEIGHT = ({"roof": -3.0, "first": -2.0}, ss.Step(9.81))
SPRINGS = np.array([40.0, 30.0, 20.0])


def chain(u: np.ndarray) -> np.ndarray:
    """The forces of hardening springs in a row from a support."""
    e = np.diff(u, prepend=0.0)
    q = SPRINGS * (e + 5.0 * e**3)
    return q - np.append(q[1:], 0.0)


def tangent(u: np.ndarray) -> np.ndarray:
    e = np.diff(u, prepend=0.0)
    k = SPRINGS * (1.0 + 15.0 * e**2)
    return np.diag(k + np.append(k[1:], 0.0)) - np.diag(k[1:], 1) - np.diag(k[1:], -1)


def hardening(**more: Any) -> ss.Structure:
    given: dict[str, Any] = {"internal_force": chain, "tangent": tangent, "u0": "static"}
    return ss.structure(M, **given | {"load": ([3.0, -1.0, 6.0], ss.Step(4.0))} | more)


def test_a_structure_under_its_weight_stays_at_rest() -> None:
    s = frame(u0="static", load=WEIGHT)
    np.testing.assert_allclose(K @ s.u0, [-2.0 * 9.81, 0.0, -3.0 * 9.81], rtol=1e-13, atol=1e-13)
    assert np.abs(s.a0).max() < 1e-13
    r = ss.march(s, "bathe", dt=0.1, t_end=2.0)
    assert np.abs(r.u - s.u0).max() < 1e-12 * np.abs(s.u0).max()


def test_what_comes_later_adds_to_it() -> None:
    """By superposition: the weight, then a ground motion, as the ground motion alone beside the static displacement."""
    both = frame(u0="static", load=WEIGHT).ground_motion(RECORD, [1.0, 1.0, 1.0])
    alone = frame(u0=0.0).ground_motion(RECORD, [1.0, 1.0, 1.0])
    u, v = (ss.march(s, "newmark", dt=0.05, t_end=3.0).u for s in (both, alone))
    np.testing.assert_allclose(u, v + both.u0, atol=1e-12)


def test_fixed_and_constrained() -> None:
    T = np.array([[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]])
    s = frame(u0="static", load=WEIGHT, constraints=T)
    np.testing.assert_allclose(T.T @ K @ T @ s.u0, T.T @ [-2.0 * 9.81, 0.0, -3.0 * 9.81], rtol=1e-13)
    held = frame(u0="static", load=({"roof": -3.0}, ss.Step(9.81)), fixed=["first"])
    np.testing.assert_allclose(K[1:, 1:] @ held.u0, [0.0, -3.0 * 9.81], atol=1e-13)


def test_an_internal_force_bears_the_load() -> None:
    s = hardening()
    np.testing.assert_allclose(chain(s.u0), 4.0 * np.array([3.0, -1.0, 6.0]), rtol=1e-12)
    np.testing.assert_allclose(s.K, tangent(s.u0))  # the tangent at the start, which Rayleigh damping takes
    r = ss.march(s, "bathe", dt=0.05, t_end=1.0)
    assert np.abs(r.u - s.u0).max() < 1e-10
    assert np.array_equal(hardening(load=()).u0, np.zeros(3))


def test_a_far_equilibrium_needs_halved_corrections() -> None:
    """An arctangent: full corrections from zero diverge."""
    s = ss.structure(
        [[1.0]], internal_force=lambda u: np.arctan(3.0 * u) + 0.01 * u, load=([1.0], ss.Step(1.5)), u0="static",
        tangent=lambda u: [3.0 / (1.0 + 9.0 * u**2) + 0.01],
    )  # fmt: skip
    assert np.arctan(3.0 * s.u0[0]) + 0.01 * s.u0[0] == pytest.approx(1.5, rel=1e-13)


def test_refusals() -> None:
    with pytest.raises(ValueError, match="expected u0 as displacements or 'static', got 'rest'; give numbers"):
        frame(u0="rest")
    with pytest.raises(ValueError, match="regular matrix of K, the stiffness matrix, for u0='static', got one"):
        ss.structure(np.eye(2), [[1.0, -1.0], [-1.0, 1.0]], u0="static", load=([1.0, 0.0], ss.Step(1.0)))
    with pytest.raises(ValueError, match="expected tangent= with u0='static'"):
        hardening(tangent=None)
    with pytest.raises(ValueError, match="expected an equilibrium under the loads at t = 0, got a residual of"):
        ss.structure(
            [[1.0]], internal_force=np.sin, tangent=lambda u: [np.cos(u)], u0="static",
            load=([1.0], ss.Step(2.0)),
        )  # fmt: skip
    assert frame(u0="static").names == NAMES
