"""Kernels of every scheme on every scene, run as plain Python, against schemes and scenes written by hand."""

import math

import numpy as np
import pytest
from by_hand import SCENES, push
from declared import BY_NAME
from nonlinear_oracle import history
from plain_kernels import SCENE_BY_NAME, plain, uncompiled, variant  # noqa: F401 (a fixture)

import substep as ss
from substep.lanes import march_lanes

PARAMETERS: dict[str, dict[str, float]] = {
    "newmark": {"beta": 0.3025, "gamma": 0.6},
    "silva_bezerra": {"gamma_t": 0.3},
    "newmark_bdf2": {"gamma_t": 0.4, "beta": 0.36, "gamma": 0.7},
    "generalized_alpha": {"alpha_m": 0.1, "alpha_f": 0.3, "beta": 0.4, "gamma": 0.75},
    "gholampour": {"delta": 0.4, "alpha_g": 0.21},
    "hht_alpha": {"alpha": -0.2},
    "wbz_alpha": {"alpha_B": -0.3},
}
PARAMETERS["generalized_alpha_mixed_displacement"] = PARAMETERS["generalized_alpha"]
PARAMETERS["hht_alpha_mixed_displacement"] = PARAMETERS["hht_alpha"]


def test_every_scene_is_written_by_hand() -> None:
    assert set(SCENES) == set(SCENE_BY_NAME)
    assert set(ss.scenes()) == set(SCENES) - {"elastic_pendulum_engineering"}


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("scheme", BY_NAME)
def test_kernel_steps_as_the_papers_do(scheme: str, scene: str) -> None:
    hand, n = SCENES[scene], 25
    s = ss.scheme(scheme, **PARAMETERS.get(scheme, {}))
    mine = variant(scene, load=push if scene == "linear_oscillator" else None, **hand.parameters)
    a0 = hand.a0 if hand.a0 is not None else hand.system.acceleration(hand.u0, hand.v0, 0.0)
    assert np.allclose(mine.a0, a0, rtol=1e-14, atol=1e-14)
    values = {key: float(value) for key, value in s.parameters.items()}
    expected = history(scheme, values, hand.system, hand.dt, n, hand.u0, hand.v0, a0)
    lanes = march_lanes(mine, s, np.array([hand.dt]), np.array([n]), history=True)
    assert lanes.status[0] == 0
    assert lanes.n_done[0] == n
    kinds = plain(scheme, scene).REPORTED
    for k, kind in enumerate(kinds):
        scale = np.abs(expected["uva".index(kind)]).max()
        assert np.abs(lanes.out[0, :, k] - expected["uva".index(kind)]).max() <= 2e-9 * scale, kind
    t = np.arange(n + 1) * hand.dt
    energies = [hand.energy(x, u, v) for x, u, v in zip(t, expected[0], expected[1], strict=True)]
    assert lanes.peak[0] == pytest.approx(max(energies), rel=1e-8)
    assert mine.energy(t, lanes.out[0, :, 0], lanes.out[0, :, 1]) == pytest.approx(energies, rel=1e-8, abs=1e-12)
    assert math.isfinite(lanes.state.sum())
