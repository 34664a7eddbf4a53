"""Composite schemes from wishes: known ones come out, none where there is none, and what is found holds.

Oracles: published values, mpmath's roots and linear algebra, and numerical stepping of the nonlinear oracle.
"""

from functools import cache
from itertools import count
from typing import Any

import mpmath
import numpy as np
import pytest
from nonlinear_oracle import System, history
from substep_derive import DeclarationError, certify, derive
from substep_derive.algebra.rooted_trees import density, rooted_trees, symmetry
from substep_derive.declare.schemes.composite import three_substep
from substep_derive.declare.schemes.designed import (
    four_substep,
    four_substep_fourth_order,
    three_substep_third_order,
)
from substep_design.answer import Answer
from substep_design.design import design
from substep_design.stability_function import StabilityFunction, approximate, coefficient, is_stable
from substep_design.stability_function import rational_number as rational
from sympy import Poly, Rational, Symbol, cancel, cos, pi, simplify, sqrt, sympify
from typer.testing import CliRunner

gamma, rho_inf = Symbol("gamma"), Symbol("rho_inf")


@cache
def answer(**wishes: Any) -> Answer:
    return design(**wishes)


def table(name: str) -> tuple[tuple, ...]:
    """The coefficients that a catalogued declaration holds, row by row."""
    scheme = {s.name: s for s in (three_substep_third_order, four_substep, four_substep_fourth_order)}[name]
    accelerations = [Symbol("a_0"), *(b.inertia for b in scheme.balances)]
    rows = []
    for i, a in enumerate(accelerations[1:], start=1):
        relation = scheme.relations[Symbol(a.name.replace("a", "v", 1))].expand()
        rows.append(tuple(cancel(relation.coeff(x) / Symbol("h")) for x in accelerations[: i + 1]))
    return tuple(rows)


# --- known ones ----------------------------------------------------------------------------------------


def test_two_sub_steps_without_high_frequencies_are_split_at_two_minus_root_two() -> None:
    """Bathe's and Silva-Bezerra's best gamma_t, the first sub-step's share, is 2 gamma."""
    found = answer(sub_steps=2, order=2, l_stable=True).found
    assert found is not None
    assert found.gamma is not None
    assert abs(2 * approximate(found.gamma) - (2 - sqrt(2)).n(40)) < 1e-35
    same = derive("silva_bezerra", gamma_t="29289321881/50000000000").series.period_error[2].subs("xi", 0)
    assert abs(same) == pytest.approx(abs(float(found.error_constant.subs(gamma, approximate(found.gamma)))), rel=1e-9)


def test_two_sub_steps_with_every_radius_are_rho_inf_bathe_with_its_default_split() -> None:
    found = answer(sub_steps=2, order=2, rho_inf="free").found
    assert found is not None
    split = 2 / (2 + sqrt(2 + 2 * rho_inf))
    assert simplify(found.equation.subs(gamma, split / 2)) == 0
    q1 = (1 + rho_inf) / (2 * split * (rho_inf - 1) + 4)
    assert simplify(found.table[1][1].subs(gamma, split / 2) - q1) == 0


def test_three_sub_steps_of_least_damping_are_those_of_zhang() -> None:
    """His gamma is 2 gamma, and its equation the default of the catalogue's three_substep."""
    found = answer(sub_steps=3, order=2, rho_inf="free", least="damping").found
    assert found is not None
    published = three_substep.parameters[1].default.equation.subs(gamma, 2 * gamma)
    assert cancel(published / found.equation).is_Rational
    low, high = sorted(found.interval)
    assert float(low) < 1 / 6 + 1e-12
    assert float(high) == pytest.approx(0.360850612858797 / 2)


@pytest.mark.parametrize(("n", "order"), [(3, 2), (4, 2)])
def test_families_of_second_order_lose_nothing_at_low_frequencies(n: int, order: int) -> None:
    """|R(iy)|^2 = 1 - (1 - rho^2) (gamma y)^(2n)/(1 + gamma^2 y^2)^n, by the scheme's own amplification matrix."""
    found = answer(sub_steps=n, order=order, rho_inf="1/2", least="damping").found
    assert found is not None
    g = float(approximate(found.gamma))
    p = [1, 1 - n * g, *(float(e.subs(gamma, approximate(found.gamma))) for e in found.numerator)]
    for y in (0.3, 2.0, 11.0):
        R = np.polyval(p[::-1], 1j * y) / (1 - 1j * g * y) ** n
        assert abs(R) ** 2 == pytest.approx(1 - 0.75 * (g * y) ** (2 * n) / (1 + (g * y) ** 2) ** n, rel=1e-11)


