"""What docs/findings.md says of schemes that papers name, where no other test derives it."""

from fractions import Fraction
from typing import Any

import pytest
from declared import BY_NAME
from substep_derive import certify
from substep_derive.stability.all_damping import certify_all_damping
from substep_derive.study.equivalence import MATRIX, SPECTRUM, equivalences
from sympy import Rational, Symbol, sqrt


@pytest.mark.parametrize(
    ("cubic", "first"), [("1/10", 0), ("27/250", 6 * sqrt(62) / 125), ("1/6", 2 * sqrt(6)), ("1/3", 6 * sqrt(3))]
)
def test_a_last_sub_step_by_backward_differences(cubic: str, first: Any) -> None:
    """Stable from 6 sqrt(12 c^2 + 8 c - 1) on, which is 0 at c = (sqrt(7) - 2)/6, and below at every damping ratio."""
    ((low, _, _, _),) = certify("trapezoid_trapezoid_backward", cubic=cubic).intervals
    assert low == first
    c = Rational(cubic)
    assert low**2 == max(36 * (12 * c**2 + 8 * c - 1), 0)
    below = certify_all_damping(BY_NAME["trapezoid_trapezoid_backward"], cubic=cubic).stable_for_all_xi
    assert below == (Fraction(cubic) < (7**0.5 - 2) / 6)


def test_a_composition_that_goes_back_in_time_is_stable_up_to_a_damping_ratio() -> None:
    low, *_, high = certify_all_damping(BY_NAME["tarnow_simo"]).cells
    assert low.stable and not high.stable
    assert float(low.high) == pytest.approx(0.999619849240130, abs=1e-12)
    assert float(high.low) == float(low.high)


@pytest.mark.parametrize("scale", ["2", "4", "5", "23/2"])
def test_structure_dependent_coefficients_that_are_too_soft(scale: str) -> None:
    found, value = certify("gui_lambda", lambda_g=scale).critical_Omega, Rational(scale)
    assert found == (None if value <= 4 else 2 * sqrt(value / (value - 4)))


@pytest.mark.parametrize(
    ("left", "right", "values", "kind"),
    [
        ("ss32", "wilson_theta", "theta, theta**2, theta**3", MATRIX),
        ("ss22", "newmark", "gamma, 2*beta", SPECTRUM),
        ("gui_lambda", "chen_ricles", "4", MATRIX),
    ],
)
def test_which_schemes_they_are(left: str, right: str, values: str, kind: str) -> None:
    (found,) = equivalences([BY_NAME[left], BY_NAME[right]])
    assert (found.left, found.right, found.kind) == (left, right, kind)
    given = found.left_values
    assert ", ".join(str(given[x]) for x in sorted(given, key=lambda s: str(Symbol(str(s))))) == values
