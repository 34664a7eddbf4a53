"""Runge-Kutta and Nystrom tables and compositions as declarations: their orders, what they reuse, what they refuse."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
import tables
from declared import BY_NAME, UNDAMPED
from declared_steps import Marcher, oscillator, vector
from nonlinear_systems import defaults
from substep_derive import DeclarationError, Parameter, Root, certify, composition, derive, nystrom, tableau
from substep_derive.algebra.constant import reduced
from substep_derive.algebra.rooted_trees import nystrom_order, nystrom_trees, rooted_trees, runge_kutta_order
from substep_derive.declare.catalogue import find_scene
from substep_derive.declare.schemes.newmark import central_difference
from substep_derive.declare.symbols import Omega, f, gamma, knot
from substep_derive.emit.first_use import catalogue_pair
from substep_derive.motion.equations import EquationsOfMotion
from substep_derive.stability.all_damping import certify_all_damping
from sympy import Interval, Matrix, Rational, Symbol, cancel, eye

import substep as ss

HALF, ONE = Fraction(1, 2), Fraction(1)
(u0, v0, a0), (u1, v1, a1) = knot(0), knot(1)
# order of the second value of u and v, as published or declared
EMBEDDED = {
    "bogacki_shampine": 2, "dormand_prince": 4, "esdirk32": 2, "esdirk43": 3,
    "rkn43": 3, "rkn64": 4, "stoermer_extrapolation": 6, "four_substep": 3,
}  # fmt: skip


def test_trees_are_as_many_as_there_are() -> None:
    """Hairer, Norsett & Wanner I (1993), II.2 and II.14; the last are the Nystrom trees of u'' = g(t, u, v)."""
    assert [len(rooted_trees(n)) for n in range(1, 9)] == [1, 1, 2, 4, 9, 20, 48, 115]
    assert [len(nystrom_trees(n, False)) for n in range(1, 9)] == [1, 1, 2, 3, 6, 10, 20, 36]
    assert all(len(set(nystrom_trees(n, True))) == len(nystrom_trees(n, True)) for n in range(1, 6))


def test_collocation_has_the_order_of_its_quadrature() -> None:
    """Radau IIA has order 3, Lobatto IIIA order 4, on their own and as Nystrom tables; Verlet's rule has order 2."""
    radau = [[Fraction(5, 12), Fraction(-1, 12)], [Fraction(3, 4), Fraction(1, 4)]]
    assert runge_kutta_order(radau, radau[1], ONE) == 3
    assert runge_kutta_order(radau, [HALF, HALF], ONE) == 1
    lobatto = [[Fraction(x) for x in row.split()] for row in ("0 0 0", "5/24 1/3 -1/24", "1/6 2/3 1/6")]
    assert runge_kutta_order(lobatto, lobatto[2], ONE) == 4
    square = [[sum(a * row[k] for a, row in zip(line, lobatto, strict=True)) for k in range(3)] for line in lobatto]
    c = [Fraction(0), HALF, ONE]
    assert nystrom_order(square, square[2], lobatto[2], c, ONE) == (4, 4)
    assert nystrom_order(square, square[2], lobatto[2], c, ONE, lobatto) == (4, 4)
    assert nystrom_order([[0, 0], [HALF, 0]], [HALF, 0], [HALF, HALF], [Fraction(0), ONE], ONE) == (2, 2)


def test_second_values_are_declared_by_these() -> None:
    assert {s.name for s in BY_NAME.values() if s.embedded} == set(EMBEDDED)
    assert all(set(BY_NAME[name].embedded) == {u1, v1} for name in EMBEDDED)


@pytest.mark.parametrize("name", EMBEDDED)
@mpmath.workdps(40)
def test_the_second_value_has_the_published_order(name: str) -> None:
    """Its difference from the first, after one step of h and of h/2, is of order p + 1."""
    scheme = BY_NAME[name]
    system = oscillator("0.2" if scheme.takes_damping else 0, 1, 1, mpmath.cos)
    differences = []
    for n in (256, 512):
        marcher = Marcher(scheme, defaults(scheme, True), system, mpmath.mpf(1) / n, vector(1))
        after = marcher.step(marcher.started(vector(1), vector("0.5")), mpmath.mpf(0))
        second = [marcher.value(marcher.form(scheme.embedded[s]), after, 0) for s in (u1, v1)]
        differences.append([abs(x - after[s])[0] for x, s in zip(second, (u1, v1), strict=True)])
    for coarse, fine in zip(*differences, strict=True):
        assert float(mpmath.log(coarse / fine, 2)) == pytest.approx(EMBEDDED[name] + 1, abs=0.1)


