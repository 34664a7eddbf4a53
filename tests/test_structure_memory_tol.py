"""Chosen steps of structures that remember: against exact motions, and what is committed of a step that is rejected."""

from typing import Any

import numpy as np
import pytest
from hysteresis import Oscillator, exact, half_sine
from scipy.stats import linregress

import substep as ss
from substep.structures.march import step_control

OF, T_END = Oscillator(5.0, 0.05, 4.0, 0.1), 3.0
PULSE = ss.HalfSine(12.0, 0.6)
MOTION = exact(OF, half_sine(12.0, 0.6), T_END)


def story(**options: Any) -> ss.Structure:
    """That oscillator as a structure."""
    law = ss.law("bilinear", k=OF.omega**2, q_y=OF.strength, alpha=OF.alpha)
    C = [[2 * OF.xi * OF.omega]]
    return ss.structure([[1.0]], springs=[([1.0], law)], C=C, load=([1.0], PULSE), **options)


@pytest.mark.parametrize(
    ("scheme", "power"), [("dormand_prince", 0.5), ("esdirk43", 0.5), ("average_acceleration", 0.45)]
)
def test_the_error_follows_the_tolerance_across_yielding_and_turns(scheme: str, power: float) -> None:
    assert len(MOTION.events) >= 3
    tolerances, errors, s = [1e-3, 1e-4, 1e-5, 1e-6], [], story()
    for tol in tolerances:
        r = ss.march(s, scheme, tol=tol, t_end=T_END)
        assert r.status == "completed"
        u, _, p, lost = MOTION.at(r.t)
        apart = np.abs(r.u[:, 0] - u).max(), np.abs(r.memory["p"][:, 0] - p).max()
        errors.append(max(apart) / np.abs(u).max())
        assert errors[-1] < 40 * tol**power
        assert np.abs(r.springs.dissipated[:, 0] - lost).max() < 60 * tol**power * lost[-1]
        assert np.array_equal(r.springs.elongations, r.u)
    assert linregress(np.log(tolerances), np.log(errors)).slope > power


@pytest.mark.parametrize("scheme", ["dormand_prince", "bathe"])
def test_a_step_that_is_rejected_commits_nothing(scheme: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The elongation at yield is 0.16, and the first step that is tried passes it by far."""
    tried = list[tuple[float, float]]()
    accepted = step_control.ChosenSteps.accepted

    def seen(clock: Any, step: Any) -> bool:
        before, trial = clock.memory.springs[0][0, 0], step.march.memory.springs[0][0, 0]
        counts = accepted(clock, step)
        assert clock.memory.springs[0][0, 0] == (trial if counts else before)
        tried.append((trial - before, counts))
        return counts

    monkeypatch.setattr(step_control.ChosenSteps, "accepted", seen)
    r = ss.march(story(v0=3.0), scheme, tol=1e-5, t_end=1.0, dt_first=0.4)
    assert any(moved != 0.0 and not counts for moved, counts in tried)
    assert sum(counts for _, counts in tried) == len(r.t) - 1


def test_a_march_goes_on_with_what_was_remembered() -> None:
    s = story()
    half = ss.march(s, "dormand_prince", tol=1e-8, t_end=1.0)
    rest = ss.march(s, "dormand_prince", tol=1e-8, t_end=T_END, start=half)
    u, _, p, _ = MOTION.at(rest.t)
    assert rest.memory["p"][0, 0] == half.state.memory["p"][0] == half.memory["p"][-1, 0] != 0.0
    assert np.abs(rest.u[:, 0] - u).max() < 1e-5
    assert np.abs(rest.memory["p"][:, 0] - p).max() < 1e-5


def test_a_material_of_ones_own() -> None:
    """The same spring, whose displacement is looked at where it turns."""

    def held(t: float, u: np.ndarray, v: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        k = OF.omega**2
        trial = k * (u - p)
        q = np.clip(trial, -OF.strength, OF.strength)
        slope = np.where(np.abs(trial) < OF.strength, k, OF.alpha * k)
        return OF.alpha * k * u + (1 - OF.alpha) * q, np.diag(slope), u - q / k

    C = [[2 * OF.xi * OF.omega]]
    s = ss.structure([[1.0]], internal_force=held, state=np.zeros(1), C=C, load=([1.0], PULSE))
    r = ss.march(s, "esdirk43", tol=1e-6, t_end=T_END)
    u, _, p, _ = MOTION.at(r.t)
    assert np.abs(r.u[:, 0] - u).max() < 1e-3 * np.abs(u).max()
    assert np.abs(r.memory["state"][:, 0] - p).max() < 1e-3 * np.abs(u).max()
