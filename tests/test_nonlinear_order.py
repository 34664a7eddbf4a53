"""The order on nonlinear equations, derived, against runs of every scheme, and against what is known."""

from collections.abc import Iterator
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest
from declared import BY_NAME, NAMES
from declared_steps import march
from nonlinear_systems import SYSTEMS, defaults, exact_end, numbers, observed
from substep_derive import Balance, DeclarationError, InconsistentScheme, Scheme, derive
from substep_derive.algebra.algebraic import generator
from substep_derive.declare.symbols import N, f, h, knot, xi
from substep_derive.nonlinear.order import NonlinearOrder, _march, nonlinear_order
from substep_derive.nonlinear.parasitic import annihilator
from substep_derive.nonlinear.step import StepSeries, lag
from substep_derive.nonlinear.trees import trees
from substep_derive.oscillator.evaluation import Evaluation
from sympy import Expr, Integer, Rational, prod
from tables import COMPOSITIONS, EXTRAPOLATIONS, NYSTROM, TABLES

from substep.derived.facade import order

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
OF_TABLES = (*TABLES, *NYSTROM, *EXTRAPOLATIONS, *COMPOSITIONS)
KINDS = {"duffing": "free", "damped_pendulum": "damped", "pushed_bar": "uva"}


@pytest.fixture(autouse=True)
def digits() -> Iterator[None]:
    with mpmath.workdps(30):
        yield


@cache
def at_defaults(name: str) -> NonlinearOrder:
    return nonlinear_order(Evaluation.at_defaults(name))


@pytest.mark.parametrize("system", KINDS)
@pytest.mark.parametrize("name", NAMES)
def test_derived_order_is_the_observed_one(name: str, system: str) -> None:
    """At t = 1, u, v and a, in mpmath's precision above order 4."""
    derived = getattr(at_defaults(name), KINDS[system])
    exact, expected, found = max(derived) > 4, pytest.approx(derived, abs=0.3), []
    for n in (64,) if exact else (20, 80):  # with 80 steps the first term of every error is the largest
        found = observed(BY_NAME[name], system, n, exact)
        if [k for k, _ in found] == expected:
            return
    raise AssertionError(found)


@pytest.mark.parametrize("name", NAMES)
def test_it_is_not_above_the_linear_one(name: str) -> None:
    linear, found = order(name), at_defaults(name)
    assert all(x <= y for x, y in zip(found.uva, linear, strict=True))
    for triple in (found.free, found.damped, found.forced):
        assert all(x >= y for x, y in zip(triple, found.uva, strict=True))
    if name in OF_TABLES:  # a table's conditions are those of nonlinear equations
        assert found.free == linear


@pytest.mark.parametrize(
    ("name", "free", "uva"),
    [
        ("rk4", (4, 4, 4), (4, 4, 4)),  # Kutta
        ("average_acceleration", (2, 2, 2), (2, 2, 2)),
        ("fox_goodwin", (2, 2, 2), (2, 2, 2)),
        ("central_difference_lagged", (2, 2, 2), (1, 1, 1)),  # the lagged velocity costs an order
        ("hht_alpha", (2, 2, 1), (2, 2, 1)),
        ("kr_alpha_plain_start", (1, 1, 1), (1, 1, 1)),
        ("backward_euler", (1, 1, 1), (1, 1, 1)),
    ],
)
def test_what_is_known(name: str, free: tuple[int, ...], uva: tuple[int, ...]) -> None:
    assert (at_defaults(name).free, at_defaults(name).uva) == (free, uva)


def test_the_frequency_s_order_is_another_matter() -> None:
    d = derive("fox_goodwin").nonlinear
    assert (d.free, d.uva, d.eigenvalue) == ((2, 2, 2), (2, 2, 2), 4)
    period = derive("fox_goodwin").series.period_error
    assert all(c.subs(xi, 0) == 0 for c in period.values())  # up to the third power


def test_general_parameters_and_the_leading_errors() -> None:
    assert derive("newmark").nonlinear.uva == (1, 1, 1)
    found = derive("newmark", gamma="1/2").nonlinear
    assert found.uva == (2, 2, 2)
    central = derive("central_difference").nonlinear
    leading = {e.quantity: (e.tree, e.growth, e.coefficient) for e in central.errors}
    # u_1 misses h^3 (f' - ...)/6, v_1 has h^3 f''/4 in place of h^3 f''/6
    assert leading["u"] == ("f_1", 1, Rational(-1, 6))
    assert leading["v"] == ("f_2", 1, Rational(1, 12))


# --- high orders -------------------------------------------------------------------------------------------


