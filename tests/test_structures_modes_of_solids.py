"""A solid that starts in one of its modes moves in it as the single oscillator does, whatever the scheme."""

import os
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.sparse.linalg import LinearOperator, eigsh

import substep as ss
from substep.structures.examples import solid

CELLS = (6, 20) if os.environ.get("SUBSTEP_VERIFY") else (6,)  # 882 and 26460 degrees of freedom


@cache
def in_its_mode(cells: int) -> tuple[ss.Structure, Any, float]:
    """The solid with its second mode as start, that mode, and its circular frequency."""
    model = solid((cells,) * 3, C=ss.Rayleigh(200.0, 2e-6))
    solve = LinearOperator(model.K.shape, matvec=model.factorized(model.K, "the stiffness"), dtype=np.float64)
    squares, shapes = eigsh(model.K, k=2, M=model.M, sigma=0.0, OPinv=solve, v0=np.ones(model.size))
    return replace(model, u0=shapes[:, 1]), shapes[:, 1], float(np.sqrt(squares[1]))


@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "generalized_alpha", "houbolt", "three_substep"])
@pytest.mark.parametrize("cells", CELLS)
def test_a_mode_of_a_solid_is_an_oscillator(cells: int, scheme: str) -> None:
    """Its own coordinate to 1e-9 of the start, which is how exact the mode is; nothing else moves."""
    model, shape, omega = in_its_mode(cells)
    dt, steps = 0.3 / omega, 40
    assert isinstance(model.C, ss.Rayleigh)
    single = ss.scene("linear_oscillator", omega=omega, xi=model.C.ratio(omega), u0=1.0)
    exact = ss.march(single, scheme, dt=dt, t_end=steps * dt).u[:, 0]
    r = ss.march(model, scheme, dt=dt, t_end=steps * dt, account=False)
    u = r.u @ model.T
    weighted = u @ (model.M @ shape)
    assert np.abs(weighted - exact).max() < 1e-9
    assert np.abs(u - weighted[:, None] * shape).max() < 1e-9 * np.abs(shape).max()
