"""The command line, as a user types it."""

import math
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from all_commands import all_commands
from matplotlib.figure import Figure
from substep_thesis import claims
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app
from substep.core.schemes import Kind
from substep.derived import facade
from substep.figures import charts
from substep.studies import failures

runner = CliRunner()


def test_alone_it_answers_what_can_be_asked() -> None:
    result = runner.invoke(app, [])
    assert result.exit_code == 0
    assert "Which scheme do I take?" in result.output
    assert result.output == runner.invoke(app, ["--help"]).output


@pytest.mark.parametrize("command", ["schemes", "scenes"])
@pytest.mark.parametrize("option", ["", "--references", "--parameters"])
def test_lists_have_every_one_within_80_columns(command: str, option: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    result = runner.invoke(app, [command, *filter(None, [option])])
    if (command, option) == ("scenes", "--parameters"):
        assert result.exit_code == 2  # they are always listed
        return
    assert result.exit_code == 0, result.output
    names, lines = ss.schemes() if command == "schemes" else ss.scenes(), result.output.splitlines()
    assert all(any(line.split(" ")[0] == name for line in lines) for name in names)
    assert max(map(len, lines)) <= 80
    assert "…" not in result.output
    assert ("growth U2-V3: in the first step u grows like Omega^2, v/omega like Omega^3" in lines) == (
        (command, option) == ("schemes", "")
    )


def test_schemes_are_listed_by_kind_and_found() -> None:
    lines = runner.invoke(app, ["schemes"]).output.splitlines()
    kinds = [line for line in lines if line in get_args(Kind)]
    assert kinds == list(get_args(Kind))
    at = {line.split(" ")[0]: k for k, line in enumerate(lines)}
    below = {
        name: max((kind for kind in kinds if lines.index(kind) < at[name]), key=lines.index) for name in ss.schemes()
    }
    assert below == {name: ss.scheme(name).kind for name in ss.schemes()}
    found = runner.invoke(app, ["schemes", "gauss", "--order", "4", "--A", "--implicit"]).output.splitlines()
    assert [line.split(" ")[0] for line in found if " A " in line] == ["gauss2"]
    none = runner.invoke(app, ["schemes", "--order", "17"])
    assert none.exit_code == 2
    assert "expected what some scheme has, got none" in " ".join(none.output.replace("│", " ").split())


def test_certify_prints_the_proof_and_reads_exact_numbers() -> None:
    result = runner.invoke(app, ["certify", "newmark_bdf2", "--gamma-t", "1/5", "--beta", "0.3025", "--gamma=3/5"])
    assert result.exit_code == 0, result.output
    assert "beta = 121/400" in result.output
    assert "stable for every Omega" in result.output.replace("\n", " ")
    limit = runner.invoke(app, ["certify", "fox_goodwin", "--xi", "0"])
    assert "sqrt(6)" in limit.output
    assert "Largest ||A^k||" in limit.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["newmark", "--beta", "__import__('os')"], "for --beta, got"),
        (["newmark", "--bta", "1/4"], "no parameter"),
        (["newmark", "--beta"], "none"),
        (["newmark", "1/4"], "such as"),
        (["newmarc"], "expected a scheme"),
        (["newmark_bdf2", "--gamma-t", "2"], "outside"),
    ],
)
def test_certify_refuses_what_is_no_exact_number(arguments: list[str], message: str) -> None:
    result = runner.invoke(app, ["certify", *arguments])
    assert result.exit_code == 2
    assert message in " ".join(result.output.replace("│", " ").split())


def test_conditions_and_equivalences() -> None:
    conditions = runner.invoke(app, ["conditions", "newmark"])
    assert conditions.exit_code == 0, conditions.output
    assert "2*beta >= gamma" in conditions.output
    assert "gamma >= 1/2" in conditions.output
    found = runner.invoke(app, ["equivalences", "bathe", "silva_bezerra"])
    assert found.exit_code == 0, found.output
    assert "silva_bezerra" in found.output
    never = " ".join(runner.invoke(app, ["conditions", "forward_euler"]).output.split())
    assert never.startswith("forward_euler, xi = 0: not stable for every Omega > 0 u is")
    assert never.count("for no parameters") == 3
    assert runner.invoke(app, ["equivalences", "bathe"]).exit_code == 2  # one alone has no other to share with
    assert runner.invoke(app, ["conditions", "newmarc"]).exit_code == 2
    assert runner.invoke(app, ["conditions", "yoshida6"]).exit_code == 2  # decided by certify alone


