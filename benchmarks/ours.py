"""The calls of substep that the jobs time: the only file to change when its interface does."""

from collections.abc import Callable
from contextlib import nullcontext
from functools import cache
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

import substep as ss
from substep.core.errors import real_array
from substep.core.kernel_modules import printed
from substep.core.scene_catalogue import checked_parameters, scene_info
from substep.core.scenes import make_scene
from substep.exact.oscillator import exact_peaks
from substep.ground_motion import yielding
from substep.ground_motion.yielding import Yielding
from substep.marching import linear
from substep.marching.linear import march_linear
from substep.marching.oscillators import Oscillators
from substep.marching.scene_lanes import Lanes, march_lanes, pair_kernels
from substep.structures.march import fixed_steps

from .linear import scheme

Array = NDArray[np.float64]


def handle(name: str, parameters: tuple[Array, ...]) -> Any:
    """A handle whose parameters are arrays, in the order of the scheme's own."""
    own = scheme(name)
    return ss.scheme(name, **dict(zip(own.parameters, parameters, strict=True))) if parameters else own


def radius(s: Any, Omega: Array, xi: Array) -> Array:
    """Spectral radius."""
    return s.spectral_radius(Omega, xi)


def stability(s: Any, Omega: Array, xi: Array) -> tuple[Array, Array, Array]:
    """Spectral radius, numerical damping, period error."""
    return s.stability(Omega, xi)


def spectrum_peaks(name: str, omegas: Array, xi: float, load: ss.Record) -> Array:
    """Peak |u| of each oscillator under the record (n + 1,), from rest."""
    return march_linear(scheme(name), at_rest(omegas, xi, load), len(load.samples) - 1, load, keep="peak_u").peak[0]


def spectrum(name: str, omegas: Array, xi: float, record: Array, dt: float, errors: bool = False) -> Array:
    """SD, SV, SA (3, lanes)."""
    found = ss.response_spectrum(record, dt, 2 * np.pi / omegas, xi, scheme(name), errors=errors)
    return np.stack([found[quantity].values for quantity in ("displacement", "velocity", "acceleration")])


def three_peaks(name: str, omegas: Array, xi: float, load: ss.Record) -> Array:
    """Peaks (3, lanes) of u, v and the absolute acceleration under the record, from rest: the march in `spectrum`."""
    lanes = march_linear(
        scheme(name), at_rest(omegas, xi, load), len(load.samples) - 1, load, keep="peak_absolute"
    )  # fmt: skip
    return lanes.peak


def exact_spectrum(omegas: Array, xi: float, record: Array, dt: float) -> Array:
    """SD, SV, SA (3, lanes) of the exact response, from which errors are reported."""
    return exact_peaks(omegas, np.full(len(omegas), xi), ss.Record(dt, record))


def history(name: str, omegas: Array, xi: float, load: ss.Record, out: Array | None = None) -> Array:
    """u, v, a (n + 1, 3, lanes), into out if given."""
    return march_linear(scheme(name), at_rest(omegas, xi, load), len(load.samples) - 1, load, out=out).out


def at_rest(omegas: Array, xi: float, load: ss.Record) -> Oscillators:
    """One oscillator a lane, stepping as the record does."""
    start = np.zeros((3, len(omegas)))
    start[2] = load.samples[0]
    xis, masses, dt = (np.full(len(omegas), x) for x in (xi, 1.0, load.dt))
    return Oscillators(omegas, xis, masses, dt, start)


def oscillator(omega: float, xi: float, load: ss.Record | None, u0: float = 0.0) -> ss.Scene:
    """One oscillator, from u0 at rest."""
    return ss.scene("linear_oscillator", omega=omega, xi=xi, u0=u0, v0=0.0, load=load)


def scene_of_lanes(name: str, **parameters: Array) -> ss.Scene:
    """A scene whose parameters are arrays, one value a lane, as a sweep makes it."""
    info = scene_info(name, {})
    return make_scene(info, checked_parameters(info, parameters, real_array), a0=None, load=None)


def _bilinear(omegas: Array, xi: float, strengths: Array, hardening: float, load: ss.Record) -> ss.Scene:
    same = np.ones(len(omegas))
    given = {"omega": omegas, "xi": xi * same, "strength": strengths, "hardening": hardening * same}
    info = scene_info("hysteretic_oscillator", {})
    return make_scene(info, checked_parameters(info, given, real_array), a0=None, load=load)


def bilinear(omegas: Array, xi: float, strengths: Array, hardening: float, load: ss.Record) -> Lanes:
    """Oscillators with a bilinear spring, from rest, by average acceleration: their last state and their energy."""
    P, n = len(omegas), len(load.samples) - 1
    scene = _bilinear(omegas, xi, strengths, hardening, load)
    return march_lanes(scene, scheme("average_acceleration"), np.full(P, load.dt), np.full(P, n))


def bilinear_kernel(
    omegas: Array, xi: float, strengths: Array, hardening: float, load: ss.Record
) -> Callable[[], Array]:
    """The same under a load that starts at 0, prepared once: a call runs the kernel alone and gives the last u."""
    P, n, scene = len(omegas), len(load.samples) - 1, _bilinear(omegas, xi, strengths, hardening, load)
    module = pair_kernels(scene, scheme("average_acceleration"))
    rows = len(module.STATE) + len(scene.info.memory)
    arrays = {
        **{name: np.broadcast_to(x, P).astype(float) for name, x in printed(scene.parameters).items()},
        **{"h": np.full(P, load.dt), "bound": np.full(P, np.inf), "n": np.full(P, n), "first": 0, "stride": 1},
        "extremes": np.empty((P, 0)),
        **{"state": np.zeros((P, rows, 1)), "out": np.zeros((P, 0, rows, 1)), "forces": load.samples[None, 1:, None]},
        **{"peak": np.empty(P), "n_done": np.empty(P, np.int64), "status": np.empty(P, np.int64)},
    }
    given = [arrays[name] for name in module.ARGUMENTS]

    def march() -> Array:
        arrays["state"][:] = 0.0
        module.march_block(*given)
        return arrays["state"][:, 0, 0]

    return march


