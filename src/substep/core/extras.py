"""What packages of their own bring to `substep`: names and commands, found by the entry points that they declare.

The core imports none of them. They are looked up when a name is asked for that the core does not have.
"""

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

NAMES = "substep"  # the group of entry points that are names of the package
COMMANDS = "substep.commands"  # and the group of those that are commands
# names and commands that the folder extras/ of the repository brings, to say so where it is not installed
OF_EXTRAS = {
    NAMES: ("Claims", "Integrator", "Program", "Stepper", "audit", "dialect", "emit", "scheme_of"),
    COMMANDS: ("explorer", "design", "audit", "emit", "claims", "reproduce"),
}


@cache
def installed(group: str) -> "Mapping[str, EntryPoint]":
    """Name -> entry point of a group, of whatever packages are installed; ours first, in our order."""
    from importlib.metadata import entry_points  # noqa: PLC0415 (on first use: it takes a tenth of substep's import)

    found = {entry.name: entry for entry in entry_points(group=group)}
    ours = [name for name in OF_EXTRAS[group] if name in found]
    return {name: found[name] for name in dict.fromkeys((*ours, *found))}


def brought(group: str, name: str) -> Any:
    """What an installed package brings under that name; None where no package has it.

    Raises ImportError, with the cure, for a name of extras/ where that is not installed.
    """
    entry = installed(group).get(name)
    if entry is not None:
        return entry.load()
    if name not in OF_EXTRAS[group]:
        return None
    called = f"substep.{name}" if group == NAMES else f"the command substep {name}"
    raise ImportError(
        f"expected the package substep-extras for {called}, got none installed; pip install ./extras, in a copy of the "
        "repository of substep"
    )
