"""The same marches on the CPU and in numba's CUDA simulator, in a process of its own: see test_device.

Run as a program, with the names of cases, it prints for each the largest relative difference as JSON. Without the
simulator, it takes the device that there is.
"""

import json
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from tempfile import TemporaryDirectory
from typing import Any, cast
from unittest.mock import patch

import numpy as np
from substep_derive.declare.scenes.constrained import four_bar
from substep_derive.kernels import linear_system

import substep as ss
from substep.core import device as core_device
from substep.sweeps.scene_plan import ScenePlan

LAUNCHED: list[int] = []  # how many lanes each launch of a kernel has had
STEPS = 12
SHAKEN = ss.Record(0.02, np.concatenate([[0.0], np.random.default_rng(3).standard_normal(STEPS)]), unit="m/s^2")
LATE = ss.Record(0.02, np.random.default_rng(4).standard_normal(STEPS), unit="m/s^2")  # not from rest: no filter


def spectrum(scheme: str, record: ss.Record = SHAKEN, **options: Any) -> Callable[..., Mapping[str, Any]]:
    """A response spectrum with its errors, and so the exact one."""
    given = {"periods": [0.1, 0.5, 2.0], "scheme": scheme, **options}
    return lambda device, **more: ss.response_spectrum(record, **given, **more, device=device)


def sweep(scene: str, scheme: str, **options: Any) -> Callable[..., Mapping[str, Any]]:
    """A sweep, of few steps unless it says otherwise."""
    given = {"dt": 0.01, "t_end": 0.01 * STEPS, "progress": False, **options}
    return lambda device, **more: ss.sweep(scene, scheme, **given, **more, device=device)


def rounded(case: Callable[..., Mapping[str, Any]], *names: str) -> Callable[[str], Mapping[str, Any]]:
    """Some variables of a case, of the GPU in single precision, with the error that it says."""

    def found(device: str) -> Mapping[str, Any]:
        if device == "cpu":
            return {name: case(device)[name] for name in names}
        results: Any = case(device, dtype="float32")
        assert all(1e-8 < results[name].attrs["float32_error"] < 1e-4 for name in names)
        return {name: results[name] for name in names}

    return found


def exact_peaks(device: str) -> Mapping[str, Any]:
    """Of the exact response, as they follow from peaks, of the GPU in single precision, and their errors."""
    ds = spectrum("average_acceleration")(device, dtype="float64" if device == "cpu" else "float32")
    return {"exact": ds["displacement"] / (1.0 + ds["displacement_error"])}


def in_parts(case: Callable[..., Mapping[str, Any]]) -> Callable[[str], Mapping[str, Any]]:
    """A case on a device whose memory holds two lanes."""

    def parts(first: int, last: int, *_: float) -> list[slice]:
        return [slice(k, min(k + 2, last)) for k in range(first, last, 2)]

    def found(device: str) -> Mapping[str, Any]:
        with patch.object(core_device, "_parts", parts):
            return case(device)

    return found


def resumed(case: Callable[..., Mapping[str, Any]]) -> Callable[[str], Mapping[str, Any]]:
    """A sweep on a GPU in chunks of two points that is saved, stopped in the second one, and goes on."""

    def found(device: str) -> Mapping[str, Any]:
        if device == "cpu":
            return case(device)
        run = ScenePlan.run

        def stopped(plan: ScenePlan, first: int, *rest: Any) -> Any:
            if first == 2:
                raise KeyboardInterrupt
            return run(plan, first, *rest)

        with TemporaryDirectory() as folder, patch.object(ScenePlan, "piece", lambda *_: (1, 2)):
            with patch.object(ScenePlan, "run", stopped):
                half: Any = case(device, save=f"{folder}/s.zarr")
                done = (half["status"].values == 0).ravel()
                assert half.attrs["interrupted"] == 1
                assert done.tolist() == [True, True, *[False] * (done.size - 2)]
            before, whole = len(LAUNCHED), cast("Any", case(device, save=f"{folder}/s.zarr")).load()
            assert len(LAUNCHED) == before + done.size // 2 - 1
            return whole

    return found


def on_a_cluster(device: str) -> Mapping[str, Any]:
    """A sweep of four chunks by two processes, each with its device."""
    from distributed import Client, LocalCluster

    case = sweep("duffing", "newmark", u0=[0.5, 1.0], dt=[0.01, 0.02], t_end=0.12)
    if device == "cpu":
        return case(device)
    LAUNCHED.append(0)  # by the workers, which raise an error where they have no device
    two = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with LocalCluster(**two) as cluster, Client(cluster) as client:
        return case(device, client=client)


