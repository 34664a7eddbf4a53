"""Functions of an internal force that do not belong together are refused by name, and correct ones never."""

from typing import Any

import numpy as np
import pytest

import substep as ss
from substep.structures.march.refusals import require_suited

M = np.diag([2.0, 1.0, 3.0])
K = np.array([[6.0, -2.0, 0.0], [-2.0, 5.0, -3.0], [0.0, -3.0, 3.0]])


def force(u: Any) -> Any:
    return K @ u + 5.0 * u**3


def tangent(u: Any) -> Any:
    return K + np.diag(15.0 * u**2)


def by_differences(u: Any) -> Any:
    return np.array([(force(u + x) - force(u)) / 1e-4 for x in 1e-4 * np.eye(3)]).T


def potential(u: Any) -> Any:
    return 0.5 * u @ K @ u + 1.25 * np.sum(u**4)


def run(scheme: str, **given: Any) -> Any:
    given = {"internal_force": force, "tangent": tangent, "potential": potential, "v0": 0.3, **given}
    return ss.march(ss.structure(M, **given), scheme, dt=0.1, t_end=0.2, account=False)


@pytest.mark.parametrize("u0", [0.0, 0.4])
@pytest.mark.parametrize("factor", [3.0, 0.5, -1.0])
def test_functions_that_do_not_belong_to_the_force_are_refused(factor: float, u0: float) -> None:
    measured, of_energy = (f"got a relative difference of {abs(x):.2g}" for x in (factor - 1.0, 1.0 - 1.0 / factor))
    for scheme in ("gholampour", "kr_alpha"):
        with pytest.raises(ValueError, match=f"{scheme}.* relies on tangent=: .*internal_force.*{measured}"):
            run(scheme, tangent=lambda u: factor * tangent(u), u0=u0)
    with pytest.raises(ValueError, match=f"energy_momentum relies on potential=: .*{of_energy}.*correct potential"):
        run("energy_momentum", potential=lambda u: factor * potential(u), u0=u0)
    with pytest.raises(ValueError, match="bathe relies on tangent="):  # by its damping
        run("bathe", tangent=lambda u: factor * tangent(u), u0=u0, C=ss.rayleigh(0.02, 0.03, at=(0.6, 2.9)))


@pytest.mark.parametrize("u0", [0.0, 0.4, 1e4])
@pytest.mark.parametrize("scheme", ["gholampour", "kr_alpha", "energy_momentum"])
def test_correct_functions_pass(scheme: str, u0: float) -> None:
    """By finite differences, with an offset of the energy, at kinks, and where the force vanishes with its slope."""
    cases: list[dict[str, Any]] = [
        {},
        {"tangent": by_differences} if u0 < 1.0 else {},
        {"potential": lambda u: potential(u) + 1e9},
        {
            "internal_force": lambda u: np.where(u > u0, 3.0, 1.0) * (u - u0),
            "tangent": lambda u: np.diag(np.where(u > u0, 3.0, 1.0)),
            "potential": lambda u: 0.5 * np.sum(np.where(u > u0, 3.0, 1.0) * (u - u0) ** 2),
        },
        {
            "internal_force": lambda u: (u - u0) ** 5,
            "tangent": lambda u: np.diag(5.0 * (u - u0) ** 4),
            "potential": lambda u: np.sum((u - u0) ** 6) / 6.0,
        },
    ]
    for case in cases:
        given = {"internal_force": force, "tangent": tangent, "potential": potential, **case}
        require_suited(ss.structure(M, u0=u0, v0=0.01, **given), ss.scheme(scheme), 0.1)


def test_a_force_that_is_not_finite_at_the_start_is_named() -> None:
    def broken(u: Any) -> Any:
        return np.where(np.arange(3) == 1, np.nan, force(u))

    for scheme in ("bathe", "central_difference", "energy_momentum"):
        with pytest.raises(
            ValueError, match="expected internal_force to be finite at the start, got nan .*freedom 'b'"
        ):
            run(scheme, internal_force=broken, names=["a", "b", "c"])
