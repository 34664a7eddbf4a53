"""Tables with irrational numbers as they are written, beside the catalogue's, which have a root as a parameter."""

from collections.abc import Callable
from typing import Any

import pytest
from substep_derive import DeclarationError, Parameter, Root, Scheme, certify, composition, derive, nystrom, tableau
from substep_derive.declare.parameter_set import ParameterSet
from substep_derive.declare.schemes.newmark import central_difference
from substep_derive.oscillator.evaluation import Evaluation
from sympy import Expr, I, Interval, Poly, Rational, Symbol, cbrt, cos, expand, pi, sqrt
from sympy.abc import theta

HALF = Rational(1, 2)
ALEXANDER = 1 - sqrt(2) / 2
CROUZEIX = HALF + cos(pi / 18) / sqrt(3)
TRIPLE = 1 / (2 - cbrt(2))
DELTA = 1 / (6 * (2 * CROUZEIX - 1) ** 2)


def sdirk2(gamma: Expr = ALEXANDER) -> Scheme:
    return tableau("written", ((gamma,), (1 - gamma, gamma)), (1 - gamma, gamma), (gamma, 1))


def crouzeix4(g: Expr = CROUZEIX, d: Expr = DELTA) -> Scheme:
    return tableau("written", ((g,), (HALF - g, g), (2 * g, 1 - 4 * g, g)), (d, 1 - 2 * d, d), (g, HALF, 1 - g))


def forest_ruth(w: Expr = TRIPLE) -> Scheme:
    return composition("written", central_difference, (w, 1 - 2 * w, w))


WRITTEN: list[tuple[Callable[[], Scheme], str, Expr]] = [
    (sdirk2, "sdirk2", ALEXANDER),
    (crouzeix4, "crouzeix4", CROUZEIX),
    (forest_ruth, "forest_ruth", TRIPLE),
]


def matrix(scheme: Scheme) -> list[Any]:
    """The amplification matrix at Omega = 3/4, xi = 1/5 and defaults, exact, in the field of the default."""
    at = Evaluation.at(ParameterSet.of(scheme, None, {}))
    step, values = at.amplification.step, {"Omega": Rational(3, 4), "xi": Rational(1, 5)}
    den = at.number(step.den.subs(values))
    return [at.number(e.subs(values)) / den for e in step.N]


@pytest.mark.parametrize(("made", "name", "number"), WRITTEN, ids=[name for _, name, _ in WRITTEN])
def test_a_written_number_gives_the_scheme_of_the_catalogue(
    made: Callable[[], Scheme], name: str, number: Expr
) -> None:
    scheme = made()
    (parameter,) = scheme.parameters
    assert isinstance(parameter.default, Root)
    low, high = parameter.domain.start, parameter.domain.end
    assert low < number.n(30) < high  # the number itself, not a conjugate
    mine, theirs = (Evaluation.at_defaults(s) for s in (scheme, name))
    assert mine.field.r.shares_generator(theirs.field.r)  # type: ignore[union-attr]
    assert matrix(scheme) == matrix(derive(name).scheme)


def test_a_written_number_is_derived_and_certified_like_a_declared_root() -> None:
    d, order = derive(sdirk2()), (2, 2, 2)
    assert d.order == d.nonlinear.uva == order
    assert d.series.order == 2
    assert certify(d.scheme).stable


def test_two_radicals_have_one_generator() -> None:
    """sqrt(2) and sqrt(3) of two steps: neither follows from the other, both from their sum."""
    a, b = sqrt(2) - 1, sqrt(3) - 1
    scheme = composition("both", central_difference, (a, b, 1 - a - b))
    (parameter,) = scheme.parameters
    assert isinstance(parameter.default, Root)
    assert Poly(parameter.default.equation, theta).degree() == 4
    assert derive(scheme).order == (2, 2, 2)


def test_a_nystrom_table_takes_them_too() -> None:
    """Two stages at (3 -+ sqrt(3))/6, Gauss's points, for u'' = g(t, u): order 3, where 1/4 and 3/4 have order 2."""
    c = ((3 - sqrt(3)) / 6, (3 + sqrt(3)) / 6)
    scheme = nystrom(
        "gauss",
        A_bar=((c[0] ** 2 / 2,), (c[1] ** 2 / 2 - Rational(1, 12), Rational(1, 12))),
        b_bar=tuple(HALF * (1 - x) for x in c),
        b=(HALF, HALF),
        c=c,
    )
    assert [p.name for p in scheme.parameters] == ["theta"]
    assert derive(scheme).order == (3, 3, 3)
    for knot in "pq":  # rows sum to c^2/2 beside the root too, from which kernels cancel what consistent schemes cancel
        relation, step = scheme.relations[Symbol(f"u_{knot}")].expand(), Symbol("h")
        second, first = relation.coeff(step, 2), relation.coeff(step, 1)
        assert second is not None and first is not None
        sums = second.subs({"a_p": 1, "a_q": 1}), first.subs("v_0", 1)
        assert expand(2 * sums[0] - sums[1] ** 2) == 0


def test_what_is_only_written_with_radicals_is_rational() -> None:
    weights = (sqrt(2) * sqrt(8) / 8, (1 + sqrt(2)) * (sqrt(2) - 1) / 2)
    assert not tableau("heun", ((), (1,)), weights, (0, 1)).parameters


HEUN = (((), (1,)), (0, 1))
OWN = Parameter(Symbol("gamma"), Interval(0, 1), Root(2 * Symbol("gamma") ** 2 - 1))


@pytest.mark.parametrize(
    ("weights", "parameters", "message"),
    [
        ((pi, 1 - pi), (), r"irrational ones real and algebraic.*got pi, 1 - pi; let"),
        ((I, 1 - I), (), "irrational ones real and algebraic"),
        ((sqrt(2), sqrt(2)), (), r"the entries of b to sum to 1, got 2\*theta; correct"),
        ((sqrt(3), 1 - sqrt(3)), (OWN,), r"whose default is a root, got sqrt\(3\), 1 - sqrt\(3\) besides; write"),
        ((sqrt(Symbol("gamma")), 1), (OWN,), "rational in the parameters, got sqrt"),
    ],
)
def test_what_has_no_generator_is_refused_with_the_cure(weights: Any, parameters: Any, message: str) -> None:
    with pytest.raises(DeclarationError, match=message):
        tableau("t", HEUN[0], weights, HEUN[1], parameters=parameters)
