"""Functions that hold formulas: recorded once, done at all points by one kernel."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME, NAMES
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf
from plain_kernels import committed

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


@pytest.mark.parametrize("name", [name for name in NAMES if BY_NAME[name].parent is None])
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
    return x**2, x**3, -x, 2 - x, 1 / x, x / 4, 3 * x, x - 1, x + 1, -0.0 * x, 0.5, x


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("n", [0, 1, 3, 127, 128, 129, 300])
def test_a_point_among_others_is_the_point_alone(n: int, compiled: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    x = RNG.uniform(0.5, 2.0, n)
    if not compiled:
        monkeypatch.setattr(kernel_modules, "committed", committed)
    found = evaluated(_powers, n, [x])
    exact = x * x, x * x * x, -x, 2 - x, 1 / x, x / 4, 3 * x, x - 1, x + 1, -0.0 * x, 0.5 + 0 * x, x
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

    assert _program(long).rows <= 6
    np.testing.assert_allclose(evaluated(long, 2, [np.array([0.5, 0.25])]), [[2.0, 4.0 / 3.0]])


@pytest.mark.parametrize("exponent", [0, -1, 0.5])
def test_a_power_that_is_no_product_is_refused(exponent: Any) -> None:
    def power(by: Any, x: Any) -> tuple[Any, ...]:
        return (x**exponent,)

    with pytest.raises(TypeError, match="whole power from 1 on"):
        evaluated(power, 1, [np.ones(1)])
