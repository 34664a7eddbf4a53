"""Effectivity of estimates beyond small steps, their filter, and what the runtime knows of them."""

import mpmath
import numpy as np
import pytest
from declared import BY_NAME, NAMES, UNDAMPED
from substep_derive import DeclarationError, derive, estimator
from substep_derive.declare.parameter_set import ParameterSet
from substep_derive.declare.symbols import C, M, Omega, h, t, xi
from substep_derive.estimate.estimator import estimator_at
from substep_derive.estimate.quality import K, effectivity, filter_of, filters
from sympy import Function, Interval, Rational, Symbol, factor, lambdify, symbols
from tables import COMPOSITIONS
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app
from substep.derived import facade
from substep.studies import estimator_charts as charts

CLOSED = ("forward_euler", "rk2", "newmark", "average_acceleration", "energy_momentum", "bathe", "newmark_bdf2", "rk4")
runner = CliRunner()


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("damping", [0, Rational(1, 5), Rational(9, 10)])
def test_the_closed_form_tends_to_one(name: str, damping: Rational) -> None:
    """In 60 digits at Omega = 10^-4, 10^-5: index - 1 falls with Omega, or faster."""
    scheme = BY_NAME[name]
    values = {p.symbol: p.inside(Rational(3, 7)) for p in scheme.parameters} | {xi: damping}
    with mpmath.workdps(60):
        for one in effectivity(estimator(name)).index:
            index = lambdify(Omega, one.subs(values), modules="mpmath")
            coarse, fine = (abs(index(mpmath.mpf(10) ** -n) - 1) for n in (4, 5))
            assert coarse < 1e-2 and fine < 0.11 * coarse


def test_the_trapezoidal_rule_in_closed_form() -> None:
    """Estimate of u on u = 1, h v = s without damping: -(a_0 - a_1) h^2/12 with u_1 of the Cayley transform."""
    s = 1j * 0.7
    u_1 = (1 - 0.7**2 / 4 + s) / (1 + 0.7**2 / 4)
    found = effectivity(estimator("average_acceleration"))
    estimate, error = (complex(x.subs({Omega: 0.7, xi: 0})) for x in (found.estimate[0], found.error[0]))
    assert estimate == pytest.approx(-(0.7**2) * (u_1 - 1) / 12)
    assert error == pytest.approx(u_1 - np.exp(s))


def test_the_trapezoidal_rules_estimate_on_a_stiff_component() -> None:
    """The figure that docs/estimators.md gives."""
    index = effectivity(estimator("average_acceleration")).index[0]
    assert abs(complex(index.subs({Omega: 10, xi: 0}))) == pytest.approx(17.5, abs=0.05)


def test_a_state_of_more_has_no_closed_form() -> None:
    with pytest.raises(DeclarationError, match=r"generalized_alpha: expected a state of u and v"):
        effectivity(estimator("generalized_alpha"))


def test_the_filter_is_the_effective_stiffness() -> None:
    beta, gamma, gamma_t = symbols("beta gamma gamma_t")
    assert factor(filter_of(BY_NAME["newmark"]) - M / (M + gamma * h * C + beta * h**2 * K)) == 0
    c = (1 - gamma_t) / (2 - gamma_t)
    assert factor(filter_of(BY_NAME["silva_bezerra"]) - M / (M + c * h * C + (c * h) ** 2 * K)) == 0
    assert factor(filter_of(BY_NAME["energy_momentum"]) - M / (M + h * C / 2 + h**2 * K / 4)) == 0
    assert filter_of(BY_NAME["rk4"]) is None
    one = estimator("newmark").displacement
    assert (one.growth, filters(one, vanishing=False), filters(one, vanishing=True)) == (2, 1, 2)


def blind(name: str, quantity: str, damping: float) -> bool:
    """Whether the leading error of u or v vanishes on linear equations, or there without damping."""
    estimates = estimator_at(ParameterSet.of(BY_NAME[name], None, {}), damped=name not in UNDAMPED)
    estimate = estimates.displacement if quantity == "u" else estimates.velocity
    leading = estimate.leading.subs(Function("g")(t), 0).doit()
    return (leading if damping else leading.subs(xi, 0)) == 0