def test_run_marches_and_writes_the_history(tmp_path: Path) -> None:
    file = tmp_path / "history.csv"
    arguments = ["--dt", "0.01", "--t-end", "30", "--EA", "1e4", "--gamma-t", "0.9", "--beta", "0.49", "--gamma", "0.9"]
    result = runner.invoke(app, ["run", "elastic_pendulum", "newmark_bdf2", *arguments, "--csv", str(file)])
    assert result.exit_code == 0, result.output
    assert "134.115867451" in result.output
    header, *rows = file.read_text().splitlines()
    assert header.startswith("t (s),x,y,velocity x")
    assert len(rows) == 3001
    options = ["--dt", "0.1", "--t-end", "50", "--EA", "1e10", "--a0", "-19.6,0"]
    failed = runner.invoke(app, ["run", "elastic_pendulum", "average_acceleration", *options])
    assert failed.exit_code == 3
    assert "newton_failed" in failed.output
    assert "stopped in the step that ends at t = 4.7 s" in failed.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["pendulum", "bathe", "--dt", "0.1", "--t-end", "1"], "expected a scene"),
        (["elastic_pendulum", "bathe", "--dt", "0.1", "--t-end", "1"], "expected a value for EA"),
        (["duffing", "bathe", "--dt", "0.1", "--t-end", "1", "--EA", "3"], "parameters of duffing: "),
        (["elastic_pendulum", "bathe", "--dt", "0.3", "--t-end", "1", "--EA", "1e4"], "nearest are 0.9 and 1.2"),
        (
            ["elastic_pendulum", "bathe", "--dt", "0.1", "--t-end", "1", "--EA", "1e4", "--strain", "log"],
            "green_lagrange",
        ),
        (
            ["elastic_pendulum", "bathe", "--dt", "0.1", "--t-end", "1", "--EA", "much"],
            "expected a number such as 0.2 or 1/5 for --EA, got 'much'",
        ),
    ],
)
def test_run_says_what_is_wrong(arguments: list[str], message: str) -> None:
    result = runner.invoke(app, ["run", *arguments])
    assert result.exit_code == 2
    assert message in " ".join(result.output.replace("│", " ").split())


def test_chart_draws_the_schemes_named(tmp_path: Path) -> None:
    result = runner.invoke(app, ["chart", "bathe", "park", "-o", str(tmp_path / "two")])
    assert result.exit_code == 0, result.output
    assert (tmp_path / "two.png").stat().st_size > 10_000
    assert runner.invoke(app, ["chart", "bath", "--file", str(tmp_path / "none")]).exit_code == 2


