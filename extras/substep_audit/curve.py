"""What was measured of stability."""

from dataclasses import dataclass

from substep.core.arrays import Array


@dataclass(frozen=True)
class Curve:
    """Measured over Omega at one damping ratio: spectral radius, numerical damping, period error, (n,) each."""

    xi: float
    Omega: Array
    radius: Array
    damping: Array
    period: Array
