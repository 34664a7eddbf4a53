"""Many linear oscillators and their steps, as the linear march and the digital filter take them."""

from typing import NamedTuple

from ..core.arrays import Array


class Oscillators(NamedTuple):
    """P oscillators and their steps: omega (rad/s), xi, mass and dt (s), (P,) each; start: u, v, a at t = 0, (3, P).

    mass: what the load is divided by.
    """

    omega: Array
    xi: Array
    mass: Array
    dt: Array
    start: Array

    def lane(self, j: int) -> "Oscillators":
        """Oscillator j alone, P = 1."""
        return Oscillators(*(x[..., j : j + 1] for x in self))
