"""Constraints that hold rates: against the exact motion of a knife edge on a slope, and a rod held as a length."""

import numpy as np
import pytest
from substep_derive import DeclarationError, Scene, rate
from sympy import Symbol, cos, sin
from test_constraints import TAKEN, VERIFY

import substep as ss

x, y, phi = (Symbol(name) for name in ("x", "y", "phi"))
SOME = ["average_acceleration", "bathe", "energy_momentum"]
TURNING, SLOPE = 3.0, 2.0  # rad/s, m/s^2
FIRST = {"backward_euler", "theta_method", "trbdf3"}  # schemes of first order


def sleigh() -> Scene:
    return Scene(
        "sleigh", coordinates={x: "m", y: "m", phi: "rad"}, kinetic=(rate(x) ** 2 + rate(y) ** 2 + rate(phi) ** 2) / 2,
        potential=-SLOPE * x, constraints={"edge": rate(x) * sin(phi) - rate(y) * cos(phi)}, parameters=(),
        start={x: 0, y: 0, phi: 0, rate(x): 0, rate(y): 0, rate(phi): TURNING}, length=1,
    )  # fmt: skip


def exact(t: np.ndarray) -> np.ndarray:
    """Neimark & Fufaev, Dynamics of Nonholonomic Systems (1972): the edge does not slide down, but goes sideways."""
    scale, angle = SLOPE / (2 * TURNING**2), TURNING * t
    return np.array([scale * np.sin(angle) ** 2, scale * (angle - np.sin(2 * angle) / 2), angle]).T


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", [*(TAKEN if VERIFY else SOME), "central_difference"])
def test_a_knife_edge_goes_where_it_should(name: str) -> None:
    scene, errors = ss.scene(sleigh()), []
    for h in (0.02, 0.01):
        r = ss.march(scene, name, dt=h, t_end=2.0)
        errors.append(np.abs(r.u - exact(r.t)).max())
        across = r.v[:, 0] * np.sin(r.u[:, 2]) - r.v[:, 1] * np.cos(r.u[:, 2])
        if name != "energy_momentum":  # which holds it at the middle of each step
            assert np.abs(across).max() < 1e-13
    order = 0.9 if name in FIRST else 1.8
    assert errors[1] < 1e-9 or np.log2(errors[0] / errors[1]) > order
    edge = 2.0 * SLOPE * np.sin(TURNING * r.t)  # m (omega v + g sin phi), with v along the edge
    assert np.abs(r.multipliers["edge"] - edge).max() < (0.5 if name in FIRST else 0.02)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", SOME)
def test_a_rod_at_velocity_level_is_the_rod_but_for_the_error_of_the_scheme(name: str) -> None:
    given = {
        "coordinates": {x: "m", y: "m"}, "kinetic": (rate(x) ** 2 + rate(y) ** 2) / 2, "potential": 9.81 * y,
        "parameters": (), "start": {x: 1, y: 0, rate(x): 0, rate(y): 0}, "length": 1,
    }  # fmt: skip
    by_length = Scene("rod_by_length", **given, constraints={"rod": (x**2 + y**2 - 1) / 2})
    by_velocity = Scene("rod_by_velocity", **given, constraints={"rod": x * rate(x) + y * rate(y)})
    differences = []
    for h in (0.02, 0.01):
        a, b = (ss.march(ss.scene(scene), name, dt=h, t_end=1.0) for scene in (by_length, by_velocity))
        differences.append(np.abs(a.u - b.u).max())
        assert np.abs((b.u * b.v).sum(axis=1)).max() < 1e-12
    assert np.log2(differences[0] / differences[1]) == pytest.approx(2.0, abs=0.2)


def test_what_has_no_direction_is_refused() -> None:
    with pytest.raises(DeclarationError, match="constraint speed to be linear in"):
        Scene(
            "fast", coordinates={x: "m"}, kinetic=rate(x) ** 2 / 2, potential=0, parameters=(), length=1,
            constraints={"speed": rate(x) ** 2 - 1}, start={x: 0, rate(x): 1},
        )  # fmt: skip
