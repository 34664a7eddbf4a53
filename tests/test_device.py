"""Marches in the threads of a GPU give what those on the CPU give: in numba's simulator always, on a device if any."""

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from in_simulator import CASES, LINEAR, SINGLE, sweep
from substep_derive.declare.catalogue import find, find_scene
from substep_derive.emit.first_use import catalogue_pair, pair_in_threads
from substep_derive.motion.equations import EquationsOfMotion

import substep as ss
from substep.core import device

HERE = Path(__file__).parent
SIMULATED = {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1"}  # kernels of the CPU as plain Python: none compiles
PRECISION = 1e-12  # relative, of linear marches
OF_NEWTON = 1e-9  # of scenes, by the tolerance of Newton's iteration and what the motion makes of it
OF_SINGLE = 1e-8, 1e-4  # single precision rounds to 6e-8: it is no closer, and keeps four digits in so few steps


def is_right(case: str, difference: float) -> bool:
    """Whether a case differs as little, and in single precision as much, as it has to."""
    if case in SINGLE:
        return OF_SINGLE[0] < difference < OF_SINGLE[1]
    return difference <= (PRECISION if case in LINEAR else OF_NEWTON)


@cache
def differences(*settings: tuple[str, str], apart: str = "") -> Mapping[str, float]:
    """The largest relative difference of each case, or of one apart, found in a process with these settings."""
    found = subprocess.run(
        [sys.executable, "-W", "ignore", str(HERE / "in_simulator.py"), *([apart] if apart else CASES)],
        env={**os.environ, **dict(settings)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert found.returncode == 0, found.stderr
    return json.loads(found.stdout)


@pytest.mark.parametrize("case", CASES)
def test_the_simulator_gives_the_values_of_the_cpu(case: str) -> None:
    assert is_right(case, differences(*SIMULATED.items())[case])


@pytest.mark.thorough
def test_each_worker_of_a_cluster_uses_its_device() -> None:
    assert differences(*SIMULATED.items(), apart="cluster")["cluster"] <= OF_NEWTON


def has_device() -> bool:
    return device.found("auto")


@pytest.mark.skipif(not has_device(), reason="numba finds no CUDA device here")
@pytest.mark.parametrize("case", CASES)
def test_a_device_gives_the_values_of_the_cpu(case: str) -> None:
    assert is_right(case, differences()[case])


@pytest.mark.skipif(has_device(), reason="a CUDA device is here")
def test_what_is_missing_for_a_device_is_said_with_the_cure() -> None:
    with pytest.raises(RuntimeError, match=r"expected a CUDA device .* pip install 'substep\[cuda\]' .*device='cpu'"):
        ss.response_spectrum([0.0, 1.0, 0.0], dt=0.01, device="cuda")
    with pytest.raises(RuntimeError, match="expected a CUDA device"):
        sweep("duffing", "bathe", u0=[0.5, 1.0])("cuda")


def test_auto_takes_the_cpu_where_there_is_no_device(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numba.cuda", None)  # as where numba has none
    assert not device.found("auto")
    with pytest.raises(ImportError, match=r"expected numba-cuda .* pip install 'substep\[cuda\]'"):
        device.found("cuda")


def test_names_of_devices_are_checked_before_anything_runs() -> None:
    with pytest.raises(ValueError, match="device"):
        sweep("duffing", "bathe", u0=[0.5, 1.0])("gpu")
    with pytest.raises(ValueError, match="workers"):
        sweep("duffing", "bathe", u0=[0.5, 1.0], workers=0)("cpu")


@pytest.mark.parametrize("pair", [("bathe", "elastic_pendulum"), ("newmark", "softening"), ("park", "penalty_bounce")])
def test_the_text_of_a_thread_is_that_of_one_lane(pair: tuple[str, str]) -> None:
    scheme, motion = find(pair[0]), EquationsOfMotion(find_scene(pair[1]))
    lane, thread = (
        text.partition("def _lane(")[2].partition("@_compile")[0]
        for text in (catalogue_pair(scheme, motion), pair_in_threads(scheme, motion))
    )
    assert lane.strip()
    assert lane.replace("np.sign(", "_sign(").replace("np.minimum(", "min(").replace("np.", "math.") == thread


def test_out_is_for_arrays_on_a_device() -> None:
    with pytest.raises(ValueError, match="expected out with Omega or xi on a GPU only"):
        ss.scheme("newmark").spectral_radius([1.0, 2.0], out=np.empty(2))


def test_lanes_that_do_not_fit_on_the_device_go_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    free = 1000.0

    class Cuda:
        @staticmethod
        def current_context() -> "Cuda":
            return Cuda()

        def get_memory_info(self) -> "Cuda":
            return self

        @property
        def free(self) -> float:
            return free

    monkeypatch.setitem(sys.modules, "numba.cuda", Cuda)
    parts = list(device._parts(0, 25, each=100.0, common=0.0))
    assert [part.stop - part.start for part in parts] == [8, 8, 8, 1]
    free = 50.0
    with pytest.raises(MemoryError, match="expected a lane to fit in the device's memory, got 1e-07 GB, of 5e-08 GB"):
        list(device._parts(0, 25, each=100.0, common=0.0))


@pytest.mark.skipif(has_device(), reason="a CUDA device is here")
def test_the_table_of_a_machine_without_a_device_says_not_measured(tmp_path: Path) -> None:
    call = [sys.executable, "-m", "benchmarks.device", str(tmp_path), "--small", "--only"]
    subprocess.run([*call, "machine,spectrum,pendulum,energy"], cwd=HERE.parent, capture_output=True, check=True)
    table = (tmp_path / "device.md").read_text(encoding="utf-8")
    assert "- device: none: expected a CUDA device" in table
    rows = [f"| {name} | not measured |  | no device |" for name in ("spectrum", "pendulum", "energy")]
    assert table.splitlines()[-3:] == rows


def test_a_warp_does_in_each_loop_what_its_slowest_lane_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(HERE.parent)
    monkeypatch.setattr(os, "environ", dict(os.environ))  # the package sets folders of caches
    from benchmarks.device.warps import waiting

    work = np.random.default_rng(2).integers(1, 6, (64, 10, 2))
    loops = sum(max(int(x) for x in work[w : w + 32, i, b]) for w in (0, 32) for i in range(10) for b in range(2))
    assert waiting(work) == pytest.approx(32 * loops / work.sum(), rel=1e-14)
    assert waiting(np.repeat([3, 7], 32)) == 1.0


@pytest.mark.thorough
def test_fewer_workers_give_the_same() -> None:
    found = [sweep("duffing", "bathe", u0=np.linspace(0.1, 1.0, 200), workers=k)("cpu") for k in (1, None)]
    assert found[0].equals(found[1])
