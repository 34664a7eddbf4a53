"""The command `substep show`."""

import re
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import pytest
from docutils.utils.math.latex2mathml import tex2mathml
from substep_derive.study.closed_forms import ClosedForm, closed_forms
from substep_derive.study.derivation import derive
from sympy import simplify
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app
from substep.derived import facade

runner = CliRunner()


@pytest.mark.parametrize("name", ss.schemes())
def test_show_prints_the_facts_within_the_terminal(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    result = runner.invoke(app, ["show", name])
    assert result.exit_code == 0, result.output
    for word in ("state: u", "order of u, v, a: ", "rho_inf: ", "overshoot: U", "K_eff of balance 1: ", "--part"):
        assert word in result.output
    words = [line for line in result.output.splitlines() if len(line) > 80]
    assert all(" " not in line.strip() for line in words)  # one factor may be wider than the terminal


@pytest.mark.parametrize("name", ss.schemes())
def test_show_prints_the_closed_forms(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    original = facade.closed_forms
    derived = cache(lambda name, part: list(original(name, part)))
    monkeypatch.setattr(facade, "closed_forms", derived)  # derived once for all ways to print
    text = runner.invoke(app, ["show", name, "--part", "all"])
    assert text.exit_code == 0, text.output
    for word in ("K_eff", "den = ", "N_12", "rho_inf", "numerical damping", "period error"):
        assert word in text.output
    assert "**" not in text.output
    latex = runner.invoke(app, ["show", name, "--latex"])
    assert latex.exit_code == 0
    assert latex.output.count(r"\[") == latex.output.count(r"\]") > 10
    assert r"\Omega" in latex.output


@pytest.mark.parametrize("name", ["bathe", "hht_alpha", "wilson_theta"])
def test_show_writes_a_page_that_is_typeset(name: str, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    assert runner.invoke(app, ["show", name, "--html", str(page)]).exit_code == 0
    body = page.read_text(encoding="utf-8").split("<body>")[1].split("</body>")[0]
    root = ElementTree.fromstring(f"<body>{body.replace('&InvisibleTimes;', ' ')}</body>")
    assert len(root.findall(".//math")) > 10


def test_show_prints_a_part_as_a_paper_does() -> None:
    stiffness = runner.invoke(app, ["show", "newmark_bdf2", "--part", "stiffness"]).output
    assert "K_eff = C*(2 - gamma_t)/(h*(1 - gamma_t))" in stiffness
    assert "den" not in stiffness
    series = " ".join(runner.invoke(app, ["show", "newmark", "--part", "series"]).output.split())
    assert "numerical damping, Omega^1 = (1 - 2*xi^2)*(2*gamma - 1)/(4*(1 - xi^2)^(3/2))" in series
    spectrum = " ".join(runner.invoke(app, ["show", "newmark", "--part", "spectrum"]).output.split())
    assert "where 4*gamma^2 + 4*gamma + 1 < 16*beta, else" in spectrum
    assert "beta >= 0" in runner.invoke(app, ["conditions", "newmark"]).output
    assert runner.invoke(app, ["show", "bathe", "--part", "nothing"]).exit_code == 2


@pytest.mark.parametrize("name", ["newmark_bdf2", "hht_alpha", "central_difference"])
def test_names_and_sentences_are_typeset(name: str) -> None:
    for form in closed_forms(name):
        sentence = isinstance(form.value, str)
        assert read(form.label) == plain("ρ∞" if form.name == "rho_inf" else form.name)
        assert form.label.startswith(r"\text{") or re.fullmatch(r"[\\\w{}]+", form.label)
        assert form.latex.startswith(r"\text{" if sentence else f"{form.label} = ")
        if sentence:
            assert read(form.latex) == plain(f"{form.name}: {form.text}")


def test_a_label_escapes_what_latex_reads_as_a_command() -> None:
    assert ClosedForm("", "50 % of (a)^(b)", "").label == r"\text{50 \% of (a)\textasciicircum{}(b)}"
    assert ClosedForm("", "rho_inf", "").label == r"\rho_\infty"
    assert ClosedForm("", "p_0 (of mu^0)", "").label == r"\text{$p_{0}$ (of $\mu^{0}$)}"


def read(latex: str) -> str:
    """The characters that Docutils reads in LaTeX; it would show a macro within a text as it is."""
    return plain("".join(ElementTree.fromstring(tex2mathml(latex)).itertext()))


def plain(text: str) -> str:
    """A text without blanks and marks of indices and powers, and with Greek letters."""
    for name, letter in {"->": "→", "Omega": "Ω", "lambda": "λ", "mu": "μ"}.items():
        text = re.sub(rf"(?<![A-Za-z]){name}(?![A-Za-z])", letter, text)
    return re.sub(r"[_^\s]", "", text)


def test_factors_are_positive_where_the_parameters_lie_in_every_part() -> None:
    text = " ".join(runner.invoke(app, ["show", "newmark_bdf2", "--part", "all"]).output.split())
    assert "C*(u_1*(2 - gamma_t)/(h*(1 - gamma_t)) + " in text
    assert "the modulus 1 + (-gamma_t*(2*gamma - 1)/(4*(2 - gamma_t)))*(omega h)^2" in text
    assert "(gamma_t - 2)" not in text
    assert "(gamma_t - 1)" not in text


@pytest.mark.parametrize("name", ["newmark_bdf2", "generalized_alpha", "newmark", "rk4"])
def test_residuals_as_in_a_paper_are_the_derived_ones(name: str) -> None:
    shown = [form.value for form in closed_forms(name, "stiffness") if form.name == "R"]
    assert len(shown) == len(derive(name).balances) > 0
    for one, system in zip(shown, derive(name).balances, strict=True):
        assert simplify(one - system.residual) == 0


def test_show_of_an_unknown_scheme_names_the_nearest() -> None:
    result = runner.invoke(app, ["show", "bath"])
    assert result.exit_code == 2
    assert "bathe" in result.output
