"""Every command of `substep`, those that the extras bring among them."""

from collections.abc import Mapping
from typing import Any

import typer
from typer.core import TyperGroup

from substep.cli.commands import app


def all_commands() -> Mapping[str, Any]:
    """Name -> command, as typer makes it."""
    group = typer.main.get_command(app)
    assert isinstance(group, TyperGroup)
    context: Any = None  # which listing needs not
    return {name: group.get_command(context, name) for name in group.list_commands(context)}
