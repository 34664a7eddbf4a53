"""What the command line completes, and what it says of files that are not there and of its own options."""

import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from all_commands import all_commands
from typer.testing import CliRunner

import substep as ss
from substep.cli import commands
from substep.cli.arguments import schemes_of
from substep.derived import facade

runner = CliRunner()
COMMANDS = all_commands()


@pytest.mark.parametrize(
    ("command", "argument"),
    [
        *((command, "name") for command in ("show", "certify", "conditions", "estimator", "emit", "design")),
        *((command, "names") for command in ("chart", "equivalences")),
        *((command, "scheme_name") for command in ("run", "spectrum")),
        *((command, "scene_name") for command in ("run", "choose")),
    ],
)
def test_names_are_completed(command: str, argument: str) -> None:
    known = ss.scenes() if argument == "scene_name" else ss.schemes()
    (parameter,) = (p for p in COMMANDS[command].params if p.name == argument)
    context = COMMANDS[command].make_context(command, [], resilient_parsing=True)
    for start in ("", *{name[:3] for name in known}, "no such"):
        completed = [item.value for item in parameter.shell_complete(context, start)]
        assert completed == [name for name in known if name.startswith(start)]


@pytest.mark.parametrize(
    "arguments",
    [["spectrum", "none.AT2"], ["show", "none.py:mine"], ["choose", "--load", "none.AT2"]],
)
def test_a_file_that_is_not_there_is_refused_with_a_cure(arguments: list[str]) -> None:
    options = ["--mass", __file__, "--stiffness", __file__, "--accuracy", "1e-3"] if arguments[0] == "choose" else []
    result = runner.invoke(commands.app, [*arguments, *options])
    assert result.exit_code == 2
    said = " ".join(result.output.replace("│", " ").split())
    assert re.search(r"expected a file to read, got none\.(AT2|py), which is not there; correct the path", said)


OF_NOTHING = {
    "chart bathe --over Omega": "--over without --quantity",
    "chart bathe --full": "--full without work-precision",
    "chart work-precision rod --xi 0.05": "--xi with work-precision",
    "failure-map --pixels 256": "--pixels without --out",
    "failure-map --out folder --port 8000": "--port with --out",
    "failure-map --out folder --open": "--open with --out",
    "schemes --markdown --references": "--references with --markdown",
    "show bathe --html page.html --latex": "--latex with --html",
    "design newmark --several-stiffnesses": "--one-stiffness with a scheme",
    "audit list --json reports.json": "--json with list",
}


@pytest.mark.parametrize("line", OF_NOTHING)
def test_an_option_of_which_nothing_is_made_is_refused(line: str) -> None:
    result = runner.invoke(commands.app, line.split())
    assert result.exit_code == 2
    said = " ".join(result.output.replace("│", " ").split())
    assert f"expected no {OF_NOTHING[line]}, of which nothing is made there" in said


def test_parameters_of_a_scheme_that_is_to_be_l_stable_are_those_of_rho_inf_0() -> None:
    by_name, by_number = (
        runner.invoke(commands.app, ["design", "generalized_alpha", *options]).output
        for options in (["--l-stable"], ["--rho-inf", "0"])
    )
    assert by_name == by_number
    assert "alpha_m = -1, alpha_f = 0" in by_name
    both = runner.invoke(commands.app, ["design", "generalized_alpha", "--l-stable", "--rho-inf", "1/2"])
    assert "the first is --rho-inf 0" in " ".join(both.output.replace("│", " ").split())


def test_schemes_of_one_name_in_two_files_are_two_curves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("one", "two"):
        Path(f"{name}.py").write_text(OWN.replace("Rational(3, 5)", "Rational(3, 5)" if name == "one" else "1"))
    drawn: dict[str, object] = {}
    monkeypatch.setattr("substep.figures.charts.quantity_figure", lambda *given: drawn.update(given[3]))
    monkeypatch.setattr("substep.figures.charts.save", lambda *_: None)
    line = ["chart", "one.py:mine", "two.py:mine", "--quantity", "spectral_radius"]
    assert runner.invoke(commands.app, line).exit_code == 0
    assert list(drawn) == ["one.py:mine", "two.py:mine"]


OWN = """
from sympy import Interval, Rational, Symbol
from substep_derive import Balance, Parameter, Scheme, h, knot

gamma = Symbol("gamma")
u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
half = Rational(1, 2)
mine = Scheme("mine", parameters=(Parameter(gamma, Interval(half, 2), Rational(3, 5)),), relations={
    u1: u0 + h * v0 + h**2 * ((half - gamma**2 / 2) * a0 + gamma**2 / 2 * a1),
    v1: v0 + h * ((1 - gamma) * a0 + gamma * a1),
}, balances=(Balance.at(end, 1),))
"""


