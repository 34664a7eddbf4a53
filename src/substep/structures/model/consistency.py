"""Whether the functions given of an internal force belong together, by one difference at the start.

From u0 to u0 + d, in a direction d that moves every degree of freedom, the force changes by the integral of the tangent
times d, and the potential by that of the force times d, here by Simpson's rule. It may be off by as much as it differs
from the trapezoidal rule, which is much at a kink or a strong curvature, and by rounding.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .internal_force import ROUNDING
from .model import Model

REACH = 1e-6  # of the displacements, relative to the largest at the start, or to 1 if that is smaller
TOLERANCE = 1e-2  # relative; a tangent by finite differences is far within it


def require_finite_start(structure: Model) -> None:
    """Raises ValueError for an internal force that is not finite at the start."""
    s = structure
    if s.internal is not None and not np.isfinite(found := s.internal(0.0, s.u0, s.v0)).all():
        place = int(np.argmin(np.isfinite(found)))
        raise ValueError(
            f"expected internal_force to be finite at the start, got {found[place]} at degree of freedom "
            f"{s.named(place)}; correct the function, or u0 and v0"
        )


def require_own_tangent(structure: Model, who: str) -> None:
    """Raises ValueError where the internal force does not change as its tangent says; who relies on that."""
    s, (d, states) = structure, _path(structure)
    assert s.internal is not None
    with np.errstate(all="ignore"):
        force = [s.internal(0.0, u, s.v0) for u in states[::2]]
        slopes = [s.internal.stiffness(0.0, u, s.v0)[0] @ d for u in states]
    _require("tangent", "the change of internal_force", who, force, slopes)


def require_own_potential(structure: Model, who: str) -> None:
    """Raises ValueError where the potential does not change by the work of the internal force at rest.

    who: what relies on that.
    """
    s, (d, states) = structure, _path(structure)
    assert s.internal is not None
    with np.errstate(all="ignore"):
        energy = [s.internal.energy(u) for u in states[::2]]
        slopes = [s.internal(0.0, u, np.zeros_like(s.v0)) @ d for u in states]
    _require("potential", "the work of internal_force", who, energy, slopes)


def _path(s: Model) -> tuple[Any, list[Any]]:
    """d and the displacements at the start, the middle and the end of the way."""
    d = REACH * max(1.0, float(np.abs(s.u0).max())) * np.cos(np.arange(s.size))
    return d, [s.u0 + x * d for x in (0.0, 0.5, 1.0)]


def _require(name: str, what: str, who: str, values: Sequence[Any], slopes: Sequence[Any]) -> None:
    change = values[1] - values[0]
    simpson, trapezoid = (slopes[0] + 4.0 * slopes[1] + slopes[2]) / 6.0, 0.5 * (slopes[0] + slopes[2])
    size, wrong, unsure = (float(np.abs(x).max()) for x in (change, change - simpson, simpson - trapezoid))
    rounding = ROUNDING * max(float(np.abs(x).max()) for x in values)
    if size > rounding and wrong > TOLERANCE * size + unsure + rounding:
        raise ValueError(
            f"{who} relies on {name}=: expected it to agree with {what} near the start, got a relative difference of "
            f"{wrong / size:.2g} over a small displacement; correct {name} or internal_force"
        )
