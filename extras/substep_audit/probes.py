"""What a stepper does: free and driven runs of few steps, over frequencies and damping ratios."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from substep.core.arrays import Array

from .linear_step import Oscillators
from .programs.adapter import Load
from .stepper import RunFailed, Stepper

STEP = 0.25  # s; not 1, so that powers of h in the wrong place show; a power of 2, so that it rounds nothing
STEPS = 12
OMEGAS = (0.01, 0.1, 0.3, 1.0, 1.7, 3.0, 10.0, 100.0, 1e4)
RATIOS = (0.0, 0.05, 0.5)
LOADS = {  # of different value, slope and curvature at t = 0; the fast ones tell near instants of a step apart
    "constant": Load("constant", 0.7),
    "ramp": Load("ramp", 0.8),
    "sine": Load("harmonic", 1.0, 1.1 / STEP, 0.0),
    "cosine": Load("harmonic", 1.0, 1.9 / STEP, 1.2),
    "fast": Load("harmonic", 1.0, 7.3 / STEP, 0.0),
    "faster": Load("harmonic", 1.0, 13.7 / STEP, 0.0),
}
DRIVEN = (0.3, 1.0, 3.0)
STARTS = ((1.0, 0.0, None), (0.0, 1.0, None))  # u, h*v, and h^2*a where it is given
RECORDED = ("function", "each step")  # loads of which it is known when the program took them
LARGEST = 1e20  # a state beyond which an unstable run is not compared: little of it is not rounding


@dataclass(frozen=True)
class Measured:
    """Histories (P, n+1, 3) of u, h*v, h^2*a on the oscillators `at`; NaN where there are none.

    start: u, h*v and, where it was given, h^2*a at t = 0, else None. load: what drove it; called: when it was asked.
    failed: Omega, xi and the error of each oscillator that the program raised on, whose rows are NaN. startup: how many
    first steps are those of another scheme. absolute: whether deviations are relative to the largest state so far, for
    a program whose noise does not shrink with the state.
    """

    at: Oscillators
    start: tuple[float, float, float | None]
    load: Load
    rows: Array
    called: tuple[tuple[float, ...], ...]
    failed: tuple[tuple[float, float, str], ...] = ()
    startup: int = 0
    absolute: bool = False

    def only(self, omegas: Sequence[float]) -> "Measured":
        """The same on the oscillators of some Omega."""
        kept = np.flatnonzero(np.isin(self.at.Omega, omegas))
        return replace(self, at=Oscillators(self.at.Omega[kept], self.at.xi[kept], self.at.h), rows=self.rows[kept])

    @cached_property
    def sizes(self) -> Array:
        """(P, n+1, 1): the largest of u, h*v and h^2*a, scaled, of a step and the one before; `absolute`: so far.

        There not less than a unit start, by whose runs such a noise is measured: of a run from rest all may be noise.
        """
        rows = np.abs(self.rows)
        rows[:, 0] = np.fmax(rows[:, 0], [abs(x or 0.0) for x in self.start])  # known, returned or not
        largest = np.nan_to_num(rows / self.at.scale[:, None]).max(axis=-1)
        if self.absolute:
            return np.maximum(np.maximum.accumulate(largest, axis=1), 1.0)[..., None]
        before = np.concatenate([largest[:, :1], largest[:, :-1]], axis=1)
        return np.maximum(np.maximum(largest, before), 1e-300)[..., None]

    @property
    def undamped(self) -> "Measured":
        """The same on the undamped oscillators alone."""
        kept = self.at.xi == 0.0
        at = Oscillators(self.at.Omega[kept], self.at.xi[kept], self.at.h)
        called = tuple(times for times, keep in zip(self.called, kept, strict=True) if keep)
        return replace(
            self, at=at, rows=self.rows[kept], called=called, failed=tuple(x for x in self.failed if not x[1])
        )

    @cached_property
    def energy_roots(self) -> Array:
        """(P, n+1): the root of u^2 + (v/omega)^2, not less than at the start; without v, of u alone."""
        u, v = self.rows[..., 0], np.nan_to_num(self.rows[..., 1])
        start = np.max([np.abs(x or 0.0) / self.at.Omega**kind for kind, x in enumerate(self.start)], axis=0)
        return np.maximum(np.hypot(u, v / self.at.Omega[:, None]), start[:, None])

    def shows(self, history: Sequence[tuple[int, int]]) -> bool:
        """Whether it holds every entry of a state: pairs of a kind, 0 to 2, and how many steps before it stands."""
        rows = self.rows[:, 1:][..., [kind for kind, _ in history]]
        return bool(np.isfinite(rows).all(axis=(1, 2)).any())

    def deviation(self, rows: Array) -> Array:
        """How far other histories are off, (P, n+1, 3); NaN where either has none.

        Relative to the state's size, and to max(1, Omega^2), by which a step from u, v, a magnifies rounding.
        """
        with np.errstate(all="ignore"):
            return (rows - self.rows) / self.at.scale[:, None] / self.sizes / self.at.scale[:, None, 2:]


def own_runs(
    stepper: Stepper, omegas: Sequence[float] = OMEGAS, ratios: Sequence[float] = RATIOS, n: int = STEPS
) -> list[Measured]:
    """From unit starts of u and h*v, with the acceleration that the stepper finds, or assumes, for itself.

    Of u alone, where v cannot be set: its motion is then one under a ramp, in which other instants of the load show.
    """
    at = oscillators(stepper, omegas, ratios)
    starts = STARTS if "v" in stepper.can.sets else STARTS[:1]
    return [measure(stepper, at, start, Load(), n) for start in starts]


def given_runs(stepper: Stepper, omegas: Sequence[float] = OMEGAS, ratios: Sequence[float] = RATIOS) -> list[Measured]:
    """From unit starts of u, h*v and h^2*a, for a stepper whose acceleration at t = 0 can be set."""
    at = oscillators(stepper, omegas, ratios)
    starts = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    return [measure(stepper, at, start, Load()) for start in starts]


def driven_runs(stepper: Stepper) -> dict[str, Measured]:
    """From rest, for each load."""
    if stepper.can.load == "none":
        return {}
    at = oscillators(stepper, DRIVEN, RATIOS[:2])
    return {name: measure(stepper, at, (0.0, 0.0, None), load) for name, load in LOADS.items()}


def measure(
    stepper: Stepper, at: Oscillators, start: tuple[float, float, float | None], load: Load, n: int = STEPS
) -> Measured:
    """Run the stepper on each oscillator. Raises RunFailed if none of them can be run."""
    u, v, a = start
    rows, called, failed = [], [], []
    for omega, xi in zip(at.omega.tolist(), at.xi.tolist(), strict=True):
        fresh = Load(load.kind, load.amplitude, load.omega, load.phase)
        given = None if a is None else a / at.h**2
        try:
            found = stepper.histories(omega, xi, at.h, n, u, v / at.h, given, fresh) * at.powers
        except RunFailed as error:
            failed.append((omega * at.h, xi, str(error)))
            if len(failed) == len(at.omega):
                raise
            found = np.full((n + 1, 3), np.nan)
        sizes = np.abs(np.nan_to_num(found, nan=0.0, posinf=np.inf)).max(axis=1, keepdims=True)
        rows.append(np.where(sizes < LARGEST, found, np.nan))
        called.append(tuple(fresh.called) if stepper.can.load in RECORDED else ())
    return Measured(at, start, load, np.array(rows), tuple(called), tuple(failed), stepper.can.startup)


def oscillators(stepper: Stepper, omegas: Sequence[float], ratios: Sequence[float]) -> Oscillators:
    """Every Omega with every damping ratio; undamped only, where the stepper takes no damping."""
    pairs = np.array([(Omega, xi) for xi in (ratios if stepper.can.damping else (0.0,)) for Omega in omegas])
    return Oscillators(pairs[:, 0], pairs[:, 1], STEP)
