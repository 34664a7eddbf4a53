"""Every command that takes a scheme, for every scheme of the catalogue."""

import inspect
import os
from typing import Any

import pytest
from all_commands import all_commands
from conftest import DEAR as SLOW
from declared import NAMES, TOGETHER, UNDAMPED
from typer.testing import CliRunner

from substep.cli.commands import app

VERIFY = bool(os.environ.get("SUBSTEP_VERIFY"))
# a command line for a scheme, {} its name; those that derive little first
CHEAP = {"certify": "certify {}"}
DEAR = {
    "emit": "emit {} --language python",
    "show": "show {}",
    "conditions": "conditions {}",
    "estimator": "estimator {}",
    "chart": "chart {} -o chart.png",
    "run": "run duffing {} --dt 0.01 --t-end 0.02",
}
# commands whose schemes are many, found by the command itself, or integrators of other programs
OTHERS = {
    "schemes",
    "scenes",
    "explorer",
    "choose",
    "spectrum",
    "equivalences",
    "design",
    "audit",
    "failures",
    "failure-map",
    "claims",
}
OTHERS |= {"reproduce"}
SOME = NAMES if VERIFY else [name for name in NAMES if name not in SLOW][:: len(NAMES) // 3]
RUNS = [(command, name) for command in CHEAP for name in NAMES] + [(command, name) for command in DEAR for name in SOME]


def test_no_command_is_left_out() -> None:
    commands = all_commands()
    assert commands.keys() == CHEAP.keys() | DEAR.keys() | OTHERS
    one = {"name", "scheme_name"}
    taking = {name for name, c in commands.items() if one & inspect.signature(c.callback).parameters.keys()}
    assert CHEAP.keys() | DEAR.keys() <= taking | {"chart"}


@pytest.mark.usefixtures("plain_functions", "uncompiled")
@pytest.mark.parametrize(("command", "name"), RUNS)
def test_a_command_ends_with_a_result_or_a_reason(
    command: str, name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, {**CHEAP, **DEAR}[command].format(name).split())
    assert result.exception is None or isinstance(result.exception, SystemExit), repr(result.exception)
    refused = command == "conditions" or (command, name in UNDAMPED) == ("run", True)
    refused |= command == "emit" and name in TOGETHER
    assert result.exit_code == 0 or (refused and result.exit_code == 2), result.output
    assert result.output
