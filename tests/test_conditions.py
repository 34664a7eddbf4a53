"""Conditions on the parameters against certificates at random rational points, on boundaries, and published regions."""

import os
from functools import cache
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from substep_derive import DeclarationError, derive
from substep_derive.declare.symbols import alpha_B, beta, gamma, theta
from substep_derive.stability.certificate import certify
from substep_derive.stability.conditions import Conditions, conditions
from sympy import And, Rational, sqrt

EXHAUSTIVE = os.environ.get("SUBSTEP_VERIFY") == "1"
POINTS = 500 if EXHAUSTIVE else 60
CONSTANT = [name for name, s in BY_NAME.items() if s.constant is not None]
SLOW = ("three_substep", "kr_alpha", "kr_alpha_plain_start")
FREE = (
    "newmark",
    "newmark_bdf2",
    "silva_bezerra",
    "rho_inf_bathe",
    "beta1_beta2_bathe",
    "noh_bathe",
    "generalized_alpha",
    "hht_alpha",
    "wbz_alpha",
    "wilson_theta",
    "gholampour",
    "oalts",
    *SLOW * EXHAUSTIVE,
)


@cache
def derived(name: str) -> Conditions:
    return conditions(BY_NAME[name])


def grid_point(name: str, rng: np.random.Generator) -> dict[str, Rational]:
    """Random parameters on a coarse grid, so that many points lie on a boundary."""
    values: dict[str, Rational] = {}
    for parameter in BY_NAME[name].parameters:
        low = parameter.domain.start
        width = (parameter.domain.end if parameter.domain.end.is_finite else low + Rational(3, 2)) - low
        while (value := low + width * Rational(int(rng.integers(0, 25)), 24)) not in parameter.domain:
            pass
        values[parameter.name] = value
    for symbol, (by, follows) in BY_NAME[name].decided.items():
        values[symbol.name] = follows.subs(by, values[by.name])
    return values


@pytest.mark.parametrize(
    ("name", "interval"),
    [
        ("hht_alpha", "-1/2 <= alpha <= 0"),
        ("wilson_theta", "theta >= 1/2 + sqrt(3)/2"),
        ("sdirk2", "1 - sqrt(2)/2 <= gamma <= 1/2"),
    ],
)
def test_what_leaves_one_parameter_an_interval_is_written_as_that(name, interval):
    assert derived(name).text.splitlines()[1:] == [f"  {interval}"]


@pytest.mark.parametrize("name", FREE)
def test_conditions_agree_with_certificates(name: str) -> None:
    found, rng = derived(name), np.random.default_rng(11)
    for _ in range(POINTS):
        values = grid_point(name, rng)
        assert found.holds(values) == certify(BY_NAME[name], **values).stable, values


@pytest.mark.parametrize("name", sorted(set(BY_NAME) - set(FREE) - set(SLOW) - set(CONSTANT)))
def test_members_agree_with_certificates(name: str) -> None:
    found = conditions(BY_NAME[name])
    values = grid_point(name, np.random.default_rng(3))
    assert found.holds(values) == certify(BY_NAME[name], **values).stable


@pytest.mark.parametrize("name", CONSTANT)
def test_conditions_with_a_constant_are_refused(name: str) -> None:
    with pytest.raises(NotImplementedError, match=f"{name}: expected numbers that are rational.*take certify"):
        conditions(BY_NAME[name])


def test_newmark() -> None:
    found = derived("newmark")
    assert And(*found.inequalities) == And(2 * beta >= gamma, gamma >= Rational(1, 2))
    assert found.eliminated
    assert found.text.splitlines()[-2:] == ["  2*beta >= gamma", "  gamma >= 1/2"]


@pytest.mark.parametrize("name", [name for name in FREE if name != "oalts"])
def test_omega_is_eliminated(name: str) -> None:
    found = derived(name)
    assert found.eliminated
    assert "Omega > 0:" not in found.text


def test_more_than_three_eigenvalues_or_a_high_degree() -> None:
    assert not derived("oalts").eliminated
    assert conditions("park").eliminated
    assert conditions("rk4").text == "rk4, xi = 0: not stable for every Omega > 0"  # though Omega stays in others
    assert not conditions("rk4").eliminated
    assert "for all Omega > 0" in conditions("four_substep").text


def test_single_parameters() -> None:
    assert derived("wilson_theta").inequalities == (2 * theta**2 - 2 * theta - 1 >= 0,)
    assert derived("wbz_alpha").inequalities == (alpha_B <= 0,)
    assert derived("silva_bezerra").inequalities == ()
    for alpha, stable in (("-1/2", True), ("-501/1000", False), (0, True), ("1/1000", False)):
        assert derived("hht_alpha").holds({"alpha": alpha}) is stable


