"""A constant damping beside forces that move with time: every scheme against SciPy, in its derived order."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from declared import NAMES
from scipy.integrate import solve_ivp
from substep_derive import DeclarationError, Scene, derive, rate, t
from sympy import Rational, Symbol, cos

import substep as ss

Array = np.ndarray
x, y = Symbol("x"), Symbol("y")
# dampers couple both points, and one of them is fixed to the ground; the spring between them is wound in time
SCENE = Scene(
    "wound_spring", coordinates={x: "m", y: "m"}, kinetic=(rate(x) ** 2 + 2 * rate(y) ** 2) / 2,
    potential=10 * (1 + cos(3 * t) / 5) * (y - x) ** 2 + 3 * x**2 + x**4,
    dissipation=Rational(3, 2) * (rate(x) - rate(y)) ** 2 + rate(x) ** 2 / 4,
    parameters=(), start={x: 1, y: 0, rate(x): 0, rate(y): 1}, length=1,
)  # fmt: skip
T_END = 0.6


@cache
def exact() -> Array:
    def slope(time: float, state: Array) -> Array:
        (p, q), (dp, dq) = state[:2], state[2:]
        spring = 20.0 * (1.0 + np.cos(3.0 * time) / 5.0) * (q - p) + 3.0 * (dq - dp)
        return np.array([dp, dq, spring - 6.0 * p - 4.0 * p**3 - dp / 2.0, -spring / 2.0])

    return solve_ivp(slope, (0.0, T_END), [1.0, 0.0, 0.0, 1.0], "DOP853", rtol=1e-13, atol=1e-14).y[:2, -1]


@pytest.mark.usefixtures("plain_pairs")
@pytest.mark.parametrize("name", NAMES)
def test_every_scheme_gives_the_damped_motion_in_its_order_or_refuses_it(name: str) -> None:
    def error(n: int) -> float:
        r: Any = ss.march(ss.scene(SCENE), name, dt=T_END / n, t_end=T_END)
        return float(np.abs(r.u[-1] - exact()).max())

    try:
        first = error(60)
    except DeclarationError as refused:
        why = "coefficients from matrices", "a scene without damping", "take the force at one knot that depends on"
        assert any(x in str(refused) for x in why)
        return
    order = min(derive(name).order[0], 4)
    assert first < 0.03 and (first < 1e-10 or first / error(120) > 0.8 * 2**order)
