"""Declarations from which something wrong would follow: powers of h and M, sums, divisions by 0, copies, gaps."""

from collections.abc import Mapping
from typing import Any

import mpmath
import numpy as np
import pytest
from declared_steps import amplification, exact, oscillator
from substep_derive import Balance, DeclarationError, Family, Parameter, Scheme, certify, derive, prescribed
from substep_derive.declare.symbols import K0, C, M, N, Omega, f, h, knot, xi
from sympy import Expr, Interval, Rational, Symbol

u0, v0, a0 = start = knot(0)
u1, v1, a1 = end = knot(1)
um, vm, am = knot(-1)
beta, gamma, rho = map(Symbol, ("beta", "gamma", "rho"))
NEWMARK = {u1: u0 + h * v0 + h**2 / 4 * (a0 + a1), v1: v0 + h / 2 * (a0 + a1)}
AT_END = Balance.at(end, 1)
RANGE = Interval(0, 4)


def scheme(
    relations: Mapping[Symbol, Any] = NEWMARK, balance: Balance = AT_END, name: str = "bad", **more: Any
) -> Scheme:
    return Scheme(name, relations, (balance,), **more)


@pytest.mark.parametrize(
    ("relations", "what"),
    [
        ({v1: v0 + (a0 + a1) / 2}, r"relation of v_1 to hold a_0 with a number times h before it, got 1/2"),
        ({u1: u0 + h * v0 + h * (a0 + a1) / 4}, r"relation of u_1 to hold a_0 with a number times h\*\*2"),
        ({u1: u0 + v0}, r"relation of u_1 to hold v_0 with a number times h before it, got 1"),
        ({v1: v0 + h / M * (a0 + a1) / 2}, r"got h/\(2\*M\)"),
        ({v1: v0 + h * a1 * M / (M + h * K0)}, r"relation of v_1 to hold a_1"),
        ({u1: u0 + h}, r"relation of u_1 as a linear combination .* got h in h \+ u_0"),
        ({u1: u0 * v0 / v0 + h * v0**2 / 3}, r"linear combination .* v_0\*\*2"),
    ],
)
def test_powers_of_the_step_and_of_the_mass(relations: Mapping[Symbol, Expr], what: str) -> None:
    """For h = 1 and M = 1 they are average acceleration and the like, of order 2; marched they are of order 0."""
    with pytest.raises(DeclarationError, match=what):
        scheme({**NEWMARK, **relations})


@pytest.mark.parametrize(
    ("balance", "what"),
    [
        (Balance(a1, v1, h * N(u1), f(1)), r"force of balance 1 to hold N\(u_1\) with a number before it, got h"),
        (Balance(a1, a1, N(u1), f(1)), r"damping of balance 1 to hold a_1 with a number times h before it"),
        (Balance(v1, v1, N(u1), f(1)), r"inertia of balance 1 to hold v_1 with a number times 1/h before it"),
        (Balance(a1, v1, N(u1 + 1), f(1)), r"displacement of N in the force of balance 1 as a linear combination"),
        (Balance(a1, v1, N(u0 + v0), f(1)), r"displacement of N in the force of balance 1 to hold v_0"),
        (Balance(a1, v1, N(N(u1)), f(1)), r"displacement of N in the force of balance 1 to hold N\(u_1\)"),
        (Balance(a1, v1, N(u1) ** 2, f(1)), r"force of balance 1 as a linear combination"),
        (Balance(a1, v1, N(u1), f(1) ** 2), r"load of balance 1 as a linear combination"),
    ],
)
def test_powers_in_balances(balance: Balance, what: str) -> None:
    with pytest.raises(DeclarationError, match=what):
        scheme(balance=balance)


def test_powers_in_what_a_start_and_a_report_say() -> None:
    with pytest.raises(DeclarationError, match=r"start of a_0 to hold N\(u_0\) with a number times 1/M"):
        scheme(start={a0: f(0) / M - N(u0)})
    with pytest.raises(DeclarationError, match="report of v_1 to hold u_[01] with a number times 1/h"):
        scheme(report={v1: u1 - u0})
    scheme(start={a0: (f(0) - C * v0 - N(u0)) / M}, report={v1: (u1 - u0) / h})
    scheme({**NEWMARK, v1: v0 + h * a1 * M / (M + h**2 * K0 + h * C)})


