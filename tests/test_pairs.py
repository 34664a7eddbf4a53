"""Kernels of every scheme on every scene, run as plain Python, against schemes and scenes written by hand."""

import math

import numpy as np
import pytest
from by_hand import SCENES, push
from declared import BY_NAME, UNDAMPED
from nonlinear_oracle import history
from plain_kernels import OTHERS, SCENE_BY_NAME, WITH_LAWS, plain, variant

import substep as ss
from substep.marching import scene_lanes
from substep.marching.scene_lanes import march_lanes

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

# Relative to the largest value. Both sides iterate until Newton's corrections are 1e-12 of the length or less, after
# which its quadratic convergence leaves less than rounding. Rounding is 2.2e-16 a step, 25 steps, and 15 times that in
# the acceleration of the bars: their force is a difference, whose terms are 1/(2*strain) of it for a strain of 0.03.
# Together 8e-14, which is what the worst pair shows; the rest is for other machines' elementary functions.
ROUNDING = 1e-12


# schemes for u'' = g(t, u) are refused on the scene that has damping
PAIRS = [(scheme, scene) for scheme in BY_NAME for scene in SCENES
         if scene != "linear_oscillator" or scheme not in UNDAMPED]  # fmt: skip


def test_every_scene_is_written_by_hand() -> None:
    assert set(SCENES) == set(SCENE_BY_NAME)
    others = {*WITH_LAWS, *(scene.name for scene in OTHERS)}
    assert set(ss.scenes()) == (set(SCENES) | others) - {"elastic_pendulum_engineering"}


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.pairs
@pytest.mark.parametrize(("scheme", "scene"), PAIRS)
def test_kernel_steps_as_the_papers_do(scheme: str, scene: str) -> None:
    hand, n = SCENES[scene], 25
    s = ss.scheme(scheme, **PARAMETERS.get(scheme, {}))
    mine = variant(scene, load=push if scene == "linear_oscillator" else None, **hand.parameters)
    a0 = hand.a0 if hand.a0 is not None else hand.system.acceleration(hand.u0, hand.v0, 0.0)
    assert np.allclose(mine.a0, a0, rtol=1e-14, atol=1e-14)
    values = {key: float(value) for key, value in s.parameters.items()}
    expected = history(scheme, values, hand.system, hand.dt, n, hand.u0, hand.v0, a0)
    found = march_lanes(mine, s, np.array([hand.dt]), np.array([n]), history=True)
    assert found.status[0] == 0
    assert found.n_done[0] == n
    kinds = plain(scheme, scene).REPORTED
    for k, kind in enumerate(kinds):
        scale = np.abs(expected["uva".index(kind)]).max()
        assert np.abs(found.out[0, :, k] - expected["uva".index(kind)]).max() <= ROUNDING * scale, kind
    t = np.arange(n + 1) * hand.dt
    energies = [hand.energy(x, u, v) for x, u, v in zip(t, expected[0], expected[1], strict=True)]
    assert found.peak[0] == pytest.approx(max(energies), rel=ROUNDING)
    own = mine.energy(t, found.out[0, :, 0], found.out[0, :, 1])
    assert np.abs(own - energies).max() <= ROUNDING * max(energies)
    assert math.isfinite(found.state.sum())


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.pairs
@pytest.mark.parametrize(("scheme", "scene"), PAIRS)
def test_lanes_in_blocks_are_the_lanes_alone(scheme: str, scene: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks of 3 for 4 lanes: steps, lengths of run and bounds differ; after one lane has ended, others may fail."""
    hand, s = SCENES[scene], ss.scheme(scheme, **PARAMETERS.get(scheme, {}))
    mine = variant(scene, load=push if scene == "linear_oscillator" else None, **hand.parameters)
    dt, n = hand.dt * np.array([1.0, 0.7, 40.0, 1.3]), np.array([2, 9, 6, 5])
    bound = np.array([np.inf, np.inf, 1e300, 0.5 * mine.E0])
    module = plain(scheme, scene)
    monkeypatch.setattr(module, "WIDTH", 3)
    monkeypatch.setitem(module.march_block.__globals__, "WIDTH", 3)
    alone, abreast = (
        march_lanes(mine, s, dt, n, bound=bound, history=True, counts=True)
        for few in (100, 0)
        if monkeypatch.setattr(scene_lanes, "FEW", few) is None
    )
    for name in ("out", "state", "newton", "peak", "n_done", "status"):
        assert np.array_equal(getattr(alone, name), getattr(abreast, name), equal_nan=True), name
    for lane, done in enumerate(alone.n_done):  # of a step that failed there is no count
        each = alone.iterations[lane, :done]
        assert np.array_equal(each, abreast.iterations[lane, :done])
        assert np.array_equal(alone.newton[lane], [each.sum(axis=0), each.max(axis=0, initial=0)])
    without = march_lanes(mine, s, dt, n, bound=bound)
    for name in ("newton", "state", "peak", "n_done", "status"):
        assert np.array_equal(getattr(alone, name), getattr(without, name), equal_nan=True), name
    assert not without.iterations.size
    assert not without.out.size


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("history", [False, True])
@pytest.mark.parametrize("stride", [1, 7])
def test_a_lane_that_fails_between_two_looks_ends_where_it_fails(
    stride: int, history: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Steps beyond the stability limit double the motion, or more: past a bound, or past all numbers."""
    s, mine = ss.scheme("central_difference"), variant("linear_oscillator", load=push, omega=1.0, xi=0.02)
    dt = np.array([0.1, 2.2, 2.5, 30.0, 0.3, 40.0, 2.1, 0.2])
    n = np.array([103, 90, 400, 200, 5, 200, 33, 64])
    bound = np.array([np.inf, 1e3, 1e300, np.inf, np.inf, np.inf, 1e1, 1e-3])
    alone, abreast = (
        march_lanes(mine, s, dt, n, bound=bound, stride=stride, extremes="uva", history=history)
        for few in (100, 0)
        if monkeypatch.setattr(scene_lanes, "FEW", few) is None
    )
    assert set(alone.status) == {0, 2, 3}
    assert len(set(alone.n_done)) == len(n)
    for name in ("out", "state", "peak", "n_done", "status", "extremes"):
        assert np.array_equal(getattr(alone, name), getattr(abreast, name)), name
