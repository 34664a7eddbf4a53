"""The numerical eigenvalue next to the exact one, as a power series in Omega.

With s = h*(exact eigenvalue), s^2 + 2*xi*Omega*s + Omega^2 = 0, the numerical eigenvalue next to e^s is e^(s + L).
"""

from collections.abc import Callable, Sequence
from math import comb, factorial
from typing import Any

from sympy import QQ

from ..algebra.power_series import Modal, PowerSeries, total
from ..declare.errors import InconsistentScheme


def exponential(exponent: Modal, one: Any, terms: int) -> PowerSeries:
    """The series of exp(exponent*Omega); one: the 1 of the ring that its coefficients are from."""
    powers = [Modal(one, 0 * one, exponent.xi)]
    for _ in range(terms - 1):
        powers.append(powers[-1] * exponent)
    return PowerSeries(power * QQ(1, factorial(k)) for k, power in enumerate(powers))


def logarithm(
    scheme: str, p: Sequence[PowerSeries], damping: Any, one: Any, inverse_of: Callable[[Modal], Modal]
) -> PowerSeries:
    """The series L; p: the coefficients of the characteristic polynomial in lambda, from the lowest power.

    L is one coefficient shorter than those of p. inverse_of: gives the reciprocal of a number that is not 0.
    Raises InconsistentScheme if no eigenvalue tends to the exact one.
    """
    terms, zero = len(p[0]), 0 * one
    # p(e^s (1 + delta)) = sum_i F[i] delta^i = 0 gives delta, which starts with Omega^2 or later
    parts = [c * exponential(Modal(zero, one * j, damping), one, terms) for j, c in enumerate(p)]
    F = [total([part.scaled(QQ(comb(j, i))) for j, part in enumerate(parts) if j >= i]) for i in range(len(parts))]
    if F[0].valuation < 3 or F[1].valuation != 1:
        raise InconsistentScheme(f"{scheme} is not consistent: no eigenvalue tends to the exact one")
    inverse = inverse_of(F[1].c[1])
    delta = F[0].over(F[1], inverse).scaled(QQ(-1))
    for _ in range(len(delta) - 3):  # F[0]/F[1] starts with Omega^2; each pass gains a power
        known = PowerSeries([*delta.c, Modal(zero, zero, damping)])  # the unknown last coefficient is not in its square
        power, correction = known, F[0]
        for higher in F[2:]:
            power = power * known
            correction = correction + higher * power
        delta = correction.over(F[1], inverse).scaled(QQ(-1))
    found, power, k = delta, delta, 1
    while power.valuation < len(power):
        power, k = power * delta, k + 1
        found = found + power.scaled(QQ((-1) ** (k + 1), k))
    return found
