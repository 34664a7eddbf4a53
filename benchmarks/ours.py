"""substep as the jobs call it: the only file to change when its interface does."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

import substep as ss
from substep.lanes import march_lanes

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


def spectrum_peaks(name: str, omegas: Array, xi: float, record: Array, dt: float) -> Array:
    """Peak |u| of each oscillator under the record (n + 1,), from rest."""
    return np.abs(_lanes(name, omegas, xi, record, dt)[:, :, 0]).max(axis=1)


def history(name: str, omegas: Array, xi: float, record: Array, dt: float, out: Array | None = None) -> Array:
    """u, h*v, h^2*a (lanes, n + 1, 3); into out (n + 1, 3, lanes) where substep takes it, which today it does not."""
    return _lanes(name, omegas, xi, record, dt)


def _lanes(name: str, omegas: Array, xi: float, record: Array, dt: float) -> Array:
    """(lanes, n + 1, 3) of u, h*v, h^2*a. The kernel takes lanes already; nothing public hands it more than one."""
    from substep_kernels.linear_march import linear_march  # noqa: PLC0415 (numba on first use)

    s, lanes, n = scheme(name), len(omegas), len(record) - 1
    increment, load, outputs, outputs_load = s.coefficients(omegas * dt, np.full(lanes, xi))
    stencil = s.stencil().reshape(-1)
    forces = dt**2 * (record[:-1, None] * (1.0 - stencil) + record[1:, None] * stencil)
    out = np.zeros((lanes, n + 1, 3))
    out[:, 0, 2] = dt**2 * record[0]
    done, status = np.empty(lanes, dtype=np.int64), np.empty(lanes, dtype=np.int64)
    places = np.array(s.kernels.OUTPUTS_IN_STATE)
    linear_march(
        increment, load, outputs, outputs_load, places, out[:, 0].copy(), forces[None], 1, out, done, status
    )  # fmt: skip
    return out


def single_run(
    name: str, omega: float, xi: float, dt: float, n: int, record: Array | None = None, u0: float = 0.0
) -> tuple[Array, Array, Array]:
    """u, v, a (n + 1,) of one oscillator, from u0 at rest."""
    load = None if record is None else ss.Record(dt, record)
    r = ss.march(ss.scene("linear_oscillator", omega=omega, xi=xi, u0=u0, v0=0.0, load=load), scheme(name), dt, n * dt)
    return r.u[:, 0], r.v[:, 0], r.a[:, 0]


def pendulum_batch(name: str, EA: float, a0: tuple[float, float], v0: Array, h: float, n: int) -> tuple[Array, Array]:
    """Last u (lanes, 2) and largest energy (lanes,) of elastic pendulums, one start velocity a lane."""
    scene = ss.scene("elastic_pendulum", EA=EA, a0=a0)
    lanes = len(v0)
    u, v, a = (np.repeat(x[None], lanes, axis=0) for x in (scene.u0, scene.v0, scene.a0))
    v[:, 1] = v0
    found = march_lanes(scene, scheme(name), np.full(lanes, h), np.full(lanes, n), start=(u, v, a))
    return found.state[:, 0], found.peak