def test_the_last_stage_is_not_evaluated_twice() -> None:
    """Evaluations a step, as published: three of Bogacki and Shampine's four stages, six of seven, five of six."""
    balances = {name: len(BY_NAME[name].balances) for name in ("bogacki_shampine", "dormand_prince", "rkn64", "rkn43")}
    assert balances == {"bogacki_shampine": 3, "dormand_prince": 6, "rkn64": 5, "rkn43": 3}
    for name in balances:
        assert BY_NAME[name].balances[-1].load == f(1)
        assert a0 in BY_NAME[name].state
    assert a1 in BY_NAME["sdirk3"].unknowns and a0 not in BY_NAME["sdirk3"].state
    assert a1 not in BY_NAME["crouzeix3"].unknowns


def test_tables_give_known_schemes() -> None:
    """Kutta's, the trapezoidal rule and backward Euler from their tables have the matrices of their declarations."""
    half = Rational(1, 2)
    kutta = tableau(
        "kutta", ((), (half,), (0, half), (0, 0, 1)), [Rational(k, 6) for k in (1, 2, 2, 1)], (0, half, half, 1)
    )
    for mine, theirs in (
        (kutta, "rk4"),
        (tableau("trapezoids", ((), (half, half)), (half, half), (0, 1)), "average_acceleration"),
        (tableau("implicit_euler", ((1,),), (1,), (1,)), "backward_euler"),
        (nystrom("verlet", ((), (half,)), (half, 0), (half, half), (0, 1), ((), (half, half))), "central_difference"),
    ):
        assert (derive(mine).A - derive(theirs).A).applyfunc(cancel).is_zero_matrix
    assert derive(kutta).order == derive("rk4").order == (4, 4, 4)


def test_a_composition_of_one_step_is_that_step_and_two_halves_are_two_steps() -> None:
    one = composition("one", central_difference, (1,))
    assert (derive(one).A - derive("central_difference").A).applyfunc(cancel).is_zero_matrix
    two = derive(composition("two", central_difference, (HALF, HALF))).A.subs({"Omega": 2})
    each = derive("central_difference").A
    assert (two[:2, :] - each[:2, :] * 0).shape == (2, 3)
    scaled = each.subs({"Omega": 1})
    units = [Rational(1), Rational(2), Rational(4)]  # u, h*v, h^2*a of a step twice as long
    expected = scaled * scaled
    assert all(cancel(two[i, j] - expected[i, j] * units[i] / units[j]) == 0 for i in range(3) for j in range(3))


def test_a_composition_keeps_the_bases_parameters_and_its_loads() -> None:
    from substep_derive.declare.schemes.newmark import newmark

    two = composition("two", newmark, (Rational(1, 3), Rational(2, 3)))
    assert [p.name for p in two.parameters] == ["beta", "gamma"]
    assert [b.load for b in two.balances] == [f(Rational(1, 3)), f(1)]
    assert derive(two.fix({"beta": "1/4", "gamma": "1/2"})).order == (2, 2, 2)


@pytest.mark.matrix
@pytest.mark.parametrize("name", tables.COMPOSITIONS)
def test_compositions_are_symmetric_and_keep_areas(name: str) -> None:
    """Undamped: a step of -h undoes a step of h, and the map of u and h*v has the determinant 1, for every weight."""
    d, half = derive(name), Rational(1, 2)
    A = d.A.subs("xi", 0)
    to_uv = A[:2, :2] - A[:2, 2] * Matrix([[Omega**2, 0]])  # a_0 = -Omega^2 u_0
    back = Matrix(2, 2, lambda i, j: to_uv[i, j] * (-1) ** (i + j))  # of -h: h*v changes its sign
    values = dict.fromkeys(d.scheme.values, half)
    assert reduced(to_uv.det().subs(values)).factor() == 1
    assert (to_uv * back).subs(values).applyfunc(lambda e: cancel(reduced(e))) == eye(2)


def test_two_irrational_numbers_need_one_generator() -> None:
    other = Parameter(Symbol("w"), Interval(1, 2), Root(Symbol("w") ** 2 - 2))
    own = Parameter(gamma, Interval(0, 1), Root(2 * gamma**2 - 4 * gamma + 1))
    with pytest.raises(DeclarationError, match="two irrational numbers"):
        tableau("two", ((gamma,), (1 - gamma, gamma)), (1 - gamma, gamma), (gamma, 1), parameters=(own, other))