@pytest.mark.usefixtures("plain_functions")
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_the_runtime_finds_one_at_small_steps_for_every_scheme(name: str, damping: float) -> None:
    if damping and name in UNDAMPED:
        with pytest.raises(ValueError, match=f"{name} is a scheme for"):
            charts.effectivity(ss.scheme(name), np.array([0.02, 0.04, 0.08]), damping)
        return
    order = max(facade.estimator_entry(name)["order"])
    first = 0.02 if order < 4 else 0.05 if order < 6 else 0.2  # errors of high order vanish in rounding
    if name in COMPOSITIONS and order > 4:
        first = 0.05  # parts of a step that are longer than it make higher terms large
    grids = [first / halves * np.array([1, 2, 4]) for halves in (1, 2)]  # higher terms of some are larger
    indices = [charts.effectivity(ss.scheme(name), grid, damping).plain for grid in grids]
    for quantity, *each in zip("uv", *indices, strict=True):
        found = any(abs(x[1] - 1) < min(0.1, max(0.6 * abs(x[2] - 1), 1e-3)) for x in each)
        assert found or blind(name, quantity, damping), (quantity, each)


def test_the_runtime_agrees_with_the_closed_form() -> None:
    grid = np.linspace(0.2, 3, 15)
    found = charts.effectivity(ss.scheme("bathe"), grid, 0.1).plain
    for own, one in enumerate(effectivity(estimator("bathe")).index):
        exact = [abs(complex(one.subs({Omega: x, xi: 0.1}))) for x in grid]
        assert found[own] == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("name", [name for name in NAMES if facade.estimator_entry(name).get("filter")])
def test_filtered_estimates_vanish_on_stiff_components(name: str) -> None:
    """The growth that is derived, in numbers: each row of the filtered estimate, in the scale of its state, falls."""
    entry = facade.estimator_entry(name)
    scales = [kind for kind, _ in ss.scheme(name).info.history]
    for own in (0, 1):
        sizes = []
        for x in (1e4, 1e5):
            factor_ = charts._value(entry["filter"][0], x, 0.1) / charts._value(entry["filter"][1], x, 0.1)
            row = charts._row(entry["estimates"][own : own + 1], x, 0.1)[0] / charts._value(entry["dens"][own], x, 0.1)
            sizes.append((max(abs(row) * x ** np.array(scales)) * x**-own, abs(factor_) ** entry["filters"][own]))
        (plain, factor0), (plain1, factor1) = sizes
        growth = np.log10(plain1 / plain)
        if derive(name).scheme.embedded:  # whose declared growth is that of almost all parameters
            assert growth <= entry["growth"][own] + 0.1
        else:
            assert growth == pytest.approx(entry["growth"][own], abs=0.1)
        assert plain1 * factor1 < 0.2 * plain * factor0


def test_a_scheme_of_ones_own_has_it_too() -> None:
    from substep_derive import Balance, Parameter, Scheme, knot

    g = Symbol("g_own")
    (u0, v0, a0), (u1, v1, a1) = knot(0), knot(1)
    relations = {u1: u0 + h * v0 + h**2 * ((1 - g**2) * a0 + g**2 * a1) / 2, v1: v0 + h * ((1 - g) * a0 + g * a1)}
    mine = Scheme("mine", relations, (Balance.at(knot(1), 1),), (Parameter(g, Interval(0, 2), Rational(3, 5)),))
    entry = facade.estimator_entry(mine)
    assert entry["order"] == (2, 1)
    assert entry["extra"] == {}
    own = estimator(mine)
    assert factor(own.v - (g - Rational(1, 2)) * h * (a1 - a0)) == 0


def test_bad_grids_are_refused() -> None:
    with pytest.raises(ValueError, match="ascending Omega from a value in"):
        charts.effectivity(ss.scheme("bathe"), np.array([1.0, 2.0]))


def test_the_command_line_says_what_and_why() -> None:
    result = runner.invoke(app, ["estimator", "newmark", "--beta", "1/4", "--gamma", "1/2"])
    assert result.exit_code == 0, result.output
    assert "error of u_1, order 2: -h^2*(a_0 - a_1)/12" in result.output
    assert "a_-1: of the step before" in result.output
    assert "4*M/(2*C*h + K*h^2 + 4*M)" in result.output
    blind = runner.invoke(app, ["estimator", "average_acceleration", "--held-only"])
    assert blind.exit_code == 2
    assert "blind in v" in blind.output.replace("\n", " ")