def building(
    stories: list[tuple[float, float, float, float]],
    hardening: float,
    record: Array,
    dt: float,
    *,
    singly: bool = False,
) -> Callable[[int], Any]:
    """A shear building of bilinear stories, each mass, stiffness, strength and dashpot: a march of so many steps.

    singly: step by step, as structures are marched that no kernel takes.
    """
    s = _shear_building(stories, hardening).ground_motion(ss.Record(dt, record), 1.0)

    def march(steps: int, account: bool = False) -> Any:
        with patch.object(fixed_steps.CompiledSteps, "of", lambda *_: None) if singly else nullcontext():
            return ss.march(s, "average_acceleration", dt, steps * dt, account=account, progress=False)

    return march


def buildings(
    stories: list[tuple[float, float, float, float]], hardening: float, record: Array, dt: float, strengths: Array
) -> Callable[[int], Any]:
    """Such buildings with these factors of strength: peaks of so many steps."""
    every = [_shear_building([(m, k, x * q, c) for m, k, q, c in stories], hardening) for x in strengths]
    options: dict[str, Any] = {"ground": [ss.Record(dt, record)], "direction": 1.0, "keep": "peak", "progress": False}
    return lambda steps: ss.sweep(every, "average_acceleration", dt=dt, t_end=steps * dt, **options)


def _shear_building(stories: list[tuple[float, float, float, float]], hardening: float) -> ss.Structure:
    masses, k, q_y, c = np.array(stories).T
    drifts = np.eye(len(masses)) - np.eye(len(masses), k=-1)
    law = ss.law("bilinear", k=k, q_y=q_y, alpha=hardening)
    return ss.shear_building(masses, law, damping=drifts.T @ np.diag(c) @ drifts)


def yielding_peaks(omegas: Array, xi: float, strengths: Array, hardening: float, load: ss.Record) -> Array:
    """Peak |u| (lanes,) of the same: what a spectrum of constant ductility marches to find its strengths."""
    ground = ss.Record(load.dt, -load.samples)
    of = Yielding(omegas, np.full(len(omegas), xi), strengths, hardening, "bilinear")
    return yielding.peaks(scheme("average_acceleration"), of, ground)


def single_run(name: str, scene: ss.Scene, dt: float, n: int) -> tuple[Array, Array, Array]:
    """u, v, a (n + 1,) of one oscillator."""
    r = ss.march(scene, scheme(name), dt, n * dt)
    return r.u[:, 0], r.v[:, 0], r.a[:, 0]


def single_lane(name: str, omega: float, xi: float, load: ss.Record, out: Array) -> Array:
    """u (n + 1,) of one oscillator from rest; out (n + 1, 3, 1) takes u, v, a, in the layout of the kernels in C."""
    lanes = at_rest(np.array([omega]), xi, load)
    return march_linear(scheme(name), lanes, len(out) - 1, load, out=out).out[:, 0, 0]


def single_kernel(name: str, omega: float, xi: float, load: ss.Record, out: Array) -> Callable[[], Array]:
    """The same as `single_lane`, with what the call prepares done once beforehand: a call runs the kernel alone."""
    n = len(out) - 1
    run = linear.prepared(scheme(name), at_rest(np.array([omega]), xi, load), n, load)
    (given, start, _), loads = (x[:, 0].copy() for x in run.of(slice(0, 1))), run.loads.of_all(0, n)

    def march() -> Array:
        run.march_one(given, start.copy(), *loads, out[1:, :, 0])
        return out[:, 0, 0]

    return march


@cache
def _pendulum(name: str, EA: float, a0: tuple[float, float]) -> tuple[Any, Any]:
    """Handles of scene and scheme, made once, so that their set-up is not timed, as that of the C kernels is not."""
    return ss.scene("elastic_pendulum", EA=EA, a0=a0), scheme(name)


def pendulum_steps(name: str, EA: float, a0: tuple[float, float], v0: Array, h: float, n: int) -> int:
    """How many of n steps all lanes of `pendulum_batch` complete."""
    return int(_pendulums(name, EA, a0, v0, h, n).n_done.min())


def pendulum_batch(name: str, EA: float, a0: tuple[float, float], v0: Array, h: float, n: int) -> tuple[Array, Array]:
    """Last u (lanes, 2) and largest energy (lanes,) of elastic pendulums, one start velocity a lane."""
    found = _pendulums(name, EA, a0, v0, h, n)
    return found.state[:, 0], found.peak


def pendulums(own: Any, scene: ss.Scene, v0: Array, h: float, n: int) -> Callable[[], Lanes]:
    """A call that marches the scene's pendulum of two coordinates from each start velocity across the rod."""
    lanes = len(v0)
    u, v, a = (np.repeat(x[None], lanes, axis=0) for x in (scene.u0, scene.v0, scene.a0))
    v[:, 1] = v0
    return lambda: march_lanes(scene, own, np.full(lanes, h), np.full(lanes, n), start=(u, v, a))


def _pendulums(name: str, EA: float, a0: tuple[float, float], v0: Array, h: float, n: int) -> Lanes:
    scene, own = _pendulum(name, EA, a0)
    return pendulums(own, scene, v0, h, n)()
