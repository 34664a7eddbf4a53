"""Estimators on a damped Duffing oscillator under a load, whose local errors come from Taylor series of 30 terms."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import mpmath
import pytest
from declared import BY_NAME
from declared_steps import oscillator, vector
from local_errors import evaluated, halved, marcher_of, two_steps
from substep_derive import Estimator, Scheme, estimator, f, h
from sympy import Rational, Symbol

C, EPS, RATE = mpmath.mpf("0.3"), mpmath.mpf("1.5"), mpmath.mpf("1.7")
TERMS = 30


@pytest.fixture(autouse=True)
def digits() -> Iterator[None]:
    with mpmath.workdps(40):
        yield


DUFFING = oscillator(C, 1, EPS, lambda t: mpmath.cos(RATE * t))


def after(u: Any, v: Any, t: Any, dt: Any) -> tuple[Any, Any]:
    """u, v at t + dt: coefficients of u = sum x_k s^k follow one after another from the equation of motion."""
    x, square, cube = [u, v], [], []
    for k in range(TERMS):
        square.append(sum(x[i] * x[k - i] for i in range(k + 1)))
        cube.append(sum(square[i] * x[k - i] for i in range(k + 1)))
        force = RATE**k * mpmath.cos(RATE * t + k * mpmath.pi / 2) / mpmath.factorial(k)
        x.append((force - C * (k + 1) * x[k + 1] - x[k] - EPS * cube[k]) / ((k + 1) * (k + 2)))
    return mpmath.polyval(x[::-1], dt), mpmath.polyval([k * c for k, c in enumerate(x)][:0:-1], dt)


def quotients(scheme: Scheme, values: dict[str, Rational], found: Estimator, n: int) -> tuple[Any, Any]:
    """Estimate/true local error of u and v after n/4 steps of 1/n."""
    marcher = marcher_of(scheme, values, DUFFING, mpmath.mpf(1) / n)
    state = marcher.started(vector(1), vector("0.3"))
    for k in range(n // 4):
        state = marcher.after(marcher.step(state, k * marcher.h))
    quarter = mpmath.mpf(1) / 4
    symbols = two_steps(marcher, state, quarter, after)
    if any("halved" in s.name for s in (found.u + found.v).free_symbols):
        symbols |= halved(marcher, values, symbols, quarter + marcher.h)
    return evaluated(found.u, symbols) / symbols["u"], evaluated(found.v, symbols) / symbols["v"]


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("average_acceleration", {}),
        ("linear_acceleration", {}),
        ("newmark", {"beta": Rational(2, 5), "gamma": Rational(3, 5)}),
        ("newmark_bdf2", {"gamma_t": Rational(2, 5), "beta": Rational(3, 7), "gamma": Rational(7, 10)}),
        ("bathe", {}),
        ("hht_alpha", {"alpha": Rational(-1, 5)}),
        ("hht_alpha_mixed_displacement", {"alpha": Rational(-1, 5)}),
        ("wilson_theta", {"theta": Rational(7, 5)}),
        ("three_substep", {"rho_inf": Rational(1, 2), "gamma": Rational(9, 25)}),
        ("rk2", {}),
        ("rk4", {}),
    ],
)
def test_estimates_tend_to_the_true_local_error(name: str, values: dict[str, Rational]) -> None:
    scheme, found = BY_NAME[name], estimator(name)
    coarse, fine = (quotients(scheme, values, found, n) for n in (64, 128))
    for far, near in zip(coarse, fine, strict=True):
        assert abs(near - 1) < max(abs(far - 1) * 0.65, 5e-3), (far, near)
        assert abs(near - 1) < 1 / 3


def test_an_estimate_for_the_load_at_another_instant_is_wrong() -> None:
    """The same test sees that: the trapezoidal rule's estimate on a scheme that takes the load at the middle."""
    scheme = BY_NAME["average_acceleration"]
    (balance,) = scheme.balances
    moved = replace(scheme, name="moved", balances=(replace(balance, load=f(Rational(1, 2))),), parent=None, fixed={})
    wrong, right = estimator("average_acceleration"), estimator(moved)
    assert all(abs(q - 1) > 1 / 3 for q in quotients(moved, {}, wrong, 64)[1:])
    assert all(abs(q - 1) < 1 / 3 for q in quotients(moved, {}, right, 64))
    assert h in right.u.free_symbols and Symbol("u_1") not in wrong.u.free_symbols
