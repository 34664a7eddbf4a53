"""Chosen steps on a ladder of lengths: where it is taken by itself, where it is asked for, what it costs and saves."""

from typing import Any

import numpy as np
import pytest
from exact_motions import exact

import substep as ss
from substep.marching.adaptive import adaptive_kernels

pytestmark = pytest.mark.usefixtures("plain_adaptive")

FORCED = ss.scene("linear_oscillator", omega=3.0, xi=0.1, load=ss.Harmonic(2.0, 5.0, 0.3))
PULSE = ss.scene("linear_oscillator", omega=3.0, xi=0.3, u0=1.0, load=ss.HalfSine(5.0, 0.7))
STRUCTURE = ss.scene("bathe_noh", k1=1e3)
ROOT = 2.0**0.5


def rungs(r: ss.Response, first: float, ends: list[float], ratio: float = ROOT) -> np.ndarray:
    """The powers of the ratio in the steps' lengths, without those that share the way to an end between them."""
    steps = np.diff(r.t)
    landing = np.zeros(len(steps), bool)
    for end in ends:
        k = int(np.flatnonzero(r.t == end)[0]) - 1
        landing[max(k - 1, 0) : k + 1] = True
    return np.log(steps[~landing] / first) / np.log(ratio)


@pytest.mark.parametrize("scheme", ["average_acceleration", "generalized_alpha", "bathe", "esdirk32"])
@pytest.mark.parametrize("scene", [FORCED, PULSE, STRUCTURE], ids=["forced", "pulse", "structure"])
def test_steps_of_linear_scenes_stand_on_a_ladder(scheme: str, scene: ss.Scene) -> None:
    first = 2e-3
    r = ss.march(scene, scheme, tol=1e-5, t_end=1.6, dt_first=first)
    k = rungs(r, first, [0.7, 1.6] if scene is PULSE else [1.6])
    assert np.abs(k - np.round(k)).max() < 1e-6
    assert len(np.unique(np.round(k))) > 2
    assert r.statistics is not None
    assert r.statistics.rejected <= 0.2 * r.statistics.accepted + 3


@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe"])
def test_the_ladder_costs_little_accuracy_and_spares_changes(scheme: str) -> None:
    """Lengths are rounded down to a rung: more steps than without, by no more than a rung, and fewer lengths."""
    with_it, without = (ss.march(FORCED, scheme, tol=1e-6, t_end=4.0, rung=x) for x in (None, 0.0))
    assert len(without.t) < len(with_it.t) < 1.5 * len(without.t)
    lengths = [np.count_nonzero(np.abs(np.diff(np.diff(r.t))) > 1e-9 * np.diff(r.t)[1:]) for r in (with_it, without)]
    assert lengths[0] < lengths[1]
    error = [np.abs(r.u - exact(FORCED, r.t)[:, 0]).max() for r in (with_it, without)]
    assert error[0] < 1.2 * error[1]


def test_where_nothing_is_inverted_any_length_is_taken() -> None:
    """Explicit balances, and nonlinear ones, whose Jacobian is solved with in every iteration."""
    kernels = {
        (scheme, scene.name): adaptive_kernels(scene, ss.scheme(scheme))
        for scheme, scene in (("bathe", FORCED), ("dormand_prince", FORCED), ("bathe", ss.scene("duffing")))
    }
    assert {key: module.RUNG > 0 for key, module in kernels.items()} == {
        ("bathe", "linear_oscillator"): True,
        ("dormand_prince", "linear_oscillator"): False,
        ("bathe", "duffing"): False,
    }
    assert kernels["bathe", "linear_oscillator"].RUNG == ROOT


def test_a_ladder_may_be_asked_for() -> None:
    first, ratio = 1e-3, 1.5
    r = ss.march("duffing", "bathe", tol=1e-5, t_end=0.3, dt_first=first, rung=ratio)
    k = rungs(r, first, [0.3], ratio)
    assert np.abs(k - np.round(k)).max() < 1e-6


@pytest.mark.parametrize("rung", [1.0, 0.5, -2.0, 20.0, np.nan])
def test_a_ratio_that_is_none_is_refused(rung: Any) -> None:
    with pytest.raises(ValueError, match="rung"):
        ss.march("duffing", "bathe", tol=1e-5, t_end=0.3, rung=rung)


def test_the_last_steps_stay_as_they_are_where_a_longer_one_saves_no_step() -> None:
    """A longer step is taken only while it saves more steps until t_end than its change costs."""
    module = adaptive_kernels(FORCED, ss.scheme("bathe"))
    held = 0.25
    for saved, taken in ((0.9, 1.0), (1.1, 2.0)):  # steps saved until the end, over the work of a change
        left = 2.0 * held * saved * module.CHANGE  # steps of twice the length save half
        assert module._on_ladder(2.0 * held, held, held, 2.0, left, 0.0, module.CHANGE)[0] == taken * held
