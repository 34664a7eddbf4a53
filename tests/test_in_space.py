"""A pendulum in space, and four-bar linkages in a row: against closed forms and motions in fewer coordinates."""

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from substep_derive import Scene, four_bars, rate
from substep_derive.motion.equations import EquationsOfMotion
from sympy import Symbol
from test_constraints import HELD_TOGETHER, TAKEN, VERIFY

import substep as ss

Array = np.ndarray
G = 9.81
PAGE = (Path(__file__).parents[1] / "docs" / "constraints_and_contact.md").read_text("utf-8")


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(
    "name", ["bathe", "generalized_alpha", "central_difference"] if VERIFY else ["generalized_alpha"]
)
def test_a_conical_pendulum_goes_round_as_its_closed_form_has_it(name: str) -> None:
    """x + i y = r exp(i w t) with w^2 = g/h, h the height of the cone, under the tension m g L/h."""
    r0, h = 0.6, 0.8
    w, errors = np.sqrt(G / h), list[float]()
    cone = ss.scene("spatial_pendulum", r0=r0, v0=r0 * w)
    for dt in (0.01, 0.005):
        r = ss.march(cone, name, dt=dt, t_end=1.0)
        exact = np.column_stack([r0 * np.cos(w * r.t), r0 * np.sin(w * r.t), np.full_like(r.t, -h)])
        errors.append(float(np.abs(r.u - exact).max()))
        assert np.abs((r.u**2).sum(axis=1) - 1.0).max() < 1e-14
        assert r.multipliers["rod"][-1] == pytest.approx(G / h, rel=20 * dt**2)
        assert r.angular_momentum is not None
        assert r.angular_momentum[0] == r0 * r0 * w
        assert np.abs(r.angular_momentum / r.angular_momentum[0] - 1.0).max() < 20 * dt**2
    assert errors[0] < 0.02
    assert errors[1] < 0.3 * errors[0]


@pytest.mark.usefixtures("uncompiled")
def test_a_spatial_pendulum_swings_as_in_its_angles() -> None:
    """z'' = ..., by the angle from the vertical and the angular momentum about it."""
    r = ss.march("spatial_pendulum", "bathe", dt=0.0025, t_end=1.0)
    theta0 = np.arcsin(0.6)
    spin = 0.6 * 1.0  # angular momentum over the mass

    def slope(_: float, y: Array) -> list[float]:
        theta, rate_of, _ = y
        turning = spin / np.sin(theta) ** 2
        return [rate_of, np.sin(theta) * np.cos(theta) * turning**2 - G * np.sin(theta), turning]

    theta, _, phi = solve_ivp(slope, (0.0, 1.0), [theta0, 0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    exact = [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), -np.cos(theta)]
    assert np.allclose(r.u[-1], exact, rtol=0.0, atol=2e-4)


def test_momenta_of_rotations_in_space_follow_from_the_symmetry() -> None:
    x, y, z = (Symbol(s) for s in "xyz")

    def momentum(kinetic: Any, potential: Any) -> Any:
        return EquationsOfMotion(
            Scene(
                "point", coordinates={x: "m", y: "m", z: "m"}, kinetic=kinetic, potential=potential, parameters=(),
                start={x: 1, y: 0, z: 0, rate(x): 0, rate(y): 1, rate(z): 0}, length=1,
            )
        ).angular_momentum  # fmt: skip

    even = (rate(x) ** 2 + rate(y) ** 2 + rate(z) ** 2) / 2
    assert momentum(even, z) == x * rate(y) - y * rate(x)
    assert momentum(even, x) == y * rate(z) - z * rate(y)
    assert momentum(even, x + z) == x * rate(y) - y * rate(x) + y * rate(z) - z * rate(y)  # about the force itself
    assert momentum(even + rate(y) ** 2, z) is None
    assert momentum(even + rate(y) * rate(z) / 2, z) is None


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("n", [1, 2, 3] if VERIFY else [1])
def test_four_bars_in_a_row_move_as_one_angle(n: int) -> None:
    """Cranks and couplers of a parallelogram: (4n + 1) rods' inertia over the angle of the cranks."""
    r = ss.march(ss.scene(four_bars(n)), "bathe", dt=0.005, t_end=0.9)
    inertia, weight = (n + 1) / 3 + n, (n + 1) / 2 + n
    found = solve_ivp(
        lambda _, y: [y[1], -weight / inertia * G * np.cos(y[0])], (0.0, 0.9), [np.pi / 2, -1.0], "DOP853",
        rtol=1e-12, atol=1e-12,
    )  # fmt: skip
    angle = found.y[0, -1]
    assert angle < -0.1  # beyond where all bars are in line
    assert np.allclose(r.u[-1][::2] - np.arange(n + 1), np.cos(angle), rtol=0.0, atol=5e-4)
    assert np.allclose(r.u[-1][1::2], np.sin(angle), rtol=0.0, atol=5e-4)
    assert np.abs(r.energy / r.energy[0] - 1.0).max() < 1e-3


TABLE = PAGE[PAGE.index("| largest gain of energy") : PAGE.index("## Constraints that repeat others")]
BOUNDS = {"10⁻⁸": 1e-8, "10⁻⁴": 1e-4, "2.3·10⁻³": 2.3e-3, "1.7·10⁻²": 1.7e-2, "0.94": 0.94}


def rows_of_the_table() -> dict[str, tuple[float, float]]:
    """Of each scheme between which gains the table has it."""
    found, low = dict[str, tuple[float, float]](), -1.0
    for line in TABLE.splitlines()[2:]:
        if not line.startswith("|"):
            break
        bound = next(x for text, x in BOUNDS.items() if text in line.split("|")[1])
        names = re.findall(r"`(\w+)`", line.split("|")[2])
        if "both with mixed displacements" in line:
            names += ["generalized_alpha_mixed_displacement", "hht_alpha_mixed_displacement"]
        found |= {name: (low, bound) for name in names}
        low = bound
    return found


GAINS = rows_of_the_table()
ENDED = ("three_substep_third_order", "radau_iia2", "radau_iia3")  # where a knot is too near to the singular position


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize("name", GAINS if VERIFY else ["average_acceleration"])
def test_schemes_gain_on_a_four_bar_in_line_what_the_page_has(name: str) -> None:
    """Over 16 steps from 0.01 to 0.0123 s, 300 steps each: all bars are in line at 0.74, 1.3 and 2.8 s."""
    scene, gains, low_high = ss.scene("four_bar"), list[float](), GAINS[name]
    for dt in np.linspace(0.01, 0.0123, 16):
        r = ss.march(scene, name, dt=float(dt), t_end=float(300 * dt))
        assert r.status == "completed" or name in ENDED
        gains.append(float((r.energy - r.energy[0]).max()) / G)
        u = r.u[:, 2:] - r.u[:, :2]
        assert np.allclose(u, [1.0, 0.0], rtol=0.0, atol=1e-6)  # it stays a parallelogram
    assert low_high[0] < max(gains) <= low_high[1]


def test_the_table_has_every_scheme_once() -> None:
    assert set(GAINS) == {*TAKEN, *HELD_TOGETHER}
    assert all(a <= b for a, b in pairwise(BOUNDS.values()))
