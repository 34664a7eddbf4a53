"""Signs of polynomials at exact points, and Hurwitz's verdict on where roots lie: what certificates are made of."""

from typing import Any

import pytest
from substep_derive.algebra.algebraic import Algebraic, Field, RealRoot
from substep_derive.algebra.points import RationalPoint, RootPoint, point, positive_roots, ring_over, simplest_between
from substep_derive.stability.hurwitz import Hurwitz, Verdict, verdict
from sympy import QQ, Poly, Symbol
from sympy.abc import x

SQRT_3 = Algebraic((1, 0, -3), (1, 2))


def test_simplest_rational_between() -> None:
    for low, high, expected in [("0", "1", "1/2"), ("1/3", "1/2", "2/5"), ("2/5", "4", "1"), ("3", "22/7", "25/8")]:
        ends = (QQ(*map(int, (*text.split("/"), "1")[:2])) for text in (low, high))
        assert str(simplest_between(*ends)) == expected


def test_zero_over_an_algebraic_field_is_found() -> None:
    """x^2 - 3 is irreducible over Q but not over Q(sqrt 3): a remainder that is not 0 may stand for 0."""
    field = Field(SQRT_3)
    ring = ring_over(field, Symbol("w"))
    w, s = ring.gens[0], field.domain.unit
    root = RealRoot(Poly(x**2 - 3, x), 1, 2)
    at = point(field, root, ring)
    assert isinstance(at, RootPoint)
    assert at.sign(at.value((w - s) * (w + 1))) == 0
    assert at.sign(at.value(w + s)) == 1
    fresh = point(field, RealRoot(Poly(x**2 - 3, x), 1, 2), ring)
    assert fresh.sign(fresh.value(w + s)) == 1
    assert fresh.sign(fresh.value(w - s + QQ(1, 10**40))) == 1
    assert fresh.sign(fresh.value(w - s - QQ(1, 10**40))) == -1
    assert [r.rational for r in positive_roots(field, [w**2 - s * w, w**2 - 4], ring)] == [None, 2]
    assert not positive_roots(field, [w + s], ring)


def rooted(*factors: tuple[int, ...]) -> list[Any]:
    """h as a product of polynomials in s, coefficients from the lowest, constants over Q[w]."""
    product = [1]
    for factor in factors:
        product = [
            sum(product[i] * factor[k - i] for i in range(len(product)) if 0 <= k - i < len(factor))
            for k in range(len(product) + len(factor) - 1)
        ]
    ring = ring_over(Field(), Symbol("w"))
    return [ring.one * c for c in product]


INSIDE, OUT, PAIR, OTHER, OFF = (1, 1), (-1, 1), (1, 0, 1), (4, 0, 1), (5, 2, 1)


@pytest.mark.parametrize(
    ("factors", "expected"),
    [
        ([INSIDE, OFF, (7, 1)], Verdict.INSIDE),
        ([INSIDE, OFF, OFF, INSIDE], Verdict.INSIDE),
        ([INSIDE, PAIR], Verdict.SIMPLE),
        ([PAIR, OTHER, INSIDE, OFF], Verdict.SIMPLE),
        ([PAIR, OTHER, (9, 0, 1)], Verdict.SIMPLE),
        ([PAIR, PAIR], Verdict.MULTIPLE),
        ([PAIR, PAIR, OTHER, OFF], Verdict.MULTIPLE),
        ([(0, 1), PAIR, INSIDE], Verdict.SIMPLE),
        ([(0, 1), (0, 1), INSIDE], Verdict.MULTIPLE),
        ([INSIDE, OFF, (1, 0)], Verdict.SIMPLE),  # a leading zero: lambda = -1
        ([INSIDE, OFF, (1, 0, 0)], Verdict.MULTIPLE),
        ([(0, 1), (1, 0)], Verdict.SIMPLE),
        ([OUT, INSIDE], Verdict.OUTSIDE),
        ([OUT, INSIDE, PAIR], Verdict.OUTSIDE),
        ([OUT, OFF, OFF], Verdict.OUTSIDE),
        ([(5, -2, 1), OFF], Verdict.OUTSIDE),
        ([PAIR, (-4, 0, 1)], Verdict.OUTSIDE),
        ([PAIR, PAIR, OUT], Verdict.OUTSIDE),
        ([(1, 0, 1, 0, 1), INSIDE], Verdict.OUTSIDE),
        ([(0, 1), (0, 1), OUT], Verdict.OUTSIDE),
        ([(0,), INSIDE], Verdict.UNDEFINED),
        ([(3,)], Verdict.INSIDE),
    ],
)
@pytest.mark.parametrize("sign", [1, -1])
def test_verdicts(factors: list[tuple[int, ...]], expected: Verdict, sign: int) -> None:
    assert verdict([sign * c for c in rooted(*factors)], RationalPoint(Field(), QQ(1))) is expected


def test_shared_factor_by_minors() -> None:
    for pairs, factors in [(1, [PAIR, INSIDE, OFF]), (2, [PAIR, OTHER, INSIDE, OFF]), (2, [PAIR, OTHER, INSIDE])]:
        h = Hurwitz("h", rooted(*factors))
        assert all(not h.determinant(h.degree - 1 - 2 * k) for k in range(pairs))
        assert h.determinant(h.degree - 1 - 2 * pairs)
        shared = h.shared(pairs)
        expected = [1, 1] if pairs == 1 else [4, 5, 1]
        assert [c / shared[-1] for c in shared] == expected
