"""Constraints and impacts as other programs compute them, in the same steps by the same schemes."""

import numpy as np
import pytest

import substep as ss

# Exudyn 1.13.6: generalized alpha with spectralRadius 0.8, index 3, steps of 0.01 s; the end, s, and positions then, m
EXUDYN = {
    "rod_pendulum": (2.0, [0.792198780996654, -0.6102631329085968]),
    "rod_double_pendulum": (2.0, [-0.4671805508187683, -0.8841619381859143, -1.4367739502814403, -1.1288834936697325]),
    "four_bar": (0.6, [0.844524729127497, 0.5355165561326072, 1.8445247291274969, 0.535516556132607]),
}
# Siconos 4.4.0: MoreauJeanOSI(0.5, 1.0), a ball from 1 m under g = 10, restitution 0.5, steps of 0.007 s; u and v
SICONOS = {100: (0.25801749999999973, -0.31499999999999817), 150: (0.059383750000000055, -0.3325000000000009)}


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize("name", EXUDYN)
def test_points_on_rods_are_those_of_exudyn(name: str) -> None:
    """Positions to rounding, though Newton ends by another criterion."""
    given, (t_end, known) = {"L": 1.0, "v0": 0.0} if name == "rod_pendulum" else {}, EXUDYN[name]
    r = ss.march(ss.scene(name, g=9.81, **given), ss.scheme("generalized_alpha", rho_inf=0.8), dt=0.01, t_end=t_end)
    assert np.abs(r.u[-1] - known).max() < 3e-12


def test_a_bouncing_ball_is_that_of_siconos() -> None:
    """Moreau and Jean's scheme, some impacts later."""
    ball = ss.scene("bouncing_ball", u0=1.0, g=10.0, restitution=0.5)
    r = ss.march(ball, "average_acceleration", dt=0.007, t_end=1.05)
    for step, (u, v) in SICONOS.items():
        assert abs(r.u[step, 0] - u) < 1e-13
        assert abs(r.v[step, 0] - v) < 1e-13
