"""A declared scheme as a stepper, to be observed as other programs are."""

import numpy as np

from substep.core.arrays import Array
from substep.core.schemes import Scheme

from .linear_step import Candidate, Loads, Oscillators
from .programs.adapter import Integrator, Load
from .stepper import Stepper


def declared(scheme: Scheme, loads: Loads | None = None, zero: bool = False) -> Stepper:
    """A scheme as its declaration says, as a stepper, to be observed as others are.

    loads: how it takes the load, if otherwise; zero: whether it starts with no acceleration.
    """

    def run(
        omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Load, a0: float | None = None
    ) -> Array:
        at = Oscillators(np.array([omega * dt]), np.array([xi]), dt)
        start = np.zeros(1) if zero else None if a0 is None else np.array([a0])

        def force(t: Array) -> Array:
            return np.array([load(x) for x in t])

        return Candidate(scheme, at, loads).histories(np.array([u0, v0]), start, n, force)[0].T

    outputs = "uva" if any(kind == 2 for kind, _ in scheme.history) else "uv"
    return Stepper(run, Integrator(sets="uva", damping=scheme.info.damping, outputs=outputs), scheme.name)
