"""A stiff part on a flexible one: the trapezoidal rule rings for ever, dissipative schemes as long as rho_inf says."""

import math
from typing import Any

import numpy as np
import pytest
from substep_kernels.facts import CATALOGUE
from sympy import sympify

import substep as ss

STIFF, FLEXIBLE, DT = 1e12, 1.0, 0.2618
K = np.array([[STIFF + FLEXIBLE, -FLEXIBLE], [-FLEXIBLE, FLEXIBLE]])
FREQUENCIES, SHAPES = np.linalg.eigh(K)
RHO = {name: float(sympify(facts["rho_inf"])) for name, facts in CATALOGUE.items() if facts["A_stable"] == "yes"}
DISSIPATIVE = [name for name, rho in RHO.items() if rho < 1.0]
CONSERVING = ["average_acceleration", "newmark", "energy_momentum"]


def ringing(name: str, steps: int) -> Any:
    """Displacement in the stiff mode (steps + 1,), which begins with 1, at omega h = 2.6e5."""
    model = ss.structure(np.eye(2), K, u0=SHAPES[:, 1])
    return np.abs(ss.march(model, name, dt=DT, t_end=steps * DT, account=False).u @ SHAPES[:, 1])


def lasts(ring: Any, limit: float) -> int:
    """The number of steps after which it stays below the limit."""
    return int(np.flatnonzero(ring >= limit)[-1]) + 1


def passes_through_growth(name: str) -> bool:
    """Whether it overshoots in the limit of stiff modes (derived), begins with another one's steps, or carries more."""
    state = ss.scheme(name).info.history
    return CATALOGUE[name]["overshoot"] != "U0-V0" or any(lag for _, lag in state) or len(state) > 3


def test_the_catalogue_has_dissipative_schemes() -> None:
    assert len(DISSIPATIVE) > 20


@pytest.mark.parametrize("name", CONSERVING)
def test_without_dissipation_it_rings_for_ever(name: str) -> None:
    assert RHO[name] == 1.0
    assert ringing(name, 500)[-100:].max() > 0.99


@pytest.mark.parametrize("name", DISSIPATIVE)
def test_ringing_lasts_as_long_as_rho_inf_says(name: str) -> None:
    """Below 1 % after ln 0.01/ln rho_inf steps; after the length of the state where rho_inf is 0.

    Schemes that overshoot have a double eigenvalue there and pass through n rho^n, or n^2 rho^n: the ringing takes
    longer to reach 1 % of its largest value. From there to 1e-8 it falls by rho_inf a step, up to that power of n.
    """
    rho, ring = RHO[name], ringing(name, 400)
    ring /= ring.max()
    found = lasts(ring, 0.01)
    if rho == 0.0:
        assert found <= len(ss.scheme(name).info.state)
        return
    steps_of = 1.0 / -math.log(rho)
    predicted = math.log(100.0) * steps_of
    if not passes_through_growth(name):
        assert found == math.ceil(predicted)
    assert found >= math.floor(predicted)
    later = lasts(ring, 1e-8)
    least = math.log(1e6) * steps_of
    assert least - 2 <= later - found <= least + 2 + 2 * math.log(later / found) * steps_of
