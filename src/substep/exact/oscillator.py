"""The exact response of oscillators to a record, linear between its samples, with which schemes are compared.

N. C. Nigam, P. C. Jennings, Calculation of response spectra from strong-motion earthquake records, Bull. Seism. Soc.
Am. 59, 909-922, 1969. Their 2x2 map comes here from the exponential of the 4x4 matrix that adds the load and its slope
to the state, so that no formula fails near critical damping or for small steps.
"""

import numpy as np

from ..core import device, single
from ..core.arrays import read_only
from ..core.loads import Record
from ..core.schemes import Array
from ..core.threads import spread

TERMS = 12  # of the exponential's Taylor series, for a matrix whose norm is at most 2^-3
NANOSECONDS = 0.25  # that a step of one lane takes, for the choice of threads


def increments(Omega: Array, xi: Array) -> tuple[Array, Array]:
    """D (P, 2, 2), B (P, 2, 2) of x1 = x0 + D x0 + B h^2 (f0, f1), x = (u, h*v), for Omega >= 0 and xi >= 0 (P,).

    Each entry has a relative error of 1e-15 (1 + (1 + xi) Omega), of its amplitude where it oscillates with Omega: the
    rounding of Omega alone causes as much.
    """
    M = np.zeros((len(Omega), 4, 4))  # acts on Omega u, h*v, h^2 f and the increment of h^2 f within the step
    M[:, 0, 1], M[:, 1, 0], M[:, 1, 1] = Omega, -Omega, -2.0 * xi * Omega
    M[:, 1, 2] = M[:, 2, 3] = 1.0
    norm = float(np.abs(M).sum(axis=2).max(initial=1.0))
    halvings = int(np.ceil(np.log2(norm))) + 3
    M *= 0.5**halvings
    E = term = M
    for k in range(2, TERMS + 1):
        term = term @ M / k
        E = E + term
    for _ in range(halvings):  # squares the exponential as 1 + E, since E keeps the digits of small steps
        E = 2.0 * E + E @ E
    free = Omega == 0.0
    E[:, 0, 1:] /= np.where(free, 1.0, Omega)[:, None]
    E[:, 1:, 0] *= Omega[:, None]
    E[free, :2] = [[0.0, 1.0, 0.5, 1.0 / 6.0], [0.0, 0.0, 1.0, 0.5]]  # the limit, where xi Omega tends to 0 too
    return E[:, :2, :2], np.stack([E[:, :2, 2] - E[:, :2, 3], E[:, :2, 3]], axis=2)


def exact_peaks(omega: Array, xi: Array, load: Record) -> Array:
    """Largest |u|, |v|, |2 xi omega v + omega^2 u| (3, P) at the record's samples; omega in rad/s, xi (P,); from rest.

    The last is the absolute acceleration where the load is that of a moving ground.
    """
    peak = np.zeros((3, len(omega)))
    if len(omega):
        _march(omega, xi, load.dt, np.zeros((2, len(omega))), load.samples, len(load.samples) - 1, None, peak)
    return peak


def exact_histories(omega: Array, xi: Array, dt: float, start: Array, samples: Array, stride: int = 1) -> Array:
    """u, v, 2 xi omega v + omega^2 u (rows, 3, P) of every stride-th of n steps under a load, linear within each.

    omega in rad/s, 0 for a body that is free and not damped, xi (P,); start: u, v (2, P); samples (n + 1,) of the load
    every dt (s), over the mass.
    """
    n = len(samples) - 1
    out = np.empty((n // stride + 1, 3, len(omega)))
    out[0] = *start, 2.0 * xi * omega * start[1] + omega**2 * start[0]
    x = np.array([start[0], dt * start[1]])
    _march(omega, xi, dt, x, np.ascontiguousarray(samples), stride, out, np.zeros((3, 0)))
    return out


def _march(
    omega: Array, xi: Array, h: float, x: Array, samples: Array, stride: int, out: Array | None, peak: Array
) -> None:
    """March x (2, P), u and h*v, through the samples; rows go into `out`, the largest values into `peak`."""
    from substep_kernels.marches.linear_march_2_01y import WIDTH, march_2  # noqa: PLC0415 (numba on first use)

    n, P = len(samples) - 1, len(omega)
    D, B = increments(omega * h, xi)
    B = B * h**2
    # the force of spring and dashpot over the mass at the end of a step, force x1, is added up from x0 and the loads
    force = np.stack([omega**2, 2.0 * xi * omega / h], axis=1)[:, None]
    rows = (D, B, force + force @ D, force @ B, np.full((P, 1, 1), 1.0 / h))
    C = np.ascontiguousarray(np.concatenate([row.reshape(P, -1) for row in rows], axis=1).T)
    nothing, to, f = np.empty((2, 0, 1)), np.empty((0, 3, P)) if out is None else out, read_only(samples)

    def part(first: int, last: int) -> None:
        own, state = (np.ascontiguousarray(some[:, first:last]) for some in (C, x))
        at_rest = np.zeros((3, last - first))
        march(own, state, at_rest, f[:-1], f[1:], nothing, 0, n, stride, to, *peak, first)

    with single.on("float64"):
        march = device.march_of_shape("linear_march_2_01y", 2) if device.is_on() else march_2
        spread(part, P, WIDTH, nanoseconds=0.0 if device.is_on() else P * n * NANOSECONDS)
