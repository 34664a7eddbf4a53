"""What a command of `substep` is: a function with the panel of --help in which it stands and an example."""

from collections.abc import Callable
from inspect import getdoc
from typing import Any, NamedTuple

import typer
from typer.main import get_command


class Command(NamedTuple):
    """parameters: those of schemes and scenes follow the command as options, which the function reads itself."""

    panel: str
    example: str
    function: Callable[..., None]
    parameters: bool = False

    def add(self, app: typer.Typer) -> None:
        """Add it to the commands of the app."""
        settings = {"allow_extra_args": True, "ignore_unknown_options": True} if self.parameters else None
        paragraphs = (getdoc(self.function) or "").split("\n\n")
        shown = "\n\n".join(
            " ".join(lines.split()) for lines in paragraphs
        )  # Rich breaks lines where the terminal ends
        epilog = f"Example: {self.example}"
        app.command(help=shown, rich_help_panel=self.panel, epilog=epilog, context_settings=settings)(self.function)

    def alone(self) -> Any:
        """The command by itself, as typer makes it."""
        app = typer.Typer(add_completion=False)
        self.add(app)
        return get_command(app)
