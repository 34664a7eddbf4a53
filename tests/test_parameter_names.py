"""Parameters whose names derivation uses itself: refused, or not mistaken for its own symbols."""

import pytest
from substep_derive import Algebraic, Balance, DeclarationError, Parameter, Scheme, certify, derive
from substep_derive.declare.symbols import h, knot
from substep_derive.stability.conditions import conditions
from sympy import Interval, Rational, Symbol, sqrt

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
half, gamma = Rational(1, 2), Symbol("gamma")


@pytest.mark.parametrize(
    "name", ["mu", "lambda", "Omega", "xi", "h", "omega", "t", "f", "M", "C", "K0", "u_x", "a_1", "v_g"]
)
def test_parameters_cannot_have_names_of_the_derivation(name: str) -> None:
    p = Symbol(name)
    relations = {u1: u0 + h * v0, v1: v0 + h * ((1 - p) * a0 + p * a1)}
    with pytest.raises(DeclarationError, match="rename the parameter|two parameters"):
        Scheme("bad", relations, (Balance.at(end, 1),), (Parameter(p, Interval(0, 1), half),))


@pytest.mark.parametrize("name", ["W", "rho"])
def test_parameters_may_have_names_of_algorithms(name: str) -> None:
    """Certificate, order, series and conditions do not mistake them for their own symbols."""
    p = Symbol(name)
    mine = {u1: u0 + h * v0 + h**2 / 2 * ((1 - p) * a0 + p * a1), v1: v0 + h * ((1 - p) * a0 + p * a1)}
    both = []
    for symbol in (p, gamma):
        relations = {k: e.subs(p, symbol) for k, e in mine.items()}
        default = Parameter(symbol, Interval(0, 1), sqrt(2) / 2)
        both.append(Scheme("own", relations, (Balance.at(end, 1),), (default,)))
    first, second = both
    assert certify(first).intervals == certify(second).intervals
    assert certify(first, **{name: "3/4"}).intervals == certify(second, gamma="3/4").intervals
    r = Algebraic((2, 0, -1), (0, 1))
    assert certify(first, **{name: r}).intervals == certify(second, gamma=r).intervals
    assert derive(first).series.numerical_damping[1].subs(p, gamma).equals(derive(second).series.numerical_damping[1])
    assert [e.subs(p, gamma) for e in conditions(first).inequalities] == list(conditions(second).inequalities)
