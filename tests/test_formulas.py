"""Functions that hold formulas: recorded once, done at all points by one kernel."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from declared import OWN
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf
from plain_kernels import committed
from substep_derive import Balance, N, Parameter, Scheme, f, h, knot

import substep as ss
from substep.core import kernel_modules
from substep.core.formulas import _program, evaluated

RNG = np.random.default_rng(128)
EPS = float(np.finfo(float).eps)
DIGITS = 70


class Exact:
    """The arithmetic of formulas in many digits: a pair is a number and a tail of 0, or a constant's two doubles."""

    def __getattr__(self, name: str) -> Callable[..., Any]:
        operation = {"plus": lambda a, b: a + b, "times": lambda a, b: a * b}[name.split("_", maxsplit=1)[0]]
        pairs = {"": (0, 0), "one": (0, 1), "two": (1, 1)}[name.partition("_")[2]]

        def done(*parts: Any) -> tuple[Any, Any]:
            given = map(mpf, parts)
            a, b = (next(given) + (next(given) if pair else 0) for pair in pairs)
            return operation(a, b), mpf(0)

        return done

    def over(self, a: Any, a_: Any, b: Any, b_: Any) -> Any:
        return (mpf(a) + a_) / (mpf(b) + b_)

    def horner(self, a: Any, _a: Any, b: Any, _b: Any, w0: Any, _w0: Any, w1: Any, _w1: Any, c: Any, c_: Any) -> Any:
        return w0 * b + mpf(c) + c_, mpf(0), w1 * b + a, mpf(0)

    def conjugate(self, a: Any, _a: Any, b: Any, _b: Any, w0: Any, _w0: Any, w1: Any, _w1: Any) -> Any:
        c = a + w1 * b
        return c, mpf(0), -b, mpf(0), a * c - w0 * b * b, mpf(0)

    def product(
        self, a: Any, _a: Any, b: Any, _b: Any, c: Any, _c: Any, d: Any, _d: Any, w0: Any, _w0: Any, w1: Any, _w1: Any
    ) -> Any:
        return a * c + w0 * b * d, mpf(0), a * d + b * c + w1 * b * d, mpf(0)

    def difference(self, a: Any, a_: Any, b: Any, b_: Any, c: Any, c_: Any, d: Any, d_: Any) -> Any:
        a, b, c, d = (mpf(x) + x_ for x, x_ in ((a, a_), (b, b_), (c, c_), (d, d_)))
        return a * b - c * d, mpf(0)


def many_digits(function: Callable[..., Any], inputs: np.ndarray) -> list[list[Any]]:
    """What the function returns at each point of inputs (k, P)."""
    with mp.workdps(DIGITS):
        return [[mpf(x) for x in function(Exact(), *map(mpf, column.tolist()))] for column in inputs.T]


def points_of(name: str, n: int) -> np.ndarray:
    """Omega, xi and the parameters near those by default (k, n)."""
    s = ss.scheme(name)
    xi = RNG.uniform(0.0, 0.5, n) if s.info.damping else np.zeros(n)
    parameters = [float(x) * RNG.uniform(1.0, 1.01, n) for x in s.kernel_parameters]
    return np.array([10.0 ** RNG.uniform(-4, 2, n), xi, *parameters])


@pytest.mark.parametrize("name", OWN)
def test_formulas_of_a_scheme_against_many_digits(name: str) -> None:
    """The increment is rounded once; the other formulas are computed in doubles, or pairs of such."""
    module, inputs = ss.scheme(name).kernels, points_of(name, 20)
    m = len(module.KEPT)
    found, exact = evaluated(module.coefficients, 20, inputs).T, many_digits(module.coefficients, inputs)
    with mp.workdps(DIGITS):
        for row, values in zip(found, exact, strict=True):
            for k, (x, value) in enumerate(zip(row, values, strict=True)):
                bound = EPS / 2 * (1 + 1e-6) * abs(value) if k < m * m else 1e-9 * max(1, abs(value))
                assert abs(mpf(x) - value) <= bound
    for function in ("amplification", "transfer", "start"):
        if hasattr(module, function):
            formulas = getattr(module, function)
            exact = np.array(many_digits(formulas, inputs), dtype=float)
            np.testing.assert_allclose(evaluated(formulas, 20, inputs).T, exact, rtol=1e-9, atol=1e-9)


def pair_of(numbers: list[float]) -> Any:
    """Doubles that are summed, and multiplied, as pairs: 4 numbers in, a sum and a product with their tails out."""
    return evaluated(_pairs_of_four, 1, [np.array([x]) for x in numbers])[:, 0].tolist()


def _pairs_of_four(by: Any, a: Any, b: Any, c: Any, d: Any) -> tuple[Any, ...]:
    first, second = by.plus(a, b), by.times(c, d)
    return (
        *by.plus_two(*first, *second), *by.times_two(*first, *second), *by.plus_one(a, *second),
        *by.times_one(a, *second), by.over(*first, *second),
    )  # fmt: skip


