"""Irrational numbers of a table that are no parameters: their arithmetic, and what is derived and printed with them.

Oracles: mpmath with 60 digits, and the same scheme with a root as the default of a parameter.
"""

import pickle
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest
from substep_derive import Constant, DeclarationError, Parameter, Root, Scheme, certify, composition, derive, tableau
from substep_derive.algebra import rational
from substep_derive.algebra.constant import approximated, reduced
from substep_derive.algebra.rational import RationalFunctions
from substep_derive.declare.schemes.newmark import central_difference
from sympy import Expr, Interval, Matrix, Poly, Rational, Symbol, cbrt, root, sqrt, symbols
from sympy.abc import x, y

import substep as ss

MP = mpmath.mp.clone()
MP.dps = 60
HALF = Rational(1, 2)
THETA = Constant("theta", cbrt(2))
CUBE_ROOT = MP.cbrt(2)
GAMMA = Constant("gamma", 1 - sqrt(2) / 2)


def value(e: Expr, **others: Any) -> Any:
    """An expression at theta, in mpmath."""
    numbers = {"theta": CUBE_ROOT, **others}
    s = sorted(e.free_symbols | {THETA}, key=str)
    total = MP.mpf(0)
    for powers, c in Poly(e, *s).terms():
        term = MP.mpf(int(c.p)) / int(c.q)
        for symbol, power in zip(s, powers, strict=True):
            term *= numbers[symbol.name] ** power
        total += term
    return total


def forest_ruth() -> Scheme:
    w = 1 / (2 - THETA)
    return composition("forest_ruth_constant", central_difference, (w, 1 - 2 * w, w))


def sdirk2() -> Scheme:
    return tableau("sdirk2_constant", ((GAMMA,), (1 - GAMMA, GAMMA)), (1 - GAMMA, GAMMA), (GAMMA, 1))


def test_a_constant_is_its_number_and_no_other() -> None:
    again = pickle.loads(pickle.dumps(THETA))
    assert again == THETA and hash(again) == hash(THETA) and again.number == THETA.number
    assert Constant("theta", sqrt(2)) != THETA
    assert Symbol("theta") != THETA
    assert abs(MP.mpf(THETA.approximation.p) / THETA.approximation.q - CUBE_ROOT) < 1e-14
    with pytest.raises(ValueError, match="expected an irrational number"):
        Constant("theta", Rational(1, 2))
    with pytest.raises(ValueError, match="expected a real number"):
        Constant("theta", sqrt(-2))


def test_numbers_have_one_form() -> None:
    assert reduced(THETA**3) == 2
    assert reduced(1 / (2 - THETA)) == (THETA**2 + 2 * THETA + 4) / 6
    assert reduced((x + THETA) * (x**2 - THETA * x + THETA**2)) == x**3 + 2
    quotient = Matrix([(x**2 - THETA**2) / (THETA * x)])
    assert rational.same(quotient, Matrix([(THETA**2 * x**2 / 2 - THETA) / x]))
    assert not rational.same(quotient, Matrix([THETA**2 * x / 2]))


def test_matrices_over_the_field_of_a_constant() -> None:
    """One row without a pivot that is a number, two with one: both ways of elimination."""
    matrix = Matrix([[x, THETA, 1], [THETA, x * y, x], [1 + x**2, y, THETA * x]])
    right = Matrix([1, THETA, x])
    numerators, den = rational.solve(matrix, right)
    assert rational.same(matrix * numerators, den * right)
    assert not rational.same(matrix * numerators, den * right * 2)
    assert reduced(rational.determinant(matrix) - matrix.det()) == 0
    permuted = Matrix([[0, 0, THETA], [THETA, 0, 0], [0, 1, x]])
    assert reduced(rational.determinant(permuted) - permuted.det()) == 0
    with pytest.raises(rational.SingularMatrix):
        rational.solve(Matrix([[THETA, 2], [1, THETA**2]]), Matrix([1, 1]))
    rows, den = rational.common_denominator(Matrix([[1 / (x - THETA), 1 / (x**2 - THETA**2)]]))
    assert reduced(den - (x**2 - THETA**2)) == 0
    assert rational.same(rows, Matrix([[x + THETA, 1]]))
    assert rational.quotient(x**3 - 2, x - THETA) == x**2 + THETA * x + THETA**2
    assert rational.quotient(x**3 - 3, x - THETA) is None
    primitive = rational.primitive((x - THETA) * (2 * THETA * y + 4), y)
    assert reduced(primitive.as_expr() - (y + THETA**2)) == 0


def test_rational_functions_over_the_field_of_a_constant() -> None:
    functions = RationalFunctions(symbols("x y"), THETA)
    e = (x**2 - THETA**2) / (y * (x - THETA))
    assert functions.number(e) == functions.number((x + THETA) / y)
    assert functions.expression(functions.number(e)) == (x + THETA) / y
    with pytest.raises(ValueError, match="expected symbols besides the constant theta"):
        RationalFunctions((), THETA)


def test_printed_numbers_are_nearer_than_pairs_of_doubles() -> None:
    """And what cancels by the constant's equation alone is gone, not small."""
    e = (THETA**2 - Rational(5, 3)) * x**2 + (63 * THETA - 50 * THETA**2) * x + (THETA**3 - 2) * y + Rational(1, 3)
    near = Poly(approximated(e), x)
    assert near.free_symbols == {x}
    assert near.coeff_monomial(1) == Rational(1, 3)
    for power, c in ((2, THETA**2 - Rational(5, 3)), (1, 63 * THETA - 50 * THETA**2)):
        found = near.coeff_monomial(x**power)
        assert abs(MP.mpf(int(found.p)) / int(found.q) / value(c) - 1) < MP.mpf(2) ** -106


