"""Structures with materials of the user's own that have a memory, declared or in a closure, where it is found."""

from typing import Any

import numpy as np
import pytest
from test_structure_springs import DT, RECORD, B, M, building, own, returned

import substep as ss


def own_by_name(t: float, u: np.ndarray, v: np.ndarray, state: dict[str, np.ndarray]) -> Any:
    force, tangent, new = own(t, u, v, state["plastic"])
    return force, (tangent, None), {"plastic": new, "t": np.array(t)}


@pytest.mark.parametrize(
    "scheme", ["average_acceleration", "bathe", "hht_alpha", "houbolt", "wilson_theta", "rk4", "radau_iia2"]
)
def test_a_material_of_ones_own_is_the_springs(scheme: str) -> None:
    s = building()
    options: dict[str, Any] = {"dt": DT, "t_end": 1.5, "account": False}
    springs = ss.march(s, scheme, **options)
    mass, damping = np.diag(M), np.asarray(s.damping)
    one = ss.structure(mass, internal_force=own, state=np.zeros(3), C=damping).ground_motion(RECORD, 1.0)
    named = {"plastic": np.zeros(3), "t": np.array(0.0)}
    other = ss.structure(mass, internal_force=own_by_name, state=named, C=damping).ground_motion(RECORD, 1.0)
    r, by_name = (ss.march(x, scheme, **options) for x in (one, other))
    assert np.allclose(r.u, springs.u, rtol=0, atol=1e-13)
    assert np.allclose(r.a, springs.a, rtol=0, atol=1e-10)
    assert np.allclose(r.memory["state"], springs.memory["p"], rtol=0, atol=1e-13)
    assert np.array_equal(by_name.u, r.u)
    assert np.allclose(by_name.memory["t"], r.t, rtol=0, atol=1e-13)  # committed where steps end
    first = ss.march(one, scheme, **options | {"t_end": 0.5})
    assert np.array_equal(ss.march(one, scheme, **options, start=first).u, r.u[50:])


class InAClosure:
    """A material that moves its memory each time it is asked."""

    def __init__(self) -> None:
        self.p = np.zeros(3)

    def force(self, u: np.ndarray) -> np.ndarray:
        q, _, self.p = returned(B @ u, self.p)
        return B.T @ q

    def tangent(self, u: np.ndarray) -> np.ndarray:
        return B.T @ np.diag(returned(B @ u, self.p)[1]) @ B


@pytest.mark.parametrize(("scheme", "t_end"), [("average_acceleration", 3.0), ("rk4", 0.75)])
def test_a_memory_in_a_closure_is_found(scheme: str, t_end: float) -> None:
    material = InAClosure()
    s = ss.structure(np.diag(M), internal_force=material.force, tangent=material.tangent)
    with pytest.raises(ValueError, match="the same force each time.*as state=") as caught:
        ss.march(s.ground_motion(RECORD, 1.0), scheme, dt=DT, t_end=t_end)
    assert caught.value.response.status == "interrupted"  # type: ignore[attr-defined]


def test_a_force_that_counts_its_calls_is_found_at_the_start() -> None:
    calls = []

    def force(u: np.ndarray) -> np.ndarray:
        calls.append(u)
        return 100.0 * u + 1e-3 * len(calls)

    s = ss.structure([[1.0]], internal_force=force, tangent=lambda u: [[100.0]], v0=1.0)
    with pytest.raises(ValueError, match="for t = 0"):
        ss.march(s, "rk4", dt=0.01, t_end=0.02)