@given(st.lists(st.floats(0.01, 100.0), min_size=4, max_size=4))
def test_pairs_have_thirty_digits(numbers: list[float]) -> None:
    found = pair_of(numbers)
    with mp.workdps(DIGITS):
        a, b, c, d = map(mpf, numbers)
        exact = a + b + c * d, (a + b) * c * d, a + c * d, a * c * d
        for value, head, tail in zip(exact, found[::2], found[1::2], strict=False):
            assert abs(mpf(head) + mpf(tail) - value) <= 8 * mpf(EPS) ** 2 * value
            assert abs(tail) <= EPS * head
        assert abs(mpf(found[-1]) - (a + b) / (c * d)) <= EPS / 2 * found[-1] * (1 + 1e-9)


def _powers(by: Any, x: Any) -> tuple[Any, ...]:
    return x**2, x**3, -x, 2 - x, 1 / x, x / 4, 3 * x, x - 1, x + 1, -0.0 * x, 0.5, x, x**-2, x**0, x**-1


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("n", [0, 1, 3, 127, 128, 129, 300])
def test_a_point_among_others_is_the_point_alone(n: int, compiled: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    x = RNG.uniform(0.5, 2.0, n)
    if not compiled:
        monkeypatch.setattr(kernel_modules, "committed", committed)
    found = evaluated(_powers, n, [x])
    exact = (
        x * x,
        x * x * x,
        -x,
        2 - x,
        1 / x,
        x / 4,
        3 * x,
        x - 1,
        x + 1,
        -0.0 * x,
        0.5 + 0 * x,
        x,
        1 / (x * x),
        1 + 0 * x,
        1 / x,
    )
    assert np.array_equal(found, np.array(exact))
    assert np.signbit(found[9]).all()
    for k in range(n):
        assert np.array_equal(evaluated(_powers, 1, [x[k : k + 1]])[:, 0], found[:, k])


def test_rows_are_used_again() -> None:
    """A long sum takes as many rows as are read later, not one for each term."""

    def long(by: Any, x: Any) -> tuple[Any, ...]:
        total = x
        for _ in range(1000):
            total = total * x + 1.0
        return (total,)

    assert _program(long, (False,)).rows <= 6
    np.testing.assert_allclose(evaluated(long, 2, [np.array([0.5, 0.25])]), [[2.0, 4.0 / 3.0]])


def test_a_power_that_is_no_rational_function_is_refused() -> None:
    def power(by: Any, x: Any) -> tuple[Any, ...]:
        return (x**0.5,)

    with pytest.raises(TypeError, match="expected a whole power"):
        evaluated(power, 1, [np.ones(1)])


def weighted(weight: sp.Expr, gamma: sp.Symbol) -> Scheme:
    """Newmark's step with beta = gamma/2 whose load is weighted, and taken twice with weights whose sum is 1."""
    u0, v0, a0 = knot(0)
    u1, v1, a1 = end = knot(1)
    load = weight * f(0) + (1 - weight) * f(1)
    return Scheme(
        "weighted",
        {u1: u0 + h * v0 + h**2 * ((1 - gamma) * a0 + gamma * a1) / 2, v1: v0 + h * ((1 - gamma) * a0 + gamma * a1)},
        (Balance(end.a, end.v, N(end.u), load),),
        (Parameter(gamma, sp.Interval(sp.Rational(1, 2), 2), sp.Rational(3, 5)),),
    )


@pytest.mark.usefixtures("plain_functions")
@pytest.mark.parametrize(
    "weight",
    ["1/gamma**2", "gamma**-3/(1 + gamma**2)", "(gamma - 3)**(-2)", "1/(1/gamma + 1/(gamma + 1))**2", "gamma**0"],
)
def test_any_rational_function_of_the_parameters_weights_a_load(
    weight: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Against the step written out: solved for a_1 number by number."""
    tmp_path.chmod(0o700)
    monkeypatch.setenv("SUBSTEP_CACHE", str(tmp_path))
    gamma, g, xi, dt, n = sp.Symbol("gamma"), 0.7, 0.1, 0.2, 25
    s = ss.scheme(weighted(sp.sympify(weight, {"gamma": gamma}), gamma), gamma=g)
    w = float(sp.sympify(weight, {"gamma": gamma}).subs(gamma, g))
    scene = ss.scene("linear_oscillator", omega=2.0, xi=xi, load=ss.Harmonic(1.0, 3.0))
    found = ss.march(scene, s, dt=dt, t_end=n * dt).u[:, 0]
    u, v, t = 1.0, 0.0, dt * np.arange(n + 1)
    loads, a = np.sin(3.0 * t), float(scene.a0[0])
    for k in range(n):
        p, q = u + dt * v + dt**2 * (1 - g) / 2 * a, v + dt * (1 - g) * a
        a = (w * loads[k] + (1 - w) * loads[k + 1] - 4 * xi * q - 4 * p) / (1 + 4 * xi * dt * g + 4 * dt**2 * g / 2)
        u, v = p + dt**2 * g / 2 * a, q + dt * g * a
        assert found[k + 1] == pytest.approx(u, rel=1e-12, abs=1e-13)
