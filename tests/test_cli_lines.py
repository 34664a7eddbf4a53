"""What commands print stays within the terminal, and nothing of it is lost."""

from inspect import cleandoc

import pytest
from all_commands import all_commands
from substep_derive import certify
from substep_derive.declare.catalogue import find
from substep_derive.estimate.quality import filter_of, in_paper
from substep_thesis import command
from substep_thesis.claims import CLAIMS, Judgement
from sympy import simplify
from typer.testing import CliRunner

import substep as ss
from substep.cli import commands, failures
from substep.cli.lines import folded, labelled
from substep.studies.failures import Row

runner = CliRunner()
COMMANDS = all_commands()


@pytest.mark.matrix
@pytest.mark.parametrize(
    "arguments",
    [
        "certify newmark_bdf2",
        "certify hht_alpha",
        "estimator bathe",
        "estimator newmark_bdf2",
        "conditions newmark_bdf2",
        "conditions bathe",
        "design generalized_alpha --rho-inf 1/2",
        "equivalences bathe silva_bezerra",
    ],
)
def test_what_is_derived_is_printed_within_80_columns_as_a_paper_writes_it(
    arguments: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    result = runner.invoke(commands.app, arguments.split())
    assert result.exit_code == 0, result.output
    assert max(map(len, result.output.splitlines())) <= 80
    assert "**" not in result.output
    assert "(gamma_t - 2)" not in result.output  # positive factors
    assert "Derivative" not in result.output
    assert "if always" not in " ".join(result.output.split())


def test_an_estimate_is_written_with_primes_and_its_filter_with_factors() -> None:
    text = " ".join(runner.invoke(commands.app, ["estimator", "newmark_bdf2"]).output.split())
    assert "*u'''(t)/(2*(2 - gamma_t)) to leading order" in text
    damped = "C*h*(1 - gamma_t)*(2 - gamma_t) + K*h^2*(1 - gamma_t)^2 + M*(2 - gamma_t)^2"
    assert text.endswith(f"filter for stiff components: M*(2 - gamma_t)^2/({damped})")


@pytest.mark.parametrize("name", ["newmark_bdf2", "hht_alpha", "trbdf3", "bathe"])
def test_a_filter_as_in_a_paper_is_the_derived_one(name: str) -> None:
    shown, derived = in_paper(find(name)), filter_of(find(name))
    assert shown is not None
    assert simplify(shown / derived) == 1


@pytest.mark.parametrize("columns", [40, 80, 1000])
def test_folded_lines_keep_every_letter_and_their_indentation(columns: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    text = certify("newmark_bdf2").text
    lines = folded(text).splitlines()
    assert "".join("".join(lines).split()) == "".join(text.split())
    narrow = [line for line in text.splitlines() if len(line) <= columns]
    assert [line for line in lines if line in narrow] == narrow
    assert (lines == text.splitlines()) == (columns == 1000)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_breaks_lines_only_where_the_terminal_ends(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "600")
    shown = [line.strip() for line in runner.invoke(commands.app, [name, "--help"]).output.splitlines()]
    for paragraph in cleandoc(COMMANDS[name].callback.__doc__).split("\n\n"):
        assert " ".join(paragraph.split()) in shown


def test_failures_cut_no_name(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(failures.console, "_width", 80)
    longest = max(ss.schemes(), key=len)
    rows = [Row(longest, scene, 0.12345, "Newton failed", 1234.5, 1.234e-5) for scene in ss.scenes()]
    failures._print_failures(rows)
    printed = capsys.readouterr().out
    assert "…" not in printed
    assert max(map(len, printed.splitlines())) <= 80


def test_claims_are_printed_in_full_within_80_columns(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The evidence in one wide column: in a table of four it took thrice as many lines."""
    monkeypatch.setenv("COLUMNS", "80")
    evidence = "at gamma_t = 0.2 it is stable exactly for Omega in (0, sqrt(30)/3], and nowhere else; " * 8
    command._print_claims([Judgement(c.id, c.text, "partly", evidence, c.command) for c in CLAIMS], len(CLAIMS))
    printed = capsys.readouterr().out
    lines = printed.splitlines()
    assert max(map(len, lines)) <= 80
    assert len(lines) <= 16 * len(CLAIMS)
    said = " ".join(printed.split())
    assert all(f"{c.id} partly {c.text} found: {evidence.strip()}" in said for c in CLAIMS)


@pytest.mark.parametrize("columns", [40, 80])
def test_labelled_text_has_a_column_of_its_own(columns: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    text = "as many words as fill some lines of a terminal, however wide or narrow that terminal may be"
    first, *others = labelled("label", text, 8).splitlines()
    assert first.startswith("label   as many")
    assert others
    assert all(line.startswith(" " * 8) and line[8] != " " for line in others)
    assert max(map(len, [first, *others])) <= columns
    assert " ".join([first, *others]).split() == ["label", *text.split()]
    assert labelled("label", "", 8).strip() == "label"
