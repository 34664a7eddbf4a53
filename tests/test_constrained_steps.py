"""Steps on points with rods: those of kernels beside the same written out by hand in NumPy."""

from typing import Any

import constrained_steps
import numpy as np
import pytest
from constrained_steps import Rods
from substep_derive import rod_chain
from test_constraints import HELD_TOGETHER, VERIFY, G

import substep as ss

Array = np.ndarray


def rods(name: str) -> tuple[Any, Rods]:
    """A scene of the catalogue, and the same written out by hand."""
    if name == "rod_pendulum":
        scene = ss.scene(name, L=1.5, m=2.0, v0=1.0, g=G)
        return scene, Rods(
            np.full(2, 2.0), lambda u, v: np.array([0.0, -2.0 * G]),
            lambda u: np.array([u @ u - 1.5**2]) / 2, lambda u: u[None],
        )  # fmt: skip

    scene = ss.scene(rod_chain(CHAINS[name]) if name in CHAINS else name)
    n = len(scene.info.multipliers)

    def along(u: Array) -> Array:
        return np.diff(u.reshape(n, 2), axis=0, prepend=np.zeros((1, 2)))

    def G_of(u: Array) -> Array:
        return np.array(
            [np.outer((np.arange(n) == k) * 1.0 - (np.arange(n) == k - 1), x) for k, x in enumerate(along(u))]
        )

    return scene, Rods(
        np.ones(2 * n), lambda u, v: np.tile([0.0, -G], n),
        lambda u: ((along(u) ** 2).sum(axis=1) - 1.0) / 2, lambda u: G_of(u).reshape(n, 2 * n),
    )  # fmt: skip


CHAINS = {"rod_chain_3": 3, "rod_chain_8": 8}
R = 6**0.5
TABLES = {  # Hairer & Wanner, Solving Ordinary Differential Equations II (1996), tables IV.5.5, IV.5.6 and IV.5.12
    "radau_iia2": [[5 / 12, -1 / 12], [3 / 4, 1 / 4]],
    "radau_iia3": [
        [(88 - 7 * R) / 360, (296 - 169 * R) / 1800, (-2 + 3 * R) / 225],
        [(296 + 169 * R) / 1800, (88 + 7 * R) / 360, (-2 - 3 * R) / 225],
        [(16 - R) / 36, (16 + R) / 36, 1 / 9],
    ],
    "lobatto_iiic2": [[1 / 2, -1 / 2], [1 / 2, 1 / 2]],
    "lobatto_iiic3": [[1 / 6, -1 / 3, 1 / 6], [1 / 6, 5 / 12, -1 / 12], [1 / 6, 2 / 3, 1 / 6]],
}
STEPS = {
    "newmark": ({"beta": 0.3025, "gamma": 0.6}, lambda *at: constrained_steps.newmark(*at, 0.3025, 0.6)),
    "generalized_alpha": ({"rho_inf": 0.8}, lambda *at: constrained_steps.generalized_alpha(*at, 0.8)),
    "bathe": ({}, constrained_steps.bathe),
    **{name: ({}, lambda *at, A=A: constrained_steps.runge_kutta(*at, A)) for name, A in TABLES.items()},
}


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(
    ("name", "scheme"),
    [
        *((name, scheme) for name in ("rod_pendulum", "rod_double_pendulum") for scheme in STEPS),
        *((name, scheme) for name in (CHAINS if VERIFY else ["rod_chain_3"]) for scheme in STEPS.keys() - TABLES),
    ],
)
def test_steps_are_those_written_by_hand(name: str, scheme: str) -> None:
    """u, v and the multipliers after each of 30 steps; by differences for derivatives, so not to the last digit."""
    parameters, step = STEPS[scheme]
    scene, p = rods(name)
    r = ss.march(scene, ss.scheme(scheme, **parameters), dt=0.02, t_end=0.6)
    names = list(r.multipliers)
    state = scene.u0, scene.v0, scene.a0, np.array([r.memory[name][0] for name in names])
    for k in range(1, 31):
        state = step(p, 0.02, state)
        assert np.allclose(r.u[k], state[0], rtol=0.0, atol=1e-9)
        assert np.allclose(r.v[k], state[1], rtol=0.0, atol=1e-8)
        assert np.allclose([r.memory[name][k] for name in names], state[3], rtol=1e-6, atol=1e-5)


def test_every_scheme_that_solves_stages_together_and_holds_constraints_is_here() -> None:
    assert set(HELD_TOGETHER) == {*TABLES, "weighted_residual_p2"}  # whose table has a parameter