@pytest.mark.matrix
@pytest.mark.parametrize(("before", "after", "word"), [
    (["show"], [], "K_eff of balance 1: 2*C/h + 2*M/h^2 + K_t(u_1)"),
    (["show"], ["--part", "stiffness"], "K_eff = 2*C/h + 2*M/h^2 + K_t(u_1)"),
    (["certify"], [], "stable for every Omega > 0"),
    (["conditions"], [], "stable for every Omega > 0"),
    (["estimator"], [], "error of u"),
    (["equivalences", "newmark:beta=1/2,gamma=1"], [], "mine"),
    (["emit"], ["--language", "python"], "mine"),
    (["run", "linear_oscillator"], ["--omega", "1", "--dt", "0.1", "--t-end", "1"], "completed"),
    (["chart"], ["--file", "chart"], "chart.png"),
    (["spectrum", "record.txt"], ["--periods", "0.5", "--scheme"], "velocity"),
], ids=lambda x: x[0] if isinstance(x, list) and x else None)  # fmt: skip
def test_a_scheme_of_ones_own_is_named_by_its_file_at_every_command(
    before: list[str], after: list[str], word: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At gamma = 1, where it is Newmark's with beta = 1/2."""
    monkeypatch.chdir(tmp_path)
    Path("own.py").write_text(OWN, encoding="utf-8")
    Path("record.txt").write_text("0 0\n0.1 1\n0.2 0\n", encoding="utf-8")
    name = "own.py:mine:gamma=1"
    arguments = [*before, *after, name] if "--scheme" in after else [*before, name, *after]
    result = runner.invoke(commands.app, arguments)
    assert result.exit_code == 0, result.output
    assert word in " ".join(result.output.split())


def test_several_schemes_are_separated_by_commas_as_are_their_parameters() -> None:
    found = schemes_of("bathe, newmark:beta=.3,gamma=3/5,rk4,newmark:gamma=.5,bathe")
    assert found == [ss.scheme("bathe"), ss.scheme("newmark", beta=0.3, gamma=0.6), ss.scheme("rk4"),
                     ss.scheme("newmark", gamma=0.5), ss.scheme("bathe")]  # fmt: skip
    assert schemes_of("") is None
    with pytest.raises(ValueError, match="write name=value"):
        schemes_of("newmark:beta")


@pytest.mark.parametrize(("mistyped", "meant"), [("certifyy", "certify"), ("auditt", "audit")])
def test_a_mistyped_command_is_answered_with_the_nearest(mistyped: str, meant: str) -> None:
    result = CliRunner().invoke(commands.app, [mistyped])
    assert result.exit_code == 2
    assert f"Did you mean '{meant}'?" in result.output


def test_the_manual_lists_every_command() -> None:
    page = (Path(__file__).parents[1] / "docs" / "commands.md").read_text(encoding="utf-8")
    assert set(COMMANDS) == set(re.findall(r"^substep ([\w-]+)", page, re.MULTILINE))


def test_show_takes_parameters_after_the_name() -> None:
    """As `certify` and `derive` find them; the defaults are those of generated/."""
    shown = runner.invoke(commands.app, ["show", "newmark:beta=.3025,gamma=3/5"])
    assert shown.exit_code == 0, shown.output
    for line in ("parameters: beta (0.3025), gamma (0.6)", "stable, undamped: for every Omega", "rho_inf: 0.8181"):
        assert line in shown.output
    part = runner.invoke(commands.app, ["show", "newmark:beta=.3025,gamma=3/5", "--part", "spectrum"]).output
    assert "rho_inf = 9/11" in part
    refused = runner.invoke(commands.app, ["show", "newmark:beta"])
    assert refused.exit_code == 2
    assert "write name=value" in " ".join(refused.output.replace("│", " ").split())


def test_equivalences_are_printed_as_they_are_found(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    printed: list[str] = []

    def found(_: list[str]) -> object:
        for text in ("one", "two"):
            yield SimpleNamespace(text=text)
            printed.append(capsys.readouterr().out)

    monkeypatch.setattr(facade, "equivalences", found)
    commands.equivalences(["bathe", "newmark"])
    assert printed == ["one\n", "two\n"]


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("show my_scheme.py", "write my_scheme.py:NAME"),
        ("certify newmark --beta abc", "for --beta, got 'abc'"),
        ("certify newmark --beta .5 --beta .6", "expected --beta once, got it twice, .5 and .6"),
        ("run linear_oscillator bathe --dt .1 --t-end 1", "or as --omega in a command"),
    ],
)
def test_the_cure_is_in_the_terms_of_the_command(command: str, message: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "300")
    result = runner.invoke(commands.app, command.split())
    assert result.exit_code == 2
    assert message in result.output


def test_the_package_runs_as_the_command() -> None:
    command = [sys.executable, "-m", "substep", "--version"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == f"substep {ss.__version__}\n"
