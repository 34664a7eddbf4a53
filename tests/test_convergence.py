"""Orders of schemes that errors of their start do not leave alone, against marching them."""

from collections.abc import Mapping
from typing import Any

import mpmath
import pytest
from declared_steps import march, oscillator, vector
from substep_derive import Balance, InconsistentScheme, Scheme, derive
from substep_derive.declare.symbols import C, M, N, f, h, knot
from substep_derive.study.profile import profile
from sympy import Expr, Rational, Symbol

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
um, vm, am = knot(-1)
TRAPEZOID = {u1: u0 + h * v0 + h**2 / 4 * (a0 + a1), v1: v0 + h / 2 * (a0 + a1)}
MIDPOINT = Balance((a0 + a1) / 2, (v0 + v1) / 2, N((u0 + u1) / 2), f(Rational(1, 2)))  # a has the eigenvalue -1
AT_END = Balance.at(end, 1)
AVERAGE = Scheme("average", TRAPEZOID, (AT_END,))


@mpmath.workdps(25)
def observed(scheme: Scheme, cubic: int) -> tuple[int, ...]:
    """Orders of u, v, a over two halvings, in the largest error of the second half of [0, 1], of a motion chosen."""

    def motion(t: Any) -> list[Any]:
        return [mpmath.cos(2 * t) + t / 3, -2 * mpmath.sin(2 * t) + 1 / mpmath.mpf(3), -4 * mpmath.cos(2 * t)]

    def load(t: Any) -> Any:
        u, v, a = motion(t)
        return a + v / 2 + 3 * u + cubic * u**3

    system, errors = oscillator(mpmath.mpf("0.5"), 3, cubic, load), []
    for n in (80, 160):
        rows = march(scheme, {}, system, mpmath.mpf(1) / n, n, *(vector(x) for x in motion(mpmath.mpf(0))[:2]))
        times = range(n // 2, n + 1)
        errors.append([max(abs(rows[i][k][0] - motion(mpmath.mpf(i) / n)[k]) for i in times) for k in range(3)])
    return tuple(round(float(mpmath.log(a / b, 2))) for a, b in zip(*errors, strict=True))


@pytest.mark.parametrize(
    ("relations", "balance", "start", "orders"),
    [
        (TRAPEZOID, AT_END, {a0: (-C * v0 - N(u0)) / M}, (1, 1, 1)),  # without the load: as any other wrong a_0
        (TRAPEZOID, AT_END, {a0: (f(0) - C * v0 - N(u0)) / M}, (2, 2, 2)),
        (TRAPEZOID, MIDPOINT, {a0: 0}, (2, 2, 0)),  # what is wrong with a_0 changes its sign in each step, for ever
        (TRAPEZOID, MIDPOINT, {}, (2, 2, 2)),
        (TRAPEZOID, Balance(a1, v1, N(u1), 0), {}, (0, 0, 0)),
        ({u1: um + 2 * h * v0, v1: vm + 2 * h * a0}, AT_END, {um: u0 - h * v0 / 2, vm: v0 - h * a0}, (1, 1, 1)),
        ({u1: um + 2 * h * v0, v1: vm + 2 * h * a0}, AT_END, AVERAGE, (2, 2, 2)),
    ],
    ids=["no load in a_0", "load in a_0", "midpoint, no a_0", "midpoint", "no load", "leapfrog, wrong", "leapfrog"],
)
def test_orders_with_the_start(relations: Any, balance: Balance, start: Any, orders: tuple[int, ...]) -> None:
    scheme = Scheme("started", relations, (balance,), start=start)
    assert observed(scheme, 0) == observed(scheme, 1) == orders
    assert derive(scheme).order == derive(scheme).nonlinear.uva == orders


@pytest.mark.parametrize(
    ("relations", "size"),
    [
        # Hairer, Norsett & Wanner I, III.3: explicit, of two steps and order 3, and divergent
        ({u1: -4 * u0 + 5 * um + h * (4 * v0 + 2 * vm), v1: -4 * v0 + 5 * vm + h * (4 * a0 + 2 * am)}, "5"),
        ({**TRAPEZOID, v1: v0 + h * (3 * a1 - am) / 2, u1: 3 * u0 - 2 * um - h * v0}, "2"),
    ],
)
def test_a_scheme_that_does_not_converge_has_no_order(relations: Mapping[Symbol, Expr], size: str) -> None:
    scheme = Scheme("diverging", relations, (AT_END,), start=AVERAGE)
    assert max(observed(scheme, 0)) < 0
    for ask in (lambda: derive(scheme).order, lambda: derive(scheme).nonlinear, lambda: profile(scheme)):
        with pytest.raises(
            InconsistentScheme, match=f"diverging does not converge: .* one of modulus {size}, by which"
        ):
            ask()
