"""A second value that a declaration gives is the special case of an estimator."""

from dataclasses import replace

import pytest
from substep_derive import Balance, NoEstimator, Scheme, estimator, h, knot
from sympy import Expr, Rational, factor

u0, v0, a0 = knot(0)
ups = [knot(label) for label in "pq"]
(up, vp, ap), (uq, vq, aq) = ups
u1, v1, a1 = end = knot(1)


def bogacki_shampine(first: tuple[str, ...], second: tuple[str, ...] | None) -> Scheme:
    """Bogacki & Shampine, Appl. Math. Lett. 2 (1989) 321-325; its last stage is the first of the next step."""
    rates = (v0, vp, vq, v1), (a0, ap, aq, a1)

    def combined(start: Expr, of: tuple[Expr, ...], weights: tuple[str, ...]) -> Expr:
        return start + h * sum(Rational(w) * x for w, x in zip(weights, of, strict=False))

    return Scheme(
        "bogacki_shampine_here",
        relations={
            up: combined(u0, rates[0], ("1/2",)),
            vp: combined(v0, rates[1], ("1/2",)),
            uq: combined(u0, rates[0], ("0", "3/4")),
            vq: combined(v0, rates[1], ("0", "3/4")),
            u1: combined(u0, rates[0], first),
            v1: combined(v0, rates[1], first),
        },
        balances=(Balance.at(knot(0), 0), Balance.at(ups[0], Rational(1, 2)), Balance.at(ups[1], Rational(3, 4)))
        + ((Balance.at(end, 1),) if second else ()),
        embedded={u1: combined(u0, rates[0], second), v1: combined(v0, rates[1], second)} if second else {},
    )


THIRD, SECOND = ("2/9", "1/3", "4/9"), ("7/24", "1/4", "1/3", "1/8")


def test_a_second_value_of_lower_order_estimates_its_own_error() -> None:
    scheme = bogacki_shampine(THIRD, SECOND)
    found = estimator(scheme)
    assert found.order == (2, 2)
    assert found.displacement.of == "the second value of u_1"
    assert factor(found.u - (scheme.embedded[u1] - u1)) == 0
    assert factor(found.v - (scheme.embedded[v1] - v1)) == 0
    assert found.extra is None


def test_a_second_value_of_higher_order_estimates_the_error_of_the_first() -> None:
    """Heun's second order beside Bogacki and Shampine's third, which is one member of the family of all."""
    third = bogacki_shampine(THIRD, SECOND)
    scheme = replace(
        third,
        name="second_here",
        relations={**third.relations, u1: u0 + h * vp, v1: v0 + h * ap},
        balances=third.balances[:3],
        embedded={u1: third.relations[u1], v1: third.relations[v1]},
    )
    found = estimator(scheme)
    assert found.order == (2, 2)
    assert found.displacement.of == "u_1"
    assert factor(found.u - (u1 - third.relations[u1])) == 0
    family, alone = found.displacement.family, estimator(replace(scheme, name="alone", embedded={}))
    assert family is not None and family.contains(found.u) and alone.displacement.family is not None
    assert alone.displacement.family.contains(found.u) and alone.extra is None
    assert family.contains(alone.u)


def test_a_second_value_that_is_the_first_is_refused() -> None:
    scheme = bogacki_shampine(THIRD, SECOND)
    same = replace(scheme, embedded={u1: u1, v1: v1})
    with pytest.raises(NoEstimator, match="expected a second value of u_1 of another order, got u_1 itself"):
        estimator(same)
