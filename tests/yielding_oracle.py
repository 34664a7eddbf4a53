"""A yielding oscillator solved exactly from event to event: each branch is linear, and so is the load in a step."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

Array = np.ndarray


@dataclass
class Exact:
    """u'' + 2 xi omega u' + q = f from rest, f linear between samples; q bilinear, per unit mass.

    Branches: 0 elastic, +1 and -1 yielding that way. The state is u, v, f and its slope; p is the plastic part.
    """

    omega: float
    xi: float
    strength: float
    hardening: float
    u: list[float] = field(default_factory=list)  # at every instant looked at
    p: float = 0.0
    lost: float = 0.0
    excursions: int = 0

    def __post_init__(self) -> None:
        self.branch, self.state = 0, np.zeros(4)
        self.k, self.soft = self.omega**2, (1.0 - self.hardening) * self.omega**2
        self.u_y = self.strength / self.k

    def matrix(self, branch: int) -> Array:
        """Of the state and a constant: in the elastic branch q = k u - soft p, yielding hardening k u +- soft u_y."""
        stiffness = self.k if branch == 0 else self.hardening * self.k
        constant = self.soft * (self.p if branch == 0 else -branch * self.u_y)
        A = np.zeros((5, 5))
        A[0, 1] = 1.0
        A[1] = [-stiffness, -2.0 * self.xi * self.omega, 1.0, 0.0, constant]
        A[2, 3] = 1.0
        return A

    def after(self, tau: float) -> Array:
        """The state tau later in this branch."""
        return (expm(self.matrix(self.branch) * tau) @ np.append(self.state, 1.0))[:4]

    def overshoot(self, x: Array) -> float:
        """Above 0 where a state has left this branch: beyond the yield displacement, or turned back."""
        if self.branch == 0:
            return abs(x[0] - self.p) - self.u_y
        return -self.branch * x[1]

    def advance(self, tau: float) -> None:
        """Through all events in a time so short that there is at most one before the next is looked for."""
        while tau > 0.0:
            x = self.after(tau)
            at = tau
            if self.overshoot(x) > 1e-13 * (self.u_y if self.branch == 0 else self.omega * self.u_y):
                at = brentq(lambda s: self.overshoot(self.after(s)), 0.0, tau, xtol=1e-15) if self.inside() else 0.0
                x = self.after(at)
                self.move(x)
                self.branch = 0 if self.branch else int(np.sign(x[0] - self.p))
                self.excursions += self.branch != 0
            else:
                self.move(x)
            tau -= at

    def inside(self) -> bool:
        return self.overshoot(self.state) < 0.0

    def move(self, x: Array) -> None:
        """To a state of this branch; yielding, the plastic part follows, and its force is constant on the way."""
        if self.branch:
            before, self.p = self.p, x[0] - self.branch * self.u_y
            self.lost += self.soft * self.branch * self.u_y * (self.p - before)
        self.state = x
        self.u.append(x[0])

    def run(self, f: Array, dt: float, parts: int) -> "Exact":
        """Through a record, looking for events in so many parts of each step."""
        for before, now in zip(f[:-1].tolist(), f[1:].tolist(), strict=True):
            self.state[2:] = before, (now - before) / dt
            for _ in range(parts):
                self.advance(dt / parts)
        return self

    def settle(self, dt: float, most: float) -> float:
        """The displacement at rest, after a free vibration of so many periods."""
        self.state[2:] = 0.0
        for _ in range(int(most * 2.0 * np.pi / self.omega / dt)):
            self.advance(dt)
        return (1.0 - self.hardening) * self.p


def exact(
    T: float, xi: float, strength: float, hardening: float, f: Array, dt: float, parts: int = 2
) -> dict[str, Any]:
    """Largest |u|, energy lost, excursions and the displacement at rest, of the ground acceleration f."""
    o = Exact(2.0 * np.pi / T, xi, strength, hardening).run(-f, dt, parts)
    found = {"displacement": max(map(abs, o.u)), "hysteretic_energy": o.lost, "yield_excursions": o.excursions}
    return found | {"residual_displacement": o.settle(dt, 6.0)}
