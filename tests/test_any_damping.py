"""What suffices for stability at every damping ratio: never too much, rarely too little, against certificates."""

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME, OF_STIFFNESS, explicit
from substep_derive.declare.symbols import Omega, xi
from substep_derive.stability.all_damping import certify_all_damping
from substep_derive.stability.any_damping import D, _in_square, stable_at_any_damping
from substep_derive.stability.certificate import certify
from substep_derive.stability.conditions import W
from substep_kernels.facts import FORMS
from sympy import Symbol
from sympy.logic.boolalg import true

import substep as ss
from substep.derived.simple_fraction import simple_fraction

KNOWN = [name for name, forms in FORMS.items() if forms["A_stable"] is not None and not BY_NAME[name].decided]
BOUNDED = {  # stable at small Omega only, for all parameters
    *(name for name, s in BY_NAME.items() if explicit(s) and name not in OF_STIFFNESS),
    "tarnow_simo",  # without damping at every Omega, with a large one nowhere
}
DRAWN = 100  # parameters of each scheme
GIVEN = {
    "newmark": {"beta": 0.3, "gamma": 0.6},
    "newmark_bdf2": {"gamma_t": 0.2, "beta": 0.3025, "gamma": 0.6},
    "generalized_alpha": {"rho_inf": 0.5},
    "hht_alpha": {"alpha": -0.2},
    "wbz_alpha": {"alpha_B": -0.3},
    "wilson_theta": {"theta": 1.5},
    "collocation": {"theta": 1.5, "beta": 0.25, "gamma": 0.5},
    "theta_method": {"theta": 0.75},
    "rho_inf_bathe": {"rho_inf": 0.25, "gamma_t": 0.5},
    "silva_bezerra": {"gamma_t": 0.3},
    "kr_alpha": {"rho_inf": 0.75},
    "sdirk2": {"gamma": 0.3},
}


def drawn(name: str) -> list[dict[str, Fraction]]:
    """Exact parameters in their intervals, at most 2 from a finite end; of each a third are the default."""
    rng, found = np.random.default_rng(1), []
    defaults = {key: simple_fraction(float(x)) for key, x in ss.scheme(name).parameters.items()}
    for _ in range(DRAWN):
        values = {}
        for parameter in BY_NAME[name].parameters:
            low, end = Fraction(str(parameter.domain.start)), parameter.domain.end
            high = Fraction(str(end)) if end.is_finite else low + 2
            inside = low + (high - low) * Fraction(int(rng.integers(1, 100)), 100)
            default = defaults[parameter.name] if rng.random() < 1 / 3 else None
            values[parameter.name] = inside if default is None else default
        found.append(values)
    return found


@pytest.mark.parametrize("name", KNOWN)
def test_what_suffices_does_so_at_any_damping(name: str) -> None:
    """Wherever it holds, no eigenvalue leaves the circle on a grid of steps and damping ratios, and proofs agree."""
    sets = [x for x in drawn(name) if FORMS[name]["A_stable"](*x.values())]
    if name in BOUNDED:
        assert not sets
        return
    assert sets
    omegas, ratios = np.logspace(-3, 5, 40)[:, None], np.array([0.0, 0.02, 0.2, 0.7, 1.0, 3.0, 30.0])
    for values in sets:
        s = ss.scheme(name, **{key: float(x) for key, x in values.items()})
        assert np.max(s.spectral_radius(omegas, ratios)) <= 1 + 1e-6, values
    for values in sets[:2]:
        assert all(certify(name, xi=damping, **values).stable for damping in ("0", "1/7", "3/2"))


@pytest.mark.parametrize(("name", "given"), GIVEN.items())
def test_schemes_that_are_a_stable_are_known_to_be(name: str, given: dict[str, float]) -> None:
    s: Any = ss.scheme(name, **given)
    own = {key: str(simple_fraction(float(x))) for key, x in s.parameters.items()}
    assert certify_all_damping(name, **own).stable_for_all_xi is True
    assert s.A_stable is True
    assert s.critical_Omega == math.inf
    assert s.L_stable is (s.rho_inf == 0.0)


def test_conditions_that_are_known_and_schemes_that_have_none() -> None:
    assert str(stable_at_any_damping(BY_NAME["newmark"])) == "(gamma >= 1/2) & (2*beta >= gamma)"
    assert stable_at_any_damping(BY_NAME["kr_alpha"]) is true
    for name in ("oalts", "four_substep", "suzuki"):  # four eigenvalues and more, and a scheme without damping
        assert stable_at_any_damping(BY_NAME[name]) is None


def test_damping_times_the_step_is_a_variable_of_its_own() -> None:
    beta = Symbol("beta")
    assert _in_square(4 * beta * Omega**4 * xi**2 + Omega * xi + Omega**2 + 3) == beta * D**2 * W + D / 2 + W + 3
    assert _in_square(Omega**3 * xi**2) is None
    assert _in_square(Omega * xi**3) is None
