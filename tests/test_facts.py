"""Facts about schemes at run time: at the defaults, at other parameters, without SymPy; and the table in the README."""

import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from substep_derive import certify, derive
from substep_kernels.facts import CATALOGUE, FORMS
from sympy import sympify
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app
from substep.derived.simple_fraction import simple_fraction

LARGE = {"yoshida6": 1e8, "bdf4": 1e15}  # else 1e9: of others the radius there differs from its limit by 1e-3 at most


@pytest.mark.parametrize("name", ss.schemes())
def test_facts_at_the_defaults_are_what_the_kernels_do(name: str) -> None:
    s: Any = ss.scheme(name)  # whose facts are all known
    assert s.order == CATALOGUE[name]["order"]
    radius = float(s.spectral_radius(LARGE.get(name, 1e9)))
    assert radius == pytest.approx(s.rho_inf, abs=2e-3) if s.rho_inf < math.inf else radius > 1e6
    limit = s.critical_Omega
    below, above = np.linspace(1e-3, 0.999, 50) * min(limit, 1e3), 1.002 * limit
    if limit > 0:
        assert s.spectral_radius(below).max() <= 1 + 1e-9
    if 0 < limit < math.inf:
        assert s.spectral_radius(above) > 1 + 1e-7
    if s.A_stable:
        assert s.spectral_radius(np.logspace(-3, 5, 40)[:, None], [0.0, 0.05, 0.5, 1.0, 4.0]).max() <= 1 + 1e-7
    assert s.L_stable is (s.A_stable and s.rho_inf == 0.0) or s.A_stable is None
    for (power, coefficient), error in zip(s.first_errors, s.stability(0.02)[1:], strict=True):
        assert error == pytest.approx(coefficient * 0.02**power, rel=0.15, abs=1e-14)


GIVEN = {
    "newmark": [{"beta": 0.3, "gamma": 0.6}, {"beta": 0.25, "gamma": 0.6}, {"beta": 0.2, "gamma": 0.5}],
    "newmark_bdf2": [{"gamma_t": 0.2, "beta": 0.3025, "gamma": 0.6}, {"gamma_t": 0.5, "beta": 0.4, "gamma": 0.5}],
    "generalized_alpha": [{"rho_inf": 0.5}, {"rho_inf": 0.0}, {"alpha_m": 0.2, "alpha_f": 0.3}],
    "hht_alpha": [{"alpha": -0.2}, {"alpha": -0.6}],
    "wbz_alpha": [{"alpha_B": -0.3}],
    "wilson_theta": [{"theta": 1.5}, {"theta": 1.2}],
    "gholampour": [{"delta": 1.0, "alpha_g": 0.6}],
    "rho_inf_bathe": [{"rho_inf": 0.25, "gamma_t": 0.5}],
    "beta1_beta2_bathe": [{"rho_inf": 0.25}],
    "kr_alpha": [{"rho_inf": 0.75}],
    "silva_bezerra": [{"gamma_t": 0.3}],
    "sdirk2": [{"gamma": 0.3}],
    "tchamwa_wielgosz": [{"phi": 1.2}],
}


@pytest.mark.parametrize(("name", "given"), [(name, given) for name, sets in GIVEN.items() for given in sets])
def test_facts_at_other_parameters_are_those_of_the_derivation(name: str, given: dict[str, float]) -> None:
    s: Any = ss.scheme(name, **given)
    own = {key: str(simple_fraction(float(x))) for key, x in s.parameters.items()}
    proof, exact = certify(name, **own), derive(name, **own)
    assert s.rho_inf == pytest.approx(float(exact.rho_inf), rel=1e-14)
    assert s.critical_Omega == (math.inf if proof.stable else None)
    assert (s.A_stable is False) == (not proof.stable)
    if name == "sdirk2":  # its default solves the condition for second order, which another value does not
        assert s.order is None
    else:
        assert all(mine <= true for mine, true in zip(s.order, exact.order, strict=True))
        assert s.order[:2] == exact.order[:2]
    assert s.overshoot is None
    assert s.first_errors == (None, None)


@pytest.mark.parametrize("name", FORMS)
def test_forms_at_the_defaults_are_the_facts(name: str) -> None:
    """The general forms and the facts at defaults are derived on two ways."""
    values = [float(x) for x in ss.scheme(name).parameters.values()]
    fractions = [simple_fraction(x) for x in values]
    almost = ss.scheme(name, **{key: float(x) * (1 + 1e-15) for key, x in list(ss.scheme(name).parameters.items())[:1]})
    if CATALOGUE[name]["values"]["rho_inf"] < math.inf and name not in {"three_substep_third_order"}:
        assert almost.rho_inf == pytest.approx(ss.scheme(name).rho_inf, abs=2e-7)
    if FORMS[name]["stable"] is not None and None not in fractions:
        stable = FORMS[name]["stable"](*fractions)
        assert stable == (CATALOGUE[name]["critical_Omega"] == "none")


