"""The runs that an audit rests on, and what they say before a scheme is looked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .curve import Curve
from .measured_stability import eigenvalues
from .noise import MARGIN, Noise, measured_noise
from .probes import Measured, driven_runs, given_runs, own_runs
from .stepper import Stepper

GUESSED = 1e-9  # what an iteration leaves of the acceleration that it starts from


@dataclass(frozen=True)
class Runs:
    """Runs of few steps, with how well they repeat themselves.

    own: free motion from the acceleration that the stepper finds, or assumes, for itself; given: from unit starts of
    u, h*v and h^2*a, where an acceleration can be set; driven: from rest, by the name of the load. ignores_a0: whether
    the given acceleration is not used.
    """

    noise: Noise
    own: Sequence[Measured]
    given: Sequence[Measured]
    driven: Mapping[str, Measured]
    ignores_a0: bool

    @classmethod
    def of(cls, stepper: Stepper) -> Runs:
        """All of them. Raises ValueError where no u is known after t = 0 or none moves, RunFailed where all fail."""
        own = own_runs(stepper)
        require_motion(stepper, own)
        noise = measured_noise(stepper, own)
        driven = {name: noise.over([run])[0] for name, run in driven_runs(stepper).items()}
        given = given_runs(stepper) if "a" in stepper.can.sets else []
        ignored = bool(given) and ignores_a0(given[-1], noise)
        return cls(noise, noise.over(own), given, driven, ignored)

    @property
    def free(self) -> Sequence[Measured]:
        """Those of free motion that show most of a step: from starts of its whole state, where they are its own."""
        return self.noise.over(self.given) if self.given and not self.ignores_a0 else self.own

    @property
    def failed(self) -> tuple[tuple[float, float, str], ...]:
        """Omega, xi and the first error of each oscillator that the program raised on."""
        found = {
            (Omega, xi): error for run in [*self.driven.values(), *self.own][::-1] for Omega, xi, error in run.failed
        }
        return tuple((Omega, xi, found[Omega, xi]) for Omega, xi in sorted(found))

    def curves(self, tolerance: float) -> tuple[Curve, ...]:
        """Spectral radius, numerical damping and period error from the eigenvalues that the histories show.

        Without the oscillators that the program raised on, of which none is known.
        """
        at = self.own[0].at
        pairs = list(zip(at.Omega.tolist(), at.xi.tolist(), strict=True))
        stopped = {(Omega, xi) for run in self.own for Omega, xi, _ in run.failed}
        found: list[Curve] = []
        for xi in dict.fromkeys(at.xi.tolist()):
            places = [p for p, (Omega, ratio) in enumerate(pairs) if ratio == xi and (Omega, ratio) not in stopped]
            values = [eigenvalues(self.own, p, tolerance) for p in places]
            errors = [x.damping_and_period(float(at.Omega[p]), xi) for x, p in zip(values, places, strict=True)]
            damping, period = np.reshape(errors, (-1, 2)).T
            found.append(Curve(xi, at.Omega[places], np.array([x.radius for x in values]), damping, period))
        return tuple(found)


def require_motion(stepper: Stepper, own: Sequence[Measured]) -> None:
    """Raise ValueError for free motion of which no u is known after t = 0, or in which no u changes after it."""
    u = np.concatenate([run.rows[:, 1:, 0] for run in own])
    if np.isnan(u).all():
        raise ValueError(
            f"expected finite displacements u from {stepper.name} after t = 0, got none in any run of free motion; "
            "return u, the first of the three histories, and name it in the outputs of its Integrator"
        )
    if (np.isnan(u) | (u == u[:, :1])).all():
        raise ValueError(
            f"expected displacements u from {stepper.name} that move from u0 = 1 or v0, got the same number at every "
            "step of every run; return the histories of the run, and pass omega, u0 and v0 on to the program"
        )


def ignores_a0(from_a0: Measured, noise: Noise) -> bool:
    """Whether a unit start of h^2*a, from rest, leaves all steps at zero but for the noise, or an iteration's end.

    A program that solves for its own acceleration may take the given one as a first guess.
    """
    after = np.nan_to_num(from_a0.rows[:, 1:]) / from_a0.at.scale[:, None]
    return bool(np.abs(after).max() <= max(GUESSED, MARGIN * noise.size))
