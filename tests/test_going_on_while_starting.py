"""A multi-step scheme that is broken off while another one still starts it carries no history yet: it starts anew."""

from typing import Any

import numpy as np
import pytest

import substep as ss

BROKEN = (("houbolt", 1), ("park", 1), ("bdf4", 1), ("bdf4", 2), ("adams_moulton4", 1))
K = np.array([[20.0, -10.0], [-10.0, 10.0]])
MODELS = {
    "oscillator": ss.scene("linear_oscillator", omega=3.0, xi=0.02),
    "scene": ss.scene("rigid_pendulum", v0=3.0),
    "structure": ss.structure(np.eye(2), K, u0=[1.0, 0.5]),
    "modes": ss.structure(np.eye(2), K, u0=[1.0, 0.5]).modes(2),
}


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(("scheme", "steps"), BROKEN)
@pytest.mark.parametrize("kind", list(MODELS))
def test_it_goes_on_as_from_u_v_and_a(kind: str, scheme: str, steps: int) -> None:
    model: Any = MODELS[kind]
    first = ss.march(model, scheme, dt=0.02, t_end=0.02 * steps)
    assert not first.state.history
    assert not first.state.more
    then = ss.march(model, scheme, dt=0.02, t_end=0.4, start=first)
    anew = {"t": first.t[-1], "u": first.u[-1], "v": first.v[-1], "a": first.a[-1]}
    assert np.allclose(then.u, ss.march(model, scheme, dt=0.02, t_end=0.4, start=anew).u, rtol=1e-12, atol=1e-13)
    whole = ss.march(model, scheme, dt=0.02, t_end=0.4)
    size = float(np.abs(whole.u).max())
    assert np.abs(then.u - whole.u[steps:]).max() < 2e-3 * size


@pytest.mark.parametrize("scheme", ["houbolt", "park", "bdf3"])
@pytest.mark.parametrize("kind", ["oscillator", "modes"])
def test_after_the_last_of_these_steps_it_is_the_run_that_was_not_broken(kind: str, scheme: str) -> None:
    model: Any = MODELS[kind]
    n = ss.scheme(scheme).starting_steps
    whole, first = (ss.march(model, scheme, dt=0.02, t_end=t_end) for t_end in (0.4, 0.02 * n))
    then = ss.march(model, scheme, dt=0.02, t_end=0.4, start=first)
    assert np.allclose(then.u, whole.u[n:], rtol=1e-14, atol=1e-15)
