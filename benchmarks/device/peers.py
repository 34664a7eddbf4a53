"""The same work by CuPy's arrays and by JAX, on the same device."""

import time
from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

import substep as ss
from substep.core import device
from substep.ground_motion.peaks import at_rest
from substep.marching.digital_filter import filter_of, filter_peaks
from substep.marching.scene_lanes import march_lanes

from .table import OURS, Report, best, shaken


def _filter_of(P: int, n: int) -> tuple[np.ndarray, np.ndarray]:

    s, load = ss.scheme("average_acceleration"), shaken(n)
    o = at_rest(2.0 * np.pi / np.geomspace(0.02, 10.0, P), np.full(P, 0.05), load)
    return filter_of(s, o, n, load), load.samples


def _ours(T: np.ndarray, f: np.ndarray) -> np.ndarray:

    return filter_peaks(T, 2, f, 3)[0]


def _against_ours(report: Report, name: str, rate: float, far: float, note: str = "") -> None:
    ours = report.value(OURS)
    report.add(name, rate, "oscillator-steps/s", note)
    report.add(f"{name}: ours is faster by", ours / rate, "", f"largest difference of SD {far:.1e}")


def _by_hand(xp: Any, T: list[Any], f: Any, step: Callable[..., Any]) -> Any:
    q = e1 = t0 = t1 = t2 = xp.zeros_like(T[0])
    for value in f:
        q, e1, t0, t1, t2 = step(T, q, e1, t0, t1, t2, float(value))
    return t0 * xp.abs(T[4])


def by_cupy(report: Report) -> None:
    """The same filter in CuPy's arrays, and as a kernel of its own for each step."""
    cp: Any = import_module("cupy")

    P, n = (8, 10) if report.small else (1 << 20, 256)
    T, f = _filter_of(P, n)
    expected = _ours(T, f)
    there = [cp.asarray(row) for row in T]

    def arrays(T, q, e1, t0, t1, t2, f0):
        P0, g1, u0, u1, _, v0, v1, a0, a1, aq = T
        e0 = (g1 * e1 + f0) - P0 * q
        q = q + e0
        t0 = cp.maximum(t0, cp.abs(u1 * e1 + (u0 * e0 + q)))
        t1 = cp.maximum(t1, cp.abs(v1 * e1 + v0 * e0))
        t2 = cp.maximum(t2, cp.abs(a1 * e1 + (a0 * e0 + aq * q)))
        return q, e0, t0, t1, t2

    names = ["P0", "g1", "u0", "u1", "v0", "v1", "a0", "a1", "aq", "q", "e1", "t0", "t1", "t2"]
    kernel = cp.ElementwiseKernel(
        ", ".join(f"float64 {x}" for x in [*names, "f0"]), "float64 qn, float64 en, float64 s0, float64 s1, float64 s2",
        "double e0 = (g1*e1 + f0) - P0*q; qn = q + e0; en = e0; s0 = fmax(t0, fabs(u1*e1 + (u0*e0 + qn)));"
        "s1 = fmax(t1, fabs(v1*e1 + v0*e0)); s2 = fmax(t2, fabs(a1*e1 + (a0*e0 + aq*qn)));", "filter_step",
    )  # fmt: skip

    def fused(T, q, e1, t0, t1, t2, f0):
        return kernel(*T[:4], *T[5:], q, e1, t0, t1, t2, f0)

    for name, step in (("CuPy, arrays", arrays), ("CuPy, a kernel a step", fused)):

        def run(step=step) -> Any:
            found = _by_hand(cp, there, f[1:], step)
            cp.cuda.Device().synchronize()
            return found

        far = float(np.abs(cp.asnumpy(run()) / expected - 1.0).max())
        _against_ours(report, f"spectrum, {name}", P * n / best(run, 2), far, f"{P} oscillators, {n} steps")