def extrapolated(numbers: list[int]) -> Scheme:
    """Stormer's scheme with 1, 2, ... sub-steps, extrapolated: of order 2k on u'' = g(u), without damping."""
    relations: dict[Any, Expr] = {}
    balances, u_end, v_end = [Balance(a0, v0, N(u0), f(0))], Integer(0), Integer(0)
    for n in numbers:
        weight = prod([Rational(n * n, n * n - m * m) for m in numbers if m != n])
        u, v = u0, v0 + h / (2 * n) * a0
        for k in range(1, n + 1):
            K = knot(f"e{n}{'abcdefgh'[k]}")
            relations |= {K.u: u + h / n * v, K.v: v}
            balances.append(Balance(K.a, K.v, N(K.u), f(Rational(k, n))))
            u, v = K.u, K.v + h / (n if k < n else 2 * n) * K.a
        u_end, v_end = u_end + weight * u, v_end + weight * v
    return Scheme("extrapolated", {**relations, u1: u_end, v1: v_end}, tuple(balances))


def midpoint_extrapolated(numbers: list[int]) -> Scheme:
    """Gragg's midpoint rule for u and v alike, extrapolated: of order 2k with damping and load too."""
    relations: dict[Any, Expr] = {}
    balances, u_end, v_end = [Balance(a0, v0, N(u0), f(0))], Integer(0), Integer(0)
    for n in numbers:
        weight = prod([Rational(n * n, n * n - m * m) for m in numbers if m != n])
        before, now = knot(0), knot(0)
        for k in range(1, n + 1):
            K, reach = knot(f"e{n}{'abcdefgh'[k - 1]}"), h / n * (1 if k == 1 else 2)
            relations |= {K.u: before.u + reach * now.v, K.v: before.v + reach * now.a}
            if k < n:
                balances.append(Balance.at(K, Rational(k, n)))
            before, now = now, K
        u_end, v_end = u_end + weight * now.u, v_end + weight * now.v
    return Scheme("midpoint_extrapolated", {**relations, u1: u_end, v1: v_end}, tuple(balances))


@pytest.mark.matrix
@pytest.mark.parametrize(
    ("scheme", "kind", "order", "system", "n"),
    [
        (extrapolated([1, 2, 3]), "free", 6, "duffing", 24),
        (extrapolated([1, 2, 3, 4]), "free", 8, "duffing", 24),
        (midpoint_extrapolated([2, 4, 6]), "uva", 6, "pushed_pendulum", 12),
        (midpoint_extrapolated([2, 4, 6, 8]), "uva", 8, "pushed_pendulum", 12),
    ],
    ids=lambda x: x.name if isinstance(x, Scheme) else str(x),
)
def test_high_orders_in_extended_precision(scheme: Scheme, kind: str, order: int, system: str, n: int) -> None:
    derived = getattr(nonlinear_order(Evaluation.at_defaults(scheme)), kind)
    assert derived == (order, order, order)
    found = observed(scheme, system, n, True)
    assert [k for k, _ in found] == pytest.approx(derived, abs=0.35), found


# --- the series itself -------------------------------------------------------------------------------------


class Differentials:
    """The trees' values on the elastic pendulum's bar, from its force's derivatives as tensors."""

    def __init__(self, of: Any, step: float, t: float, start: Any) -> None:
        make, u, _ = SYSTEMS["pushed_bar"]
        self.of, self.h, self.t, self.system = of, step, t, make(False)
        self.K0 = self.system.tangent(numbers(u, False))
        self.u, self.v = start
        e, k = np.eye(2), 3.0
        second = k * 2 * sum(np.einsum(x, e, self.u) for x in ("ij,k->ijk", "ik,j->ijk", "jk,i->ijk"))
        third = k * 2 * sum(np.einsum(x, e, e) for x in ("ij,kl->ijkl", "ik,jl->ijkl", "il,jk->ijkl"))
        self.slopes = [self.system.force(self.u), self.system.tangent(self.u), second, third]
        self.known: dict[int, Any] = {}

    def value(self, tree: int) -> Any:
        if tree not in self.known:
            self.known[tree] = self._value(*self.of.keys[tree])
        return self.known[tree]

    def _value(self, kind: str, branches: tuple[int, ...]) -> Any:
        if kind in "uv":
            return self.u if kind == "u" else self.h * self.v
        if kind == "f":
            k, turn = branches[0], branches[0] * np.pi / 2
            rates = [1.3**k * np.cos(1.3 * self.t + turn), 2 * np.sin(self.t + turn)]
            return self.h ** (k + 2) * np.array(rates)
        if kind in "CK":
            matrix = self.h * self.system.damping if kind == "C" else self.h**2 * self.K0
            return matrix @ self.value(branches[0])
        if len(branches) > 3:
            return 0 * self.u
        found = self.h**2 * self.slopes[len(branches)]
        for branch in branches:
            found = found @ self.value(branch)
        return found

    def sum(self, series: Any) -> Any:
        return sum((float(c) * self.value(tree) for level in series for tree, c in level.items()), 0 * self.u)


