"""`python -m substep` is the command `substep`."""

from .cli.commands import app

app(prog_name="substep")
