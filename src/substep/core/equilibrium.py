"""Where a scene stays at rest."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

import numpy as np

if TYPE_CHECKING:
    from .scenes import Scene


def equilibrium(scene: Scene) -> float:
    """The displacement nearest to 0 at which a scene of one coordinate stays at rest under its load at t = 0.

    Raises ValueError for more coordinates, and where the iteration finds none.
    """
    from scipy.optimize import root_scalar  # noqa: PLC0415  # pyright: ignore

    if scene.u0.shape != (1,):
        raise ValueError(
            f"expected u0='static' for a scene of one coordinate, got {len(scene.u0)} of {scene.name}; give the "
            "displacements, or march from start={'u': ..., 'v': ...}"
        )

    given = scene.info.unstrained
    unstrained = None if given is None else np.array([given(*scene.parameters.values())])

    def acceleration(u: float) -> float:
        at = np.array([[u]])
        memory = None if unstrained is None else scene.committed(at, unstrained)
        return float(scene.acceleration(np.zeros(1), at, np.zeros((1, 1)), memory)[0, 0])

    if (loaded := acceleration(0.0)) == 0.0:
        return 0.0
    x1 = 1e-3 * scene.length
    while acceleration(x1) == loaded and x1 < 1e100:  # too short to be felt beside the load
        x1 *= 1e3
    found: Any = cast("Callable[..., Any]", root_scalar)(acceleration, x0=0.0, x1=x1, xtol=1e-14, rtol=4e-15)
    if not found.converged or not math.isfinite(found.root):
        raise ValueError(
            f"expected a displacement at which {scene.name} stays at rest, found none; give u0 as a number"
        )
    return float(found.root)