@pytest.mark.parametrize("quantity", ["spectral_radius", "numerical_damping", "amplitude_error", "period_error"])
@pytest.mark.parametrize("over", ["h/T", "Omega"])
def test_chart_draws_one_quantity_at_given_parameters(
    quantity: str, over: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(charts, "save", lambda figure, *_: drawn.append(figure))
    second = "newmark_bdf2:gamma_t=.2,beta=.3025,gamma=3/5"
    options = ["--xi", ".05", "--quantity", quantity, "--over", over, "--out", str(tmp_path / "one.png")]
    result = runner.invoke(app, ["chart", "bathe", second, *options])
    assert result.exit_code == 0, result.output
    assert f"{tmp_path / 'one'}.png" in result.output.replace("\n", "")
    (axes,) = drawn[0].axes
    schemes = ss.scheme("bathe"), ss.scheme("newmark_bdf2", gamma_t=0.2, beta=0.3025, gamma=0.6)
    scale = 1.0 if over == "Omega" else 2 * math.pi
    for line, s in zip(axes.lines, schemes, strict=False):
        x, y = line.get_data()
        expected = getattr(s, quantity)(np.asarray(x) * scale, 0.05)
        np.testing.assert_allclose(y, expected * (100 if "error" in quantity else 1), rtol=1e-9, atol=1e-12)
    for wrong in ("bathe:beta=1", "newmark:beta", "newmark:beta=x", "newmark:beta=-1"):
        assert runner.invoke(app, ["chart", wrong]).exit_code == 2


@pytest.mark.parametrize("options", [
    ["oalts", "--xi", "1", "--quantity", "period_error"],
    ["bathe", "--xi", "1.5", "--quantity", "numerical_damping"],
    ["bathe", "newmark", "--xi", "2", "--quantity", "amplitude_error"],
    ["bathe", "--xi", "1"],
])  # fmt: skip
def test_a_chart_without_a_value_is_refused(options: list[str], tmp_path: Path) -> None:
    result = runner.invoke(app, ["chart", *options, "--file", str(tmp_path / "empty")])
    assert result.exit_code == 2
    assert "expected xi < 1 for" in result.output
    assert not list(tmp_path.iterdir())


def test_a_chart_of_the_radius_is_drawn_at_any_damping(tmp_path: Path) -> None:
    options = ["--xi", "1.5", "--quantity", "spectral_radius", "--file", str(tmp_path / "radius")]
    assert runner.invoke(app, ["chart", "bathe", *options]).exit_code == 0


def test_exit_codes_version_and_completion(monkeypatch: pytest.MonkeyPatch) -> None:
    assert runner.invoke(app, ["--version"]).output.strip() == f"substep {ss.__version__}"
    help_ = " ".join(runner.invoke(app, ["--help"]).output.split())
    assert "Exit codes: 0 done; 2 wrong input" in help_
    assert "--install-completion" in help_
    assert runner.invoke(app, ["run", "duffing", "bathe", "--dt", "1"]).exit_code == 2
    assert runner.invoke(app, ["nothing"]).exit_code == 2

    def interrupted(name: str, **_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(facade, "certificate", interrupted)
    stopped = runner.invoke(app, ["certify", "bathe"])
    assert stopped.exit_code == 130
    last = " ".join(stopped.output.split())
    assert last.endswith("substep certify: interrupted; what was printed or written before is complete and kept")


def test_claims_and_failures_print_what_was_found_before_ctrl_c(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop() -> None:
        raise KeyboardInterrupt

    def battery(folder: Path, step: Callable[[list[failures.Row]], object], full: bool) -> None:
        step([failures.Row("bathe", "duffing", 0.125, "survived", None, 1.0)])
        stop()

    stopped = replace(claims.CLAIMS[1], judge=stop)
    monkeypatch.setattr(claims, "CLAIMS", (claims.CLAIMS[0], stopped, claims.CLAIMS[2]))
    monkeypatch.setattr(failures, "battery", battery)
    for arguments, wanted in (
        (["claims"], ["the first 1 of 3", claims.CLAIMS[0].id]),
        (["failures", "--folder", str(tmp_path)], ["bathe", "0.125", "survived"]),
    ):
        result = runner.invoke(app, arguments)
        assert result.exit_code == 130
        assert all(word in result.output for word in wanted)
        assert " ".join(result.output.split()).endswith("what was printed or written before is complete and kept")
        assert claims.CLAIMS[2].id not in result.output


@pytest.mark.parametrize("command", all_commands())
def test_help_has_an_example_that_the_command_takes(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    output = runner.invoke(app, [command, "--help"]).output
    (example,) = [line for line in output.splitlines() if "Example: substep " in line]
    _, name, *arguments = shlex.split(example.split("Example: ")[1])
    assert name == command
    all_commands()[command].make_context(command, arguments)


def test_help_and_lists_come_without_numba_sympy_or_matplotlib() -> None:
    for arguments in (["--help"], ["schemes"], ["scenes"], ["show", "bathe"], ["show", "bath"]):
        code = (
            "import sys; from typer.testing import CliRunner; from substep.cli.commands import app;"
            f"CliRunner().invoke(app, {arguments!r});"
            "print({'numba', 'sympy', 'matplotlib', 'scipy', 'xarray'} & set(sys.modules))"
        )
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        assert done.stdout.strip() == "set()", arguments


def test_files_without_a_folder_are_refused_before_the_work(tmp_path: Path) -> None:
    nowhere = str(tmp_path / "none" / "file")
    run = ["--dt", "0.01", "--t-end", "0.1"]
    motion = tmp_path / "motion.txt"
    motion.write_text("0 0\n0.01 1\n0.02 0\n")
    for arguments in (
        ["run", "duffing", "bathe", *run, "--csv", nowhere],
        ["chart", "bathe", "--file", nowhere],
        ["spectrum", str(motion), "--csv", nowhere],
        ["spectrum", str(motion), "--chart", nowhere],
        ["choose", "duffing", "--accuracy", "1e-2", "--file", nowhere],
    ):
        result = runner.invoke(app, arguments)
        assert result.exit_code == 2, arguments
        assert "expected a folder that is there" in " ".join(result.output.replace("│", " ").split())


def test_spectrum_prints_writes_and_draws(tmp_path: Path) -> None:
    file, out = tmp_path / "motion.txt", tmp_path / "out.csv"
    file.write_text("\n".join(f"{0.01 * i:.2f} {math.sin(0.11 * i) * math.sin(0.01 * i):.9f}" for i in range(315)))
    options = ["--xi", "0.02", "--scheme", "newmark", "--beta", "0.25", "--gamma=0.5", "--periods", "0.1,0.57,2"]
    result = runner.invoke(app, ["spectrum", str(file), *options, "--csv", str(out), "--chart", str(tmp_path / "s")])
    assert result.exit_code == 0, result.output
    assert "315 samples" in result.output
    assert "accelerations read in m/s^2" in result.output
    assert "SA is within 1 % of the exact response from T = 0.1 s on" in result.output
    in_g = runner.invoke(app, ["spectrum", str(file), *options, "--unit", "g"])
    assert "accelerations read in g" in in_g.output
    assert "0.57" in result.output
    header, *rows = out.read_text().splitlines()
    assert header.startswith("period (s),displacement (m),velocity (m s-1),acceleration (m s-2),pseudo_velocity")
    assert len(rows) == 3
    assert (tmp_path / "s.png").stat().st_size > 10_000
    assert "Nigam" in (tmp_path / "s.svg").read_text(encoding="utf-8")
    unstable = runner.invoke(
        app, ["spectrum", str(file), "--scheme", "central_difference", "--chart", str(tmp_path / "u")]
    )
    assert unstable.exit_code == 0, unstable.output
    assert "unstable at 15 of 200 periods" in unstable.output
    assert "inf m" not in unstable.output
    assert "inf %" not in unstable.output
    assert runner.invoke(app, ["spectrum", str(file), "--scheme", "bath"]).exit_code == 2
    file.write_text("0 1\n0.01 981\n")
    asked = runner.invoke(app, ["spectrum", str(file)])
    assert asked.exit_code == 2
    assert 'give --unit="m/s^2"' in " ".join(asked.output.replace("│", " ").split())
    bad = runner.invoke(app, ["spectrum", str(file), "--periods", "1,x"])
    assert bad.exit_code == 2
    assert "for --periods, got 'x'" in " ".join(bad.output.replace("│", " ").split())


def test_spectrum_resamples_and_refines_as_python_does(tmp_path: Path) -> None:
    file, out = tmp_path / "uneven.txt", tmp_path / "out.csv"
    t = np.cumsum(np.where(np.arange(300) % 3 == 0, 0.013, 0.008))
    np.savetxt(file, np.column_stack([t, np.sin(9 * t) * np.sin(t)]), header="time (s), acceleration (g)")
    options = ["--periods", "0.03,0.1,1", "--csv", str(out)]
    refused = runner.invoke(app, ["spectrum", str(file), *options])
    assert refused.exit_code == 2
    assert "interpolate by --resample=" in " ".join(refused.output.replace("│", " ").split())
    found = runner.invoke(app, ["spectrum", str(file), *options, "--resample", "0.01", "--refine", "auto"])
    assert found.exit_code == 0, found.output
    record = ss.read_record(file, resample=0.01)
    s = ss.response_spectrum(record, periods=[0.03, 0.1, 1.0], refine="auto")
    header, *rows = out.read_text(encoding="utf-8").splitlines()
    columns = header.split(",")
    assert columns.index("steps (1)") == 6
    for i, row in enumerate(rows):
        values = dict(zip(columns, map(float, row.split(",")), strict=True))
        assert values["steps (1)"] == int(s.steps[i])
        assert values["acceleration (m s-2)"] == pytest.approx(float(s.acceleration[i]), rel=1e-6)
    more = int((s.steps > 1).sum())
    assert more >= 1
    said = " ".join(found.output.split())
    assert f"{more} of 3 periods took more than a step a sample, at most {int(s.steps.max())}" in said
    assert "accelerations read in g" in said
    wrong = runner.invoke(app, ["spectrum", str(file), "--resample", "0.01", "--refine", "4"])
    assert wrong.exit_code == 2
    assert 'expected refine="auto"' in " ".join(wrong.output.replace("│", " ").split())


def test_run_takes_a_period_in_place_of_omega() -> None:
    options = ["--dt", "0.1", "--t-end", "1", "--xi", "0.1"]
    by_period, by_omega = (
        runner.invoke(app, ["run", "linear_oscillator", "bathe", *options, *given])
        for given in (["--T", "0.5"], ["--omega", f"{4 * math.pi!r}"])
    )
    assert by_period.exit_code == 0, by_period.output
    assert by_period.output == by_omega.output
    both = runner.invoke(app, ["run", "linear_oscillator", "bathe", *options, "--T", "0.5", "--f", "2"])
    assert "got f and T; drop all but one" in " ".join(both.output.replace("│", " ").split())


def test_without_arguments_it_answers_four_questions(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Each question with commands that work; other tests run `choose`, which takes a minute, and `audit`."""
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.chdir(tmp_path)
    shown = runner.invoke(app, []).output
    for question in ("Which scheme do I take?", "Is it stable?", "How large a step?", "What does my program do?"):
        assert question in shown
    commands = re.findall(r"`substep (\w.*?)`", shown)
    assert len(commands) == 7
    for command in commands:
        if not command.startswith(("choose", "audit")):
            found = runner.invoke(app, shlex.split(command))
            assert found.exit_code == 0, (command, found.output)