def test_crouzeix_is_found_where_the_radius_is_not_wished() -> None:
    """gamma = 1/2 + cos(pi/18)/sqrt(3), Hairer & Wanner II, table IV.6.3 (s = 3, order 4)."""
    found = answer(sub_steps=3, order=4).found
    assert found is not None
    assert abs(approximate(found.gamma) - (Rational(1, 2) + cos(pi / 18) / sqrt(3)).n(40)) < 1e-35
    assert certify(found.scheme).stable
    assert derive(found.scheme).order == (4, 4, 4)


# --- none ----------------------------------------------------------------------------------------------


def test_three_sub_steps_of_order_four_have_no_free_radius() -> None:
    for wished in ("free", "1/2", 0):
        found = answer(sub_steps=3, order=4, rho_inf=wished)
        assert (found.verdict, found.found) == ("none", None)
        assert "24*gamma^3" in found.text
        assert "A-stable, |R(oo)| = 0.6304" in found.text


@pytest.mark.parametrize(("n", "order"), [(4, 5), (2, 4), (3, 5)])
def test_orders_that_no_stable_scheme_has(n: int, order: int) -> None:
    """Hairer & Wanner II, table IV.6.4: order s + 1 is A-stable for s = 1, 2, 3 and 5 alone; more no one has."""
    assert answer(sub_steps=n, order=order).verdict == "none"


def test_more_than_order_n_plus_one_has_no_real_poles_even_if_they_differ() -> None:
    assert answer(sub_steps=2, order=4, one_stiffness=False).verdict == "none"


@pytest.mark.parametrize(("n", "low", "high"), [(3, "1/3", "1.06857902"), (4, "0.39433757", "1.28057976")])
def test_the_a_stable_interval_is_the_published_one(n: int, low: str, high: str) -> None:
    """Hairer & Wanner II, table IV.6.3: gamma for A-stability at order s."""
    function = StabilityFunction(tuple(coefficient(k, n) for k in range(n + 1)), n)
    small = Rational(1, 10**7)
    for end, sign in ((Rational(low), 1), (Rational(high), -1)):
        assert is_stable(function.excess, rational(end + sign * small))
        assert not is_stable(function.excess, rational(end - sign * small))


# --- undecided -----------------------------------------------------------------------------------------


def test_without_time_it_is_undecided_and_says_what_was_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    found = design(sub_steps=3, order=3, rho_inf="free", cpu_seconds=0)
    assert found.verdict == "undecided"
    assert "0 s of CPU time" in found.text
    clock = count()
    monkeypatch.setattr("substep_design.answer.process_time", lambda: next(clock))
    short = design(sub_steps=3, order=3, rho_inf="free", cpu_seconds=3)
    assert short.verdict == "undecided"
    assert short.text.count("done: A-stability") == 2
    assert design(sub_steps=3, order=3, rho_inf="free", cpu_seconds=1000).verdict == "found"


@pytest.mark.parametrize(
    "wishes",
    [
        {"sub_steps": 5, "order": 2, "rho_inf": "1/2"},
        {"sub_steps": 2, "order": 3, "rho_inf": "1/2", "one_stiffness": False},
        {"sub_steps": 4, "order": 2, "rho_inf": "free", "least": "damping"},
    ],
)
def test_what_is_not_decided_is_not_called_none(wishes: dict[str, Any]) -> None:
    found = answer(**wishes)
    assert (found.verdict, found.found) == ("undecided", None)
    assert len(found.proof) > 0


# --- what nobody had printed ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("wishes", "name"),
    [
        ({"sub_steps": 3, "order": 3, "rho_inf": "free"}, "three_substep_third_order"),
        ({"sub_steps": 4, "order": 4, "rho_inf": "free"}, "four_substep"),
        ({"sub_steps": 4, "order": 4, "rho_inf": "1/3"}, "four_substep_fourth_order"),
    ],
)
def test_the_catalogue_holds_what_is_found(wishes: dict[str, Any], name: str) -> None:
    found = answer(**wishes).found
    assert found is not None
    assert [
        [cancel(a - b) for a, b in zip(r, s, strict=True)] for r, s in zip(found.table, table(name), strict=True)
    ] == [[0] * len(row) for row in found.table]


