"""Claimed regions of stability against certificates at points of them, and conditions compared as mathematics."""

from typing import Any

import pytest
from substep_derive.declare.schemes.alpha import generalized_alpha
from substep_derive.declare.symbols import alpha_f, alpha_g, alpha_m, beta, delta, gamma, theta
from substep_derive.stability.certificate import certify
from substep_derive.stability.conditions import conditions
from substep_thesis.derive import printed
from substep_thesis.derive.region import Region, same_conditions, stable_values
from sympy import And, Eq, FiniteSet, Interval, Or, Rational, Symbol, oo, sqrt

half, third = Rational(1, 2), Rational(1, 3)
above = Symbol("above")


def inside_the_declared_intervals(region: Region) -> list[dict[str, Any]]:
    domains = {p.name: p.domain for p in region.scheme.parameters}
    return [point for point in region.points() if all(x in domains[name] for name, x in point.items())]


@pytest.mark.parametrize("region", [printed.wbz_region, printed.generalized_alpha_region, printed.gholampour_region()])
def test_a_region_proved_stable_is_stable_by_certificate(region: Region) -> None:
    assert region.stable
    assert not region.unstable
    points = inside_the_declared_intervals(region)
    assert len(points) >= 3
    assert all(certify(region.scheme, **point).stable for point in points)


def test_the_printed_regions_are_those_of_the_thesis() -> None:
    """Points of the coordinates satisfy the printed inequalities, and each inequality is reached as an equation."""
    for point in printed.gholampour_region().points():
        at = {delta: point["delta"], alpha_g: point["alpha_g"]}
        assert all(c.subs(at) for c in printed.gholampour_conditions)
    assert {"delta": third, "alpha_g": third / 2} in printed.gholampour_region().points()
    touched = set()
    for point in printed.generalized_alpha_region.points():
        m, f, b, g = (point[x.name] for x in (alpha_m, alpha_f, beta, gamma))
        gaps = (f - m, half - f, b - Rational(1, 4) - (f - m) / 2)  # (2.36), (2.36), (2.37)
        assert min(gaps) >= 0
        assert g == half - m + f  # (2.38)
        touched |= {k for k, gap in enumerate(gaps) if gap == 0}
    assert touched == {0, 1, 2}


def test_a_region_that_is_wrong_is_refuted_at_an_exact_point() -> None:
    as_printed = printed.gholampour_region(printed.gholampour_printed)
    assert as_printed.unstable
    assert not certify(printed.gholampour_printed, **as_printed.counterexample or {}).stable
    too_low = Region(  # (2.37) with a smaller beta: stable for some of it only
        generalized_alpha,
        {alpha_m: third * 0, alpha_f: half / 2, beta: Rational(1, 5) + above, gamma: Rational(3, 4)},
        {above: Interval(0, 1)},
    )
    assert not too_low.stable
    assert not too_low.unstable
    found = too_low.counterexample or {}
    assert not certify(generalized_alpha, **found).stable
    assert any(certify(generalized_alpha, **point).stable for point in too_low.points())


def test_a_double_root_on_the_circle_counts_as_unstable() -> None:
    """rho_inf-Bathe at rho_inf = 1 has the eigenvalue -1 twice at one Omega, nowhere else."""
    from substep_derive.declare.schemes.composite import rho_inf_bathe
    from substep_derive.declare.symbols import gamma_t, rho_inf

    closed, open_ = (
        Region(rho_inf_bathe, {rho_inf: 1 - above, gamma_t: half}, {above: interval})
        for interval in (Interval(0, 1), Interval.Lopen(0, 1))
    )
    assert open_.stable
    assert closed.counterexample == {"rho_inf": 1, "gamma_t": half}


def test_without_coordinates_a_region_is_one_scheme() -> None:
    from substep_derive.declare.catalogue import find

    rk4 = Region(find("rk4"), {}, {})
    assert rk4.counterexample == {}
    assert rk4.unstable
    assert Region(find("bathe"), {}, {}).stable


def test_what_is_not_decided_is_not_called_stable(monkeypatch: pytest.MonkeyPatch) -> None:
    from substep_derive.stability.conditions import Conditions

    region = Region(
        generalized_alpha, {alpha_m: above, alpha_f: above, beta: above, gamma: half}, {above: Interval(0, half)}
    )
    assert not region.stable
    again = Region(region.scheme, region.values, region.coordinates)
    monkeypatch.setattr(Conditions, "holds", lambda *_: True)
    with pytest.raises(NotImplementedError, match="undecided"):
        again.stable


def test_conditions_are_compared_as_mathematics() -> None:
    newmark = conditions("newmark")
    assert same_conditions(newmark, (2 * beta >= gamma, gamma >= half))
    assert same_conditions(newmark, (1 - 2 * gamma <= 0, gamma / 4 <= beta / 2))  # scaled, turned round, in order
    assert same_conditions(newmark, (And(gamma >= half, 2 * beta >= gamma),))
    assert not same_conditions(newmark, (2 * beta >= gamma, gamma > half))
    assert not same_conditions(newmark, (2 * beta >= gamma, gamma <= half))
    assert not same_conditions(newmark, (2 * beta >= gamma,))
    assert not same_conditions(newmark, (Or(2 * beta >= gamma, gamma >= half),))
    assert not same_conditions(newmark, (2 * beta >= gamma, Eq(gamma, half)))
    assert same_conditions(conditions("gholampour"), printed.gholampour_conditions)
    assert not same_conditions(conditions("rk4"), ())  # not free of Omega: not all there is


def test_exact_sets_of_one_parameter() -> None:
    assert stable_values(conditions("hht_alpha")) == Interval(-half, 0)
    assert stable_values(conditions("wilson_theta")) == Interval((1 + sqrt(3)) / 2, oo)
    assert stable_values(conditions("wbz_alpha")) == Interval(-1, 0)
    assert stable_values(conditions("silva_bezerra")) == Interval.open(0, 1)
    assert printed.hht_values.is_subset(stable_values(conditions("hht_alpha")))
    assert FiniteSet(Rational(136, 100)).intersect(stable_values(conditions("wilson_theta"))).is_empty
    with pytest.raises(ValueError, match="expected one parameter"):
        stable_values(conditions("newmark"))


@pytest.mark.parametrize("tiny", [Rational(1, 10**9), Rational(1, 10**30)])
def test_the_exact_set_ends_where_certificates_do(tiny: Any) -> None:
    assert certify("hht_alpha", alpha=-half).stable
    assert not certify("hht_alpha", alpha=-half - tiny).stable
    assert not certify("hht_alpha", alpha=tiny).stable
    assert not Region(printed.wilson_theta, {theta: Rational(1366, 1000) + above}, {above: Interval(0, oo)}).stable
