"""Many linear oscillators and their steps, as the linear march and the digital filter take them."""

from typing import NamedTuple

from ..core.schemes import Array


class Oscillators(NamedTuple):
    """P oscillators and their steps: omega in rad/s, xi, dt in s (P,); start: u, v, a (3, P)."""

    omega: Array
    xi: Array
    dt: Array
    start: Array

    def lane(self, j: int) -> "Oscillators":
        """One of them."""
        return Oscillators(*(x[..., j : j + 1] for x in self))
