"""Schemes as a run takes them: with numbers for parameters, and started by another one where they carry a history."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core.arrays import Array
from ..core.schemes import Scheme
from ..core.schemes import scheme as make_scheme
from .clock import Begin

if TYPE_CHECKING:
    from ..derived.modules import Declaration


def numbers_only(scheme: "Scheme | str | Declaration", cure: str) -> Scheme:
    """The handle of a scheme. Raises ValueError, with the cure, for the first parameter that is an array."""
    found = make_scheme(scheme)
    for name, value in found.parameters.items():
        if value.ndim:
            raise ValueError(f"expected one value for {name} of {found.name}, got an array; {cure}")
    return found


def under_way(scheme: Scheme, begin: Begin, n: int) -> bool:
    """Whether a scheme carries a history of its own after n steps, or another one is still starting it."""
    return begin.rows is not None or n >= scheme.starting_steps


def carried(history: Iterable[tuple[int, int]], done: Any, row: Callable[[Any, int], Array]) -> Array:
    """The state (s, ...) that a scheme carries after the steps that its starter has done, a number or (P,) of lanes.

    history: as of `Scheme.history`, of each entry 0 for u, 1 for v or 2 for a, and how many steps before the last one
    it stands. row: u, v or a, by its number, after so many steps; a run that ends before has the start's.
    """
    return np.array([row(np.maximum(done - lag, 0), kind) for kind, lag in history])


def require_acceleration(scheme: Scheme, own: int, starters: int) -> None:
    """Raises ValueError for a scheme with an acceleration of its own that is started by one without.

    own, starters: how many of u, v and a each of them finds, off one linear oscillator.
    """
    assert scheme.starter is not None
    if starters < own:
        raise ValueError(
            f"expected a scheme to start {scheme.name} that finds an acceleration, as it does itself, got "
            f"{scheme.starter.name}, which does so on one linear oscillator only; start it with one that carries a, "
            "such as dormand_prince"
        )
