"""What the search for a scheme's live eigenvalues depends on, besides the coefficients of their polynomial."""

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class EigenvalueKind:
    """How many roots are found; twice: they are those of the stability polynomial, each beside its conjugate.

    Live eigenvalues are those that are not always 0.
    """

    roots: int
    twice: bool

    @property
    def name(self) -> str:
        """The name of the shared module that finds them."""
        return f"eigenvalues_{self.roots}{'_twice' if self.twice else ''}"

    @classmethod
    def named(cls, name: str) -> "EigenvalueKind":
        """The kind whose module has that name."""
        found = re.fullmatch(r"eigenvalues_(\d+)(_twice)?", name)
        assert found is not None  # the modules of schemes name no others
        return cls(int(found[1]), found[2] is not None)

    @property
    def live(self) -> int:
        """How many live eigenvalues there are."""
        return 2 * self.roots if self.twice else self.roots
