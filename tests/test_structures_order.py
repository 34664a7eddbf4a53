"""Observed order of every scheme on a damped, forced structure against the derived one."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from scipy.linalg import expm
from substep_kernels.facts import CATALOGUE

import substep as ss

M = np.array([[2.0, 0.3, 0.0], [0.3, 1.5, 0.2], [0.0, 0.2, 1.0]])
K = np.array([[3.0, -1.0, 0.0], [-1.0, 2.5, -1.0], [0.0, -1.0, 1.5]])
C = np.array([[0.3, -0.1, 0.0], [-0.1, 0.2, 0.0], [0.0, 0.0, 0.05]])  # its modes are coupled
START = np.array([[0.3, -0.2, 0.1], [0.1, 0.4, -0.3]])
FORCE, OMEGA, PHASE = np.array([1.0, 0.0, 0.5]), 1.3, 0.4
END, PARTS = 6.0, 8  # errors are taken at the last four of eight instants up to the end
STEPS = {1: 1024, 2: 256, 3: 128, 4: 64, 5: 48, 6: 32, 8: 8}  # the coarser number, where rounding is far away


@cache
def exact(damped: bool) -> Any:
    """u, v, a (instants, 3, n), by the matrix exponential and the steady motion of the harmonic load."""
    by_mass, n = np.linalg.inv(M), len(M)
    damping = C if damped else 0.0 * C
    rates = np.block([[np.zeros((n, n)), np.eye(n)], [-by_mass @ K, -by_mass @ damping]])
    amplitude = np.linalg.solve(K - OMEGA**2 * M + 1j * OMEGA * damping, FORCE)

    def steady(t: float) -> Any:
        moving = amplitude * np.exp(1j * (OMEGA * t + PHASE))
        return np.r_[moving.imag, (1j * OMEGA * moving).imag]

    found = []
    for t in np.arange(PARTS // 2 + 1, PARTS + 1) * END / PARTS:
        y = expm(rates * t) @ (START.ravel() - steady(0.0)) + steady(t)
        a = by_mass @ (FORCE * np.sin(OMEGA * t + PHASE) - K @ y[:n] - damping @ y[n:])
        found.append([y[:n], y[n:], a])
    return np.array(found)


def errors(scheme: ss.Scheme, n: int) -> Any:
    """Of u, v and a, (3,)."""
    damped = scheme.info.damping
    model = ss.structure(M, K, C=C if damped else None, load=(FORCE, ss.Harmonic(1.0, OMEGA, PHASE)),
                         u0=START[0], v0=START[1])  # fmt: skip
    r = ss.march(model, scheme, dt=END / n, t_end=END, account=False)
    rows = np.stack([r.u, r.v, r.a], axis=1)[n // PARTS :: n // PARTS][PARTS // 2 :]
    return np.sqrt(((rows - exact(damped)) ** 2).mean(axis=(0, 2)))


@pytest.mark.parametrize("name", list(BY_NAME))
def test_observed_order_is_the_derived_one(name: str) -> None:
    """Of u, v, a, within a quarter. Schemes for u'' = g(t, u) meet the structure without damping."""
    scheme, facts = ss.scheme(name), CATALOGUE[name]
    derived = np.array(facts["order"])
    n = STEPS[max(derived)]
    observed = np.log2(errors(scheme, n) / errors(scheme, 2 * n))
    assert np.abs(observed - derived).max() <= 0.25, (observed, derived)
