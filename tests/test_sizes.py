"""Runs that are too long: how many steps that is, how much memory, and a cure that works."""

import numpy as np
import pytest

import substep as ss
from substep.core import memory

SCENES = {"linear_oscillator": {"omega": 1.0}, "duffing": {}}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("dt", [1e-300, 5e-324, 1e-16])
def test_more_steps_than_a_double_counts_are_refused(name: str, dt: float) -> None:
    scene = ss.scene(name, **SCENES[name])
    with pytest.raises(ValueError, match=r"expected at most 2\*\*53 steps, got .* take a longer dt"):
        ss.march(scene, "newmark", dt=dt, t_end=10.0)
    with pytest.raises(ValueError, match=r"expected at most 2\*\*53 steps"):
        ss.sweep(scene, "newmark", dt=dt, t_end=10.0, progress=False)
    with pytest.raises(ValueError, match=r"expected at most 2\*\*53 steps"):
        ss.march(ss.structure(np.eye(2), np.eye(2), u0=[1.0, 0.0]), "newmark", dt=dt, t_end=10.0)


@pytest.mark.parametrize("name", SCENES)
def test_histories_that_do_not_fit_are_refused_with_their_size(name: str) -> None:
    scene = ss.scene(name, **SCENES[name])
    with pytest.raises(MemoryError, match=r"got 1e\+15 steps, which take .* GB, of .* GB free; take a longer dt"):
        ss.march(scene, "newmark", dt=1e-14, t_end=10.0)


@pytest.mark.usefixtures("uncompiled")
def test_the_stride_that_is_named_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "SMALL", 0)
    monkeypatch.setattr(memory, "available_memory", lambda: 24_000)
    for name, parameters in SCENES.items():
        scene = ss.scene(name, **parameters)
        with pytest.raises(MemoryError, match="GB free") as raised:
            ss.march(scene, "newmark", dt=0.01, t_end=10.0)
        stride = int(str(raised.value).rpartition("with stride=")[2])
        assert ss.march(scene, "newmark", dt=0.01, t_end=10.0, stride=stride).status == "completed"
        longer = ss.march(scene, "newmark", dt=0.1, t_end=10.0)
        assert len(longer.t) == 101


def test_no_stride_is_named_where_each_step_takes_too_much(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "SMALL", 0)
    monkeypatch.setattr(memory, "available_memory", lambda: 2_000)
    with pytest.raises(MemoryError) as raised:
        ss.march(ss.scene("duffing"), "newmark", dt=0.01, t_end=10.0)
    assert "stride" not in str(raised.value)


@pytest.mark.parametrize("n", [2.5, 0, -1, True, np.nan, "3", 2.0, None])
def test_powers_are_a_whole_number(n: object) -> None:
    with pytest.raises(ValueError, match="expected n to be a whole number of powers >= 1, got"):
        ss.scheme("newmark").power_norm(1.0, n=n)
