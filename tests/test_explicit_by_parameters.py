"""Parameters that make an implicit scheme explicit, so that reactions move nothing: refused, with the cure."""

from typing import Any

import numpy as np
import pytest
from substep_derive import Contact, Friction, Scene, rate
from sympy import Symbol

import substep as ss

y = Symbol("y")
EXPLICIT = ss.scheme("newmark", beta=0, gamma=0.5)
FALL: dict[str, Any] = {
    "coordinates": {y: "m"}, "kinetic": rate(y) ** 2 / 2, "parameters": (), "length": 1, "start": {y: 0, rate(y): 1}
}  # fmt: skip


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("scheme", [EXPLICIT, ss.scheme("theta_method", theta=0)])
def test_a_scheme_that_parameters_make_explicit_is_refused_on_constraints_and_contacts(scheme: ss.Scheme) -> None:
    which = f"got {scheme.name} at {'beta' if scheme.name == 'newmark' else 'theta'} = 0, which makes it explicit"
    floors = [
        Scene(f"floor_{e}", potential=9.81 * y, contacts={"floor": Contact(y + 2, restitution=e)}, **FALL)
        for e in (None, 0)
    ]
    for scene in ("rod_pendulum", *floors):
        with pytest.raises(ValueError, match=which):
            ss.march(scene, scheme, dt=0.01, t_end=1.0)


def test_it_is_refused_in_a_sweep_and_on_a_structure() -> None:
    with pytest.raises(
        ValueError, match=r"got newmark at beta = 0, .* take other parameters, or a scheme that is decl"
    ):
        ss.sweep("rod_pendulum", "newmark", beta=[0.25, 0.0], gamma=0.5, dt=0.01, t_end=1.0)
    ball = ss.structure(np.eye(1), np.zeros((1, 1)), contacts={"floor": ({0: 1.0}, 2.0)}, restitution=0.0)
    with pytest.raises(ValueError, match="got newmark at beta = 0, which makes it explicit"):
        ss.march(ball, EXPLICIT, dt=0.01, t_end=1.0)


@pytest.mark.usefixtures("uncompiled")
def test_friction_is_held_at_velocities_which_it_moves() -> None:
    """v = 1 under a friction of 1 stops at t = 1 s, 1/2 from the start."""
    sliding = Scene("sliding_alone", potential=0 * y, frictions={"drag": Friction(y, 1)}, **FALL)
    r = ss.march(sliding, EXPLICIT, dt=0.01, t_end=2.0)
    assert r.u[-1, 0] == pytest.approx(0.5, abs=0.01)
    assert abs(r.v[-1, 0]) < 1e-12
