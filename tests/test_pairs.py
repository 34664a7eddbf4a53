"""Kernels of every scheme on every scene, run as plain Python, against schemes and scenes written by hand."""

import math
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from by_hand import SCENES, ByHand, push
from declared import BY_NAME
from nonlinear_oracle import history
from substep_derive.motion import Motion
from substep_derive.package import catalogue_pair
from substep_derive.scenes import ALL

import substep as ss

SCENE_BY_NAME = {scene.name: scene for scene in ALL}
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


@cache
def motion(name: str) -> Motion:
    return Motion(SCENE_BY_NAME[name])


@cache
def text(scheme: str, scene: str) -> str:
    return catalogue_pair(BY_NAME[scheme], motion(scene))


@cache
def plain(scheme: str, scene: str) -> SimpleNamespace:
    """The module with its kernels as Python functions."""
    source = text(scheme, scene).replace("from numba import njit", "njit = lambda **_: lambda function: function")
    space: dict[str, Any] = {}
    exec(compile(source, f"{scheme}__{scene}", "exec"), space)
    return SimpleNamespace(**space)


def run(monkeypatch: pytest.MonkeyPatch, scene: ss.Scene, scheme: ss.Scheme, dt: float, n: int, **options: Any) -> Any:
    """`march_lanes` on the plain module: u, v, a histories of one lane, and the lanes."""
    from substep import lanes

    monkeypatch.setattr(lanes, "pair_module", lambda scene, scheme: plain(scheme.name, scene.name))
    with np.errstate(all="ignore"):
        return lanes.march_lanes(scene, scheme, np.array([dt]), np.array([n]), history=True, **options)


def scene_of(name: str, hand: ByHand) -> ss.Scene:
    parameters = dict(hand.parameters)
    if name == "elastic_pendulum_engineering":
        return ss.scene("elastic_pendulum", strain="engineering", **parameters)
    load = (push) if name == "linear_oscillator" else None
    return ss.scene(name, load=load, **parameters)


def test_every_scene_is_written_by_hand() -> None:
    assert set(SCENES) == set(SCENE_BY_NAME)
    assert set(ss.scenes()) == set(SCENES) - {"elastic_pendulum_engineering"}


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("scheme", BY_NAME)
def test_kernel_steps_as_the_papers_do(scheme: str, scene: str, monkeypatch: pytest.MonkeyPatch) -> None:
    hand, n = SCENES[scene], 25
    s = ss.scheme(scheme, **PARAMETERS.get(scheme, {}))
    mine = scene_of(scene, hand)
    a0 = hand.a0 if hand.a0 is not None else hand.system.acceleration(hand.u0, hand.v0, 0.0)
    assert np.allclose(mine.a0, a0, rtol=1e-14, atol=1e-14)
    values = {key: float(value) for key, value in s.parameters.items()}
    expected = history(scheme, values, hand.system, hand.dt, n, hand.u0, hand.v0, a0)
    lanes = run(monkeypatch, mine, s, hand.dt, n)
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