@pytest.mark.parametrize("scheme", [three_substep_third_order, four_substep], ids=lambda s: s.name)
@pytest.mark.parametrize("radius", ["0", "1/3", "9/10", "1"])
def test_found_families_are_certified_and_have_their_radius(scheme: Any, radius: str) -> None:
    """Damped and undamped; the radius at gamma by mpmath, from a step so large that only R(oo) is left."""
    assert certify(scheme, rho_inf=radius).stable
    assert certify(scheme, xi="1/10", rho_inf=radius).stable
    n = len(scheme.balances)
    for g in roots_inside(scheme, Rational(radius)):
        last = sum((-1) ** j * mpmath.binomial(n, j) * g**j / mpmath.factorial(n - j) for j in range(n + 1))
        assert abs(last) / g**n == pytest.approx(float(Rational(radius)), abs=1e-9)


def roots_inside(scheme: Any, radius: Rational) -> list[float]:
    """The only root of gamma's equation in its interval, by numpy."""
    parameter = scheme.parameters[1]
    coefficients = Poly(parameter.default.equation.subs(rho_inf, radius), gamma).all_coeffs()
    low, high = float(parameter.domain.start), float(parameter.domain.end)
    found = [x.real for x in np.roots([float(c) for c in coefficients]) if abs(x.imag) < 1e-9 and low < x.real < high]
    assert len(found) == 1
    return found


def test_stable_everywhere_on_both_branches_by_plain_numbers() -> None:
    """|R(iy)| <= 1 on a grid of y at many rho_inf, from the tables by numpy alone."""
    for scheme in (three_substep_third_order, four_substep):
        rows = table(scheme.name)
        for radius in np.linspace(0, 1, 9):
            (g,) = roots_inside(scheme, Rational(float(radius)))
            A = np.zeros((len(rows) + 1, len(rows) + 1))
            for i, row in enumerate(rows, start=1):
                A[i, : len(row)] = [float(e.subs(gamma, g)) for e in row]
            y = np.logspace(-2, 5, 120)
            R = [np.linalg.solve(np.eye(len(A)) - 1j * x * A, np.ones(len(A)))[-1] for x in y]
            assert np.abs(R).max() <= 1 + 1e-10
            assert abs(R[-1]) == pytest.approx(radius, abs=1e-3)


def duffing_end(name: str, parameters: dict[str, float], n: int) -> float:
    """u(2) of u'' + 0.3 u' + u + 2 u^3 = cos t in n steps."""
    force, tangent = (lambda u: u + 2 * u**3), (lambda u: np.diag(1 + 6 * u**2))
    system = System(np.eye(1), 0.3 * np.eye(1), force, tangent, lambda t: np.array([np.cos(t)]))
    u0, v0 = np.array([1.0]), np.array([0.5])
    u, _, _ = history(name, parameters, system, 2 / n, n, u0, v0, system.acceleration(u0, v0, 0.0))
    return float(u[-1, 0])


@pytest.mark.parametrize(
    ("name", "parameters", "order", "coarsest"),
    [
        ("three_substep_third_order", {"gamma": 0.3756022250150166, "rho_inf": 0.5}, 3, 16),
        ("four_substep", {"gamma": 0.4704805776216769, "rho_inf": 0.5}, 4, 32),  # the observed order falls to 4
        ("four_substep_fourth_order", {}, 4, 16),
    ],
)
def test_the_order_holds_on_a_damped_forced_duffing_oscillator(
    name: str, parameters: dict, order: int, coarsest: int
) -> None:
    """Differences of runs whose steps are halved fall by 2^order."""
    ends = [duffing_end(name, parameters, n) for n in coarsest * np.array([1, 2, 4, 8])]
    first, second, third = np.abs(np.diff(ends))
    assert np.log2(second / third) == pytest.approx(order, abs=0.25)
    assert first > second


# --- trees, period error -------------------------------------------------------------------------------


