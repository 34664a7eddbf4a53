"""Composites of least error for every rho_inf: what elimination finds against a search in plain numbers."""

from math import comb, factorial

import numpy as np
import pytest
from substep_derive.declare.symbols import gamma, rho_inf
from substep_design.answer import Budget, OutOfTimeError
from substep_design.design import design
from substep_design.least import Least, least_for_every_radius
from substep_design.stability_function import approximate
from sympy import GoldenRatio, Rational, sqrt

CRITERIA = ("error_constant", "period_error", "damping")
Y = np.logspace(-1.5, 3.5, 1500)


def found(n: int, criterion: str) -> tuple[Least, ...]:
    return least_for_every_radius(n, criterion, Budget(300.0))


def numerator(n: int, g: float) -> list[float]:
    """Coefficients of e^z (1 - g z)^n up to z^n."""
    return [sum((-g) ** j * comb(n, j) / factorial(k - j) for j in range(k + 1)) for k in range(n + 1)]


def size(n: int, g: float, criterion: str) -> float:
    """The coefficient of log R - z that the criterion asks for, by the power series of the logarithm."""
    series = np.zeros(n + 3)  # of R e^-z - 1
    terms = [(-1) ** k / factorial(k) for k in range(n + 3)]
    poles = [comb(n - 1 + k, k) * g**k for k in range(n + 3)]
    for i, a in enumerate(numerator(n, g)):
        for j, b in enumerate(terms):
            for k, c in enumerate(poles):
                if i + j + k < n + 3:
                    series[i + j + k] += a * b * c
    odd = (n + 1) % 2 == 1
    first = criterion == "error_constant" or (criterion == "period_error") == odd
    return abs(series[n + 1 if first else n + 2])


def best_by_numbers(n: int, radius: float, criterion: str) -> float:
    """gamma of the least error: every root of |R(oo)| = radius that is stable on a grid."""
    last = np.array([(-1) ** j * comb(n, j) / factorial(n - j) for j in range(n + 1)])  # of z^n, in powers of gamma
    stable = []
    for sign in (1, -1):
        equation = last.copy()
        equation[n] -= sign * radius * (-1) ** n
        for g in np.roots(equation[::-1]):
            if abs(g.imag) < 1e-9 and g.real > 0:
                R = np.polyval(numerator(n, g.real)[::-1], 1j * Y) / (1 - 1j * g.real * Y) ** n
                if np.abs(R).max() < 1 + 1e-9:
                    stable.append(g.real)
    return min(stable, key=lambda g: size(n, g, criterion))


@pytest.mark.matrix(4)  # each number with another criterion
@pytest.mark.parametrize("criterion", CRITERIA)
@pytest.mark.parametrize("n", [2, 3, 4])
def test_a_search_in_numbers_finds_the_same(n: int, criterion: str) -> None:
    pieces = found(n, criterion)
    ends = [float(one.high.partition("...")[0]) for one in pieces]
    assert pieces[0].low == "0"
    assert ends[-1] == 1.0
    inside = [(a + b) / 2 for a, b in zip([0.0, *ends[:-1]], ends, strict=True)]
    for radius in sorted([*np.linspace(0.013, 0.987, 9), *inside]):
        best = best_by_numbers(n, radius, criterion)
        piece = pieces[int(np.searchsorted(ends, radius))].piece
        assert float(approximate(piece.low)) < best
        assert piece.high is None or best < float(approximate(piece.high))
        assert abs(piece.equation.subs({gamma: best, rho_inf: radius})) < 1e-9


def test_two_sub_steps_are_noh_and_bathes_but_in_an_interval() -> None:
    """It ends at the root of the golden ratio's inverse, and holds the third order of gamma = (3 + sqrt(3))/6."""
    first, second, third = found(2, "error_constant")
    assert first.piece == third.piece != second.piece
    assert second.low.endswith("(root of rho_inf^8 + 35*rho_inf^6 + 300*rho_inf^4 - 79*rho_inf^2 - 32)")
    assert second.high.endswith("(root of rho_inf^4 + rho_inf^2 - 1)")
    assert float(second.high.partition("...")[0]) == pytest.approx(float(sqrt(1 / GoldenRatio)), rel=1e-11)
    radius = sqrt(3) - 1
    assert second.piece.equation.subs({gamma: (3 + sqrt(3)) / 6, rho_inf: radius}).expand() == 0
    split = 2 / (2 + sqrt(2 + 2 * rho_inf))  # of rho_inf_bathe
    assert first.piece.equation.subs(gamma, split / 2).simplify() == 0


def test_an_answer_for_every_radius_says_where_others_are_better() -> None:
    assert "but for\n  rho_inf from 0.682897757866" in design(sub_steps=2, order=2, rho_inf="free").text
    assert "damping is least on this branch.\n" in design(sub_steps=2, order=2, rho_inf="free", least="damping").text
    with pytest.raises(OutOfTimeError):
        least_for_every_radius(3, "error_constant", Budget(0.0))


def test_four_sub_steps_may_turn_to_the_sixth_power() -> None:
    """Of third order, and so with more damping: log R - z has no term of z^5 there."""
    answer = design(sub_steps=4, order=3, rho_inf="1/2", least="period_error")
    assert "gamma = 0.444988913164" in answer.text
    g, p = 0.44498891316442, Rational(1, 2)
    terms = [(-1) ** k / factorial(k) for k in range(6)]
    P = [*numerator(4, g)[:4], float(p) * g**4]
    series = np.array([sum(P[i] * terms[k - i] for i in range(min(k, 4) + 1)) for k in range(6)])
    poles = np.array([comb(3 + k, k) * g**k for k in range(6)])
    whole = np.convolve(series, poles)[:6]
    assert abs(whole[5]) < 1e-12
    assert abs(whole[4]) > 1e-3
