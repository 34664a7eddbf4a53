"""Exact periods against integration of the equation of motion to a quarter period, Gauss's mean and known limits."""

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import substep as ss
from substep.exact.periods import period
from substep.studies.failures.table import CASES

SWINGING = {
    "duffing": lambda u: -100.0 * u * (1 + 10 * u**2),
    "softening": lambda u: -100.0 * np.tanh(u),
    "simple_pendulum": lambda u: -np.sin(u),
}


class Zero:
    """Ends an integration where one component of (u, v) vanishes."""

    terminal = True

    def __init__(self, place: int) -> None:
        self.place = place

    def __call__(self, _: float, y: np.ndarray) -> float:
        return y[self.place]


def quarter(slope: Callable[[float], float], u0: float, v0: float) -> float:
    """When u first vanishes from rest at u0, or v from u = 0 at v0: a quarter of a period, by DOP853."""
    found = solve_ivp(
        lambda _, y: (y[1], slope(y[0])), (0.0, 100.0), (u0, v0), "DOP853", events=Zero(0 if v0 == 0 else 1),
        rtol=3e-14, atol=1e-15,
    )  # fmt: skip
    return float(found.t_events[0][0])


@pytest.mark.parametrize("name", SWINGING)
def test_default_periods_are_those_of_the_integrated_motion(name: str) -> None:
    """To 1e-12, rounding of DOP853's hundreds of steps.

    The pendulum misses the top by 1 - v0^2/4 = 7.6e-7 of its energy: a relative error of the energy counts 1e6 times.
    """
    where = ss.scene(name)
    expected = 4 * quarter(SWINGING[name], where.u0[0], where.v0[0])
    assert period(where) == pytest.approx(expected, rel=1e-8 if name == "simple_pendulum" else 1e-12)


def by_the_mean(rest: float, w: float) -> float:
    """T = 2 pi/(w AGM(1, sqrt(rest))), Gauss; rest is the share of the energy that is missing at the top."""
    a, b = 1.0, math.sqrt(rest)
    for _ in range(9):
        a, b = (a + b) / 2, math.sqrt(a * b)
    return 2 * math.pi / (w * a)


def default_rest() -> float:
    """1 - v0^2/4 of the default pendulum, exactly, then rounded."""
    return float(1 - Fraction(repr(float(ss.scene("simple_pendulum").v0[0]))) ** 2 / 4)


@pytest.mark.parametrize("u0", [1e-3, 0.7, 3.0])
def test_pendulum_by_the_arithmetic_geometric_mean(u0: float) -> None:
    mine = period(ss.scene("simple_pendulum", g_over_L=4.0, u0=u0, v0=0.0))
    assert mine == pytest.approx(by_the_mean(math.cos(u0 / 2) ** 2, 2.0), rel=4e-15)


def test_pendulum_near_the_top() -> None:
    """By the mean, and by K = L + (L - 1) rest/4 + O(L rest^2), L = ln(4/sqrt(rest)): the next term is below 1e-12."""
    mine, rest = period(ss.scene("simple_pendulum")), default_rest()
    assert mine == pytest.approx(by_the_mean(rest, 1.0), rel=4e-15)
    L = math.log(4 / math.sqrt(rest))
    assert mine == pytest.approx(4 * (L + (L - 1) * rest / 4), rel=1e-12)


@pytest.mark.parametrize("name", ["duffing", "softening"])
def test_small_swings_are_those_of_the_linear_oscillator(name: str) -> None:
    """To the square of the amplitude: w^2 = k (1 + 3/4 eps u0^2), and 1 - u0^2/4 for tanh u = u - u^3/3."""
    u0 = 1e-4
    stretch = {"duffing": -3 / 8 * 10 * u0**2, "softening": u0**2 / 8}[name]
    assert period(ss.scene(name, u0=u0)) == pytest.approx(2 * math.pi / 10 * (1 + stretch), rel=1e-13)


def test_wide_softening_swings_are_those_under_a_constant_force() -> None:
    """T = 4 sqrt(2 u0/k) for |tanh u| = 1; it is less for |u| < 1 or so, a share of 1/u0 of the way."""
    u0 = 500.0
    assert period(ss.scene("softening", u0=u0)) == pytest.approx(4 * math.sqrt(2 * u0 / 100.0), rel=1 / u0)
    assert period(ss.scene("softening", u0=-u0)) == period(ss.scene("softening", u0=u0))


def test_what_has_no_period() -> None:
    with pytest.raises(ValueError, match="expected a scene with a known period, one of: duffing"):
        period(ss.scene("linear_oscillator", omega=1.0))
    with pytest.raises(ValueError, match="turns back below the top"):
        period(ss.scene("simple_pendulum", v0=2.0))
    with pytest.raises(ValueError, match="turns back below the top"):
        period(ss.scene("simple_pendulum", v0=0.0))
    for name in ("duffing", "softening"):
        with pytest.raises(ValueError, match="u0 other than 0"):
            period(ss.scene(name, u0=0.0))


def test_the_battery_takes_its_steps_from_the_exact_periods() -> None:
    times = {case.make().name: case.time for case in CASES if case.given is None}
    assert times == {name: period(ss.scene(name)) for name in SWINGING}
    (case,) = (case for case in CASES if case.label == "softening")
    assert case.steps == (case.time / 4, case.time / 20)