def test_generalized_alpha_of_second_order() -> None:
    """Chung & Hulbert 1993: alpha_m <= alpha_f <= 1/2 and beta >= 1/4 + (alpha_f - alpha_m)/2."""
    found, rng = derived("generalized_alpha"), np.random.default_rng(5)
    for _ in range(POINTS):
        m, f = Rational(int(rng.integers(-20, 11)), 20), Rational(int(rng.integers(0, 11)), 20)
        b = Rational(1, 4) + (f - m) / 2 + Rational(int(rng.integers(-2, 3)), 20)
        g = Rational(1, 2) - m + f
        if b >= 0 and g >= 0:
            published = m <= f and b >= Rational(1, 4) + (f - m) / 2
            assert found.holds({"alpha_m": m, "alpha_f": f, "beta": b, "gamma": g}) == published


def on_the_discriminant(split: Rational, root: Rational, sign: int) -> dict[str, Rational]:
    """newmark_bdf2 where the discriminant of p(-1) vanishes; root^2 = 2*gamma*(2 - gamma_t) - 1."""
    g = (root**2 + 1) / (2 * (2 - split))
    w = -1 + sign * root
    return {
        "gamma_t": split,
        "gamma": g,
        "beta": ((1 - split) * w + g * (2 - split) + 1 - split) / (2 * split * (2 - split) ** 2),
    }


BOUNDARY = [
    *({"gamma_t": t, "beta": b, "gamma": Rational(1, 2)} for t in map(Rational, ("1/3", "1/2", "3/4"))
      for b in map(Rational, ("1/4", "3/10", "2/5"))),
    *({"gamma_t": t, "beta": g / (2 * t), "gamma": g} for t in map(Rational, ("1/3", "1/2", "3/4"))
      for g in map(Rational, ("1/2", "4/5", "3/2"))),
    *({"gamma_t": t, "beta": g / (2 * (2 - t)), "gamma": g} for t in map(Rational, ("1/3", "1/2", "3/4"))
      for g in map(Rational, ("1/2", "2/3", "4/5"))),
    *(on_the_discriminant(t, s, sign) for t in map(Rational, ("1/3", "1/2", "3/4"))
      for s in map(Rational, ("3/4", "9/10", "5/4")) for sign in (1, -1)),
]  # fmt: skip


@pytest.mark.parametrize("shift", [0, 1, -1])
def test_boundary_surfaces_of_newmark_bdf2(shift: int) -> None:
    found, tiny, stable = derived("newmark_bdf2"), Rational(1, 10**6), set()
    for values in BOUNDARY:
        near = {**values, "beta": values["beta"] + shift * tiny}
        if near["beta"] >= 0:
            expected = certify("newmark_bdf2", **near).stable
            stable.add(expected)
            assert found.holds(near) == expected, near
    assert stable == {True, False}


@pytest.mark.parametrize(("b", "g"), [("1/4", "1/2"), ("1/3", "2/3"), ("1/2", "1/2"), ("1/5", "2/5"), ("1/4", "3/5")])
def test_boundary_of_newmark(b: str, g: str) -> None:
    assert derived("newmark").holds({"beta": b, "gamma": g}) == certify("newmark", beta=b, gamma=g).stable


def test_minus_one_twice_at_one_frequency() -> None:
    """At rho_inf = 1 the powers stay bounded (A = -I), but -1 is a double eigenvalue at one Omega."""
    assert derived("rho_inf_bathe").text.splitlines()[-1] == "  rho_inf != 1"
    found = certify("rho_inf_bathe", rho_inf=1, gamma_t="1/2")
    assert [high for _, high, _, _ in found.intervals] == [4, found.intervals[1][1]]


@pytest.mark.parametrize("damping", ["1/20", "1/2"])
def test_damped(damping: str) -> None:
    found, rng = conditions("newmark", damping), np.random.default_rng(7)
    for _ in range(20):
        values = grid_point("newmark", rng)
        assert found.holds(values) == certify("newmark", damping, **values).stable, values


def test_what_cannot_be_asked() -> None:
    found = derived("newmark")
    with pytest.raises(ValueError, match="give a value for gamma"):
        found.holds({"beta": "1/4"})
    with pytest.raises(DeclarationError, match="no parameter 'theta'"):
        found.holds({"theta": 1})
    with pytest.raises(TypeError):
        found.holds({"beta": 0.25, "gamma": "1/2"})
    with pytest.raises(DeclarationError):
        conditions("newmarkk")


def test_the_threshold_of_wilson_is_irrational() -> None:
    tiny = Rational(1, 10**40)
    threshold = (1 + sqrt(3)) / 2
    above: Any = Rational(str(threshold.n(60))) + tiny
    assert derived("wilson_theta").holds({"theta": above})
    assert not derived("wilson_theta").holds({"theta": above - 2 * tiny})


def test_what_is_derived_shows_itself_in_one_line() -> None:
    """At most a line at a prompt, where its formulas would fill screens."""
    d = derive("newmark_bdf2")
    for found in (d, d.amplification, d.series, d.estimator, conditions("newmark_bdf2")):
        assert len(repr(found)) <= 100
        assert "\n" not in repr(found)
    assert repr(d) == "<derivation of newmark_bdf2: gamma_t, beta, gamma; state u, h*v, h^2*a>"