def test_keys_that_are_no_symbols() -> None:
    with pytest.raises(DeclarationError, match="relations as a mapping from symbols to expressions, got 'u_1'"):
        scheme({"u_1": u0, v1: v0})  # type: ignore[dict-item]


def test_a_division_by_what_vanishes_in_a_range() -> None:
    """Cleared of its denominators gamma (u_1 - u_0 - h v_0) = h^2 a_1 holds at gamma = 0 too, and says a_1 = 0."""
    with pytest.raises(DeclarationError, match=r"divides by gamma: expected an interval of gamma without 0"):
        scheme({**NEWMARK, u1: u0 + h * v0 + h**2 * a1 / gamma}, parameters=(Parameter(gamma, RANGE, 2),))
    family = Family(Parameter(rho, Interval(-1, 1), 0), {gamma: 1 / (1 + rho)})
    with pytest.raises(DeclarationError, match=r"divides by rho \+ 1: expected an interval of rho without -1"):
        scheme(parameters=(Parameter(gamma, RANGE, 2),), families=(family,))


def test_a_division_by_what_vanishes_at_given_parameters() -> None:
    parameters = (Parameter(gamma, RANGE, 2), Parameter(beta, RANGE, 1))
    two = scheme({**NEWMARK, u1: u0 + h * v0 + h**2 * a1 / (gamma - beta)}, parameters=parameters)
    message = r"divides by -beta \+ gamma: expected parameters at which that is not 0, got beta = 1, gamma = 1"
    with pytest.raises(DeclarationError, match=message):
        certify(two, gamma=1, beta=1)
    with pytest.raises(DeclarationError, match=message):
        two.fix({"gamma": 1, "beta": 1})
    with pytest.raises(DeclarationError, match=r"divides by 1 - beta: .* got beta = 1"):
        two.fix({"gamma": 1}).fix({"beta": 1})


@pytest.mark.parametrize("ask", [certify, prescribed])
def test_parameters_at_which_relations_do_not_determine_a_step(ask: Any) -> None:
    """At gamma = 0 the relation of u_1 holds no u_1."""
    relations = {u1: u0 + h * v0 + h**2 * a1 * gamma + (1 - gamma) * (u1 - u0), v1: v0 + h * a1}
    singular = scheme(relations, parameters=(Parameter(gamma, RANGE, 1),))
    with pytest.raises(DeclarationError, match="dependent for every Omega|expected parameters at which .* gamma = 0"):
        ask(singular, gamma=0)


def test_a_copy_of_a_balance_is_not_proved_to_be_stable() -> None:
    copied = Scheme("copied", {u1: NEWMARK[u1]}, (AT_END, AT_END))
    with pytest.raises(DeclarationError, match="dependent for every Omega"):
        certify(copied, structures=True)


def test_a_state_that_never_moves_has_no_proof_on_structures() -> None:
    kept = scheme({**NEWMARK, knot(1, "kept").u: knot(0, "kept").u}, start={knot(0, "kept").u: u0})
    assert certify(kept, structures=True).verdict == "open"


def test_parameters_of_the_names_of_matrices() -> None:
    K = Parameter(Symbol("K"), RANGE, 1)
    with pytest.raises(DeclarationError, match="whose name is free, got 'K'"):
        scheme({**NEWMARK, v1: v0 + h * (a0 + K.symbol * (a1 - a0))}, parameters=(K,))


@pytest.mark.parametrize(
    ("relations", "state", "critical"),
    [
        ({u1: um + 2 * h * v0, v1: vm + 2 * h * a0}, (u0, v0, a0, um, vm), 1),  # leapfrog, which does not read u_0
        ({**NEWMARK, v1: v0 + h / 2 * (a0 + knot(-2).a)}, (u0, v0, a0, am, knot(-2).a), 0),
    ],
)
def test_what_lies_between_a_history_and_the_step_is_carried(relations: Any, state: Any, critical: int) -> None:
    s = scheme(relations, name="gaps", start=scheme(name="average"))
    assert s.state == state
    omega, damping = Rational(2, 3), Rational(1, 10)
    with mpmath.workdps(30):
        expected = amplification(s, {}, oscillator(2 * exact(damping * omega), exact(omega) ** 2)).astype(float)
    found = derive(s).A.subs({Omega: omega, xi: damping})
    np.testing.assert_allclose(np.array(found.tolist(), dtype=float), expected, atol=1e-14)
    assert certify(s).critical_Omega == critical
