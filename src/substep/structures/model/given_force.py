"""The internal force of a structure from what is given of it: K, springs, and functions of the user's."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from ..solvers.matrices import Matrix
from .internal_force import InternalForce
from .material import Material
from .memory import RememberingForce
from .springs import springs_of


def internal_of(
    T: Matrix,
    names: Sequence[str],
    M: Matrix,
    K: Matrix | None,
    springs: Iterable[tuple[Any, Any]],
    force: Callable[..., Any] | None,
    tangent: Callable[..., Any] | None,
    potential: Callable[..., Any] | None,
    state: Any,
) -> InternalForce | RememberingForce | None:
    """None where it is K u alone; M (N, N), K (n, n) of those that are free.

    Raises ValueError for what does not go together.
    """
    if not isinstance(springs, Iterable):  # pyright: ignore[reportUnnecessaryIsInstance] (a user gives it)
        raise ValueError(
            f"expected springs as pairs (row of B, law), got {springs!r}; leave springs out, or give a list"
        )
    pairs = list(springs)
    if K is not None if force is not None else K is None and not pairs:
        raise ValueError("expected K, or internal_force with its tangent; give one of the two")
    if force is None and (tangent is not None or potential is not None):
        raise ValueError("expected tangent and potential with internal_force only, got one with K; leave it out")
    if force is None and state is not None:
        raise ValueError("expected state with internal_force only, got it without; leave it out, or give the function")
    if state is not None and (tangent is not None or potential is not None):
        raise ValueError(
            "expected no tangent and potential beside state, with which internal_force returns its tangent, got one; "
            "leave it out"
        )
    if pairs and force is not None and state is None:
        raise ValueError(
            "expected springs beside K, or beside internal_force with state=, got them beside one without; let it "
            "return force, tangent and state, with state={}"
        )
    if pairs or state is not None:
        own = None if force is None else Material(force, state)
        return RememberingForce(
            T, K, springs_of(pairs, T, names, dense=isinstance(M, np.ndarray)) if pairs else None, own
        )
    return None if force is None else InternalForce(T, force, tangent, potential)
