"""A declaration with a mistake gets an error that names it."""

from typing import Any

import pytest
from declared import BY_NAME
from substep_derive import Balance, DeclarationError, Parameter, Scheme, certify, derive
from substep_derive.algebra.exact_number import exact_number
from substep_derive.declare.schemes.multi_step import backward_differences
from substep_derive.declare.symbols import N, f, gamma, h, knot
from sympy import Abs, I, Interval, Rational, Symbol, pi, sin, sqrt

import substep as ss

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
half = Rational(1, 2)
GOOD = {u1: u0 + h * v0 + h**2 / 4 * (a0 + a1), v1: v0 + h / 2 * (a0 + a1)}


def test_a_good_declaration_derives() -> None:
    assert derive(Scheme("good", GOOD, (Balance.at(end, 1),))).A == derive("newmark", beta="1/4", gamma="1/2").A


def test_undeclared_parameter() -> None:
    with pytest.raises(DeclarationError, match="'gamma' is neither"):
        Scheme("bad", {**GOOD, v1: v0 + h * (1 - gamma) * a0 + h * gamma * a1}, (Balance.at(end, 1),))


def test_unknown_that_no_relation_defines() -> None:
    with pytest.raises(DeclarationError, match=r"without a relation of their own: .*v_1.*relation is missing"):
        Scheme("bad", {u1: GOOD[u1]}, (Balance.at(end, 1),))


def test_a_relation_too_many() -> None:
    with pytest.raises(DeclarationError, match="relation too many"):
        Scheme("bad", {**GOOD, a1: a0}, (Balance.at(end, 1),))


def test_a_relation_that_repeats_another() -> None:
    ug = Symbol("u_g")
    twice = {u1: ug, ug: u1, v1: GOOD[v1]}
    with pytest.raises(DeclarationError, match="not determined"):
        derive(Scheme("bad", twice, (Balance.at(end, 1),))).den


def test_a_relation_that_is_not_linear() -> None:
    with pytest.raises(DeclarationError, match=r"relation of v_1 as a linear combination .* got a_1\*v_0"):
        Scheme("bad", {**GOOD, v1: v0 * a1}, (Balance.at(end, 1),))


@pytest.mark.parametrize("odd", [sqrt(2), 0.25, pi, sqrt(gamma), 2**gamma, Abs(gamma), sin(1), I], ids=str)
def test_a_coefficient_that_is_not_rational(odd: Any) -> None:
    inside = Parameter(gamma, Interval.open(0, 1), half)
    for bad in ({v1: v0 + h * odd * (a0 + a1)}, {v1: v0 + h * (a0 + a1) / (1 + odd)}):
        with pytest.raises(DeclarationError, match=r"neither rational .* as the default of a Parameter"):
            Scheme("bad", {**GOOD, **bad}, (Balance.at(end, 1),), (inside,))
    for bad in (Balance(odd * a1, v1, N(u1), f(1)), Balance(a1, v1, odd * N(u1), f(1))):
        with pytest.raises(DeclarationError, match="neither rational"):
            Scheme("bad", GOOD, (bad,), (inside,))
    chosen = Parameter(gamma, Interval.open(0, 2), sqrt(2) / 2)  # which is the way to have one
    derive(Scheme("good", {**GOOD, v1: v0 + h * ((1 - gamma) * a0 + gamma * a1)}, (Balance.at(end, 1),), (chosen,)))


def test_balances_in_the_wrong_order() -> None:
    inner = knot("g")
    relations = {
        inner.u: u0 + h / 2 * v0 + h**2 / 16 * (a0 + inner.a),
        inner.v: v0 + h / 4 * (a0 + inner.a),
        u1: inner.u + h / 2 * inner.v,
        v1: inner.v + h / 4 * (inner.a + a1),
    }
    with pytest.raises(DeclarationError, match="balance 1 reads .* later"):
        derive(Scheme("bad", relations, (Balance.at(end, 1), Balance.at(inner, half)))).balances


def test_a_state_that_is_not_carried_over() -> None:
    vm = knot(-1).v
    with pytest.raises(DeclarationError, match="no relation defines"):
        Scheme("bad", {u1: u0 + h * vm, Symbol("v_q"): h * a1}, (Balance(a1, v0, N(u1), f(1)),), start={vm: v0})


def test_a_start_with_irrational_numbers() -> None:
    """Those of butcher6 are no numbers of the field in which the started scheme's errors are computed."""
    with pytest.raises(DeclarationError, match=r"rational numbers to start it, got butcher6 with the constant theta"):
        backward_differences(6, BY_NAME["butcher6"], BY_NAME["bdf4"].published)


def test_a_start_that_says_nothing_of_the_history() -> None:
    vm = knot(-1).v
    with pytest.raises(DeclarationError, match=r"reads v_-1, for which start says nothing"):
        Scheme("bad", {u1: u0 + h * vm, v1: GOOD[v1]}, (Balance.at(end, 1),))


def test_parameters_are_exact_and_inside_their_interval() -> None:
    assert exact_number("0.2") == Rational(1, 5)
    with pytest.raises(TypeError, match="write it as text"):
        exact_number(0.2)
    for text in ("__import__('os')", "1/0", "x", "nan"):
        with pytest.raises(ValueError, match="expected a rational"):
            exact_number(text)
    with pytest.raises(DeclarationError, match="outside"):
        derive("newmark_bdf2", gamma_t=1)
    with pytest.raises(DeclarationError, match="no parameter 'delta'"):
        derive("newmark", delta=1)
    with pytest.raises(DeclarationError, match="expected a scheme"):
        derive("newmarc")


def test_what_is_no_scheme_of_the_catalogue_is_named_before_those_that_are() -> None:
    with pytest.raises(
        DeclarationError, match=r"^expected a scheme, got 'newmarc'; did you mean 'newmark'\? near are: "
    ):
        derive("newmarc")
    with pytest.raises(
        DeclarationError, match=r"got Scheme\(newmark, .*\); of a handle, pass its name, .* as text such"
    ):
        certify(ss.scheme("newmark", gamma=0.6))  # pyright: ignore


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_a_value_that_is_not_finite_is_refused_without_the_advice_to_write_it_as_text(value: float) -> None:
    for given in ({"beta": value}, {"beta": str(value)}, {"xi": value}):
        with pytest.raises(ValueError, match=f"expected a rational number such as .*, got '?{value}") as refused:
            certify("newmark", **given)
        assert "write it as text" not in str(refused.value)
    with pytest.raises(TypeError, match=r"write it as text, '0.3'"):
        certify("newmark", beta=0.3)
