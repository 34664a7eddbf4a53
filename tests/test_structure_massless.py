"""Nodes without mass beside contacts of structures, and mass that is moved from one node to others."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_constraints import VERIFY
from test_structure_contacts import PAIR, bar

import substep as ss

Array = np.ndarray


def test_a_massless_degree_of_freedom_may_be_beside_a_contact() -> None:
    """A mass that carries a massless node on two springs meets a floor as it would with both springs in one."""
    chain = np.array([[300.0, -300.0, 0.0], [-300.0, 450.0, -150.0], [0.0, -150.0, 150.0]])
    given: dict[str, Any] = {"v0": -1.0, "contacts": {"floor": ({0: 1.0}, 0.1)}}
    three = ss.structure(np.diag([1.0, 0.0, 2.0]), chain, **given)
    two = ss.structure(np.diag([1.0, 2.0]), 100.0 * PAIR, **given)
    r, s = (ss.march(x, "average_acceleration", dt=0.01, t_end=0.6) for x in (three, two))
    assert np.allclose(r.u[:, [0, 2]], s.u, rtol=0.0, atol=1e-12)
    with pytest.raises(ValueError, match="expected mass at the degrees of freedom of contacts, got none at 1"):
        ss.structure(np.diag([1.0, 0.0, 2.0]), chain, contacts={"floor": ({1: 1.0}, 0.1)})


@pytest.mark.parametrize("name", ["average_acceleration", "bathe", "newmark_bdf2", "generalized_alpha", "houbolt"])
def test_a_massless_node_meets_a_stop_as_a_gap_in_a_spring(name: str) -> None:
    """A mass on a spring whose other end is free until it meets a stop: what pushes is the spring, and only pushes.

    The same as an internal force; where it begins at rest on the stop, the reaction bears what presses there.
    """
    k, gap = 300.0, 0.1

    def push(u: Array) -> Array:
        return np.array([min(0.0, k * (u[0] + gap))])

    def slope(u: Array) -> Array:
        return np.array([[k if u[0] < -gap else 0.0]])

    K = np.array([[k, -k], [-k, k]])
    two = ss.structure(np.diag([1.0, 0.0]), K, v0=-1.0, contacts={"stop": ({1: 1.0}, gap)}, remembered=True)
    one = ss.structure([[1.0]], internal_force=push, tangent=slope, v0=-1.0)
    r, s = (ss.march(x, name, dt=0.01, t_end=0.6, account=False) for x in (two, one))
    assert np.allclose(r.u[:, 0], s.u[:, 0], rtol=0.0, atol=1e-10)
    assert np.allclose(r.memory["stop"], [-push(u)[0] for u in r.u], rtol=0.0, atol=1e-8)
    at = 20  # in contact
    assert r.memory["stop"][at] > 1.0
    half = ss.march(two, name, dt=0.01, t_end=0.01 * at, account=False)
    on = ss.march(two, name, dt=0.01, t_end=0.6, start=half.state, account=False)
    assert np.array_equal(on.u, r.u[at:])
    pressed: dict[str, Any] = {"contacts": {"stop": ({1: 1.0}, 0.0)}, "remembered": True, "u0": [-0.01, 0.0]}
    still = ss.march(ss.structure(np.diag([1.0, 0.0]), K, **pressed), name, dt=0.001, t_end=0.01, account=False)
    assert still.memory["stop"][0] == pytest.approx(3.0)
    assert still.a[0, 0] == pytest.approx(3.0)
    with pytest.raises(ValueError, match="expected equilibrium of the massless degree of freedom 1"):
        ss.structure(np.diag([1.0, 0.0]), K, **pressed | {"u0": [0.01, 0.0]}).a0


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["average_acceleration", "generalized_alpha", "bathe", "newmark_bdf2", "hht_alpha"])
def test_a_bar_whose_end_has_no_mass_meets_a_floor(name: str) -> None:
    """The pressure is that of the exact solution from the front on: it does not ring. Nobody gains energy ...

    ... but the trapezoidal rule, a little, as the node leaves within a step, where the impact is at the end of one.
    """
    n, h, phases = 100, 1 / 600, 32 if VERIFY else 2
    most = 1e-4 if name == "average_acceleration" else 1e-9
    x = np.linspace(0.0, 10.0, n + 1)
    whole = bar(n, 5.0)
    M = ss.redistributed_mass(whole.M, [0], np.column_stack([np.ones(n + 1), x]))
    for phase in np.arange(phases) / phases:
        floor = {"floor": ({0: 1.0}, 5.0 + 10 * h * phase)}
        s = ss.structure(M, whole.K, v0=-10.0, contacts=floor, remembered=True)
        r = ss.march(s, name, dt=h, t_end=1.25)
        p, since = r.memory["floor"], r.t - 0.5 - h * phase
        assert r.energy.max() <= 500.0 * (1.0 + most)
        assert np.abs(p[(since > 0.05) & (since < 0.6)] - 300.0).max() < 9.0
        assert 1.0 < p.max() / 300.0 < 1.2
        assert r.v[-1, 1:].mean() == pytest.approx(10.0, abs=0.3)


@settings(max_examples=25)
@given(st.integers(4, 12), st.integers(0, 2**32 - 1))
def test_mass_that_moves_elsewhere_keeps_what_it_is_asked_to(n: int, seed: int) -> None:
    """Mass, centre and moments of inertia of nodes in a plane, of which one has none."""
    rng = np.random.default_rng(seed)
    m, (x, y) = rng.uniform(1.0, 2.0, n), rng.uniform(-1.0, 1.0, (2, n))
    mass, zero = np.repeat(m, 2), np.zeros(n)
    fields = np.stack([np.ravel([1 + zero, zero], "F"), np.ravel([zero, 1 + zero], "F"), np.ravel([-y, x], "F")], 1)
    try:
        found = ss.redistributed_mass(np.diag(mass), [0, 1], fields)
    except ValueError as error:
        assert "expected positive masses" in str(error)
        return
    after = found.diagonal()
    assert np.allclose(fields.T @ np.diag(after) @ fields, fields.T @ np.diag(mass) @ fields, rtol=0, atol=1e-9 * n)
    assert not after[:2].any()
    assert (after[2:] > 0.0).all()
    # least: no change that keeps these products is nearer, as the normal equations say
    gradient = np.where(mass > 0, (after - mass) / mass, 0.0)[2:]
    products = np.array([fields[2:, i] * fields[2:, j] for i in range(3) for j in range(i, 3)]).T
    assert np.allclose(products @ np.linalg.lstsq(products, gradient, rcond=None)[0], gradient, atol=1e-9)


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ((np.ones((2, 2)), [0], [1, 1]), "expected M as a diagonal matrix"),
        ((np.eye(2), [2], [1, 1]), "expected degrees of freedom from 0 to 1, got 2"),
        ((np.eye(2), [0], [1, 1, 1]), r"expected fields of shape \(2,\)"),
        ((np.eye(2), [0], np.eye(2)), "expected positive masses"),
    ],
)
def test_mass_that_cannot_move_is_refused(given: Any, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        ss.redistributed_mass(*given)