def in_loops(device: str) -> Mapping[str, Any]:
    """A four-bar linkage whose systems are solved in loops, in arrays of each thread, on a device alone."""
    given = {"v0": [0.5, 1.0], "dt": 0.01, "t_end": 0.04, "progress": False}
    if device == "cpu":
        return ss.sweep(four_bar, "newmark", **given)
    with patch.object(linear_system, "MOST", 0):
        return ss.sweep(replace(four_bar, name="four_bar_in_loops"), "newmark", **given, device=device)


HALF_SINE = ss.HalfSine(1.0, 0.1)
OMEGA = np.array([1.0, 20.0, 150.0])
LINEAR = {
    "filter": spectrum("average_acceleration", xi=[0.02, 0.1]),
    "filter of third order": spectrum("generalized_alpha"),
    "march": spectrum("newmark", LATE),
    "refined": spectrum("wilson_theta", refine="auto"),
    "final": sweep("linear_oscillator", "generalized_alpha", omega=OMEGA, rho_inf=[0.2, 0.8]),
    "peak": sweep("linear_oscillator", "bathe", omega=OMEGA, keep="peak", load=HALF_SINE),
    "history": sweep("linear_oscillator", "newmark", omega=OMEGA, keep="history", samples=4, load=HALF_SINE),
    "own loads": sweep("linear_oscillator", "newmark", omega=OMEGA, load=HALF_SINE, duration=[0.05, 0.1]),
    "started by another": sweep("linear_oscillator", "park", omega=OMEGA, keep="history"),
    "inelastic": lambda device: ss.inelastic_spectrum(SHAKEN, periods=[0.2, 1.0], ductility=2.0, device=device),
    "incremental": lambda device: ss.incremental_dynamic_analysis(
        [SHAKEN], [0.2, 1.0], intensity=[1.0, 2.0], strength=0.5, measure="scale", device=device
    ),
    "exact beside single": exact_peaks,
    "unstable": sweep("linear_oscillator", "central_difference", omega=[1.0, 1e30], t_end=0.3, keep="peak"),
}
SCENES = {
    "pendulum": sweep("elastic_pendulum", "bathe", EA=[1e4, 1e6], v0=[7.0, 8.0]),
    "pendulum, peak": sweep("elastic_pendulum", "newmark_bdf2", EA=[1e4, 1e6], keep="peak"),
    "pendulum, history": sweep("elastic_pendulum", "energy_momentum", EA=[1e4, 1e6], keep="history", samples=3),
    "contact": sweep("penalty_bounce", "newmark", u0=[0.01, 0.1], v0=[-1.0, -2.0]),
    "explicit": sweep("softening", "rk4", u0=[0.5, 1.0], k=[1.0, 10.0]),
    "started": sweep("duffing", "kr_alpha", u0=[0.5, 1.0]),
    "started by another": sweep("simple_pendulum", "houbolt", u0=[0.5, 1.0], keep="history"),
    "law": sweep(
        "hysteretic_oscillator",
        "newmark",
        law="bilinear",
        strength=0.5,
        dt=0.05,
        t_end=0.6,
        omega=[1.0, 9.0],
        v0=[1.0, 3.0],
    ),
    "rod": sweep("rod_pendulum", "generalized_alpha", v0=[7.0, 8.0]),
    "in loops": in_loops,
    "floor": sweep("bouncing_ball", "average_acceleration", u0=[0.01, 0.02], dt=0.02, t_end=0.24),
    "sliding": sweep("sliding_block", "bathe", v0=[0.2, 3.0], dt=0.02, t_end=0.24),
    "bound": sweep("elastic_pendulum", "bathe", EA=[1e4, 1e6], energy_bound=300.0),
    "tol": sweep("elastic_pendulum", "bathe", EA=[1e4, 1e6], dt=None, tol=[1e-2, 1e-3], t_end=0.1),
    "tol, peak": sweep("duffing", "generalized_alpha", u0=[0.5, 1.0], dt=None, tol=1e-3, t_end=0.5, keep="peak"),
    "tol, grid": sweep(
        "simple_pendulum", "newmark", u0=[0.5, 1.0], dt=None, tol=1e-3, t_end=0.3, keep="history", grid=[0.0, 0.1, 0.3]
    ),
    "tol, record": sweep(
        "linear_oscillator", "newmark_bdf2", omega=[1.0, 9.0], dt=None, tol=1e-2, t_end=0.2, load=SHAKEN
    ),
    "tol, pulse": sweep("linear_oscillator", "newmark", omega=[1.0, 9.0], dt=None, tol=1e-2, t_end=0.3, load=HALF_SINE),
    "tol, law": sweep(
        "hysteretic_oscillator",
        "newmark",
        law="bilinear",
        strength=0.5,
        dt=None,
        tol=1e-2,
        t_end=0.6,
        omega=9.0,
        v0=[1.0, 3.0],
    ),
    "tol, bound": sweep("elastic_pendulum", "bathe", EA=[1e4, 1e6], dt=None, tol=1e-2, t_end=0.1, energy_bound=300.0),
    "failing": sweep("elastic_pendulum", "newmark", EA=[1e4, 1e30], dt=0.1, t_end=1.2),
}


