"""Every scheme of the catalogue in steps that the march chooses: its errors follow the tolerance, or it is refused."""

import numpy as np
import pytest
from declared import BY_NAME, NAMES, TOGETHER
from exact_motions import exact
from substep_derive.declare.symbols import knot
from substep_derive.estimate.estimator import acceleration_lag

import substep as ss
from substep.marching.adaptive import march_adaptive
from substep.run.clock import Control

pytestmark = pytest.mark.usefixtures("plain_adaptive")

DAMPED = ss.scene("linear_oscillator", omega=3.0, xi=0.1, load=ss.Harmonic(2.0, 5.0, 0.3))
FREE = ss.scene("elastic_pendulum", EA=1e3)
COARSE, FINE = 1e-3, 1e-5


def reason(name: str) -> str | None:
    """Why the step of a declaration cannot change; None where it can."""
    scheme = BY_NAME[name]
    if any(s not in knot(0) for s in scheme.state):
        return "carries"
    return "carries" if scheme.start_scheme is not None or scheme.start else None


def errors(scene: ss.Scene, name: str, tol: float, t_end: float) -> tuple[float, float]:
    """Largest errors of u and of v, relative to the largest u and v."""
    r = ss.march(scene, name, tol=tol, t_end=t_end)
    assert r.status == "completed"
    assert r.statistics is not None
    assert r.statistics.rejected <= 3 + 0.1 * r.statistics.accepted
    reference = exact(scene, r.t).swapaxes(0, 1)
    u, v = (np.abs(x - y).max() / np.abs(y).max() for x, y in zip((r.u, r.v), reference, strict=True))
    return float(u), float(v)


@pytest.mark.parametrize("name", NAMES)
def test_a_scheme_follows_the_tolerance_or_is_refused_with_the_reason(name: str) -> None:
    """An estimate of O(h^(p+1)) gives steps in proportion to tol^(1/(p+1)), so an error to tol^(p/(p+1)) or less."""
    scene, t_end = (DAMPED, 4.0 if name in TOGETHER else 2.0) if BY_NAME[name].takes_damping else (FREE, 0.8)
    if why := reason(name):
        with pytest.raises(ValueError, match=rf"{name}, which {why}.*give dt"):
            ss.march(scene, name, tol=COARSE, t_end=t_end)
        return
    if scene is FREE:
        with pytest.raises(ValueError, match=f"{name} is a scheme for u'' = "):
            ss.march(DAMPED, name, tol=COARSE, t_end=t_end)
    p = ss.scheme(name).local_error(scene.info.damped).order
    coarse, fine = (errors(scene, name, tol, t_end) for tol in (COARSE, FINE))
    least = (COARSE / FINE) ** (p / (p + 1)) / 2.0
    for kind in (0, 1):
        assert fine[kind] < 0.02
        assert coarse[kind] / fine[kind] > least, "uv"[kind]


@pytest.mark.parametrize("name", NAMES)
def test_both_u_and_v_are_estimated(name: str) -> None:
    if reason(name):
        return
    found = ss.scheme(name).local_error(BY_NAME[name].takes_damping)
    assert all(terms for terms, _ in found.terms)
    assert len(found.weights) == sum(len(terms) + len(below) for terms, below in found.terms)


@pytest.mark.parametrize("kind", ["u", "v"])
@pytest.mark.parametrize("name", ["average_acceleration", "rk4", "energy_momentum", "wbz_alpha", "sdirk2"])
def test_each_error_is_controlled_by_itself(name: str, kind: str) -> None:
    """A tolerance of u alone, or of v alone: the steps follow it, whatever that error is estimated from."""
    s, found, steps = ss.scheme(name), [], []
    power = 1.0 / (s.local_error(damped=True).order + 1)
    for tol in (1e-3, 1e-5):
        atol = (tol, 1e6) if kind == "u" else (1e6, tol)
        r = march_adaptive(DAMPED, s, Control.of(DAMPED.length, tol, 2.0, rtol=0.0, atol=atol))
        found.append(np.abs((r.u if kind == "u" else r.v) - exact(DAMPED, r.t)[:, "uv".index(kind)]).max())
        steps.append(len(r.t) - 1)
    assert 1 / 1.5 < steps[1] / steps[0] / 100.0**power < 1.5
    assert found[0] / found[1] > 100.0 ** (1.0 - power) / 2.0


@pytest.mark.parametrize("name", ["hht_alpha", "wbz_alpha", "generalized_alpha", "explicit_generalized_alpha"])
def test_an_acceleration_that_belongs_to_a_step_follows_its_length(name: str) -> None:
    """Else its difference from the motion's own is that of another length, which is taken for an error of v."""
    assert acceleration_lag(BY_NAME[name]) == 1
    r = ss.march(DAMPED, name, tol=1e-5, t_end=3.0)
    assert r.statistics is not None
    assert np.count_nonzero(np.abs(np.diff(np.diff(r.t))) > 1e-9) >= 4  # the length changes
    assert r.statistics.rejected <= 2
