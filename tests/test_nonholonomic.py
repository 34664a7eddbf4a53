"""Constraints that hold rates: a knife edge on a slope, a rod held as a length, and a disk that rolls."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from substep_derive import DeclarationError, Scene, rate
from sympy import Rational, Symbol, cos, pi, sin
from test_constraints import SLIDING, VERIFY

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
@pytest.mark.parametrize(
    "name", [*((*SLIDING, "lobatto_iiia3") if VERIFY else (*SOME, "radau_iia2")), "central_difference"]
)
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


R, FALL, TURN, SPIN = 0.5, Rational(3, 10), Rational(1, 2), Rational(6)  # m; rates of tilt, yaw and spin, rad/s
ACROSS, ALONG = R**2 / 4.0, R**2 / 2.0  # moments of inertia of a thin disk of 1 kg, about a diameter and its axis


def disk() -> Scene:
    """A disk that rolls on a plane: the velocity of the centre and of rotation leave what touches at rest."""
    theta, psi = Symbol("theta"), Symbol("psi")  # tilt of its axis, and spin; phi is the yaw
    spin = rate(psi) + rate(phi) * cos(theta)
    r, fast = Rational(1, 2), SPIN + TURN * cos(pi / 3)
    return Scene(
        "rolling_disk", coordinates={x: "m", y: "m", theta: "rad", phi: "rad", psi: "rad"},
        kinetic=(rate(x) ** 2 + rate(y) ** 2 + (r * cos(theta) * rate(theta)) ** 2) / 2
        + r**2 / 8 * (rate(theta) ** 2 + (rate(phi) * sin(theta)) ** 2) + r**2 / 4 * spin**2,
        potential=Rational(981, 100) * r * sin(theta), parameters=(), length=1,
        constraints={
            "along_x": rate(x) - r * (rate(theta) * sin(theta) * sin(phi) - spin * cos(phi)),
            "along_y": rate(y) + r * (rate(theta) * sin(theta) * cos(phi) + spin * sin(phi)),
        },
        start={
            x: 0, y: 0, theta: pi / 3, phi: 0, psi: 0, rate(x): -r * fast, rate(y): -r * FALL * sin(pi / 3),
            rate(theta): FALL, rate(phi): TURN, rate(psi): SPIN,
        },
    )  # fmt: skip


def by_newton_and_euler(_: float, state: np.ndarray) -> np.ndarray:
    """The same in rotations w about the level diameter, the steepest one and the axis, where forces are eliminated."""
    tilt, yaw, w1, w2, w3 = state[2], state[3], *state[5:]
    about = w2 / np.tan(tilt)  # the rate at which these axes turn about the third
    return np.array([
        R * (w1 * np.sin(tilt) * np.sin(yaw) - w3 * np.cos(yaw)),
        -R * (w1 * np.sin(tilt) * np.cos(yaw) + w3 * np.sin(yaw)),
        w1, w2 / np.sin(tilt), w3 - about,
        (ACROSS * about * w2 - (ALONG + R**2) * w2 * w3 - 9.81 * R * np.cos(tilt)) / (ACROSS + R**2),
        (ALONG * w1 * w3 - ACROSS * about * w1) / ACROSS,
        R**2 * w1 * w2 / (ALONG + R**2),
    ])  # fmt: skip


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["average_acceleration", "bathe", "generalized_alpha"])
def test_a_disk_rolls_as_by_newton_and_euler(name: str) -> None:
    """Coordinates for 1.5 s, in which it nods thrice, and the forces along the plane, which accelerate its centre."""
    tilt, (fall, turn, spin) = np.pi / 3, map(float, (FALL, TURN, SPIN))
    start = [0.0, 0.0, tilt, 0.0, 0.0, fall, turn * np.sin(tilt), spin + turn * np.cos(tilt)]
    exact = solve_ivp(by_newton_and_euler, (0.0, 1.6), start, "DOP853", rtol=1e-12, atol=1e-12, dense_output=True).sol
    before, after = (by_newton_and_euler(0.0, exact(1.5 + h))[:2] for h in (-1e-4, 1e-4))
    force = (after - before) / 2e-4  # on 1 kg
    errors = []
    for n in (150, 300):
        r = ss.march(ss.scene(disk()), name, dt=1.5 / n, t_end=1.5)
        assert r.status == "completed"
        of_force = force + [of_rate[-1] for of_rate in r.multipliers.values()]
        errors.append([np.abs(r.u - exact(r.t)[:5].T).max(), np.abs(of_force).max()])
    assert max(errors[1]) < 0.01
    assert np.log2(np.divide(*errors)) == pytest.approx([2.0, 2.0], abs=0.1)


def test_what_has_no_direction_is_refused() -> None:
    with pytest.raises(DeclarationError, match="constraint speed to be linear in"):
        Scene(
            "fast", coordinates={x: "m"}, kinetic=rate(x) ** 2 / 2, potential=0, parameters=(), length=1,
            constraints={"speed": rate(x) ** 2 - 1}, start={x: 0, rate(x): 1},
        )  # fmt: skip