def test_declarations_take_one_irrational_number() -> None:
    a, b = Constant("a", sqrt(2)), Constant("b", sqrt(3))
    with pytest.raises(DeclarationError, match="two: expected one algebraic constant, got a, b"):
        composition("two", central_difference, (a / 4, b / 4, 1 - a / 4 - b / 4))
    weight = Symbol("weight")
    parameter = Parameter(weight, Interval(0, 1), Root(2 * weight**2 - 1))
    with pytest.raises(DeclarationError, match="two irrational numbers"):
        composition("both", central_difference, (weight, a / 4, 1 - weight - a / 4), parameters=(parameter,))
    with pytest.raises(DeclarationError, match="weights to sum to 1"):
        composition("sum", central_difference, (a / 4, a / 4))


def test_a_constant_stands_in_steps_alone_under_a_name_of_its_own() -> None:
    u0, v0, a0 = symbols("u_0 v_0 a_0")
    with pytest.raises(DeclarationError, match="expected a start from rational numbers and parameters, got the const"):
        replace(central_difference, name="own", start={a0: THETA * a0, v0: v0, u0: u0})
    entry = 1 - sqrt(2) / 2
    beta = Parameter(Symbol("beta"), Interval(0, 1), HALF)
    with pytest.raises(DeclarationError, match="beta"):
        tableau("own", ((Constant("beta", entry),),), (1,), (beta.symbol,), parameters=(beta,))
    for name in ("h", "Omega", "xi"):
        with pytest.raises(DeclarationError, match=name):
            composition("own", central_difference, (Constant(name, entry), 1 - Constant(name, entry)))


def test_a_constant_and_a_parameter_give_one_scheme() -> None:
    """Forest and Ruth's scheme, damped: weight is a parameter in the catalogue."""
    own = derive(forest_ruth())
    assert own.scheme.parameters == ()
    assert own.symbols.keys() == {"Omega", "xi"}
    w, at = 1 / (2 - CUBE_ROOT), {"Omega": MP.mpf(3) / 4, "xi": MP.mpf(1) / 5}
    other = derive("forest_ruth")
    for mine, theirs in zip(own.N, other.N, strict=True):
        wanted = value(theirs, weight=w, **at) / value(other.den, weight=w, **at)
        assert abs(value(mine, **at) / value(own.den, **at) - wanted) < MP.mpf(10) ** -50
    assert own.order == other.order == (4, 4, 4)
    assert own.nonlinear.uva == (4, 4, 4)
    assert (own.nonlinear.symmetric.word, own.nonlinear.symplectic.word) == ("yes", "yes")
    assert certify(own.scheme).critical_Omega == certify("forest_ruth").critical_Omega
    assert "theta = r" in certify(own.scheme).text


@pytest.mark.parametrize(("made", "name"), [(forest_ruth, "forest_ruth"), (sdirk2, "sdirk2")])
def test_kernels_of_both_agree(made: Any, name: str) -> None:
    """Within roundings of the catalogue's kernels, whose parameter is a double."""
    mine, theirs = ss.scheme(made()), ss.scheme(name)
    Omega = np.array([0.05, 0.4, 1.3])
    np.testing.assert_allclose(mine.amplification(Omega, xi=0.1), theirs.amplification(Omega, xi=0.1), atol=4e-15)
    np.testing.assert_allclose(mine.spectral_radius(Omega, xi=0.1), theirs.spectral_radius(Omega, xi=0.1), atol=4e-15)
    scene = ss.scene("duffing")
    runs = [ss.march(scene, s, dt=0.05, t_end=2.0) for s in (mine, theirs)]
    np.testing.assert_allclose(runs[0].u, runs[1].u, atol=1e-13)


def test_a_rule_of_higher_degree_holds_constants() -> None:
    """Two half steps of sdirk2, written by R of degree 4, are two steps of the catalogue's sdirk2."""
    twice = composition("twice", sdirk2(), (HALF, HALF))
    whole, part = ss.scheme(twice), ss.scheme("sdirk2")
    for Omega, xi in ((0.3, 0.0), (2.0, 0.3)):
        scale = np.diag([1.0, 0.5])  # h*v of half a step
        once = np.linalg.inv(scale) @ np.squeeze(part.amplification(Omega / 2, xi=xi))[:2, :2] @ scale
        np.testing.assert_allclose(np.squeeze(whole.amplification(Omega, xi=xi))[:2, :2], once @ once, atol=1e-14)


def test_yoshida_in_digits() -> None:
    """The radicals of Yoshida's weights in 60 digits against the declared instants of its loads."""
    inner, outer = 1 / (2 - MP.cbrt(2)), 1 / (2 - MP.root(2, 5))
    weights = [o * i for o in (outer, 1 - 2 * outer, outer) for i in (inner, 1 - 2 * inner, inner)]
    theta = MP.root(2, 15)
    instants = [value(tau, theta=theta) for tau in derive("yoshida6").stencil]
    ends = [sum(weights[: k + 1]) for k in range(9)]
    assert len(instants) == 9
    for found, wanted in zip(sorted(instants), sorted(ends), strict=True):
        assert abs(found - wanted) < MP.mpf(10) ** -55
    assert max(abs(w) for w in weights) > 2  # steps of twice the length, backwards and forwards
    assert Constant("theta", root(2, 15)).definition == "theta is the root of theta**15 - 2 in [1, 2]"
