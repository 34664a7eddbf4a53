"""What substep does on a device, beside what it does on the CPU of the same machine."""

import math
import platform
import time
from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import Any

import numba
import numpy as np
from numba import cuda

import substep as ss
from substep.core import device
from substep.core.threads import at_most, cores
from substep.exact.oscillator import exact_peaks
from substep.ground_motion.peaks import at_rest
from substep.marching.digital_filter import filter_of, filter_peaks
from substep.marching.scene_lanes import march_lanes

from .table import OURS, RATE, Report, best, missing_device, operations, shaken, threads_of_a_block


def machine(report: Report) -> None:
    """What the device is."""

    facts = report.facts
    facts["python"], facts["numba"], facts["numpy"] = platform.python_version(), numba.__version__, np.__version__
    facts["numba.cuda"] = getattr(cuda, "implementation", "")
    for name in ("numba_cuda", "cupy", "jax"):
        try:
            facts[name] = __import__(name).__version__
        except Exception as error:  # also one that is installed and broken
            facts[name] = f"none ({type(error).__name__})"
    facts["CPU cores"] = cores()
    if missing := missing_device():
        facts["device"] = f"none: {missing}"
        return
    here = getattr(cuda, "get_current_device", object)()  # the simulator has none
    name = getattr(here, "name", "simulator")
    facts["device"] = name.decode() if isinstance(name, bytes) else str(name)
    for name in ("MULTIPROCESSOR_COUNT", "CLOCK_RATE"):
        facts[name] = getattr(here, name, "unknown")
    free, total = cuda.current_context().get_memory_info()
    facts["device memory, GB free / all"] = f"{free / 1e9:.1f} / {total / 1e9:.1f}"


