"""A mechanism all of whose motion is given: multipliers against the forces that the motion takes."""

from dataclasses import fields

import numpy as np
import pytest
from substep_derive import Scene, t
from substep_derive.declare.scenes.mechanisms import slider_crank
from sympy import Symbol

import substep as ss

Array = np.ndarray
RATE = 150.0  # rad/s
# coordinates and multipliers at 0.1 s in the reference sheet, from another program
AT_END = [15.0, -0.331163913464838, 0.169746176502319]
FORCES_AT_END = [-60.7644790884216, -163.7170590818, 25.01465778]


def driven() -> Scene:
    """Simeon's slider and crank, whose crank turns steadily."""
    given = {f.name: getattr(slider_crank, f.name) for f in fields(slider_crank)}
    constraints = {**slider_crank.constraints, "drive": Symbol("phi1") - RATE * t}
    return Scene(**given | {"name": "driven_slider_crank", "reference": "", "constraints": constraints})


def inverse_dynamics(at: Array) -> tuple[Array, Array]:
    """Coordinates (n, 3), and forces (n, 3) of pin, slot and drive, by balance of block, rod and crank in turn."""
    L1, L2, M2, M3, J2 = 0.15, 0.30, 0.151104, 0.075552, 0.0045339259
    crank = RATE * at
    rod = -np.arcsin(L1 / L2 * np.sin(crank))
    turn = -L1 / L2 * RATE * np.cos(crank) / np.cos(rod)
    angular = (L1 / L2 * RATE**2 * np.sin(crank) + np.sin(rod) * turn**2) / np.cos(rod)
    block = L1 * np.cos(crank) + L2 * np.cos(rod)
    a = -L1 * RATE**2 * np.cos(crank) - L2 * (np.cos(rod) * turn**2 + np.sin(rod) * angular)
    c, s = (L1 * L2 * M2 * f(crank - rod) / 2.0 for f in (np.cos, np.sin))
    slot = -M3 * a
    pin = (s * RATE**2 - J2 * angular - slot * L2 * np.sin(rod)) / (L2 * np.cos(rod))
    drive = -c * angular - s * turn**2 - pin * L1 * np.cos(crank) - slot * L1 * np.sin(crank)
    return np.array([crank, rod, block]).T, np.array([pin, slot, drive]).T


def test_the_forces_by_hand_are_those_of_the_reference_sheet() -> None:
    (place,), (forces,) = inverse_dynamics(np.array([0.1]))
    assert np.allclose(place, AT_END, rtol=0.0, atol=1e-14)
    assert np.allclose(forces, FORCES_AT_END, rtol=1e-9, atol=0.0)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(("name", "own"), [("generalized_alpha", 2), ("bathe", 1), ("bdf2", 2)])
def test_a_driven_crank_takes_the_forces_of_its_motion(name: str, own: int) -> None:
    """The motion to rounding; multipliers of the equations of motion of second order, the scheme's own of `own`."""
    errors = []
    for n in (1000, 2000):
        r = ss.march(ss.scene(driven()), name, dt=0.1 / n, t_end=0.1)
        assert r.status == "completed"
        motion, forces = inverse_dynamics(r.t)
        assert np.abs(r.u - motion).max() < 1e-14
        found = [np.column_stack([of[held] for held in r.multipliers]) for of in (r.multipliers, r.memory)]
        assert np.abs(found[0][0] - forces[0]).max() < 1e-10
        errors.append([np.abs(x[-1] - forces[-1]).max() for x in found])
    assert errors[1][0] < 0.005
    assert np.log2(np.divide(*errors)) == pytest.approx([2.0, own], abs=0.1)
