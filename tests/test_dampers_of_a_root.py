"""A damper of a root of the velocity, whose slope has no bound at rest: a start at rest, against SciPy."""

from functools import cache
from itertools import product

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from substep_derive import Scene, rate
from substep_derive.declare.catalogue import find_law
from sympy import Symbol

import substep as ss

u = Symbol("u")
C, T_END = 0.6, 2.0
BENT = Scene(
    "bent", coordinates={u: "m"}, kinetic=(1 + u**2) * rate(u) ** 2 / 2, potential=2 * u**2,
    laws={"damper": find_law("power_damper").on(u, c=C, exponent=0.5)}, parameters=(), start={u: 1, rate(u): 0},
    length=1,
)  # fmt: skip
SCENES = {
    "a constant mass": lambda: ss.scene(
        "hysteretic_oscillator", law="power_damper", omega=2.0, c=C, exponent=0.5, u0=1
    ),
    "a mass that moves": lambda: ss.scene(BENT),
}
NAMES = ["average_acceleration", "bathe", "sdirk3", *(x for x in ss.schemes() if ss.scheme(x).info.together)]
REFUSED = ("discontinuous_galerkin_p1", "a mass that moves")  # by name, since it mixes forces of two knots
CASES = [case for case in product(NAMES, SCENES) if case != REFUSED]


@cache
def exact(bent: int) -> float:
    """The last u; bent: what multiplies u^2 in the mass."""

    def slope(_: float, x: np.ndarray) -> list[float]:
        force = 4 * x[0] + bent * x[0] * x[1] ** 2 + C * np.sign(x[1]) * np.sqrt(abs(x[1]))
        return [x[1], -force / (1 + bent * x[0] ** 2)]

    return solve_ivp(slope, (0.0, T_END), [1.0, 0.0], rtol=1e-10, atol=1e-10).y[0, -1]


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(("name", "scene"), CASES)
def test_an_iteration_from_rest_does_not_stop_there(name: str, scene: str) -> None:
    """Newton's first correction is 0 where the slope has no bound, which once counted as converged."""
    r = ss.march(SCENES[scene](), name, dt=0.025, t_end=T_END)
    assert r.status == "completed"
    assert abs(r.u[-1, 0] - exact(int(scene != "a constant mass"))) < 2e-3
