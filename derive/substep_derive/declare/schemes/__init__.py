"""The catalogue: declarations only. A new scheme is one declaration in a module here, and one entry in its ALL."""

from collections.abc import Iterator, Sequence

from ..in_turn import in_turn
from ..scheme import Scheme

MODULES = (
    *("explicit", "newmark", "one_step", "alpha", "multi_step", "composite"),
    *("runge_kutta", "diagonally_implicit", "nystrom", "composition", "designed"),
    *("coupled", "further", "literature", "without_tangent"),
)
# those whose schemes' modules are printed on first use, not committed
ON_FIRST_USE = ("coupled", "further", "literature", "without_tangent")
EXAMPLES = ("newmark_bdf2", "bathe")  # whose kernels on the elastic pendulum are committed


def declared(modules: Sequence[str] = MODULES) -> Iterator[Scheme]:
    """Every scheme in the catalogue's order."""
    return in_turn(__name__, modules)
