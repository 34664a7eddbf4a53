"""What the command line completes, and what it says of files that are not there and of its own options."""

from types import SimpleNamespace

import pytest
import typer
from typer.testing import CliRunner

import substep as ss
from substep.cli import commands
from substep.derived import facade

runner = CliRunner()
COMMANDS = typer.main.get_command(commands.app).commands  # pyright: ignore


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
    [["spectrum", "none.AT2"], ["emit", "none.AT2:mine", "--language", "c"], ["choose", "--load", "none.AT2"]],
)
def test_a_file_that_is_not_there_is_refused_with_a_cure(arguments: list[str]) -> None:
    options = ["--mass", __file__, "--stiffness", __file__, "--accuracy", "1e-3"] if arguments[0] == "choose" else []
    result = runner.invoke(commands.app, [*arguments, *options])
    assert result.exit_code == 2
    said = " ".join(result.output.replace("│", " ").split())
    assert "expected a file to read, got none.AT2, which is not there; correct the path" in said


def test_equivalences_are_printed_as_they_are_found(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    printed: list[str] = []

    def found(names: list[str]) -> object:
        for text in names:
            yield SimpleNamespace(text=text)
            printed.append(capsys.readouterr().out)

    monkeypatch.setattr(facade, "equivalences", found)
    commands.equivalences(["one", "two"])
    assert printed == ["one\n", "two\n"]
