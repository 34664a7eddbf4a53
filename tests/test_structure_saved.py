"""Marches of structures on disk: they go on where they were stopped, know each other, and are asked as others are."""

from typing import Any

import numpy as np
import pytest
from test_structure_input import PUSH, RECORD, K, M, frame

import substep as ss


@pytest.mark.parametrize("scheme", ["bathe", "houbolt"])
def test_a_march_on_disk_goes_on_where_it_was_stopped(tmp_path: Any, scheme: str, monkeypatch: Any) -> None:
    monkeypatch.setattr("substep.structures.saved.BUFFER", 60)  # numbers: a checkpoint every few rows
    calls = [0]

    def stopped_at(count: float) -> Any:
        def load(t: Any) -> Any:
            calls[0] += np.ndim(t) > 0 and np.size(t) == 1
            if calls[0] > count:
                raise KeyboardInterrupt
            return np.sin(t)

        return load

    def march(count: float, **more: Any) -> Any:
        calls[0] = 0
        damped = frame(C=ss.Rayleigh(0.1, 0.01), load=([1.0, 0.0, 0.0], stopped_at(count)))
        return ss.march(damped, scheme, 0.1, 8.0, stride=2, **more)

    whole = march(np.inf)
    stopped = march(50, save=tmp_path / "run")
    assert stopped.status == "interrupted"
    assert 3 < len(stopped.u) < len(whole.u)
    finished = march(np.inf, save=tmp_path / "run")
    again = march(np.inf, save=tmp_path / "run")
    for r in (finished, again):
        assert r.status == "completed"
        for name in ("u", "v", "a", "energy", "newton_iterations"):
            assert np.array_equal(getattr(r, name), getattr(whole, name)), name
        assert np.array_equal(r.account.numerical, whole.account.numerical)
    with pytest.raises(ValueError, match="another path"):
        ss.march(frame(), scheme, 0.1, 8.0, save=tmp_path / "run")


def hardening(factor: float, **more: Any) -> ss.Structure:
    return ss.structure(
        M, internal_force=lambda u: K @ u + factor * u**3, tangent=lambda u: K + np.diag(3.0 * factor * u**2), **more
    )


@pytest.mark.parametrize("start", [{"u0": [0.1, 0.0, 0.2]}, {"v0": 0.1}, {"load": PUSH}], ids=["u0", "v0", "load"])
def test_another_internal_force_is_another_march(tmp_path: Any, start: dict[str, Any]) -> None:
    """Also where its tangent at the start is the same."""
    first = ss.march(hardening(2.0, **start), "bathe", 0.1, 1.0, save=tmp_path / "run")
    again = ss.march(hardening(2.0, **start), "bathe", 0.1, 1.0, save=tmp_path / "run")
    assert np.array_equal(first.u, again.u)
    with pytest.raises(ValueError, match="another path"):
        ss.march(hardening(2.001, **start), "bathe", 0.1, 1.0, save=tmp_path / "run")


@pytest.mark.parametrize("newton", ["simplified", "full"])
def test_a_nonlinear_march_goes_on_to_the_bit_with_full_newton(tmp_path: Any, newton: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr("substep.structures.saved.BUFFER", 60)
    limit = [np.inf]

    def load(t: Any) -> Any:
        if np.size(t) == 1 and np.max(t) > limit[0]:
            raise KeyboardInterrupt
        return np.sin(t)

    def march(end: float, **more: Any) -> Any:
        limit[0] = end
        return ss.march(hardening(50.0, v0=3.0, load=([1.0, 0.0, 0.0], load)), "bathe", 0.1, 6.0, newton=newton, **more)

    whole, stopped = march(np.inf), march(3.0, save=tmp_path / "run")
    assert stopped.status == "interrupted"
    finished = march(np.inf, save=tmp_path / "run")
    assert np.abs(finished.u - whole.u).max() <= (1e-9 if newton == "simplified" else 0.0) * np.abs(whole.u).max()


@pytest.mark.parametrize("scheme", ["bathe", "rk4"])
def test_histories_beyond_the_limit_stay_on_disk(tmp_path: Any, scheme: str, monkeypatch: Any) -> None:
    """All that is asked of them is that of histories in memory, also of a run that was stopped."""
    monkeypatch.setattr("substep.structures.saved.BUFFER", 60)
    limit = [0.55]

    def load(t: Any) -> Any:
        if np.size(t) == 1 and np.max(t) > limit[0]:
            raise KeyboardInterrupt
        return np.sin(t)

    moved = frame(load=([1.0, 0.0, 0.0], load)).ground_motion(RECORD, 1.0)
    monkeypatch.setattr("substep.structures.steps.BLOCK", 1)  # loads are asked for step by step
    for status in ("interrupted", "completed"):
        expected = ss.march(moved, scheme, 0.1, 1.0)
        with monkeypatch.context() as patched:
            patched.setattr("substep.structures.saved.IN_MEMORY", 0)
            found = ss.march(moved, scheme, 0.1, 1.0, save=tmp_path / "run")
        assert found.status == expected.status == status
        assert not isinstance(found.u, np.ndarray)
        for name in ("t", "u", "v", "a", "absolute_a"):
            assert np.array_equal(np.asarray(getattr(found, name)), getattr(expected, name)), name
        assert found.to_xarray().equals(expected.to_xarray())
        assert repr(found) == repr(expected)
        limit[0] = np.inf
