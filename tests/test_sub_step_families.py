"""Families of composites that papers give, among the functions of docs/findings.md: MSSTH(n), and s = 5, 6."""

from fractions import Fraction
from math import comb, factorial

import numpy as np
import pytest
from substep_derive import derive
from substep_derive.declare.tableau import tableau

import substep as ss


def mssth_weights(n: int, g: Fraction) -> list[Fraction]:
    """Zhang, Zhang, Xing & Masarati, Nonlinear Dyn. 102 (2020): after trapezoids of length g, these weights."""
    if n == 3:
        return [
            -(6 * g**3 - 21 * g**2 + 12 * g - 2) / (12 * g**2),
            -(6 * g**2 - 9 * g + 2) / (6 * g**2),
            (3 * g**2 - 6 * g + 2) / (12 * g**2),
            g / 2,
        ]
    return [
        -(12 * g**4 - 45 * g**3 + 33 * g**2 - 10 * g + 1) / (24 * g**3),
        -(33 * g**3 - 63 * g**2 + 26 * g - 3) / (24 * g**3),
        (15 * g**3 - 39 * g**2 + 22 * g - 3) / (24 * g**3),
        -(3 * g**3 - 9 * g**2 + 6 * g - 1) / (24 * g**3),
        g / 2,
    ]


@pytest.mark.parametrize(
    ("n", "g", "same", "order"),
    [(3, Fraction(7, 9), "three_substep_third_order", 3), (4, Fraction(9, 10), "four_substep", 3)],
)
def test_mssth_has_the_spectrum_of_ours_and_four_sub_steps_lose_an_order(
    n: int, g: Fraction, same: str, order: int
) -> None:
    b = mssth_weights(n, g)
    A = [[0], *([g / 2, *[g] * (k - 1), g / 2] for k in range(1, n)), b]
    d = derive(tableau("mssth", A=A, b=b, c=[*(k * g for k in range(n)), 1]))
    assert d.nonlinear is not None
    assert (d.nonlinear.eigenvalue, d.nonlinear.free, d.nonlinear.forced) == (n, (order,) * 3, (order,) * 3)
    ours = ss.scheme(same, gamma=float(g / 2))
    assert ours.order is not None
    assert ours.order[:2] == (n, n)
    for Omega, xi in ((0.4, 0.0), (3.0, 0.1), (40.0, 0.0)):
        wanted = np.sort_complex(np.linalg.eigvals(ours.amplification(Omega, xi)))
        A_mssth = np.array(d.A.subs({d.symbols["Omega"]: Omega, d.symbols["xi"]: xi}).tolist(), dtype=float)
        assert np.allclose(wanted, np.sort_complex(np.linalg.eigvals(A_mssth)), atol=1e-10), (Omega, xi)


@pytest.mark.parametrize("radius", [0.0, 0.3, 0.8, 1.0])
@pytest.mark.parametrize(
    ("s", "equation", "low", "high"),
    [
        (5, lambda r: [120 * (1 + r), -600, 600, -200, 25, -1], 0.2465, 0.2781),
        (6, lambda r: [720 * (1 + r), -4320, 5400, -2400, 450, -36, 1], 0.2840, 0.3342),
    ],
)
def test_five_and_six_sub_steps_have_their_order_at_every_radius(s, equation, low, high, radius) -> None:
    (g,) = (x.real for x in np.roots(equation(radius)) if abs(x.imag) < 1e-9 and low < x.real < high)
    P = [sum((-g) ** j * comb(s, j) / factorial(k - j) for j in range(k + 1)) for k in range(s + 1)]  # of order s
    assert P[s] / (-g) ** s == pytest.approx(-radius, abs=1e-9)
    y = np.logspace(-1.5, 3.5, 3000)
    assert np.abs(np.polyval(P[::-1], 1j * y) / (1 - 1j * g * y) ** s).max() < 1 + 1e-9