HEUN = (((), (1,)), (HALF, HALF), (0, 1))
VERLET: dict[str, Any] = {"A_bar": ((), (HALF,)), "b_bar": (HALF, 0), "b": (HALF, HALF), "c": (0, 1)}
WRONG: list[tuple[Callable[[], Any], str]] = [
    (lambda: tableau("t", ((), (1,)), (HALF, HALF), (0, HALF)), "row 2 of A to sum to 1/2, got 1; correct"),
    (lambda: tableau("t", ((), (1,)), (HALF, HALF, 0), (0, 1)), "expected 2 entries in b, as in c, got 3"),
    (lambda: tableau("t", ((), (1,), (1,)), (HALF, HALF), (0, 1)), "expected 2 rows in A.*got 3 rows of 0, 1, 1"),
    (lambda: tableau("t", (), (), ()), "expected at least one entries in c"),
    (lambda: tableau("t", HEUN[0], (HALF, 1), HEUN[2]), "the entries of b to sum to 1, got 3/2"),
    (lambda: tableau("t", HEUN[0], (0.5, 0.5), HEUN[2]), "exact entries in b, got the float 0.5.*write Rational"),
    (lambda: tableau("t", ((), (gamma,)), (HALF, HALF), (0, gamma)), "holds gamma; declare parameters="),
    (lambda: tableau("t", *HEUN, b_hat=(HALF, HALF)), "b_hat of another order than b.*got order 2 for both"),
    (lambda: tableau("t", *HEUN, b_hat=(1, 1)), "the entries of b_hat to sum to 1, got 2"),
    (lambda: tableau("t", *HEUN, b_hat=("x", 1)), "expected an expression in symbols"),
    (lambda: nystrom("t", **{**VERLET, "A_bar": ((), (1,))}), "twice the entries of row 2 of A_bar to sum to 1, got 2"),
    (lambda: nystrom("t", **{**VERLET, "b_bar": (1, 0)}), "the entries of b_bar to sum to 1/2, got 1"),
    (lambda: nystrom("t", **VERLET, A=((), (HALF,))), "row 2 of A to sum to 1, got 1/2"),
    (lambda: nystrom("t", **VERLET, b_hat=(HALF, HALF)), "b_hat of another order than b"),
    (lambda: nystrom("t", **VERLET, b_bar_hat=(0, HALF)), "b_bar_hat of another order than b_bar"),
    (lambda: composition("t", central_difference, (HALF, 1)), "the weights to sum to 1, got 3/2"),
    (lambda: composition("t", central_difference, (0.5, 0.5)), "exact entries in weights"),
    (lambda: composition("t", central_difference, ()), "at least one entries in weights"),
    (lambda: composition("t", central_difference, [Fraction(1, 50)] * 50), "at most 40 stages or steps, got 50"),
    (lambda: composition("t", BY_NAME["houbolt"], (1,)), "expected a one-step scheme to compose.*got houbolt"),
    (lambda: composition("t", BY_NAME["kr_alpha"], (1,)), "goes on with the u_1, v_1, a_1 that it reports"),
]


@pytest.mark.parametrize(("call", "message"), WRONG)
def test_a_wrong_table_is_refused_with_the_cure(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(DeclarationError, match=message):
        call()


def test_schemes_without_damping_are_these_and_are_refused_by_name_where_there_is_damping() -> None:
    assert set(UNDAMPED) == {"rkn43", "rkn64", "stoermer_extrapolation", "suzuki", "yoshida6"}
    message = "rkn64 is a scheme for u'' = g"
    with pytest.raises(DeclarationError, match=message):
        certify("rkn64", xi="1/20")
    with pytest.raises(DeclarationError, match=message):
        certify_all_damping("rkn64")
    with pytest.raises(DeclarationError, match=f"{message}.*got linear_oscillator"):
        catalogue_pair(BY_NAME["rkn64"], EquationsOfMotion(find_scene("linear_oscillator")))
    s, damped = ss.scheme("rkn64"), ss.scene("linear_oscillator", omega=2.0, xi=0.05)
    with pytest.raises(ValueError, match=f"{message}.*got 0.05"):
        ss.march(damped, s, dt=0.1, t_end=1.0)
    with pytest.raises(ValueError, match=message):
        ss.response_spectrum(np.sin(np.arange(50.0)), 0.1, [1.0, 2.0], [0.0, 0.05], s)
    with pytest.raises(ValueError, match=message):
        s.coefficients(0.5, [0.0, 0.1])
    found = s.stability([0.5, 0.5], [0.0, 0.1])
    assert all(np.isfinite(x[0]) and np.isnan(x[1]) for x in found)
    assert s.period_error(0.5) == pytest.approx(0.0, abs=1e-6)


def test_a_run_without_damping_is_as_accurate_as_its_order() -> None:
    """Eight digits a period with 12 evaluations of the order 8, on the oscillator."""
    r = ss.march(ss.scene("linear_oscillator", omega=2 * np.pi), ss.scheme("stoermer_extrapolation"), dt=0.1, t_end=1.0)
    assert abs(r.u[-1, 0] - 1) < 1e-7
