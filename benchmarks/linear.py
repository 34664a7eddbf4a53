"""The linear oscillator under a record: coefficients that every alternative shares, and the exact response."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from mpmath import mp
from numpy.typing import NDArray

import substep as ss

Array = NDArray[np.float64]

SCHEMES: dict[str, dict[str, float]] = {
    "newmark_bdf2": {"gamma_t": 0.2, "beta": 0.3025, "gamma": 0.6},
    "bathe": {},
    "newmark": {"beta": 0.25, "gamma": 0.5},
    "generalized_alpha": {"rho_inf": 0.8},
}


@cache
def scheme(name: str) -> Any:
    """The handle of a scheme, with its parameters in SCHEMES if it is named there."""
    return ss.scheme(name, **SCHEMES.get(name, {}))


@cache
def record(n: int, dt: float = 0.01) -> Array:
    """A synthetic ground motion of n + 1 samples in m/s^2, a sum of 40 frequencies that is 0 at both ends."""
    t = dt * np.arange(n + 1)
    frequencies = np.geomspace(0.2, 12.0, 40)
    phases = np.random.default_rng(1940).uniform(0, 2 * np.pi, 40)
    waves = np.sin(2 * np.pi * frequencies * t[:, None] + phases) / np.sqrt(frequencies)
    samples = np.sin(np.pi * t / t[-1]) ** 2 * waves.sum(axis=1)
    samples[[0, -1]] = 0.0
    samples.flags.writeable = False
    return samples


@dataclass(frozen=True)
class TwoLoads:
    """x1 = x0 + D x0 + B0 h^2 f_n + B1 h^2 f_n+1 for a load linear between steps; D (m, m, lanes), B (m, lanes).

    x is (u, hv) where the balance at the step's end gives the acceleration, else (u, hv, h^2 a).
    """

    D: Array
    B0: Array
    B1: Array

    @classmethod
    def of(cls, handle: Any, Omega: Array, xi: float) -> "TwoLoads":
        """From the coefficients of the scheme's handle, in which differences are cancelled symbolically."""
        increment, load, _, _ = handle.coefficients(Omega, np.full(Omega.shape, xi))
        D, B = increment.transpose(1, 2, 0), load.transpose(1, 2, 0)
        stencil = handle.stencil().reshape(-1)
        B0, B1 = (B * (1.0 - stencil)[:, None]).sum(axis=1), (B * stencil[:, None]).sum(axis=1)
        return cls(*(np.ascontiguousarray(x) for x in (D, B0, B1)))

    def companion(self) -> Array:
        """det, P = det(I - A), c1, c0, S (5, lanes) of the companion form in spectrum.c, for x = (u, hv)."""
        (D00, D01), (D10, D11) = self.D
        P = D00 * D11 - D01 * D10
        det = 1.0 + D00 + D11 + P
        total = self.B0 + self.B1
        S = D01 * total[1] - D11 * total[0]
        b2, b0 = self.B1[0], D01 * self.B0[1] - (1.0 + D11) * self.B0[0]
        return np.stack([det, P, b2 / S - 1.0, -b0 / S, S])

    def filter(self) -> tuple[Array, Array]:
        """Numerator and denominator (lanes, 3) of u as a digital filter of h^2 f."""
        det, P, c1, c0, S = self.companion()
        b0 = -c0 * S
        b2 = (c1 + 1.0) * S
        return np.stack([b2, S - b2 - b0, b0], axis=1), np.stack([np.ones_like(det), P - 1.0 - det, det], axis=1)


@cache
def exact_peaks(omegas: tuple[float, ...], xi: float, n: int, dt: float) -> Array:
    """Peak |u|, |v|, |2 xi omega v + omega^2 u| (3, P) at the samples, exact, from rest.

    The load is `record(n, dt)`, linear between its samples.
    """
    f, coefficients, rates = record(n, dt), [], []
    with mp.workdps(30):
        for omega in omegas:
            w = mp.mpc(-xi * omega, mp.sqrt(1 - mp.mpf(xi) ** 2) * omega)
            one = (mp.expm1(w * dt)) / (w * dt)
            two = (one - 1) / (w * dt)
            coefficients.append([complex(c) for c in (mp.exp(w * dt), dt * (one - two), dt * two, 1 / w.imag)])
            rates.append([1.0, complex(w), complex(2 * xi * omega * w + omega**2)])  # u, v, absolute acceleration
    (growth, now, then, scale), rate = np.array(coefficients).T, np.array(rates).T
    z, peak = np.zeros(len(omegas), dtype=complex), np.zeros((3, len(omegas)))
    for i in range(n):
        z = growth * z + now * f[i] + then * f[i + 1]
        np.maximum(peak, np.abs((rate * z).imag), out=peak)
    return peak * scale.real
