"""Many linear oscillators and their steps, as the linear march and the digital filter take them."""

from typing import NamedTuple

from ..core.arrays import Array


class Oscillators(NamedTuple):
    """P oscillators and their steps: omega (rad/s), xi, mass and dt (s), (P,) each; start: u, v, a at t = 0, (P,) each.

    mass: what the load is divided by.
    """

    omega: Array
    xi: Array
    mass: Array
    dt: Array
    start: Array | list[Array]  # rows

    def lane(self, j: int) -> "Oscillators":
        """Oscillator j alone, P = 1."""
        return self.lanes(slice(j, j + 1))

    def lanes(self, some: slice) -> "Oscillators":
        """Some of the oscillators."""
        omega, xi, mass, dt = (x[some] for x in (self.omega, self.xi, self.mass, self.dt))
        return Oscillators(omega, xi, mass, dt, [x[some] for x in self.start])