@pytest.mark.parametrize("name", FORMS)
def test_rho_inf_has_a_closed_form_or_is_refused_with_the_ways_to_a_number(name: str) -> None:
    """At the defaults it is what was found there without the closed form."""
    d, s = derive(name), ss.scheme(name)
    if FORMS[name]["limit_text"]:
        at_defaults = {p.symbol: float(s.parameters[p.name]) for p in d.scheme.parameters}
        assert float(d.rho_inf.subs(at_defaults)) == pytest.approx(s.rho_inf, abs=2e-7)
        return
    with pytest.raises(
        ValueError, match=r"got the largest modulus of the \d roots of .* free; give values as in derive"
    ):
        d.rho_inf
    exact = {key: str(simple_fraction(float(x))) for key, x in s.parameters.items()}
    assert float(derive(name, **exact).rho_inf) == pytest.approx(s.rho_inf, rel=1e-12)


@pytest.mark.parametrize("name", ss.schemes())
def test_the_closed_form_of_rho_inf_is_there_as_text_and_latex(name: str) -> None:
    """Where there is one; SymPy reads the text as what is derived."""
    text, latex = ss.scheme(name).rho_inf_forms
    assert bool(text) == bool(latex) == bool(name in FORMS and FORMS[name]["limit_text"])
    if text and not set("|,") & set(text):  # neither a modulus nor cases
        defaults = {key: float(x) for key, x in ss.scheme(name).parameters.items()}
        assert float(sympify(text.replace("^", "**"), defaults)) == pytest.approx(ss.scheme(name).rho_inf, abs=1e-12)


def test_facts_of_a_scheme_of_ones_own_are_left_to_the_derivation() -> None:
    s = ss.scheme(replace(derive("newmark").scheme, name="mine"))
    assert (s.order, s.rho_inf, s.critical_Omega, s.A_stable, s.L_stable, s.overshoot) == (None,) * 6
    assert s.rho_inf_forms == ("", "")
    for name in ("order", "critical_Omega", "A_stable", "L_stable"):
        assert "`substep_derive." in str(getattr(type(s), name).__doc__)


def test_parameters_that_are_no_simple_fractions_leave_stability_to_certify() -> None:
    s = ss.scheme("newmark", beta=math.pi / 10, gamma=0.6)
    assert (s.critical_Omega, s.A_stable, s.order) == (None, None, (1, 1, 1))
    assert s.rho_inf == pytest.approx(float(s.spectral_radius(1e9)), abs=1e-6)
    many = ss.scheme("newmark", beta=[0.25, 0.3, 0.4], gamma=0.6)
    assert many.rho_inf == pytest.approx([float(many.lane(j).rho_inf) for j in range(3)], rel=1e-7)
    assert (many.order, many.critical_Omega) == (None, None)


@pytest.mark.parametrize(
    ("name", "beta"), [("linear_acceleration", 1 / 6), ("fox_goodwin", 1 / 12), ("central_difference", 0.0)]
)
def test_facts_at_the_parameters_of_a_member_are_the_member_s(name: str, beta: float) -> None:
    """The limit of Newmark's scheme at gamma = 1/2 is 1/sqrt(1/4 - beta)."""
    given = ss.scheme("newmark", beta=beta, gamma=0.5)
    assert given.critical_Omega == pytest.approx(1.0 / math.sqrt(0.25 - beta), rel=1e-14)
    assert given.facts == ss.scheme(name).facts
    assert ss.scheme("newmark", beta=beta, gamma=0.6).critical_Omega is None


@pytest.mark.filterwarnings("ignore:hht_alpha is not A-stable")
@pytest.mark.parametrize(("name", "given"), [("newmark", {"gamma": 0.4}), ("hht_alpha", {"alpha": 0.1})])
def test_a_handle_says_that_its_parameters_take_stability_away(name: str, given: dict[str, float]) -> None:
    s = ss.scheme(name, **given)
    assert s.spectral_radius(1.0) > 1.0
    assert s.A_stable is False
    assert repr(s).endswith(", not A-stable)")
    assert "A-stable" not in repr(ss.scheme(name))
    assert "A-stable" not in repr(ss.scheme("rk4"))  # which no parameter takes it from


def test_facts_come_without_sympy_or_numba_and_only_when_asked_for() -> None:
    code = (
        "import sys, substep as ss; s = ss.scheme('bathe'); assert 'substep_kernels.facts' not in sys.modules;"
        "print(s.order, s.rho_inf, s.critical_Omega, s.A_stable, s.L_stable, s.overshoot, s.first_errors);"
        "ss.scheme('newmark', beta=0.3, gamma=0.6).rho_inf; assert not {'sympy', 'numba'} & set(sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (
        done.stdout.strip()
        == "(2, 2, 2) 0.0 inf True True U0-V0 ((3, 0.003472222222222222), (2, 0.041666666666666664))"
    )


def test_the_table_of_schemes_in_the_readme_is_up_to_date() -> None:
    readme = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    found = readme.split("<!-- substep schemes --markdown -->\n")[1].split("<!-- end -->")[0]
    assert found.strip() == CliRunner().invoke(app, ["schemes", "--markdown"]).output.strip()
