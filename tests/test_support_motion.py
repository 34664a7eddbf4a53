"""Supports that move, together or each in its own way, against the whole structure with its supports driven."""

from typing import Any

import numpy as np
import pytest
from scipy import sparse
from scipy.integrate import solve_ivp

import substep as ss

# a chain of four: supports 0 and 3, masses 1 and 2 between them, and a spring from 1 to the ground
K = np.array([[50.0, -50.0, 0, 0], [-50, 130, -60, 0], [0, -60, 90, -30], [0, 0, -30, 30]])
M = np.diag([1.0, 2.0, 1.5, 1.0])
FREE = [1, 2]


def chain(**options: Any) -> Any:
    return ss.structure(M, K, fixed=[0, 3], **options)


def exact(left: Any, right: Any, t_end: float, C: np.ndarray | None = None) -> np.ndarray:
    """u of the masses at t_end where the supports are at `left` and `right`, pairs of displacement and velocity."""
    free, held = np.ix_(FREE, FREE), np.ix_(FREE, [0, 3])
    damping = np.zeros((4, 4)) if C is None else C

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        moved, moving = (np.array([left[k](t), right[k](t)]) for k in (0, 1))
        force = -K[held] @ moved - damping[held] @ moving - K[free] @ y[:2] - damping[free] @ y[2:]
        return np.concatenate([y[2:], force / np.diag(M)[FREE]])

    return solve_ivp(rate, (0.0, t_end), np.zeros(4), method="DOP853", rtol=1e-12, atol=1e-13).y[:2, -1]


LEFT = (lambda t: 0.1 * (1 - np.cos(2.0 * t)), lambda t: 0.2 * np.sin(2.0 * t), lambda t: 0.4 * np.cos(2.0 * t))
RIGHT = (lambda t: 0.05 * t**2, lambda t: 0.1 * t, lambda t: 0.1 + 0.0 * t)


@pytest.mark.parametrize(
    ("given", "C"),
    [(ss.Rayleigh(0.0, 0.01), 0.01 * K), (0.02 * K, 0.02 * K), (sparse.csr_array(0.01 * K), 0.01 * K), (None, 0.0 * K)],
)
def test_each_support_moves_in_its_own_way(given: Any, C: np.ndarray) -> None:
    expected = exact(LEFT, RIGHT, 3.0, C)
    shaken = chain(C=given)
    for dof, (u, v, _) in ((0, LEFT), (3, RIGHT)):
        shaken = shaken.support_motion([dof], displacement=u, velocity=v)
    r = ss.march(shaken, "rkn64" if shaken.C is None else "dormand_prince", dt=0.005, t_end=3.0)
    assert np.abs(r.u[-1, FREE] - expected).max() < 1e-9


def test_by_accelerations_the_motion_is_that_beyond_the_static_one() -> None:
    expected = exact(LEFT, RIGHT, 2.0)
    h = 0.001
    t = np.arange(0.0, 2.0 + 2 * h, h)
    shaken = chain()
    static = np.zeros(2)
    for dof, (u, _, a) in ((0, LEFT), (3, RIGHT)):
        shaken = shaken.support_motion([dof], acceleration=ss.Record(h, a(t)))
        static += -np.linalg.solve(K[np.ix_(FREE, FREE)], K[FREE, dof]) * u(2.0)
    r = ss.march(shaken, "newmark", dt=h, t_end=2.0)
    assert np.abs(r.u[-1, FREE] + static - expected).max() < 1e-5


def test_all_supports_together_are_a_motion_of_the_ground() -> None:
    floor = np.array([[30.0, -30, 0], [-30, 50, -20], [0, -20, 20]])
    building, record = ss.structure(np.eye(3), floor, fixed=[0]), ss.Record(0.02, np.sin(np.arange(100.0)))
    one = ss.march(building.support_motion([0], acceleration=record), "bathe", dt=0.02, t_end=1.0)
    other = ss.march(building.ground_motion(record, 1.0), "bathe", dt=0.02, t_end=1.0)
    assert np.allclose(one.u, other.u, rtol=1e-12, atol=1e-15)
    assert np.allclose(one.absolute_a, other.absolute_a, rtol=1e-11, atol=1e-13)


@pytest.mark.parametrize(
    ("made", "match"),
    [
        (lambda s: s.support_motion([1], displacement=ss.Step(1.0)), "which moves; fix it"),
        (lambda s: s.support_motion([], displacement=ss.Step(1.0)), "at least one support"),
        (lambda s: s.support_motion([0]), "one of the two"),
        (lambda s: s.support_motion([0], displacement=ss.Step(1.0), acceleration=ss.Record(1.0, [0, 1])), "one of the"),
        (lambda s: s.support_motion([0], acceleration=ss.Step(1.0)), "ss.Record"),
    ],
)
def test_what_is_no_motion_of_supports_is_refused(made: Any, match: str) -> None:
    with pytest.raises(ValueError, match=match):
        made(chain())


def test_damping_and_mass_between_supports_and_structure_are_not_left_out_silently() -> None:
    moved = {"displacement": ss.Step(0.1)}
    for C in (ss.Rayleigh(0.0, 0.01), 0.01 * K):
        with pytest.raises(ValueError, match="expected velocity= with displacement="):
            chain(C=C).support_motion([0], **moved)
    chain(C=np.diag([1.0, 2.0, 1.0, 0.0])).support_motion([0], **moved)  # nothing between supports and structure
    for s in (chain(C=ss.modal_damping(0.05, modes=2)), chain(C=0.01 * K).modes(2).damped(0.05).structure):
        with pytest.raises(ValueError, match="or a matrix, got ratios of modes"):
            s.support_motion([0], **moved)
    coupled = M + 0.1 * np.eye(4, k=1) + 0.1 * np.eye(4, k=-1)
    with pytest.raises(ValueError, match="lumped"):
        ss.structure(coupled, K, fixed=[0, 3]).support_motion([0], **moved)
    with pytest.raises(ValueError, match="internal force"):
        ss.structure(M, internal_force=lambda u: K @ u, tangent=lambda u: K, fixed=[0, 3]).support_motion([0], **moved)


def test_a_static_start_is_so_with_the_supports_where_they_are_put_at_the_start() -> None:
    """By the whole chain: K u = f with the supports' displacements given; from there on nothing moves."""
    weight = np.array([0.0, -3.0, 2.0, 0.0])
    put = np.array([0.1, 0.0, 0.0, -0.2])
    expected = np.linalg.solve(K[np.ix_(FREE, FREE)], (weight - K @ put)[FREE])
    still = chain(load=(weight, ss.Step(1.0)), u0="static")
    for dof in (0, 3):
        still = still.support_motion([dof], displacement=ss.Step(put[dof]))
    r = ss.march(still, "bathe", dt=0.01, t_end=1.0)
    assert np.abs(r.u[:, FREE] - expected).max() < 1e-12
    later = chain(load=(weight, ss.Step(1.0)), u0="static").support_motion([0], displacement=ss.Step(0.1, start=0.5))
    assert later.u0 == pytest.approx(np.linalg.solve(K[np.ix_(FREE, FREE)], weight[FREE]), rel=1e-12)
    given = chain(load=(weight, ss.Step(1.0))).support_motion([0], displacement=ss.Step(0.1))
    assert not given.u0.any()  # that is the start that was given
