"""Marches and eigenvalues of the schemes in far more digits than a double holds."""

from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
from mpmath import mp
from numpy.typing import NDArray
from substep_derive import derive
from substep_derive.oscillator.spectrum import live
from sympy import Rational

from .linear import scheme

Array = NDArray[np.float64]
BITS = 300  # of the fixed point: 90 digits after the point


def _rational(number: float) -> Rational:
    exact = Fraction(float(number))
    return Rational(exact.numerator, exact.denominator)


@cache
def _derivation(name: str) -> Any:
    return derive(name)


def _values(name: str, Omega: float, xi: float, parameters: tuple[float, ...] = ()) -> dict[Any, Rational]:
    symbols, own = _derivation(name).symbols, scheme(name).parameters
    given = {"Omega": Omega, "xi": xi, **dict(zip(own, parameters or map(float, own.values()), strict=True))}
    return {symbol: _rational(given[key]) for key, symbol in symbols.items()}


def _doubled(number: int) -> int:
    """The double nearest to a number, both in fixed point."""
    return int(Fraction(number / (1 << BITS)) * (1 << BITS))


def march(
    name: str, Omega: float, xi: float, forces: Array | None, n: int, u0: float = 0.0, *, rounded: bool = False
) -> Array:
    """u (n + 1,) of the scheme, without rounding, from u0 at rest with the consistent acceleration.

    forces: h^2 f at the steps' ends (n + 1,), linear between them, or None. rounded: only A - I is rounded to doubles,
    which no march in doubles can avoid. State (u, hv, h^2 a).
    """
    derivation, values = _derivation(name), _values(name, Omega, xi)
    one = 1 << BITS

    def fixed(number: Any) -> int:
        return int(number.p) * one // int(number.q)

    A = [[fixed(derivation.A[i, j].subs(values)) for j in range(3)] for i in range(3)]
    if rounded:
        A = [[(i == j) * one + _doubled(A[i][j] - (i == j) * one) for j in range(3)] for i in range(3)]
    x = [fixed(_rational(u0)), 0, fixed(-(values[derivation.symbols["Omega"]] ** 2) * _rational(u0))]
    B = [[0, 0] for _ in range(3)]
    f = [0] * (n + 1)
    if forces is not None:
        f = [fixed(_rational(sample)) for sample in forces]
        x[2] += f[0]
        for i in range(3):
            load = [(derivation.load[i, k].subs(values), tau.subs(values)) for k, tau in enumerate(derivation.stencil)]
            B[i] = [fixed(sum(b * (1 - tau) for b, tau in load)), fixed(sum(b * tau for b, tau in load))]
    out = [x[0]]
    (a, b, c), (d, e, g), (p, q, r) = A
    (k0, k1), (l0, l1), (m0, m1) = B
    x0, x1, x2 = x
    for i in range(n):
        f0, f1 = f[i], f[i + 1]
        x0, x1, x2 = (
            (a * x0 + b * x1 + c * x2 + k0 * f0 + k1 * f1) >> BITS,
            (d * x0 + e * x1 + g * x2 + l0 * f0 + l1 * f1) >> BITS,
            (p * x0 + q * x1 + r * x2 + m0 * f0 + m1 * f1) >> BITS,
        )
        out.append(x0)
    return np.array([value / one for value in out])


def spectrum(name: str, Omega: float, xi: float, *parameters: float) -> tuple[float, float, float]:
    """Spectral radius, numerical damping, period error to 50 digits, then rounded; without parameters: at the usual."""
    derivation, values = _derivation(name), _values(name, Omega, xi, parameters)
    with mp.workdps(80):
        coefficients = [c.subs(values) for c in live(derivation.charpoly).all_coeffs()]
        roots = mp.polyroots([mp.mpf(int(c.p)) / int(c.q) for c in coefficients], maxsteps=500, extraprec=400)
        radius = max(abs(root) for root in roots)
        pairs = [root for root in roots if root.imag > mp.mpf(10) ** -60]
        if not pairs:
            return float(radius), np.nan, np.nan
        pair = max(pairs, key=abs)
        damped = mp.sqrt(1 - mp.mpf(xi) ** 2)
        angle = mp.arg(pair)
        return float(radius), float(-mp.log(abs(pair)) / angle - xi / damped), float(Omega * damped / angle - 1)
