"""What to choose for a scene or for a structure."""

from typing import Any

from ..core.errors import called_as
from ..structures.structure import Modes, Structure


@called_as('choose("duffing", 1e-3, t_end=10.0)')
def choose(subject: Any, accuracy: float, **options: Any) -> Any:
    """The scheme and step, and of a structure the number of modes, that reach an accuracy for the least work.

    subject: a scene, for which options and result are those of `substep.studies.precision.choose`, or a structure or
    its modes, for which they are those of `substep.studies.structures.choose`. Raises ValueError as these do.

    >>> frame = ss.structure(np.diag([2.0, 1.0]), [[6.0, -2.0], [-2.0, 4.0]], u0=[1.0, 0.0], names=["roof", "floor"])
    >>> found = ss.choose(frame, 1e-2, t_end=1.0, quantity="roof", among=["bathe"])
    >>> found.best.error <= 1e-2
    True
    """
    if isinstance(subject, Structure | Modes):
        from .structures import choose as of_structure  # noqa: PLC0415

        return of_structure(subject, accuracy, **options)
    from .precision import choose as of_scene  # noqa: PLC0415 (Matplotlib)

    return of_scene(subject, accuracy, **options)
