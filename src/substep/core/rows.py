"""The rows of a run of a scene, as far as other modules of this package than `substep.core.response` ask about them."""

from typing import Any, Protocol

from .arrays import Array
from .scenes import Scene


class Rows(Protocol):
    """What each of them reads of a response: see `substep.core.response.Response`, which imports these modules."""

    @property
    def scene(self) -> Scene:
        """The scene that was marched."""
        ...

    @property
    def t(self) -> Any:
        """Times (n+1,), s."""
        ...

    @property
    def u(self) -> Array:
        """Displacements (n+1, d)."""
        ...

    @property
    def v(self) -> Array:
        """Velocities (n+1, d)."""
        ...

    def memory_of_rows(self, rows: slice) -> tuple[Array, ...]:
        """Some rows of what laws remember, as a last argument of the scene's functions; nothing where there is none."""
        ...