def radii(scheme: str, **parameters: float) -> Callable[[str], Mapping[str, Any]]:
    """The spectral radius at points, NaN at the last ones, where the CPU refuses Omega."""
    Omega = np.append(np.geomspace(1e-3, 1e3, 30), [-1.0, np.inf])
    s = ss.scheme(scheme, **parameters)

    def found(device: str) -> Mapping[str, Any]:
        if device == "cpu":
            return {"radius": np.append(s.spectral_radius(Omega[:-2], 0.1), [np.nan, np.nan])}
        from numba import cuda

        LAUNCHED.append(len(Omega))
        there = cuda.to_device(Omega)
        assert s.spectral_radius(there.reshape(4, 8), 0.1).shape == (4, 8)
        radius, damping = cuda.device_array(len(Omega)), cuda.to_device(np.full(len(Omega), 0.1))
        assert s.spectral_radius(there, 0.1, out=radius) is radius
        both = s.spectral_radius(there, damping).copy_to_host()
        assert np.array_equal(both, radius.copy_to_host(), equal_nan=True)
        return {"radius": both}

    return found


LINEAR |= {f"in parts: {name}": in_parts(LINEAR[name]) for name in ("filter", "peak", "history", "own loads")}
SCENES |= {f"in parts: {name}": in_parts(SCENES[name]) for name in ("pendulum, history", "tol, grid")}
LINEAR["resumed"] = resumed(LINEAR["final"])
SCENES["resumed"] = resumed(SCENES["pendulum"])
LINEAR |= {f"radii of {name}": radii(name) for name in ("newmark", "generalized_alpha")}
PEAKS = "displacement", "velocity", "acceleration"
SINGLE = {
    "single: filter": rounded(spectrum("average_acceleration"), *PEAKS),
    "single: march": rounded(spectrum("newmark", LATE, errors=False), *PEAKS),
    "single: history": rounded(LINEAR["history"], *"uva"),
    "single: pendulum": rounded(SCENES["pendulum"], *"uv"),
    "single: peak": rounded(SCENES["pendulum, peak"], "peak_u", "peak_v"),
    "single: functions": rounded(sweep("softening", "newmark", u0=[0.5, 1.0], k=[1.0, 10.0]), *"uva"),
    "single: law": rounded(SCENES["law"], *"uv"),
}
CASES = {**LINEAR, **{f"scene: {name}": case for name, case in SCENES.items()}, **SINGLE}
APART = {"cluster": on_a_cluster}


def difference(case: Callable[[str], Mapping[str, Any]]) -> float:
    """The largest difference of any variable, over its largest value; infinite where one of two is NaN, or a count."""
    here, launches = case("cpu"), len(LAUNCHED)
    there, worst = case("cuda"), 0.0
    assert len(LAUNCHED) > launches, "no kernel was launched"
    for name in here:
        a, b = (np.asarray(x[name], float) for x in (here, there))
        if not np.array_equal(np.isnan(a), np.isnan(b)) or not np.array_equal(np.isinf(a), np.isinf(b)):
            return np.inf
        finite = np.isfinite(a)
        scale = 1.0 if str(name).endswith("_error") else max(np.abs(a[finite]).max(initial=0.0), 1e-300)
        worst = max(worst, np.abs(a - b)[finite].max(initial=0.0) / scale)
    return float(worst)


def counted(launch: Callable[..., None]) -> Callable[..., None]:
    """A launch that is taken down."""

    def counts(kernel: Any, lanes: int, *arguments: Any) -> None:
        LAUNCHED.append(lanes)
        launch(kernel, lanes, *arguments)

    return counts


if __name__ == "__main__":
    core_device._launch = counted(core_device._launch)
    print(json.dumps({name: difference({**CASES, **APART}[name]) for name in sys.argv[1:]}))
