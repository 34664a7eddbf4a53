"""A run that goes on from another is the run that was not broken."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from declared import UNDAMPED

import substep as ss

SCHEMES = ss.schemes()
LOADS: dict[str, Any] = {
    "none": None,
    "harmonic": ss.Harmonic(2.0, 3.0, 0.4),
    "record": ss.Record(0.05, np.sin(np.arange(200.0) ** 1.5)),
    "own": lambda t: np.cos(2.0 * t) + 0.1 * t,
}


def same(whole: ss.Response, *parts: ss.Response) -> None:
    for name in ("t", "u", "v", "a"):
        together = [getattr(parts[0], name), *(getattr(part, name)[1:] for part in parts[1:])]
        assert np.array_equal(np.concatenate(together), getattr(whole, name)), name
    assert whole.status == parts[-1].status == "completed"


def broken(model: Any, scheme: Any, dt: float, ends: tuple[float, float, float], **options: Any) -> None:
    whole = ss.march(model, scheme, dt=dt, t_end=ends[-1], **options)
    parts = [ss.march(model, scheme, dt=dt, t_end=ends[0], **options)]
    for end in ends[1:]:
        parts.append(ss.march(model, scheme, dt=dt, t_end=end, start=parts[-1], **options))
    same(whole, *parts)


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("scheme", SCHEMES)
def test_an_oscillator_goes_on_to_the_bit(scheme: str, load: str) -> None:
    xi = 0.0 if scheme in UNDAMPED else 0.05
    scene = ss.scene("linear_oscillator", omega=3.0, xi=xi, u0=0.3, v0=-1.0, load=LOADS[load])
    broken(scene, scheme, 0.05, (1.5, 1.55, 4.0))


@pytest.mark.pairs
@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("scene", [name for name in ss.scenes() if name != "linear_oscillator"])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_scene_goes_on_to_the_bit(scheme: str, scene: str) -> None:
    parameters = {"elastic_pendulum": {"EA": 1e4}, "duffing": {"eps": 0.5}}.get(scene, {})
    broken(ss.scene(scene, **parameters), scheme, 0.01, (0.05, 0.06, 0.2))


def frame(**options: Any) -> Any:
    K = np.array([[6.0, -2.0, 0.0], [-2.0, 4.0, -1.0], [0.0, -1.0, 2.0]])
    given = {"load": ([1.0, 0.0, 2.0], LOADS["harmonic"]), "u0": [0.1, 0.2, -0.1], "v0": [0.0, 1.0, 0.0]}
    return ss.structure(np.diag([2.0, 1.0, 1.0]), **({"K": K} | given | options))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_structure_goes_on_to_the_bit(scheme: str) -> None:
    C = None if scheme in UNDAMPED else 0.05 * np.diag([3.0, 1.0, 1.0])
    broken(frame(C=C), scheme, 0.05, (1.0, 1.05, 2.0), account=False)


def hardening(u: np.ndarray) -> np.ndarray:
    return np.array([6.0 * u[0] - 2.0 * u[1] + u[0] ** 3, -2.0 * u[0] + 4.0 * u[1] - u[2], 2.0 * u[2] - u[1]])


def slope(u: np.ndarray) -> np.ndarray:
    return np.array([[6.0 + 3.0 * u[0] ** 2, -2.0, 0.0], [-2.0, 4.0, -1.0], [0.0, -1.0, 2.0]])


@pytest.mark.parametrize("scheme", [name for name in SCHEMES if name != "energy_momentum"])
def test_a_nonlinear_structure_goes_on_to_the_bit(scheme: str) -> None:
    broken(frame(K=None, internal_force=hardening, tangent=slope), scheme, 0.05, (0.5, 0.55, 1.0), account=False)


@pytest.mark.parametrize("start", ["moving", "rest"])
@pytest.mark.parametrize("coupled", [False, True])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_modes_go_on_to_the_bit(scheme: str, coupled: bool, start: str) -> None:
    if coupled and scheme in UNDAMPED:
        return
    still = {"u0": 0.0, "v0": 0.0} if start == "rest" else {}
    modes = frame(C=0.05 * np.diag([3.0, 1.0, 1.0]) if coupled else None, **still).modes(3)
    broken(modes, scheme, 0.05, (1.0, 1.05, 2.0), account=False)