def multiply_adds(report: Report) -> None:
    """The rate of multiply-adds in double precision that the device reaches, with nothing else to do."""

    @cuda.jit
    def chains(x, n):
        j = cuda.grid(1)
        if j < x.size:
            a, b = 0.999999, 1e-9
            p, q, r, s = x[j], x[j] + 1.0, x[j] + 2.0, x[j] + 3.0
            for _ in range(n):
                p, q, r, s = p * a + b, q * a + b, r * a + b, s * a + b
                p, q, r, s = p * a + b, q * a + b, r * a + b, s * a + b
                p, q, r, s = p * a + b, q * a + b, r * a + b, s * a + b
                p, q, r, s = p * a + b, q * a + b, r * a + b, s * a + b
            x[j] = p + q + r + s

    lanes, n = (64, 4) if report.small else (1 << 20, 2000)
    x = cuda.to_device(np.linspace(0.0, 1.0, lanes))

    def run() -> None:
        chains[-(-lanes // 256), 256](x, n)
        cuda.synchronize()

    report.add(RATE, lanes * n * 16 / best(run, 3), "1/s", "measured, of this device")


def spectrum(report: Report) -> None:
    """Peaks of oscillators under a record: the kernel of the filter, and what it is compared with."""

    n = 40 if report.small else 4096
    s, load = ss.scheme("average_acceleration"), shaken(n)

    def filters(P: int) -> Any:
        o = at_rest(2.0 * np.pi / np.geomspace(0.02, 10.0, P), np.full(P, 0.05), load)
        return filter_of(s, o, n, load)

    sizes = (4, 8) if report.small else (1 << 13, 1 << 16, 1 << 20)
    T = filters(16 if report.small else 1 << 14)

    def on_cpu() -> np.ndarray:
        return filter_peaks(T, s.kernels.FILTER, load.samples, 3)

    expected, steps = on_cpu(), n * T.shape[1]
    all_cores = steps / best(on_cpu, 5)
    with at_most(1):
        one_core = steps / best(on_cpu, 3)
    report.add(
        "spectrum, one CPU core", one_core, "oscillator-steps/s", f"{T.shape[1]} oscillators, {n} steps, SD SV SA"
    )
    report.add("spectrum, all CPU cores", all_cores, "oscillator-steps/s", f"{cores()} cores")

    def launches(T: Any) -> list[float]:
        with report.kernels.counted() as seconds:
            for _ in range(4):
                filter_peaks(T, s.kernels.FILTER, load.samples, 3)
        return seconds

    with device.on("cuda"):
        first, *later = launches(T)
        report.add("spectrum, first launch", first - min(later), "s", "compiles")
        found = filter_peaks(T, s.kernels.FILTER, load.samples, 3)
        for P in sizes[:-1]:
            rate = n * P / min(launches(filters(P)))
            report.add(f"spectrum, kernel, {P} oscillators", rate, "oscillator-steps/s")
        P, many = sizes[-1], filters(sizes[-1])
        for threads in (32, 128, 256):
            with threads_of_a_block(threads):
                rate = n * P / min(launches(many))
            report.add(f"spectrum, kernel, blocks of {threads} threads", rate, "oscillator-steps/s", f"{P} oscillators")
        rate = n * P / min(launches(many))
        report.add(OURS, rate, "oscillator-steps/s", f"{P} oscillators, {n} steps, blocks of {device.THREADS} threads")
    report.add("spectrum, kernel / one CPU core", rate / one_core, "")
    report.add("spectrum, kernel / all CPU cores", rate / all_cores, "")
    sums, comparisons = operations(device._peaks_of_filter(s.kernels.FILTER, 3).peaks)
    limit = report.value(RATE) / sums
    report.add(
        "spectrum, kernel / limit of its sums", rate / limit, "", f"{sums} fused operations, {comparisons} comparisons"
    )
    limit = report.value(RATE) / (sums + comparisons)
    report.add("spectrum, kernel / limit with comparisons", rate / limit, "")
    report.add("spectrum, largest relative difference from the CPU", float(np.abs(found / expected - 1.0).max()))


def march_of_a_shape(report: Report) -> None:
    """The march that any load and any scheme takes, for peaks."""

    n, P = (40, 8) if report.small else (4096, 1 << 19)
    load, omega = shaken(n), 2.0 * np.pi / np.geomspace(0.02, 10.0, P)
    some = omega[:: max(P >> 12, 1)]
    expected = exact_peaks(some, np.full(len(some), 0.05), load)
    with device.on("cuda"):
        found = exact_peaks(some, np.full(len(some), 0.05), load)
        with report.kernels.counted() as seconds:
            for _ in range(2):
                exact_peaks(omega, np.full(P, 0.05), load)
    with at_most(1):
        one = best(lambda: exact_peaks(some, np.full(len(some), 0.05), load), 3)
    rate = n * P / min(seconds)
    report.add("linear march, kernel", rate, "oscillator-steps/s", f"{P} oscillators, peaks")
    report.add("linear march, kernel / one CPU core", rate * one / (n * len(some)), "")
    sums, comparisons = operations(device._march_of_shape("linear_march_2_01y", 2).march)
    limit = report.value(RATE) / (sums + comparisons)
    report.add(
        "linear march, kernel / limit with comparisons",
        rate / limit,
        "",
        f"{sums} fused operations, {comparisons} comparisons",
    )
    report.add("linear march, largest relative difference from the CPU", float(np.abs(found / expected - 1.0).max()))


def spectrum_call(report: Report) -> None:
    """`response_spectrum` as it is called, with everything around the kernel."""
    n, P = (40, 8) if report.small else (8192, 1 << 17)
    load, periods = shaken(n), np.geomspace(0.05, 10.0, P)
    seconds = {}
    for name in ("cpu", "cuda"):
        call = partial(ss.response_spectrum, load, periods=periods, errors=False, device=name)
        seconds[name] = best(call, 2)
        report.add(f"response_spectrum, {name}", seconds[name], "s", f"{P} periods, {n} samples, no errors")
    report.add("response_spectrum, cpu / cuda", seconds["cpu"] / seconds["cuda"], "", "all cores")


def pendulum(report: Report) -> None:
    """Newton in every sub-step, of lanes whose start velocities differ, in both regimes."""

    n, P, few = (5, 4, 4) if report.small else (1000, 1 << 18, 1 << 13)
    for scheme in ("bathe", "newmark_bdf2"):
        s = ss.scheme(scheme)
        for case, EA, a0 in (("flexible", 1e4, (0.0, 0.0)), ("stiff", 1e10, (-19.6, 0.0))):
            scene = ss.scene("elastic_pendulum", EA=EA, a0=a0)

            def lanes(count: int, scene=scene, s=s) -> Any:
                v0 = np.zeros((count, 2))
                v0[:, 1] = np.linspace(7.0, 8.0, P)[:: P // count][:count]
                start = np.broadcast_to(scene.u0, (count, 2)), v0, np.broadcast_to(scene.a0, (count, 2))
                return march_lanes(scene, s, np.full(count, 0.01), np.full(count, n), start=start)

            title = f"pendulum, {scheme}, {case}"
            expected = lanes(few)
            all_cores = few * n / best(lambda lanes=lanes: lanes(few), 2)
            with at_most(1):
                one_core = few * n / best(lambda lanes=lanes: lanes(few), 1)
            with device.on("cuda"):
                with report.kernels.counted() as seconds:
                    lanes(P)
                    second = time.perf_counter()
                    lanes(P)
                call = time.perf_counter() - second
                found = lanes(few)
                for threads in (32, 128, 256) if scheme == "bathe" else ():
                    with threads_of_a_block(threads), report.kernels.counted() as others:
                        lanes(P)
                    name = f"{title}, kernel, blocks of {threads} threads"
                    report.add(name, P * n / min(others), "lane-steps/s")
            rate = P * n / min(seconds)
            if case == "flexible":
                report.add(f"{title}, first launch", seconds[0] - min(seconds), "s", "compiles")
            report.add(f"{title}, kernel", rate, "lane-steps/s", f"{P} lanes, {n} steps")
            report.add(f"{title}, kernel / one CPU core", rate / one_core, "")
            report.add(f"{title}, kernel / all CPU cores", rate / all_cores, "")
            report.add(f"{title}, whole call / one CPU core", P * n / call / one_core, "", "with copies")
            report.add(f"{title}, iterations a step", float(expected.newton[:, 0].sum(axis=1).mean() / n), "")
            same = (found.n_done == expected.n_done).all() and (found.status == expected.status).all()
            far = np.abs(found.state[:, 0] - expected.state[:, 0]).max() / scene.parameters["L"]
            report.add(
                f"{title}, largest difference of u from the CPU / L", float(far), "", f"steps the same: {bool(same)}"
            )


def sweeps(report: Report) -> None:
    """`ss.sweep` as it is called."""
    many = np.linspace(0.0, 1.0, 4 if report.small else 1024)
    pendula = {"EA": 10.0 ** (3.0 + 3.0 * many), "v0": 6.0 + 2.0 * many}
    oscillators = {"omega": 1.0 + 49.0 * many, "rho_inf": many}
    for scene, scheme, axes in (
        ("elastic_pendulum", "bathe", pendula),
        ("linear_oscillator", "generalized_alpha", oscillators),
    ):
        t_end = 0.1 if report.small else 10.0
        seconds, found = {}, {}
        for name in ("cpu", "cuda"):

            def run(name=name, scene=scene, scheme=scheme, axes=axes, t_end=t_end, found=found) -> None:
                found[name] = ss.sweep(scene, scheme, dt=0.01, t_end=t_end, **axes, device=name, progress=False)

            seconds[name] = best(run, 1)
            runs = found[name].status.size
            report.add(f"sweep of {scene}, {name}", seconds[name] / runs * 1e9, "ns/run", f"{runs} runs to {t_end} s")
        report.add(f"sweep of {scene}, cpu / cuda", seconds["cpu"] / seconds["cuda"], "", "all cores")
        far = abs(found["cpu"].u - found["cuda"].u).max() / abs(found["cpu"].u).max()
        report.add(f"sweep of {scene}, largest difference of u", float(far))


def stability_grid(report: Report) -> None:
    """The spectral radius at points whose array is on the device, stored there; and how fast that memory is copied."""

    @cuda.jit
    def fills(x):
        j = cuda.grid(1)
        if j < x.size:
            x[j] = 1e-2 * math.exp(11.5 * j / x.size)  # 0.01 to 1000

    @cuda.jit
    def copies(x, y):
        j = cuda.grid(1)
        if j < x.size:
            y[j] = 1.5 * x[j]

    P = 64 if report.small else 1 << 28
    x, y = cuda.device_array(P), cuda.device_array(P)
    fills[-(-P // 256), 256](x)

    def timed(run: Callable[[], Any]) -> float:
        def whole() -> None:
            run()
            cuda.synchronize()

        return best(whole, 5)

    bandwidth = 16.0 * P / timed(lambda: copies[-(-P // 256), 256](x, y))
    report.add("copy on the device", bandwidth / 1e9, "GB/s", f"{P} doubles")
    few = slice(None, None, max(P >> 18, 1))
    Omega = np.ascontiguousarray(x.copy_to_host()[few])
    for name in ("newmark", "bathe", "generalized_alpha"):
        s = ss.scheme(name)
        begin = time.perf_counter()
        s.spectral_radius(x, 0.02, out=y)
        cuda.synchronize()
        first = time.perf_counter() - begin
        found, expected = y.copy_to_host()[few], s.spectral_radius(Omega, 0.02)
        seconds = timed(lambda s=s: s.spectral_radius(x, 0.02, out=y))
        with at_most(1):
            one = best(lambda s=s: s.spectral_radius(Omega, 0.02), 3) / Omega.size
        report.add(f"spectral radius, {name}", P / seconds, "points/s", f"{P} points, first call {first:.2f} s")
        report.add(f"spectral radius, {name} / one CPU core", one * P / seconds, "", "a range of Omega, in order")
        report.add(f"spectral radius, {name} / copy on the device", 16.0 * P / seconds / bandwidth)
        other = timed(lambda s=s: s.spectral_radius(x, 0.02))
        report.add(f"spectral radius, {name} / copy, in a new array", 16.0 * P / other / bandwidth)
        far = float(np.abs(found / expected - 1.0).max())
        report.add(f"spectral radius, {name}, largest relative difference from the CPU", far)


def chosen_steps(report: Report) -> None:
    """Pendulums that choose their steps, a thread each."""
    few = 4 if report.small else 1 << 12
    many = few if report.small else 1 << 18
    for scheme in ("bathe", "generalized_alpha"):
        seconds, found = {}, {}
        for name, P in (("cpu", few), ("cuda", many)):
            axes = {"v0": 6.0 + 2.0 * np.arange(P) / P, "EA": 1e4}

            def run(name=name, axes=axes, scheme=scheme, found=found) -> None:
                found[name] = ss.sweep(
                    "elastic_pendulum",
                    scheme,
                    tol=1e-5,
                    t_end=0.1 if report.small else 5.0,
                    **axes,
                    device=name,
                    progress=False,
                )

            seconds[name] = best(run, 2) / P
            report.add(f"chosen steps, {scheme}, {name}", seconds[name] * 1e9, "ns/run", f"{P} runs, whole call")
        report.add(f"chosen steps, {scheme}, cpu / cuda", seconds["cpu"] / seconds["cuda"], "", "all cores")
        here, there = found["cpu"], found["cuda"].isel(v0=slice(None, None, many // few))
        same = float((here.accepted == there.accepted).mean())
        far = float(abs(here.u - there.u).max() / abs(here.u).max())
        report.add(
            f"chosen steps, {scheme}, steps a run", float(here.accepted.mean()), "", f"same number in {same:.3%}"
        )
        report.add(f"chosen steps, {scheme}, largest difference of u", far)


def inelastic(report: Report) -> None:
    """Constant-ductility spectra as they are called."""
    n, P = (40, 4) if report.small else (4096, 4096)
    seconds, found = {}, {}
    for name in ("cpu", "cuda"):

        def run(name=name) -> None:
            found[name] = ss.inelastic_spectrum(
                shaken(n), periods=np.geomspace(0.2, 5.0, P), ductility=[2.0, 4.0], errors=False, device=name
            )

        seconds[name] = best(run, 1)
        report.add(f"inelastic_spectrum, {name}", seconds[name], "s", f"{P} periods, 2 ductilities, {n} samples")
    report.add("inelastic_spectrum, cpu / cuda", seconds["cpu"] / seconds["cuda"], "", "all cores")
    far = abs(found["cpu"].A_y / found["cuda"].A_y - 1.0).max()
    report.add("inelastic_spectrum, largest relative difference of A_y", float(far))


def energy(report: Report) -> None:
    """What a step costs in joules, by the device's own counter."""
    if report.small:
        return
    nvml = import_module("pynvml")
    nvml.nvmlInit()
    handle = nvml.nvmlDeviceGetHandleByIndex(0)
    begin, first = time.perf_counter(), nvml.nvmlDeviceGetTotalEnergyConsumption(handle)
    time.sleep(2.0)
    report.add(
        "power at rest",
        (nvml.nvmlDeviceGetTotalEnergyConsumption(handle) - first) * 1e-3 / (time.perf_counter() - begin),
        "W",
    )
    s, n, P = ss.scheme("average_acceleration"), 4096, 1 << 20
    load = shaken(n)
    T = filter_of(s, at_rest(2.0 * np.pi / np.geomspace(0.02, 10.0, P), np.full(P, 0.05), load), n, load)
    there, f, out = cuda.to_device(T), cuda.to_device(load.samples), cuda.device_array((3, P))
    kernel = device._peaks_of_filter(s.kernels.FILTER, 3).peaks
    bathe, scene = ss.scheme("bathe"), ss.scene("elastic_pendulum", EA=1e4)
    lanes = 1 << 18
    v0 = np.stack([np.zeros(lanes), np.linspace(7.0, 8.0, lanes)], axis=1)
    start = np.broadcast_to(scene.u0, (lanes, 2)), v0, np.broadcast_to(scene.a0, (lanes, 2))

    def peaks() -> None:
        for _ in range(20):
            kernel[-(-P // device.THREADS), device.THREADS](there, f, out)
        cuda.synchronize()

    def pendulums() -> None:
        with device.on("cuda"):
            march_lanes(scene, bathe, np.full(lanes, 0.001), np.full(lanes, 20000), start=start)

    for name, run, steps in (
        ("spectrum, a step", peaks, 20 * P * n),
        ("pendulum, bathe, a step", pendulums, lanes * 20000),
    ):
        run()
        begin, first, done = time.perf_counter(), nvml.nvmlDeviceGetTotalEnergyConsumption(handle), 0
        while time.perf_counter() - begin < 3.0:
            run()
            done += steps
        joules, seconds = (nvml.nvmlDeviceGetTotalEnergyConsumption(handle) - first) * 1e-3, time.perf_counter() - begin
        report.add(
            f"{name}, energy", joules / done * 1e12, "pJ", f"{joules / seconds:.0f} W, {done / seconds:.3g} steps/s"
        )