@pytest.mark.parametrize("name", NAMES)
def test_the_series_of_the_first_steps_is_the_steps(name: str) -> None:
    """What a run reports after its first own step and the one after, up to the first power that the series leaves out.

    The bar has two coordinates, its damping matrix does not commute with its tangent, nor K0 with the tangent later.
    """
    scheme, weight = BY_NAME[name], 5
    make, u, v = SYSTEMS["pushed_bar"]
    system, values = make(False), defaults(scheme, False)
    step = StepSeries(Evaluation.at_defaults(scheme))
    if name == "energy_momentum":  # a discrete gradient on several coordinates is the mean but for h^2 times a square
        weight = 3
    of = trees(True, True, step.reads_tangent)
    of.grow(weight)
    reports = _march(step, of, weight)
    next(reports)
    first = lag(scheme) if step.starter else 0
    root = step.evaluation.field
    errors: dict[int, list[float]] = {}
    for after in (1, 2):
        series = [
            [{tree: float(root.expression(c).subs(numeric(root))) for tree, c in level.items()} for level in s]
            for s in next(reports)[1]
        ]
        for size in (0.0125, 0.00625):
            rows = march(scheme, values, system, size, first + after, numbers(u, False), numbers(v, False))
            t = size * (first + after)
            uv = exact_end("pushed_bar", False, t)[:2]
            at = Differentials(of, size, t, uv)
            differences = [abs(at.sum(series[k]) - rows[-1][k] * size**k).max() for k in range(3)]
            errors.setdefault(after, []).append(max(differences))
    for large, small in errors.values():
        assert small < 1e-13 or large / small > 2 ** (weight + 0.5), errors


def numeric(field: Any) -> dict[Any, Any]:
    """The value of the generator of Q(r)."""
    if field.root is None:
        return {}
    return {generator: Rational(str(field.root.approximation()))}


# --- declarations that are unusual, or wrong ---------------------------------------------------------------


@pytest.mark.parametrize("name", ["oalts", "generalized_alpha", "park", "wilson_theta", "kr_alpha"])
def test_more_filtering_changes_nothing(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the filter leaves is constant or grows with n: a longer filter leaves the same."""
    from substep_derive.nonlinear import order as module

    expected = at_defaults(name)

    def longer(step: StepSeries, active: int, weight: int, *, lasting: bool = False) -> list[Any]:
        return annihilator(step, active, weight + 2, lasting=lasting)

    monkeypatch.setattr(module, "annihilator", longer)
    assert nonlinear_order(Evaluation.at_defaults(name)) == expected


def test_an_error_that_does_not_die_out_is_seen() -> None:
    """A start of first order makes a scheme of second order one of first order, however well it steps."""
    um = knot(-1).u
    relations = {u1: 2 * u0 - um + h**2 * a0, v1: (3 * u1 - 4 * u0 + um) / (2 * h)}
    balances = (Balance(a0, (u1 - um) / (2 * h), N(u0), f(0)),)
    good = Scheme("good", relations, balances, start={um: u0 - h * v0 + h**2 / 2 * a0})
    poor = Scheme("poor", relations, balances, start={um: u0 - h * v0})
    assert nonlinear_order(Evaluation.at_defaults(good)).uva[:2] == (2, 2)
    assert nonlinear_order(Evaluation.at_defaults(poor)).uva[:2] == (1, 1)
    for scheme, expected in ((good, 2), (poor, 1)):
        found = observed(scheme, "pushed_bar", 20, False)
        assert [k for k, _ in found[:2]] == pytest.approx([expected, expected], abs=0.2)


def test_a_scheme_of_no_order_is_refused() -> None:
    with pytest.raises(InconsistentScheme):
        derive(Scheme("still", {u1: u0, v1: v0}, (Balance.at(end, 1),))).nonlinear


def test_a_force_at_no_displacement_is_refused() -> None:
    relations = {u1: u0 + h * v0 + h**2 / 2 * a0, v1: v0 + h / 2 * (a0 + a1)}
    scheme = Scheme("half", relations, (Balance(a1, v1, N(u1 / 2), f(1)),))
    with pytest.raises(DeclarationError, match="add up to 1, got 1/2"):
        nonlinear_order(Evaluation.at_defaults(scheme))
