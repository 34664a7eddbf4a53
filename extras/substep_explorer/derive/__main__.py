"""`make derive`: write the explorer's generated/explorer.js, unless its stamp says that it is up to date."""

import sys
from pathlib import Path

from substep_derive.declare.catalogue import find_scene
from substep_derive.declare.schemes import declared
from substep_derive.emit.stamp import stamped
from substep_derive.motion.equations import EquationsOfMotion
from substep_derive.written import write
from substep_languages.languages import TEMPLATES

from .module import explorer_module

HERE = Path(__file__).parent
GENERATED = HERE.with_name("generated")
SOURCES = (HERE, TEMPLATES.parent)
EXPLORED = ("linear_oscillator", "simple_pendulum", "elastic_pendulum")  # scenes that the explorer marches


def package() -> dict[str, str]:
    """Path -> text of the file and of its stamp."""
    explored = (EquationsOfMotion(find_scene(name)) for name in EXPLORED)
    return stamped({"explorer.js": explorer_module(declared(), explored)}, *SOURCES)


if __name__ == "__main__":
    sys.exit(write(package, GENERATED, *SOURCES))
