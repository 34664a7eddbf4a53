"""Where a run that goes on, or one with rows or an end between its steps, could go wrong without a word."""

from typing import Any

import numpy as np
import pytest

import substep as ss

K = np.array([[6.0, -2.0, 0.0], [-2.0, 4.0, -1.0], [0.0, -1.0, 2.0]])
M = np.diag([2.0, 1.0, 1.0])


def frame(**options: Any) -> Any:
    return ss.structure(M, K, **({"u0": [0.1, 0.2, -0.1], "v0": [0.0, 1.0, 0.0]} | options))


PUSH = ([1.0, 0.0, 2.0], ss.Step(3.0))


@pytest.mark.parametrize("dt", [0.1, 0.001])
def test_an_acceleration_that_a_new_load_does_not_match_is_carried(dt: float) -> None:
    """By Newmark's textbook formulas on one oscillator, whose load jumps where the second run begins."""
    still, pushed = (ss.scene("linear_oscillator", omega=2.0, load=load) for load in (None, ss.Step(3.0)))
    first = ss.march(still, "newmark", dt=dt, t_end=10 * dt)
    then = ss.march(pushed, "newmark", dt=dt, t_end=20 * dt, start=first)
    u, v, a = (float(x[-1, 0]) for x in (first.u, first.v, first.a))
    for k in range(1, 11):
        ahead = u + dt * v + 0.25 * dt**2 * a
        new = (3.0 - 4.0 * ahead) / (1.0 + dt**2)
        u, v, a = ahead + 0.25 * dt**2 * new, v + 0.5 * dt * (a + new), new
        assert then.u[k, 0] == pytest.approx(u, rel=1e-12)
        assert then.v[k, 0] == pytest.approx(v, rel=1e-12)


@pytest.mark.parametrize("scheme", ["newmark", "bathe", "generalized_alpha", "bdf3"])
@pytest.mark.parametrize(
    "loads", [[([1.0, 0.0, 2.0], ss.Harmonic(1.0, 2.0))], [], [PUSH, ([0.0, 1.0, 0.0], ss.Step(1.0))]]
)
def test_modes_under_another_load_move_as_their_structure(scheme: str, loads: list[Any]) -> None:
    before, after = frame(load=PUSH), frame(load=loads)
    by_modes, whole = (
        ss.march(to, scheme, dt=0.05, t_end=2.0, start=ss.march(model, scheme, dt=0.05, t_end=1.0), account=False)
        for model, to in ((before.modes(3), after.modes(3)), (before, after))
    )
    assert np.abs(by_modes.u - whole.u).max() < 1e-12
