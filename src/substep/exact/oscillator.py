"""The exact response of oscillators to a record, linear between its samples, with which schemes are compared.

N. C. Nigam, P. C. Jennings, Calculation of response spectra from strong-motion earthquake records, Bull. Seism. Soc.
Am. 59, 909-922, 1969. Their 2x2 map comes here from the exponential of the 4x4 matrix that adds the load and its slope
to the state, so that no formula fails near critical damping or for small steps.
"""

import numpy as np

from ..core.loads import Record
from ..core.schemes import Array
from ..core.threads import spread

TERMS = 12  # of the exponential's Taylor series, for a matrix whose norm is at most 2^-3
NANOSECONDS = 0.25  # that a step of one lane takes, for the choice of threads


def increments(Omega: Array, xi: Array) -> tuple[Array, Array]:
    """D (P, 2, 2), B (P, 2, 2) of x1 = x0 + D x0 + B h^2 (f0, f1), x = (u, h*v), for Omega > 0 and xi >= 0 (P,).

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
    E[:, 0, 1:] /= Omega[:, None]
    E[:, 1:, 0] *= Omega[:, None]
    return E[:, :2, :2], np.stack([E[:, :2, 2] - E[:, :2, 3], E[:, :2, 3]], axis=2)


def exact_peaks(omega: Array, xi: Array, load: Record) -> Array:
    """Largest |u|, |v|, |2 xi omega v + omega^2 u| (3, P) at the record's samples; omega in rad/s, xi (P,); from rest.

    The last is the absolute acceleration where the load is that of a moving ground.
    """
    from substep_kernels.linear_march_2_01y import WIDTH, march_2  # noqa: PLC0415 (numba on first use)

    h, n, P = load.dt, len(load.samples) - 1, len(omega)
    D, B = increments(omega * h, xi)
    B = B * h**2
    # the force of spring and dashpot over the mass at the end of a step, force x1, is added up from x0 and the loads
    force = np.stack([omega**2, 2.0 * xi * omega / h], axis=1)[:, None]
    rows = (D, B, force + force @ D, force @ B, np.full((P, 1, 1), 1.0 / h))
    C = np.ascontiguousarray(np.concatenate([row.reshape(P, -1) for row in rows], axis=1).T)
    x, peak, samples = np.zeros((2, P)), np.zeros((3, P)), load.samples

    def part(first: int, last: int) -> None:
        march_2(
            C, x, samples[:-1], samples[1:], np.empty((2, 0, 1)), 0, n, n, np.empty((0, 3, P)), peak, first, last
        )  # fmt: skip

    spread(part, P, WIDTH, nanoseconds=P * n * NANOSECONDS)
    return peak
