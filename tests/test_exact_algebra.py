"""Exact algebra against identities of its own: elimination, sparse combinations, reading, zeros over Q(r), series."""

import random
from itertools import combinations
from typing import Any

import pytest
from substep_derive.algebra import rational
from substep_derive.algebra.algebraic import Algebraic, Field, RealRoot, generator
from substep_derive.algebra.constant import Constant
from substep_derive.algebra.expanded import coefficients, polynomial_in, terms
from substep_derive.algebra.points import RootPoint, ring_over
from substep_derive.declare.catalogue import find
from substep_derive.declare.symbols import Omega, xi
from substep_derive.estimate import sparse
from substep_derive.nonlinear.order import _order, nonlinear_order
from substep_derive.nonlinear.step import StepSeries
from substep_derive.oscillator.evaluation import Evaluation
from sympy import (
    QQ,
    CoercionFailed,
    Expr,
    Integer,
    Matrix,
    Poly,
    PolynomialError,
    Rational,
    cancel,
    expand,
    factor,
    gcd_list,
    symbols,
    together,
)

x, y = symbols("x y")
ROOT = Constant("q", Algebraic((1, 0, 0, -2), (1, 2)))  # the cube root of 2


def random_matrix(rng: random.Random, rows: int, columns: int, number: Expr) -> Matrix:
    shown = [Integer(0)] * 4 + [Integer(1), Rational(-2, 3), x, y - x / 2, x * y + number, x**2 - y, 1 / (1 + x)]
    return Matrix(rows, columns, lambda i, j: rng.choice(shown))


@pytest.mark.parametrize("number", [Rational(5, 7), ROOT])
def test_solutions_satisfy_their_equations_and_have_no_factor_in_common(number: Expr) -> None:
    rng, regular = random.Random(3), 0
    for n in (1, 2, 3, 4, 4) * 3:
        matrix, right = random_matrix(rng, n, n, number), random_matrix(rng, n, 2, number)
        cleared = rational.clear_rows(matrix)
        determinant = rational.determinant(matrix)
        assert rational.same(Matrix([determinant]), Matrix([cleared.det(method="berkowitz").expand()]))
        if rational.same(Matrix([determinant]), Matrix([0])):
            with pytest.raises(rational.SingularMatrix):
                rational.solve(matrix, right)
            continue
        regular += 1
        numerators, den = rational.solve(matrix, right)
        assert rational.same(matrix * numerators, den * right)
        twice, below = rational.cancelled((numerators * (x + 1)).applyfunc(expand), expand(den * (x + 1)))
        assert rational.same(twice * den, numerators * below)
        assert expand(below - den) == 0 or expand(below + den) == 0
        if number is not ROOT:
            assert gcd_list([*numerators, den]) in (1, -1)
    assert regular > 4


def spans(columns: list[list[int]], right: list[int], p: int) -> bool:
    """Whether the right side is a combination of the columns modulo p: both matrices have the same rank."""

    def rank(vectors: list[list[int]]) -> int:
        rows, found = [list(v) for v in vectors], 0
        for place in range(len(right)):
            pivot = next((r for r in rows if r[place]), None)
            if pivot is None:
                continue
            found += 1
            rows = [
                [(a - r[place] * pow(pivot[place], -1, p) * b) % p for a, b in zip(r, pivot, strict=True)]
                for r in rows
                if r is not pivot
            ]
        return found

    return rank(columns) == rank([*columns, right])


@pytest.mark.parametrize("p", [5, 101, 2**31 - 1])
def test_the_sparsest_combinations_are_all_of_the_smallest_sets(p: int) -> None:
    rng, sizes = random.Random(p), set()
    for _ in range(60):
        rows, count = rng.randint(1, 5), rng.randint(1, 7)
        columns = [[rng.choice((0, 0, 1, 2, rng.randrange(p))) for _ in range(rows)] for _ in range(count)]
        columns += [[2 * a % p for a in columns[0]]]  # two that are multiples of each other
        factors = [rng.choice((0, 1, rng.randrange(p))) for _ in columns]
        right = [sum(f * c[i] for f, c in zip(factors, columns, strict=True)) % p for i in range(rows)]
        holding = (
            [k for k in combinations(range(len(columns)), size) if spans([columns[i] for i in k], right, p)]
            for size in range(len(columns) + 1)
        )
        wanted = next(sets for sets in holding if sets)
        assert sparse.sparsest(columns, right, p) == wanted
        sizes.add(len(wanted[0]))
    assert {0, 1, 2, 3} <= sizes


