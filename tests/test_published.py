"""What is published about a scheme, which its declaration carries, is what is derived."""

from dataclasses import replace
from typing import Any

import pytest
from declared import BY_NAME
from substep_derive import Scheme, certify
from substep_derive.declare.digest import scheme_digest
from substep_derive.declare.parameter_set import ParameterSet
from substep_derive.oscillator.evaluation import Evaluation
from substep_derive.oscillator.spectrum import rho_infinity_at
from substep_derive.stability.conditions import conditions
from substep_kernels.facts import CATALOGUE
from substep_thesis.derive.region import same_conditions
from sympy import Rational, oo, simplify, sympify

FACTS = ("order", "rho_inf", "critical_Omega", "stable_if")


def stating(fact: str) -> pytest.MarkDecorator:
    """Every scheme that states the fact, with what it states."""
    stated = [(s, getattr(s.published, fact)) for s in BY_NAME.values() if s.published is not None]
    kept = [pytest.param(s, value, id=s.name) for s, value in stated if value not in (None, ())]
    assert kept
    return pytest.mark.parametrize(("scheme", "stated"), kept)


def test_every_fact_that_can_be_stated_is_tested() -> None:
    from dataclasses import fields

    from substep_derive.declare.published import Published

    assert {f.name for f in fields(Published)} == {"source", *FACTS}
    assert all(s.published is None or s.published.source for s in BY_NAME.values())


@stating("order")
def test_order(scheme: Scheme, stated: int) -> None:
    """The order as it is committed; that it is what is derived is tested in test_generated."""
    assert CATALOGUE[scheme.name]["order"][:2] == (stated, stated)


@stating("rho_inf")
def test_spectral_radius_at_infinity(scheme: Scheme, stated: Any) -> None:
    """As a function of the argument that names it, at several values of its interval."""
    stated = sympify(stated)
    given = {p.name: p.domain for p in (*scheme.parameters, *(f.argument for f in scheme.families))}
    ends = [(s.name, given[s.name].start, given[s.name].end) for s in stated.free_symbols]
    shares = Rational(1, 2), Rational(4, 5), Rational(1)
    points = [{name: low + share * (high - low)} for name, low, high in ends for share in shares] or [{}]
    for values in points:
        found = rho_infinity_at(Evaluation.at(ParameterSet.of(scheme, None, values)))
        assert found == stated if stated == oo else simplify(found - stated.subs(values)) == 0, values


@stating("critical_Omega")
def test_critical_Omega(scheme: Scheme, stated: Any) -> None:
    found = certify(scheme)
    assert found.stable if stated == oo else found.critical_Omega == stated


@stating("stable_if")
def test_stable_region(scheme: Scheme, stated: Any) -> None:
    assert same_conditions(conditions(scheme), stated)


@stating("source")
def test_what_is_published_is_no_part_of_the_digest(scheme: Scheme, stated: str) -> None:
    assert stated
    without = replace(scheme, published=None)
    assert scheme_digest(without) == scheme_digest(scheme)
    assert without == scheme
