"""Damping in percent is asked about, wherever a damping ratio is given."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import substep as ss

SHAKEN = np.sin(0.3 * np.arange(200))
FRAME = ss.structure(np.eye(2), np.diag([1.0, 400.0]))
GIVEN: dict[str, Callable[[Any], Any]] = {
    "spectrum": lambda xi: ss.response_spectrum(SHAKEN, dt=0.02, periods=[1.0], xi=xi),
    "rotated": lambda xi: ss.response_spectrum_rotated(SHAKEN, SHAKEN, dt=0.02, periods=[1.0], xi=xi),
    "code": lambda xi: ss.design_spectrum("ec8", [1.0], a_g=1.0, ground="A", xi=xi),
    "history": lambda xi: ss.response_spectrum(SHAKEN, dt=0.02, periods=[1.0]).history(1.0, xi=xi),
    "inelastic": lambda xi: ss.inelastic_spectrum(SHAKEN, dt=0.02, periods=[1.0], xi=xi, ductility=[1.0]),
    "incremental": lambda xi: ss.incremental_dynamic_analysis(
        [SHAKEN], dt=0.02, periods=[1.0], xi=xi, intensity=[0.1], strength=1.0
    ),
    "modal": lambda xi: ss.modal_damping(xi, modes=2),
    "modal, rows": lambda xi: ss.modal_damping([0.02, xi]),
    "modes": lambda xi: FRAME.modes(2).damped(xi),
    "modes, rows": lambda xi: FRAME.modes(2).damped([xi, 0.02]),
    "building": lambda xi: ss.shear_building([1.0], ss.law("bilinear", k=1.0, q_y=1.0), damping=xi),
    "rayleigh": lambda xi: ss.rayleigh(xi, xi, at=(1.0, 2.0)),
}


@pytest.mark.parametrize("given", GIVEN.values(), ids=GIVEN)
def test_a_ratio_above_1_is_taken_for_percent(given: Callable[[Any], Any]) -> None:
    given(0.05)
    given(1.0)
    for percent, ratio in ((5, "0.05"), (2.5, "0.025")):
        with pytest.raises(
            ValueError, match=f"(xi|damping) as a ratio, at most 1, got {percent}; {percent} % is {ratio}"
        ):
            given(percent)


@pytest.mark.parametrize(
    "given",
    [
        lambda xi, **meant: ss.scene("linear_oscillator", omega=1.0, xi=xi, **meant),
        lambda xi, **meant: ss.scene("hysteretic_oscillator", omega=1.0, strength=1.0, xi=xi, **meant),
        lambda xi, **meant: ss.scene("hysteretic_oscillator", law="clough", omega=1.0, strength=1.0, xi=xi, **meant),
        lambda xi, **meant: swept(xi=xi, **meant),
        lambda xi, **meant: swept(scene_xi=[0.05, xi], **meant),
    ],
)
def test_xi_of_any_scene_is_a_ratio_and_percent_from_2_on(given: Callable[..., Any]) -> None:
    given(1.9)
    with pytest.raises(ValueError, match="xi of .*_oscillator.* as a ratio, got 5; 5 % is 0.05; .*add overdamped=True"):
        given(5.0)
    given(5.0, overdamped=True)


def swept(**axes: Any) -> Any:
    return ss.sweep("linear_oscillator", "bathe", dt=0.1, t_end=0.5, omega=1.0, **axes)


def test_ratios_of_modes_may_be_above_1_where_they_are_said_to_be_meant() -> None:
    """High modes that stiffness damps: their ratios are computed, and may be given again."""
    stiff = ss.structure(np.eye(2), np.diag([1.0, 400.0]), C=np.diag([0.1, 60.0]))
    assert stiff.modes(2).xi.max() == pytest.approx(1.5)
    xi = stiff.modes(2).xi
    assert ss.modal_damping(xi, overdamped=True).xi.max() == pytest.approx(1.5)
    assert FRAME.modes(2).damped(xi, overdamped=True).xi.max() == pytest.approx(1.5)
