"""Parameters that another given one decides: rho_inf of schemes whose gamma alone makes the step."""

import pytest
from declared import ALL
from substep_derive import DeclarationError, Parameter, Root, certify, derive, tableau
from sympy import Interval, Rational, Symbol

import substep as ss

gamma, rho_inf = Symbol("gamma"), Symbol("rho_inf")
DECIDED = {"three_substep_third_order": (3, 0.4, 13 / 48), "four_substep": (4, 0.5, 1 / 3)}


def test_these_schemes_have_one() -> None:
    found = {s.name: {p.name: by.name for p, (by, _) in s.decided.items()} for s in ALL if s.decided}
    assert found == {name: {"rho_inf": "gamma"} for name in DECIDED}


@pytest.mark.parametrize("name", DECIDED)
def test_the_handle_shows_the_radius_that_it_has(name: str) -> None:
    _, given, radius = DECIDED[name]
    s = ss.scheme(name, gamma=given)
    assert s.parameters["rho_inf"] == pytest.approx(radius, abs=1e-14)
    assert s.spectral_radius(1e9) == pytest.approx(radius, abs=1e-8)
    many = ss.scheme(name, gamma=[given, given + 0.01])
    assert many.parameters["rho_inf"] == pytest.approx(many.spectral_radius(1e9), abs=1e-8)
    assert [*s.given] == ["gamma"]
    default = ss.scheme(name)
    assert default.parameters["rho_inf"] == 0.5
    again = ss.scheme(name, gamma=float(default.parameters["gamma"]))
    assert again.parameters["rho_inf"] == pytest.approx(0.5, abs=1e-12)


@pytest.mark.parametrize("name", DECIDED)
def test_both_are_refused_unless_they_agree(name: str) -> None:
    _, given, radius = DECIDED[name]
    assert ss.scheme(name, gamma=given, rho_inf=radius) == ss.scheme(name, gamma=given)
    with pytest.raises(ValueError, match=rf"expected rho_inf or gamma of {name}, which decides it.*drop one"):
        ss.scheme(name, gamma=given, rho_inf=0.9)
    exact = str(Rational(given).limit_denominator(100))
    with pytest.raises(DeclarationError, match="gamma decides rho_inf: expected one of the two, got rho_inf = 9/10"):
        certify(name, gamma=exact, rho_inf="9/10")
    with pytest.raises(DeclarationError, match="gamma decides rho_inf"):
        derive(name, gamma=exact, rho_inf="9/10")


@pytest.mark.parametrize("name", DECIDED)
def test_a_gamma_that_no_radius_has_is_refused(name: str) -> None:
    """Beyond rho_inf = 0, where R(oo) changes its sign."""
    beyond = {"three_substep_third_order": "439/1000", "four_substep": "579/1000"}[name]
    with pytest.raises(ValueError, match=rf"rho_inf of {name} \(which gamma decides\)"):
        ss.scheme(name, gamma=float(Rational(beyond)))
    for asked in (certify, derive):
        with pytest.raises(DeclarationError, match=r"rho_inf = -\d+/\d+ lies outside 0 <= rho_inf <= 1"):
            asked(name, gamma=beyond)
    for radius in (0.0, 1.0):  # the ends themselves, gamma rounded
        end = float(ss.scheme(name, rho_inf=radius).parameters["gamma"])
        assert ss.scheme(name, gamma=end).parameters["rho_inf"] == radius


@pytest.mark.parametrize("name", DECIDED)
def test_exact_results_say_what_follows(name: str) -> None:
    _, given, radius = DECIDED[name]
    exact = Rational(given).limit_denominator(100)
    title = certify(name, gamma=exact).text.splitlines()[0]
    assert f"rho_inf = {Rational(radius).limit_denominator(100)}, gamma = {exact}" in title
    member = derive(name, gamma=exact)
    assert not member.scheme.parameters
    assert abs(float(member.rho_inf)) == pytest.approx(radius, abs=1e-15)


def test_a_declaration_of_ones_own_is_treated_alike() -> None:
    """gamma = (1 - p)/2 at the default; p decides nothing else."""
    p = Symbol("p_own")
    parameters = (
        Parameter(p, Interval(0, 1), Rational(1, 2)),
        Parameter(gamma, Interval(0, 1), Root(2 * gamma + p - 1)),
    )
    own = tableau("own", ((gamma,),), (1,), (gamma,), parameters=parameters)
    assert own.decided == {p: (gamma, 1 - 2 * gamma)}
    assert own.fix({"gamma": "1/3"}).fixed == {"gamma": Rational(1, 3), "p_own": Rational(1, 3)}


def test_a_default_that_reads_a_third_parameter_decides_nothing() -> None:
    """gamma = p + q at the default: gamma alone says neither."""
    p, q = Symbol("p_own"), Symbol("q_own")
    quarter = Rational(1, 4)
    parameters = (
        Parameter(p, Interval(0, 1), quarter),
        Parameter(q, Interval(0, 1), quarter),
        Parameter(gamma, Interval(0, 2), Root(gamma - p - q)),
    )
    own = tableau("own", ((gamma,),), (1,), (gamma,), parameters=parameters)
    assert own.decided == {}
    assert "gamma = 3/4" in certify(own, gamma="3/4").text.splitlines()[0]