def _by_jax(report: Report, kind: str, P: int, n: int) -> None:
    jax: Any = import_module("jax")
    jnp: Any = import_module("jax.numpy")

    there = jax.devices(kind)[0]
    T, f = _filter_of(P, n)
    expected = _ours(T, f)

    def one(T: Any, f: Any) -> Any:
        P0, g1, u0, u1, S, v0, v1, a0, a1, aq = T

        def step(carry: Any, f0: Any) -> Any:
            q, e1, t0, t1, t2 = carry
            e0 = (g1 * e1 + f0) - P0 * q
            q = q + e0
            t0 = jnp.maximum(t0, jnp.abs(u1 * e1 + (u0 * e0 + q)))
            t1 = jnp.maximum(t1, jnp.abs(v1 * e1 + v0 * e0))
            t2 = jnp.maximum(t2, jnp.abs(a1 * e1 + (a0 * e0 + aq * q)))
            return (q, e0, t0, t1, t2), None

        zero = jnp.zeros(())
        (_, _, t0, t1, t2), _ = jax.lax.scan(step, (zero,) * 5, f)
        return t0 * jnp.abs(S), t1, t2

    run = jax.jit(jax.vmap(one, in_axes=(1, None)))
    on = jax.device_put(T, there), jax.device_put(f[1:], there)
    begin = time.perf_counter()
    found = np.asarray(jax.block_until_ready(run(*on))[0])
    first = time.perf_counter() - begin
    rate = P * n / best(lambda: jax.block_until_ready(run(*on)), 2)
    far = float(np.abs(found / expected - 1.0).max())
    _against_ours(
        report,
        f"spectrum, JAX vmap and scan, {kind}",
        rate,
        far,
        f"{P} oscillators, {n} steps, first call {first:.1f} s",
    )


def pendulum_by_jax(report: Report) -> None:
    """Average acceleration of the flexible pendulum with Newton, by vmap, scan and while_loop, and ours beside it."""
    jax: Any = import_module("jax")
    jnp: Any = import_module("jax.numpy")

    P, n, h = (4, 5, 0.01) if report.small else (1 << 17, 250, 0.01)
    s, scene = ss.scheme("average_acceleration"), ss.scene("elastic_pendulum", EA=1e4)
    L, m, EA = (float(scene.parameters[name]) for name in ("L", "m", "EA"))
    v0 = np.zeros((P, 2))
    v0[:, 1] = np.linspace(7.0, 8.0, P)
    start = np.broadcast_to(scene.u0, (P, 2)), v0, np.broadcast_to(scene.a0, (P, 2))
    march = partial(march_lanes, scene, s, np.full(P, h), np.full(P, n), start=start)
    with device.on("cuda"), report.kernels.counted() as seconds:
        march()
        march()
        ours = march()
    rate = P * n / min(seconds)
    report.add("pendulum, average_acceleration, kernel", rate, "lane-steps/s", f"{P} lanes, {n} steps")
    k, beta, near = EA / (2.0 * L**3 * m), 0.25 * h * h, 1e-12 * L / (0.25 * h * h)

    def step(state: Any, _: Any) -> Any:
        u, v, a = state
        star = u + h * v + beta * a

        def again(carry: Any) -> Any:
            z, _, taken = carry
            x = star + beta * z
            stretch = k * (x @ x - L * L)
            residual = z + stretch * x
            jacobian = (1.0 + beta * stretch) * jnp.eye(2) + 2.0 * beta * k * jnp.outer(x, x)
            det = jacobian[0, 0] * jacobian[1, 1] - jacobian[0, 1] * jacobian[1, 0]
            change = jnp.array([
                jacobian[1, 1] * residual[0] - jacobian[0, 1] * residual[1],
                jacobian[0, 0] * residual[1] - jacobian[1, 0] * residual[0],
            ]) / det  # fmt: skip
            return z - change, jnp.abs(change).max(), taken + 1

        first = again(((u - star) / beta, jnp.inf, 0))
        z, _, _ = jax.lax.while_loop(lambda c: (c[1] > near) & (c[2] < 50), again, first)
        return (star + beta * z, v + 0.5 * h * (a + z), z), None

    run = jax.jit(jax.vmap(lambda u, v, a: jax.lax.scan(step, (u, v, a), None, length=n)[0]))
    for kind, lanes in (("gpu", P), ("cpu", P >> 4)):
        name = f"pendulum, JAX vmap, scan and while_loop, {kind}"
        try:
            there = jax.devices(kind)[0]
        except RuntimeError as error:  # where JAX has none of that kind
            report.add(name, "failed", note=str(error))
            continue
        on = [jax.device_put(np.array(x[: max(lanes, 1)]), there) for x in start]
        found = np.asarray(jax.block_until_ready(run(*on))[0])
        theirs = len(found) * n / best(lambda on=on: jax.block_until_ready(run(*on)), 2)
        far = float(np.abs(found - ours.state[: len(found), 0]).max() / L)
        report.add(
            name, theirs, "lane-steps/s", f"{len(found)} lanes, {n} steps; largest difference of u / L {far:.1e}"
        )
        report.add(f"{name}: ours is faster by", rate / theirs)


def by_jax_on_the_device(report: Report) -> None:
    """The same filter in JAX, with 64 bits."""
    _by_jax(report, "gpu", *((8, 10) if report.small else (1 << 20, 2048)))


def by_jax_on_the_CPU(report: Report) -> None:
    """The same on the CPU."""
    _by_jax(report, "cpu", *((8, 10) if report.small else (1 << 14, 1024)))
