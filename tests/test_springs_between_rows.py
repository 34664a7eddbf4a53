"""What springs of a structure do at times that are asked for, and not at the ends of steps."""

import numpy as np
import pytest

import substep as ss


@pytest.mark.parametrize("chosen", [{"dt": 0.01}, {"tol": 1e-4}])
def test_what_springs_do_is_at_the_times_that_are_asked_for(chosen: dict[str, float]) -> None:
    """Two yielding stories: at ends of steps what a march has there, and between them on straight lines."""
    frame = ss.shear_building([1.0, 1.0], ss.law("bilinear", k=40.0, q_y=[0.5, 0.3], alpha=0.02))
    shaken = frame.ground_motion(ss.Record(0.02, np.sin(5 * 0.02 * np.arange(200))), 1.0)
    whole = ss.march(shaken, "bathe", t_end=3.0, **chosen)
    rows = [3, 50, len(whole.t) - 1]
    r = ss.march(shaken, "bathe", t_end=3.0, at=whole.t[rows], **chosen)
    for name in ("elongations", "forces", "stored", "dissipated"):
        assert np.allclose(getattr(r.springs, name), getattr(whole.springs, name)[rows], rtol=1e-12, atol=1e-14)
    assert np.array_equal(r.memory["p"], whole.memory["p"][rows])
    assert np.allclose(r.base_shear, whole.base_shear[rows], rtol=1e-9, atol=1e-12)
    middle = 0.5 * (whole.t[50] + whole.t[51])
    q = ss.march(shaken, "bathe", t_end=3.0, at=[middle], **chosen)
    assert np.allclose(q.springs.forces[0], 0.5 * (whole.springs.forces[50] + whole.springs.forces[51]))
    assert q.energy_dissipated.shape == (1,)
    assert np.allclose(q.springs.elongations[0, 0], q.u[0, 0], rtol=0.0, atol=1e-4)
