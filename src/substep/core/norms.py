"""The largest spectral norm among the powers of many small matrices."""

import math

import numpy as np

from .arrays import Array

POWERS, POINTS = 64, 128  # that are looked at together, so that what is computed from them stays in the cache
WEIGHTS = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])  # of the entries 00, 11, 22, 01, 02, 12 of a symmetric matrix


def largest_norm_of_powers(A: Array, n: int) -> Array:
    """The largest of ||A||, ||A^2||, ..., ||A^n|| (P,) in the spectral norm, for A (P, m, m); inf on overflow."""
    largest = np.zeros(len(A))
    with np.errstate(over="ignore", invalid="ignore"):
        for first in range(0, len(A), POINTS):
            part = slice(first, first + POINTS)
            largest[part] = _of_few(A[part], n)
    return largest


def _of_few(A: Array, n: int) -> Array:
    largest, power, powers = spectral_norm(A), A, np.empty((min(n, POWERS), *A.shape))
    for first in range(1, n, POWERS):
        block = powers[: n - first]
        for out in block:  # one by one: a power of a power would multiply its rounding
            power = np.matmul(power, A, out=out)
        frobenius = np.sqrt(np.einsum("kpij,kpij->kp", block, block))
        wanted = ~(frobenius <= largest)  # only there the spectral norm, which is not above it, can be larger
        norms = np.zeros(wanted.shape)
        norms[wanted] = spectral_norm(block[wanted])
        largest = np.maximum(largest, norms.max(axis=0))
        if np.isinf(largest).all():
            break
    return largest


def spectral_norm(M: Array) -> Array:
    """The largest singular value (P,) of matrices (P, m, m), to a few roundings; inf if an entry is not finite.

    For m <= 3 in closed form. With t the third of the trace of G = M^T M, B = G - t I and C the part of B^2 without
    trace, the largest eigenvalue of G is t + sqrt(2/3) |B| cos(angle/3), where the angle is that between B and C
    (O. K. Smith, Comm. ACM 4, 168, 1961, whose arccos loses half the digits where two singular values are equal). It is
    taken from the sum and the difference of the unit vectors, which keeps them (W. Kahan).
    """
    P, m, _ = M.shape
    scale = np.abs(M).max(axis=(1, 2))
    finite = np.isfinite(scale)
    scaled = M / np.where(finite & (scale > 0.0), scale, 1.0)[:, None, None]
    if m > 3:
        norms = np.zeros(P)
        norms[finite] = np.linalg.norm(scaled[finite], 2, axis=(1, 2))
        return np.where(finite, scale * norms, np.inf)
    rows = np.ascontiguousarray(scaled.transpose(1, 2, 0))
    G = np.zeros((6, P))
    for k, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
        if j < m:
            G[k] = np.einsum("kp,kp->p", rows[:, i], rows[:, j])
    third = (G[0] + G[1] + G[2]) / 3.0
    G[:3] -= third
    a, b, c, d, e, f = G
    size2 = np.maximum(WEIGHTS @ (G * G), np.finfo(float).tiny)
    size = np.sqrt(size2)
    C = np.array(
        [
            a * a + d * d + e * e, d * d + b * b + f * f, e * e + f * f + c * c,
            d * (a + b) + e * f, e * (a + c) + d * f, f * (b + c) + d * e,
        ]
    )  # fmt: skip
    np.multiply(C, math.sqrt(6.0) / size2, out=C)
    C[:3] -= math.sqrt(2.0 / 3.0)
    B = G / size
    angle = 2.0 * np.arctan2(np.sqrt(WEIGHTS @ (B - C) ** 2), np.sqrt(WEIGHTS @ (B + C) ** 2))
    largest = np.sqrt(third + math.sqrt(2.0 / 3.0) * size * np.cos(angle / 3.0))
    return np.where(finite, scale * largest, np.inf)
