"""Damping in percent is asked about, wherever a damping ratio of a structure is given as one number."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import substep as ss

SHAKEN = np.sin(0.3 * np.arange(200))
GIVEN: dict[str, Callable[[Any], Any]] = {
    "spectrum": lambda xi: ss.response_spectrum(SHAKEN, dt=0.02, periods=[1.0], xi=xi),
    "rotated": lambda xi: ss.response_spectrum_rotated(SHAKEN, SHAKEN, dt=0.02, periods=[1.0], xi=xi),
    "code": lambda xi: ss.design_spectrum("ec8", [1.0], a_g=1.0, ground="A", xi=xi),
    "modal": lambda xi: ss.modal_damping(xi, modes=2),
    "rayleigh": lambda xi: ss.rayleigh(xi, xi, at=(1.0, 2.0)),
}


@pytest.mark.parametrize("given", GIVEN.values(), ids=GIVEN)
def test_a_ratio_above_1_is_taken_for_percent(given: Callable[[Any], Any]) -> None:
    given(0.05)
    given(1.0)
    for percent, ratio in ((5, "0.05"), (2.5, "0.025")):
        with pytest.raises(ValueError, match=f"xi as a ratio, at most 1, got {percent}; {percent} % is {ratio}"):
            given(percent)


def test_ratios_of_modes_may_be_above_1() -> None:
    """High modes that stiffness damps: their ratios are computed, and may be given again."""
    stiff = ss.structure(np.eye(2), np.diag([1.0, 400.0]), C=np.diag([0.1, 60.0]))
    assert stiff.modes(2).xi.max() == pytest.approx(1.5)
    assert ss.modal_damping(stiff.modes(2).xi).xi.max() == pytest.approx(1.5)
