"""Schemes by the names that people write, and what is answered to names that are not ours."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from declared import BY_NAME
from substep_derive import derive
from substep_derive.declare.errors import DeclarationError
from substep_derive.declare.symbols import knot
from sympy import Symbol, symbols

import substep as ss
from substep.core.elsewhere import WHY

ANYWAY = {"adding_a_scheme", "beta_0", "beta_1", "rho_inf"}  # words with an underscore that are no schemes
CLAIMED: dict[str, list[str]] = {}
for _name, _scheme in BY_NAME.items():
    for _synonym in _scheme.synonyms:
        _known, _, _values = _synonym.partition(": ")
        CLAIMED.setdefault(_known, []).append(f"{_name} at {_values}" if _values else _name)


@pytest.mark.parametrize(("synonym", "names"), CLAIMED.items())
def test_a_synonym_is_the_one_scheme_that_has_it(synonym: str, names: list[str]) -> None:
    assert re.fullmatch("[a-z0-9]+(_[a-z0-9]+)*", synonym)
    assert synonym not in BY_NAME
    if " at " in names[0]:
        with pytest.raises(ValueError, match=f"which is {names[0]}; write"):
            ss.scheme(synonym)
        return
    if len(names) == 1:
        assert ss.scheme(synonym) == ss.scheme(names[0])
        return
    for call, error in ((ss.scheme, ValueError), (derive, DeclarationError)):
        with pytest.raises(error, match=f"which may be '?{names[0]}'? or .*write which"):
            call(synonym)


@pytest.mark.parametrize(
    ("written", "name"),
    {
        "Newmark-beta": "newmark",
        "Newmark's method": "newmark",
        "trapezoidal rule": "average_acceleration",
        "Constant Average Acceleration": "average_acceleration",
        "HHT": "hht_alpha",
        "HHT-alpha": "hht_alpha",
        "gen_alpha": "generalized_alpha",
        "Generalized-alpha method": "generalized_alpha",
        "velocity Verlet": "central_difference",
        "Störmer-Verlet": "central_difference",
        "Crank-Nicolson": "average_acceleration",
        "Crank\u2013Nicolson": "average_acceleration",
        "implicit Euler": "backward_euler",
        "Houbolt's method": "houbolt",
        "Wilson's theta": "wilson_theta",
        "Bathe": "bathe",
    }.items(),
)
def test_however_it_is_written(written: str, name: str) -> None:
    assert ss.scheme(written).name == name


def test_a_march_takes_them_too() -> None:
    oscillator = ss.scene("linear_oscillator", omega=2.0)
    assert ss.march(oscillator, "Crank-Nicolson", dt=0.1, t_end=0.2).scheme == ss.scheme("average_acceleration")


def test_the_derivation_knows_them_too() -> None:
    assert derive("crank_nicolson").A == derive("average_acceleration").A


@pytest.mark.parametrize(
    ("written", "names"),
    {
        "TR-BDF2": {"bathe", "silva_bezerra", "newmark_bdf2"},
        "leapfrog": {"central_difference", "central_difference_lagged"},
        "midpoint rule": {"rk2", "energy_momentum"},
    }.items(),
)
def test_what_may_be_several_is_asked(written: str, names: set[str]) -> None:
    with pytest.raises(ValueError, match=f"expected one scheme, got '{written}', which may be") as caught:
        ss.scheme(written)
    assert names == {name for name in re.findall(r"\w+", str(caught.value)) if name in BY_NAME}


def test_an_unknown_scheme_is_answered_by_the_nearest_five() -> None:
    with pytest.raises(ValueError, match=r"did you mean 'newmark'\? near are: (\w+, ){4}\w+; substep.schemes\(\)"):
        ss.scheme("newmarc")


@pytest.mark.parametrize(
    ("given", "answer"),
    [
        ({"period": 0.5}, "T, in s"),
        ({"frequency": 2.0}, "f, in Hz"),
        ({"freq": 2.0}, "f, in Hz"),
        ({"wn": 2.0}, "omega, in rad/s"),
        ({"w": 2.0}, "omega, in rad/s"),
        ({"omega": 1.0, "zeta": 0.05}, "xi, the damping ratio"),
        ({"omega": 1.0, "damping": 0.05}, "xi, the damping ratio"),
        ({"k": 4.0}, r"omega = sqrt\(k/m\)"),
        ({"omega": 1.0, "c": 0.1}, r"xi = c/\(2 sqrt\(k m\)\)"),
    ],
)
def test_a_parameter_that_people_write_is_answered_by_ours(given: dict[str, float], answer: str) -> None:
    with pytest.raises(ValueError, match=f"got '{list(given)[-1]}'; here it is {answer}"):
        ss.scene("linear_oscillator", **given)


@pytest.mark.parametrize(("name", "parameter"), [("hht_alpha", "alpha"), ("wbz_alpha", "alpha_B")])
def test_an_alpha_of_the_other_sign_is_asked_about(name: str, parameter: str) -> None:
    with pytest.warns(UserWarning, match=rf"{parameter} = 0.1, .* it is -0.1 here: ss.scheme\('{name}', .*=-0.1\)"):
        wrong = ss.scheme(name, **{parameter: 0.1})
    assert wrong.spectral_radius(1.0) > 1.0 > ss.scheme(name, **{parameter: -0.1}).spectral_radius(1.0)
    ss.scheme(name, **{parameter: 0.0})
    ss.scheme(name, **{parameter: [-0.1, 0.1]})  # for a chart
    ss.scheme("newmark", gamma=0.4)  # whose sign none has otherwise


def test_an_alpha_of_another_paper_is_answered_by_the_one_of_the_scheme() -> None:
    """Both signs as the schemes are the same: HHT at alpha = -0.1 is generalized-alpha at alpha_f = 0.1."""
    with pytest.raises(ValueError, match="got 'alpha_f'; here it is alpha = -alpha_f"):
        ss.scheme("hht", alpha_f=0.1)
    with pytest.raises(ValueError, match="got 'alpha'; here it is alpha_f = -alpha, for HHT's alpha with alpha_m = 0"):
        ss.scheme("generalized_alpha", alpha=-0.1)
    chung = ss.scheme("generalized_alpha", alpha_m=0.0, alpha_f=0.1)
    same = ss.scheme("hht_alpha", alpha=-0.1)
    assert same.amplification(0.7, 0.05) == pytest.approx(chung.amplification(0.7, 0.05), rel=1e-14, abs=1e-14)


@pytest.mark.parametrize(
    ("call", "answer"),
    [
        (lambda: ss.scheme("tr"), r"got 'tr'; near are: tr_bdf2, trbdf3, trapezoidal, "),
        (lambda: ss.scheme_of("OpenSees", "HTT"), r"did you mean 'HHT'\? near are: .*; docs/catalogue_of_programs.md"),
        (lambda: ss.scene("double_pendulum", theta_1=1.0), r"did you mean 'theta1_0'\?"),
        (lambda: ss.scene("pendlum"), r"near are: (\w+, ){4}\w+; substep.scenes\(\), or `substep scenes`, lists all$"),
        (lambda: ss.scene("xyzzy"), r"^expected a scene, got 'xyzzy'; substep.scenes\(\), or `substep scenes`, lists"),
        (lambda: ss.scheme("xyzzy"), r"^expected a scheme, got 'xyzzy'; substep.schemes\(\), or"),
        (lambda: ss.scheme_of("OpenSees", "xyzzy"), "^expected an integrator of OpenSees, got 'xyzzy'; docs/"),
        (lambda: ss.scene("linear_oscillator", xyzzy=1.0), "got 'xyzzy'; known are: omega, "),
    ],
)
def test_near_names_are_named_and_others_are_not(call: Callable[[], Any], answer: str) -> None:
    with pytest.raises(ValueError, match=answer):
        call()


@pytest.mark.parametrize(("given", "ours"), {"h": "dt", "time_step": "dt", "tmax": "t_end"}.items())
def test_an_argument_that_people_write_is_answered_by_ours(given: str, ours: str) -> None:
    with pytest.raises(ValueError, match=f"an argument of march, got '{given}'; here it is {ours};"):
        ss.march("duffing", "bathe", **{given: 0.1})


def test_a_sweep_answers_a_period_by_omega() -> None:
    with pytest.raises(ValueError, match="got 'T'; here it is omega = 2 pi/T"):
        ss.sweep("linear_oscillator", "bathe", dt=0.1, t_end=1.0, T=[0.5, 1.0])


@pytest.mark.parametrize("name", BY_NAME)
def test_a_scheme_is_found_by_what_it_is_and_by_no_other_answer(name: str) -> None:
    s = ss.scheme(name)
    assert s.order is not None
    has = {"order": min(s.order[:2]), "solves": s.balances, "A_stable": s.A_stable, "L_stable": s.L_stable}
    has = {key: value for key, value in has.items() if value is not None} | {"explicit": s.kind == "explicit"}
    assert name in ss.schemes(**has)
    for key, value in has.items():
        other = value + 1 if type(value) is int else not value
        assert name not in ss.schemes(**{key: other})
    for text in (name, name.upper().replace("_", " "), s.reference.split(",")[0], *BY_NAME[name].synonyms):
        assert name in ss.schemes(search=text.partition(": ")[0])


def test_what_is_explicit_takes_no_tangent_of_the_force() -> None:
    explicit = {name for name in BY_NAME if ss.scheme(name).kind == "explicit"}
    for name in ("chang", "kr_alpha", "forest_ruth", "newmark", "energy_momentum", "bathe"):
        tangents = [str(balance.effective_stiffness) for balance in derive(name).balances]
        assert (name in explicit) == all("K_t" not in k and "N_discrete" not in k for k in tangents)
    assert {"central_difference", "kr_alpha", "rk4", "chang"} <= explicit
    assert not {"newmark", "energy_momentum", "gauss2", "bdf2"} & explicit


def test_schemes_are_asked_for_by_answers_that_there_are() -> None:
    assert ss.schemes() == tuple(BY_NAME)
    assert ss.schemes(search="no such scheme") == ()
    for name, value in (("order", 2.0), ("order", True), ("solves", "2"), ("A_stable", 1), ("explicit", "no")):
        with pytest.raises(ValueError, match=f"expected {name} as .*, got {value!r}; give one, or leave it out"):
            ss.schemes(**{name: value})  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize("names", WHY)
def test_a_method_that_is_not_ours_is_answered_by_the_reason(names: str) -> None:
    page = (Path(__file__).parents[1] / "docs" / "findings.md").read_text(encoding="utf-8")
    assert f"| {', '.join(f'`{name}`' for name in names.split())} | {WHY[names]} |" in page
    for name in names.split():
        assert re.fullmatch("[a-z0-9]+(_[a-z0-9]+)*", name)
        assert name not in CLAIMED and name not in BY_NAME
        with pytest.raises(
            ValueError, match=f"^expected a scheme of the catalogue, got '{name}', which is none: "
        ) as caught:
            ss.scheme(name)
        assert str(caught.value).endswith(WHY[names])
    assert {word for word in re.findall(r"\w+", WHY[names]) if "_" in word} <= {*BY_NAME, "substep_derive", *ANYWAY}


@pytest.mark.parametrize(
    "written", ["Nigam-Jennings", "Crank\u2013Nicolson\u2013Leapfrog", "Adams-Bashforth method", "MSSTH(4)"]
)
def test_however_such_a_method_is_written(written: str) -> None:
    with pytest.raises(ValueError, match="which is none: "):
        ss.scheme(written)


def test_of_what_a_sentence_says_is_the_same() -> None:
    """Katona and Zienkiewicz's displacements and velocities with m = 2, against Newmark's."""
    u0, v0, a0, a1, h, b0, b1 = symbols("u0 v0 a0 a1 h b0 b1")
    newmark = {
        s: e.subs({knot(0).u: u0, knot(0).v: v0, knot(0).a: a0, knot(1).a: a1})
        for s, e in BY_NAME["newmark"].relations.items()
    }
    values = {Symbol("beta"): b0 / 2, Symbol("gamma"): b1}
    theirs = {
        knot(1).u: u0 + h * v0 + h**2 / 2 * a0 + b0 * h**2 / 2 * (a1 - a0),
        knot(1).v: v0 + h * a0 + b1 * h * (a1 - a0),
    }
    for symbol, e in theirs.items():
        assert (newmark[symbol].subs(values) - e).expand() == 0
