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
