"""Grazing: an oscillator that touches its stop with hardly any velocity, by steps of one length and by chosen ones.

u = -cos t reaches 1 at rest, with the acceleration -1: a stop at 1 - d is met with the velocity sqrt(d (2 - d)), whose
derivative by d has no bound (Nordmark, J. Sound Vib. 145 (1991) 279-297).
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from test_friction import LASTING

import substep as ss
from substep.core.impacts import Impact

# how far before a stop a motion that turns back is still hit, in h^2 times its acceleration: the velocity at the start
# of a step, or of explicit steps the mean velocity that has led there, goes on to the displacement that is held
REACH = dict.fromkeys(LASTING, 1 / 2) | {"central_difference": 9 / 8}


def first_impacts(name: str, h: float, beyond: float) -> list[Impact]:
    """The first impact, if any, at each of 16 phases, of a stop `beyond` the motion, in h^2."""
    found = list[Impact]()
    for phase in np.arange(16) / 16:
        t = 2.0 + h * phase
        scene = ss.scene("impact_oscillator", b=1.0 + beyond * h**2, u0=-np.cos(t), v0=np.sin(t))
        found += ss.march(scene, name, dt=h, t_end=2.0).impacts[:1]
    return found


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", REACH)
def test_steps_of_one_length_hit_what_passes_near_and_how_near_is_known(name: str) -> None:
    h, reach = 0.01, REACH[name]
    assert not first_impacts(name, h, 1.05 * reach + 0.05)
    assert len(first_impacts(name, h, 0.6 * reach)) == 16  # whatever the phase
    for hit in first_impacts(name, h, 0.0):  # at rest, were it exact
        assert -(1.25 + 2 * reach) * h < hit.before < -0.9 * h


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("depth", [1e-2, 1e-3, 1e-4])
def test_chosen_steps_find_how_softly_it_is_met(depth: float) -> None:
    """By a scheme that keeps energy the velocity is that of the depth; when it is met, to the error of u over it."""
    scene = ss.scene("impact_oscillator", b=1.0 - depth, u0=-1.0)
    square = depth * (2.0 - depth)
    for tol in (1e-5, 1e-6, 1e-7):
        r = ss.march(scene, "average_acceleration", tol=tol, t_end=5.0)
        error = tol ** (2 / 3)
        assert r.impacts[0].before ** 2 == pytest.approx(square, abs=5e-5 * error)
        assert r.impacts[0].t == pytest.approx(np.arccos(depth - 1.0), abs=0.06 * error / np.sqrt(square))
    r = ss.march(ss.scene("impact_oscillator", b=1.0 + depth, u0=-1.0), "average_acceleration", tol=1e-7, t_end=5.0)
    assert not r.impacts


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("b", [pytest.param(0.3, marks=pytest.mark.thorough), 0.35])
def test_a_driven_oscillator_that_grazes_is_that_of_event_driven_integration(b: float) -> None:
    """Its impacts and its end after eight periods of the load, against SciPy's DOP853 from impact to impact."""
    c, e, t_end = 0.2, 0.8, 8 * np.pi

    def slope(t: float, x: np.ndarray) -> list[float]:
        return [x[1], np.cos(2.0 * t) - c * x[1] - x[0]]

    def closes(t: float, x: np.ndarray) -> float:
        return b - x[0]

    closes.terminal, closes.direction = True, -1.0  # pyright: ignore[reportFunctionMemberAccess]
    t, x, speeds = 0.0, np.array([-0.3, 0.0]), list[float]()
    while t < t_end:
        s = solve_ivp(slope, (t, t_end), x, method="DOP853", rtol=1e-12, atol=1e-13, events=closes, max_step=0.05)
        t, x = float(s.t[-1]), s.y[:, -1].copy()
        if s.status == 1:
            speeds.append(-x[1])
            x = np.array([b - 1e-15, -e * x[1]])
    scene = ss.scene("impact_oscillator", c=c, restitution=e, b=b, amplitude=1.0, omega_d=2.0, u0=-0.3)
    r = ss.march(scene, "average_acceleration", tol=1e-7, t_end=t_end)
    assert len(speeds) >= 3
    assert [hit.before for hit in r.impacts] == pytest.approx(speeds, abs=6e-4)
    assert np.abs(np.array([*r.u[-1], *r.v[-1]]) - x).max() < 6e-4
