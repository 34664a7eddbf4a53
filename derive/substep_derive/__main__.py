"""`make derive`: write generated/substep_kernels, unless its stamp says that it is up to date."""

import sys
from pathlib import Path

from .declare import scenes, schemes
from .package import package
from .written import write

GENERATED = Path(__file__).parents[2] / "generated" / "substep_kernels"


def main() -> int:
    """Exit status 1 if --check finds a difference."""
    return write(lambda: package(schemes.declared(), scenes.declared()), GENERATED)


if __name__ == "__main__":
    sys.exit(main())
