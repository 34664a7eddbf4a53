"""Where a scene of one coordinate stays at rest."""

import math
from collections.abc import Callable
from typing import Any, cast


def equilibrium(name: str, acceleration: Callable[[float], float], length: float) -> float:
    """The displacement nearest to 0 at which a scene of that name and length is not accelerated.

    Raises ValueError where the iteration finds none.
    """
    from scipy.optimize import root_scalar  # noqa: PLC0415  # pyright: ignore

    if (loaded := acceleration(0.0)) == 0.0:
        return 0.0
    x1 = 1e-3 * length
    while acceleration(x1) == loaded and x1 < 1e100:  # too short to be felt beside the load
        x1 *= 1e3
    found: Any = cast("Callable[..., Any]", root_scalar)(acceleration, x0=0.0, x1=x1, xtol=1e-14, rtol=4e-15)
    if not found.converged or not math.isfinite(found.root):
        raise ValueError(f"expected a displacement at which {name} stays at rest, found none; give u0 as a number")
    return float(found.root)
