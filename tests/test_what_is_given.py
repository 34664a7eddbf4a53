"""What is given counts, and as it was when it was given: nothing is lost, and no later change reaches it."""

import numpy as np
import pytest

import substep as ss


def test_damping_of_a_shear_building_by_another_word_is_refused() -> None:
    story = ss.law("linear", k=100.0)
    with pytest.raises(ValueError, match=r"as damping=, got C; give the same as damping="):
        ss.shear_building([1.0], story, C=[[2.0]], v0=1.0)
    r = ss.march(ss.shear_building([1.0], story, damping=[[2.0]], v0=1.0), "gauss2", dt=0.01, t_end=2.0)
    omega = np.sqrt(99.0)  # of a unit mass, with xi = 0.1
    assert np.allclose(r.u[:, 0], np.exp(-r.t) * np.sin(omega * r.t) / omega, rtol=0.0, atol=1e-7)


def test_a_load_by_name_and_by_number_of_one_degree_of_freedom_is_refused() -> None:
    def pushed(load: dict[str | int, float]) -> ss.Structure:
        return ss.structure(np.eye(2), np.eye(2), names=["a", "b"], load=(load, ss.Step(1.0)))

    with pytest.raises(ValueError, match="once in a load, got 0 again; add up its parts"):
        pushed({"a": 1.0, 0: 2.0})
    r = ss.march(pushed({"a": 3.0, 1: 1.0}), "gauss3", dt=0.02, t_end=1.0)
    assert np.allclose(r.u, np.outer(1.0 - np.cos(r.t), [3.0, 1.0]), rtol=0.0, atol=1e-12)
