"""Structures with an internal force of the user's: against scenes, whose kernels are derived from energies."""

from typing import Any

import numpy as np
import pytest
from substep_derive.declare.schemes import ALL

import substep as ss

SCHEMES = [s.name for s in ALL]
START = 1e-3  # s, a small first step


def pendulum(**more: Any) -> tuple[ss.Scene, ss.Structure]:
    """The elastic pendulum as a scene and as a structure, its force from the scene's own acceleration."""
    scene = ss.scene("elastic_pendulum", a0="consistent", **more)
    m = scene.parameters["m"]

    def force(u: Any) -> Any:
        return -m * scene.acceleration(np.zeros(()), u, np.zeros(2))

    def tangent(u: Any) -> Any:
        steps = 1e-6 * np.eye(2)
        return np.array([(force(u + e) - force(u - e)) / 2e-6 for e in steps]).T

    def potential(u: Any) -> float:
        return float(scene.energy(np.zeros(()), u, np.zeros(2)))

    frame = ss.structure(
        m * np.eye(2), internal_force=force, tangent=tangent, potential=potential, u0=scene.u0, v0=scene.v0
    )
    return scene, frame


@pytest.mark.parametrize("name", SCHEMES)
def test_every_scheme_marches_the_pendulum_as_its_kernel_does(name: str) -> None:
    scene, frame = pendulum(EA=1e4)
    h, n = 1e-3, 40
    expected, found = ss.march(scene, name, h, n * h), ss.march(frame, name, h, n * h, account=False)
    assert found.status == expected.status == "completed"
    if name == "energy_momentum":  # which forms the discrete gradient in the scene's invariants: it keeps the energy
        energy = ss.march(frame, name, h, n * h).energy
        assert np.ptp(energy) <= 2e-11 * energy.max()
        assert np.abs(found.u - expected.u).max() <= 1e-4 * np.abs(expected.u).max()
        return
    for x, y in ((found.u, expected.u), (h * found.v, h * expected.v)):
        assert np.abs(x - y).max() <= 1e-9 * np.abs(expected.u).max()


@pytest.mark.parametrize("name", SCHEMES)
def test_every_scheme_marches_duffing_as_its_kernel_does(name: str) -> None:
    """With the tangent of every iteration to 1e-10; with one that is kept to what its last corrections leave, 1e-8."""
    scene = ss.scene("duffing", a0="consistent")
    k, eps = scene.parameters["k"], scene.parameters["eps"]
    frame = ss.structure(
        [[1.0]], internal_force=lambda u: k * u * (1 + eps * u * u), tangent=lambda u: [k * (1 + 3 * eps * u * u)],
        potential=lambda u: k * u[0] ** 2 / 2 + k * eps * u[0] ** 4 / 4, u0=scene.u0, v0=scene.v0,
    )  # fmt: skip
    h, n = 0.01, 40
    expected = ss.march(scene, name, h, n * h)
    for newton, digits in (("full", 1e-10), ("simplified", 1e-8)):
        found = ss.march(frame, name, h, n * h, account=False, newton=newton)
        rows = (
            int((np.abs(expected.u[:, 0]) < 10.0).argmin()) or n + 1
        )  # a run that grows beyond reason is not compared
        for x, y in ((found.u[:rows], expected.u[:rows]), (h * found.v[:rows], h * expected.v[:rows])):
            assert np.abs(x - y).max() <= digits * np.abs(expected.u).max()
