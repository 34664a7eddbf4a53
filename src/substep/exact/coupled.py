"""The exact response of oscillators that damping couples, under loads that are linear between samples."""

import numpy as np

from ..core.arrays import Array


def coupled_histories(
    omega: Array, C: Array, shapes: Array, dt: float, start: Array, samples: Array, stride: int = 1
) -> Array:
    """u (rows, m) of q'' + C q' + omega^2 q = shapes g(t), every stride-th of n steps, by one matrix exponential.

    omega (m,), rad/s; C (m, m), 1/s; shapes (m, J); start: u, v (2, m); samples (n + 1, J) of g every dt (s).
    """
    from scipy import linalg  # noqa: PLC0415

    m, J = shapes.shape
    A = np.zeros((2 * m + 2 * J,) * 2)  # acts on u, dt*v, g and the increment of g within a step
    A[:m, m : 2 * m] = np.eye(m)
    A[m : 2 * m, :m], A[m : 2 * m, m : 2 * m] = np.diag(-((omega * dt) ** 2)), -dt * C
    A[m : 2 * m, 2 * m : 2 * m + J], A[2 * m : 2 * m + J, 2 * m + J :] = dt**2 * shapes, np.eye(J)
    E = linalg.expm(A)[: 2 * m].T
    by_state, by_load, by_slope = E[: 2 * m], E[2 * m : 2 * m + J], E[2 * m + J :]
    pushed = samples[:-1] @ by_load + np.diff(samples, axis=0) @ by_slope
    n = len(pushed)
    out, x = np.empty((n // stride + 1, m)), np.concatenate([start[0], dt * start[1]])
    out[0] = start[0]
    for i in range(n):
        x = x @ by_state + pushed[i]
        if (i + 1) % stride == 0:
            out[(i + 1) // stride] = x[:m]
    return out