def test_rooted_trees() -> None:
    """Their numbers (A000081), and sum over trees of order p of 1/(density symmetry) = 1/p! times labellings."""
    assert [len(rooted_trees(k)) for k in range(1, 9)] == [1, 1, 2, 4, 9, 20, 48, 115]
    for k in range(1, 8):  # the exact solution of y' = y^2, y(0) = 1 is 1/(1 - t): every elementary differential counts
        assert sum(Rational(1, density(t) * symmetry(t)) * growth(t) for t in rooted_trees(k)) == 1


def growth(tree: tuple) -> int:
    """The elementary differential of f = y^2 at y = 1: f' = 2, f'' = 2, higher derivatives 0."""
    own = {0: 1, 1: 2, 2: 2}.get(len(tree), 0)
    for child in tree:
        own *= growth(child)
    return own


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_criteria_are_the_leading_terms_of_the_stability_function(n: int) -> None:
    """log R(iy) - iy at y = 1e-6, in 60 digits: its real part damps, its imaginary part turns."""
    function = StabilityFunction(tuple(coefficient(k, n) for k in range(n + 1)), n)
    with mpmath.workdps(60):
        g, y = mpmath.mpf(3) / 10, mpmath.mpf(10) ** -6
        p = [mpmath.mpf(e.p) / e.q for e in (sympify(c).subs(gamma, Rational(3, 10)) for c in function.numerator)]
        z = 1j * y
        error = mpmath.log(mpmath.polyval(p[::-1], z) / (1 - g * z) ** n) - z
        for criterion, part in (("damping", error.real), ("period_error", error.imag)):
            power = n + 1 if (criterion == "damping") == (n % 2 == 1) else n + 2
            expected = abs(float(function.least(criterion).subs(gamma, Rational(3, 10))))
            assert float(abs(part) / y**power) == pytest.approx(expected, rel=1e-4)
    assert function.least("error_constant") == function.error(n + 1)


# --- wrong wishes --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("wishes", "message"),
    [
        ({"sub_steps": 0, "order": 2}, "sub-steps as an integer from 1"),
        ({"sub_steps": 2, "order": 0}, "order as an integer from 1"),
        ({"sub_steps": 2, "order": 5}, "at most 2 n = 4"),
        ({"sub_steps": 2, "order": 2, "rho_inf": "3/2"}, "rho_inf from 0 to 1"),
        ({"sub_steps": 2, "order": 2, "rho_inf": -1}, "rho_inf from 0 to 1"),
        ({"sub_steps": 2, "order": 2, "rho_inf": "1/2", "l_stable": True}, "ask for one of the two"),
        ({"sub_steps": 2, "order": 2, "least": "cost"}, "error_constant"),
        ({"sub_steps": 2, "order": 2, "cpu_seconds": -1}, "at least 0"),
        ({}, "got neither"),
        ({"scheme": "bathe", "sub_steps": 2}, "got both"),
    ],
)
def test_wrong_wishes_are_refused_with_the_cure(wishes: dict[str, Any], message: str) -> None:
    with pytest.raises(DeclarationError, match=message):
        design(**wishes)


def test_a_float_is_refused() -> None:
    with pytest.raises(TypeError):
        design(sub_steps=2, order=2, rho_inf=0.5)


def test_the_command_prints_parameters_proof_and_certificate() -> None:
    from substep.cli.commands import app

    def run(*words: str) -> Any:
        return CliRunner().invoke(app, ["design", *words])

    found = run("--sub-steps", "2", "--order", "2", "--rho-inf", "free", "--one-stiffness")
    assert found.exit_code == 0, found.output
    for words in (
        "-2*gamma^2*rho_inf + 2*gamma^2 - 4*gamma + 1 = 0",
        "0.292893",
        "stable for every Omega > 0",
        "ends at 2*gamma",
    ):
        assert words in " ".join(found.output.split())  # lines are folded
    none = run("--sub-steps", "3", "--order", "4", "--rho-inf", "free")
    assert "there is none" in none.output
    assert "alpha_f = 1/3" in run("generalized_alpha", "--rho-inf", "1/2").output
    assert run("--sub-steps", "2", "--order", "9").exit_code == 2
    assert run().exit_code == 2
    assert run("bathe", "--sub-steps", "2").exit_code == 2
