"""Nonlinear systems written by hand, in double or in mpmath's precision, and their exact motions."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import mpmath
import numpy as np
from declared_steps import System, march
from scipy.integrate import solve_ivp
from substep_derive import Scheme
from substep_derive.algebra.algebraic import generator
from substep_derive.declare.parameter_set import ParameterSet
from sympy import Rational, Symbol

Array = Any


def number(value: str, exact: bool) -> Any:
    return mpmath.mpf(value) if exact else float(value)


def numbers(values: Any, exact: bool) -> Array:
    """An array of floats or of mpmath's numbers, from text."""
    if isinstance(values, str):
        return number(values, exact)
    return np.array([numbers(x, exact) for x in values], dtype=object if exact else float)


def each(g: Callable[[Any], Any]) -> Callable[[Array], Array]:
    return lambda x: np.array([g(y) for y in x], dtype=x.dtype)


def duffing(exact: bool) -> System:
    """u'' = -4 u - 2 u^3."""
    return System(
        lambda u: 4 * u + 2 * u**3,
        lambda u: np.diag(4 + 6 * u**2),
        lambda u, w: (u + w) * (2 + (u * u + w * w) / 2),
        numbers([["0"]], exact),
        lambda t: numbers(["0"], exact),
    )


def damped_pendulum(exact: bool) -> System:
    """u'' = -4 sin u - 0.6 u'."""
    sin, cos, sinc = (mpmath.sin, mpmath.cos, mpmath.sinc) if exact else (np.sin, np.cos, lambda x: np.sinc(x / np.pi))
    return System(
        lambda u: 4 * each(sin)(u),
        lambda u: np.diag(4 * each(cos)(u)),
        lambda u, w: 4 * each(sin)((u + w) / 2) * each(sinc)((w - u) / 2),
        numbers([["0.6"]], exact),
        lambda t: numbers(["0"], exact),
    )


def pushed_pendulum(exact: bool) -> System:
    """u'' = -4 sin u - 0.6 u' + cos 1.3 t."""
    cos, still = mpmath.cos if exact else np.cos, damped_pendulum(exact)
    return replace(still, load=lambda t: np.array([cos(number("1.3", exact) * t)], dtype=object if exact else float))


def pushed_bar(exact: bool) -> System:
    """The elastic pendulum's bar with Green-Lagrange strain, a damper that does not commute with it, and a load."""
    cos, sin = (mpmath.cos, mpmath.sin) if exact else (np.cos, np.sin)
    k, eye = number("3", exact), numbers([["1", "0"], ["0", "1"]], exact)
    return System(
        lambda u: k * (u @ u - 1) * u,
        lambda u: k * ((u @ u - 1) * eye + 2 * np.outer(u, u)),
        lambda u, w: k * ((u @ u + w @ w) / 2 - 1) * (u + w) / 2,
        numbers([["0.5", "0.2"], ["0.2", "0.9"]], exact),
        lambda t: np.array([cos(number("1.3", exact) * t), 2 * sin(t)], dtype=object if exact else float),
    )


SYSTEMS: dict[str, tuple[Callable[[bool], System], list[str], list[str]]] = {
    "duffing": (duffing, ["1.1"], ["0.5"]),
    "damped_pendulum": (damped_pendulum, ["0.7"], ["0.9"]),
    "pushed_pendulum": (pushed_pendulum, ["0.7"], ["0.9"]),
    "pushed_bar": (pushed_bar, ["1.2", "0.1"], ["-0.4", "0.8"]),
}


@cache
def exact_end(name: str, exact: bool, t: float = 1.0) -> tuple[Array, Array, Array]:
    """u, v, a at t."""
    make, u, v = SYSTEMS[name]
    system, d = make(exact), len(u)
    start = [*numbers(u, exact), *numbers(v, exact)]

    def rate(s: Any, y: Any) -> list[Any]:
        y = np.array(list(y), dtype=object if exact else float)
        return [*y[d:], *system.acceleration(y[:d], y[d:], s)]

    if exact:
        end = np.array(list(mpmath.odefun(rate, 0, start)(t)), dtype=object)
    else:
        end = solve_ivp(rate, (0, t), start, method="DOP853", rtol=3e-14, atol=1e-15).y[:, -1]
    return end[:d], end[d:], system.acceleration(end[:d], end[d:], number(str(t), exact))


def defaults(scheme: Scheme, exact: bool) -> dict[Symbol, Any]:
    """Every parameter's default, to the working precision."""
    at = ParameterSet.of(scheme, None, {})
    found, number_r = {}, Rational(0)
    for symbol, value in at.values.items():
        if value.has(generator):
            root = at.field.root
            assert root is not None
            while root.high - root.low > Rational(1, 10**45):
                at.field.narrow()
            middle = (root.low + root.high) / 2
            number_r = Rational(int(middle.numerator), int(middle.denominator))
        rational = value.subs(generator, number_r)
        found[symbol] = mpmath.mpf(rational.p) / rational.q if exact else float(rational)
    return found


def observed(scheme: Scheme, name: str, n: int, exact: bool) -> list[tuple[float, float]]:
    """For u, v, a at t = 1: (the order from n, 2n, 4n steps, extrapolated to vanishing steps; the least error)."""
    make, u, v = SYSTEMS[name]
    system, truth, one = make(exact), exact_end(name, exact), number("1", exact)
    errors = []
    for steps in (n, 2 * n, 4 * n):
        rows = march(scheme, defaults(scheme, exact), system, one / steps, steps, numbers(u, exact), numbers(v, exact))
        errors.append([max(abs(x - y)) for x, y in zip(rows[-1], truth, strict=True)])
    found = []
    for coarse, middle, fine in zip(*errors, strict=True):
        first, second = (float(mpmath.log(x / y, 2)) for x, y in ((coarse, middle), (middle, fine)))
        found.append((2 * second - first, float(fine)))
    return found
