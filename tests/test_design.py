"""Designed parameters against the published ones, and against the requirements that they have to meet."""

import os

import pytest
from substep_derive import DeclarationError, derive
from substep_derive.algebra.algebraic import Algebraic
from substep_derive.declare.symbols import beta, gamma_t
from substep_derive.stability.certificate import certify
from substep_derive.stability.conditions import conditions
from substep_design.design import design
from substep_design.parameters import least_period_error, rho
from substep_design.second_order import region
from sympy import Rational, simplify, sqrt

EXHAUSTIVE = os.environ.get("SUBSTEP_VERIFY") == "1"
ALL_RADII = ("0", "1/10", "1/3", "1/2", "3/4", "9/10", "1")
RADII = ALL_RADII if EXHAUSTIVE else ("0", "1/2")


def test_generalized_alpha_of_chung_and_hulbert() -> None:
    (found,) = design("generalized_alpha")
    published = {
        "alpha_m": (2 * rho - 1) / (rho + 1),
        "alpha_f": rho / (rho + 1),
        "beta": 1 / (1 + rho) ** 2,
        "gamma": (3 - rho) / (2 * (1 + rho)),
    }
    assert all(simplify(found.values[name] - e) == 0 for name, e in published.items())
    assert "all eigenvalues" in found.text


@pytest.mark.parametrize("radius", RADII)
def test_generalized_alpha_at_a_number(radius: str) -> None:
    (found,) = design("generalized_alpha", radius)
    made = derive("generalized_alpha", **found.values)
    assert made.rho_inf == Rational(radius)
    assert made.series.order == 2
    assert certify("generalized_alpha", **found.values).stable


@pytest.mark.parametrize(("name", "parameter"), [("hht_alpha", "alpha"), ("wbz_alpha", "alpha_B")])
def test_one_parameter(name: str, parameter: str) -> None:
    found = [one.values[parameter] for one in design(name)]
    assert any(simplify(e - (rho - 1) / (rho + 1)) == 0 for e in found)


def test_hht_reaches_a_radius_twice() -> None:
    """Beyond -1/3 the third eigenvalue is the largest, and dissipation grows worse again."""
    found = design("hht_alpha", "3/4")
    assert {one.values["alpha"] for one in found} == {Rational(-1, 7), Rational(-3, 7)}
    assert not design("hht_alpha", "1/4")


@pytest.mark.skipif(not EXHAUSTIVE, reason="SUBSTEP_VERIFY=1: takes some seconds")
def test_rho_inf_bathe_is_what_it_says() -> None:
    assert any(one.values == {"rho_inf": rho, "gamma_t": gamma_t} for one in design("rho_inf_bathe"))


@pytest.mark.parametrize("parameters", [("silva_bezerra", {}), ("newmark_bdf2", {"gamma": "1/2", "beta": "1/4"})])
def test_least_period_error(parameters: tuple) -> None:
    name, given = parameters
    found = least_period_error(name, **given)
    assert (found.parameter, found.value) == ("gamma_t", 2 - sqrt(2))
    assert simplify(found.constant - (sqrt(2) / 2 - Rational(2, 3))) == 0


@pytest.mark.parametrize("b", ["3/10", "1/6", "1/5"])
def test_least_period_error_at_another_beta(b: str) -> None:
    found = least_period_error("newmark_bdf2", gamma="1/2", beta=b)
    error = derive("newmark_bdf2", gamma="1/2", beta=b).series.period_error[2].subs("xi", 0)
    size = abs(found.constant.n(30))
    assert all(abs(error.subs(gamma_t, Rational(k, 50))) >= size for k in range(1, 50))


def test_least_period_error_needs_one_free_parameter() -> None:
    with pytest.raises(ValueError, match="leave one parameter free"):
        least_period_error("newmark_bdf2", gamma="1/2")
    with pytest.raises(ValueError, match="leave one parameter free"):
        least_period_error("bathe")


def test_second_order_region() -> None:
    """(beta - 1/(4 t (2 - t)))^2 <= (1 - t)^3/(4 t^2 (2 - t)^4)."""
    inside = conditions(derive("newmark_bdf2", gamma="1/2").scheme)
    for t in (Rational(k, 6) for k in range(1, 6)):
        for b in (Rational(k, 12) for k in range(13)):
            closed = (b - 1 / (4 * t * (2 - t))) ** 2 <= (1 - t) ** 3 / (4 * t**2 * (2 - t) ** 4)
            assert inside.holds({"gamma_t": t, "beta": b}) == bool(closed)


def test_region_without_high_frequencies() -> None:
    (found,) = region(0)
    assert found.beta == Rational(1, 4)
    assert found.intervals == ((0, 1, False, False),)


def test_region_of_a_radius() -> None:
    found = region("1/2")
    assert [
        simplify(one.beta - e) for one, e in zip(found, (1 / (6 - 2 * gamma_t), 1 / (2 + 2 * gamma_t)), strict=True)
    ] == [0, 0]
    for one in found:
        ((low, high, low_closed, high_closed),) = one.intervals
        assert (low, low_closed, high_closed) == (0, False, True)
        split = Rational(str((high / 2).n(10)))
        made = derive("newmark_bdf2", gamma="1/2", gamma_t=split, beta=one.beta.subs(gamma_t, split))
        assert made.rho_inf == Rational(1, 2)
        beyond = Rational(str(high.n(12))) + Rational(1, 10**9)
        assert not certify("newmark_bdf2", gamma="1/2", gamma_t=beyond, beta=one.beta.subs(gamma_t, beyond)).stable
        r = Algebraic.of(high)
        assert certify(
            "newmark_bdf2",
            gamma="1/2",
            gamma_t=r,
            beta=Algebraic(r.coefficients, r.interval, one.beta.subs(gamma_t, r.value)),
        ).stable


def test_no_second_order_member_keeps_all_high_frequencies() -> None:
    assert region(1) == ()


def test_what_cannot_be_designed() -> None:
    with pytest.raises(DeclarationError, match="goes to infinity"):
        design("central_difference", "1/2")
    with pytest.raises(TypeError):
        region(0.5)
    assert beta not in derive("bathe").scheme.values
