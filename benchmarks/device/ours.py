"""What substep does on a device, beside what it does on the CPU of the same machine."""

import platform
import time
from functools import partial
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

from .table import OURS, RATE, Report, best, operations, shaken, threads_of_a_block


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
    def copies(x, y):
        j = cuda.grid(1)
        if j < x.size:
            y[j] = 1.5 * x[j]

    P = 64 if report.small else 1 << 26
    Omega = np.geomspace(1e-2, 1e3, P)
    x, y = cuda.to_device(Omega), cuda.device_array(P)

    def copy() -> None:
        copies[-(-P // 256), 256](x, y)
        cuda.synchronize()

    bandwidth = 16.0 * P / best(copy, 3)
    report.add("copy on the device", bandwidth / 1e9, "GB/s", f"{P} doubles")
    few = slice(None, None, max(P >> 18, 1))
    for name in ("newmark", "bathe", "generalized_alpha"):
        s = ss.scheme(name)
        begin = time.perf_counter()
        found = s.spectral_radius(x, 0.02).copy_to_host()[few]
        first = time.perf_counter() - begin

        def run(s=s) -> None:
            s.spectral_radius(x, 0.02)
            cuda.synchronize()

        seconds, expected = best(run, 3), s.spectral_radius(Omega[few], 0.02)
        with at_most(1):
            one = best(lambda s=s: s.spectral_radius(Omega[few], 0.02), 3) / Omega[few].size
        report.add(f"spectral radius, {name}", P / seconds, "points/s", f"{P} points, first call {first:.2f} s")
        report.add(f"spectral radius, {name} / one CPU core", one * P / seconds, "", "a range of Omega, in order")
        report.add(f"spectral radius, {name} / copy on the device", 16.0 * P / seconds / bandwidth)
        far = float(np.abs(found / expected - 1.0).max())
        report.add(f"spectral radius, {name}, largest relative difference from the CPU", far)