def test_a_search_that_takes_too_long_finds_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    p, rng = 2**31 - 1, random.Random(1)
    columns = [[rng.randrange(p) for _ in range(4)] for _ in range(12)]
    right = [sum(column[i] for column in columns) % p for i in range(4)]
    assert len(sparse.sparsest(columns, right, p)[0]) == 4
    monkeypatch.setattr(sparse, "MOST_VISITED", 3)
    assert sparse.sparsest(columns, right, p) == []


@pytest.mark.parametrize(
    "e", [Integer(0), Rational(-3, 4), x, 2 * x**3 * y - y / 3 + 1, (x + y) ** 3 / 2, x * (y - 1) + y * (1 - x)]
)
def test_polynomials_are_read_as_sympy_reads_them(e: Expr) -> None:
    read = Poly(e, x, y, domain=QQ)
    assert Poly.from_dict(terms(e, (x, y)), x, y, domain=QQ) == read
    assert all(terms(e, (x, y)).values())
    assert coefficients(e, x) == Poly(e, x).all_coeffs()
    assert coefficients(together(e / y).expand(), x) == Poly(together(e / y).expand(), x).all_coeffs()
    for one, variable in ((e, x), (e.expand(), x), (expand(e * Omega * xi - y), xi), (e / y, x)):
        assert (found := polynomial_in(variable, one)) == Poly(one, variable)
        assert found.domain == Poly(one, variable).domain


@pytest.mark.parametrize(
    "den", [Integer(-6), 2 - 2 * x, 4 * x * y - 4 * y, expand((x - y) ** 2 * (1 - x) * Rational(3, 2))]
)
def test_fractions_are_cancelled_and_factored_as_sympy_does(den: Expr) -> None:
    numerators = Matrix([[0, 3, x - 1], [2 - 2 * x**2, expand((y - x) * (3 * x + 6 * y)), x * y / 2 - y / 2]])
    assert rational.in_factors(numerators, den) == (numerators / den).applyfunc(lambda e: factor(cancel(e)))
    assert rational.in_factors(Matrix([[2, 0]]), Integer(-6)) == Matrix([[Rational(-1, 3), 0]])


def test_what_is_no_polynomial_is_refused() -> None:
    for e in (1 / x, 2**x, x * Omega):
        with pytest.raises((PolynomialError, CoercionFailed)):
            terms(e, (x, y))


def at_root(field: Field, polynomial: Poly) -> tuple[RootPoint, Any]:
    ring = ring_over(field, Omega)
    return RootPoint(field, RealRoot(polynomial, 1, 2), ring), ring.gens[0]


def test_a_zero_over_an_extension_is_told_from_a_number_that_is_nearly_zero() -> None:
    field = Field(Algebraic((1, 0, 0, 0, -2), (1, 2)))  # r, the fourth root of 2
    r, v = field.domain.unit, Poly(generator**8 - 2, generator)
    at, w = at_root(field, v)  # its square is r
    for number, sign in (
        (w**2 - r, 0),  # a simple root of the norm
        ((w**2 - r) ** 2, 0),  # a double one
        ((w**2 - r) * (w - 1), 0),
        (w**2 + r, 1),  # a conjugate vanishes there, not this number
        (w**2 - r + QQ(1, 10**40), 1),
        (r - w**2 + QQ(-1, 10**40), -1),
        ((w**2 + r) * QQ(1, 10**40), 1),
    ):
        fresh, _ = at_root(field, v)
        assert fresh.sign(fresh.value(number)) == at.sign(at.value(number)) == sign
        decided = fresh._by_norm(number)  # wherever it decides, it agrees
        assert decided is None or decided == (sign == 0)
    assert at_root(field, v)[0]._by_norm(w**2 - r) is True
    assert at_root(field, v)[0]._by_norm(w**2 + r) is False
    assert at_root(field, v)[0]._by_norm((w**2 - r) ** 2) is None


def test_numbers_at_a_damping_ratio_are_those_of_the_polynomial_there() -> None:
    at = Evaluation.at_defaults("newmark")
    polynomial = at.amplification.step.den
    third = at.field.domain.convert(QQ(1, 3))
    for _ in range(2):  # the second time from what was read before
        assert at.coefficients(polynomial, third) == at.coefficients(polynomial.subs(xi, Rational(1, 3)).expand())
    assert any(power for _, power in at.coefficients(polynomial))


@pytest.mark.parametrize("name", ["noh_bathe", "rk4", "sdirk2", "houbolt", "rkn43", "generalized_alpha", "kr_alpha"])
def test_orders_without_damping_or_load_are_those_of_their_own_series(name: str) -> None:
    at = Evaluation.at_defaults(find(name))
    found, step = nonlinear_order(at), StepSeries(at)
    kinds = {"free": (False, False), "damped": (True, False), "forced": (False, True), "uva": (True, True)}
    for kind, parts in kinds.items():
        assert getattr(found, kind) == _order(step, parts, 10, {})[0], kind
