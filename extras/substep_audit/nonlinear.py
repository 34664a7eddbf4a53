"""What a stepper does under a cubic spring: schemes that take one linear step can differ there."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from substep.core.arrays import Array
from substep.core.schemes import Scheme
from substep.structures.structure import structure

from .identify import Identification, Match, with_other_values
from .noise import QUIET, Noise
from .probes import STEP, STEPS, Measured
from .programs.adapter import Load, Spring
from .stepper import RunFailed, Stepper

OMEGAS = (0.3, 0.5)  # of the linear part; at u = 1 the slope is four times as large
START = (1.0, 0.7)  # u, v/omega
LARGEST = 1e6  # beyond which a run is not compared: each step there triples the relative error


def split(found: Identification, stepper: Stepper, free: Sequence[Measured], noise: Noise = QUIET) -> Identification:
    """Of the schemes that agree on the linear oscillator, those that agree under a cubic spring too.

    free: the runs that they were found from; with them, other values of their parameters are tried. Where none agrees,
    all are kept: the program takes the force in a way of its own, which `nonlinear` then says. As they were for a
    stepper that takes no force, or starts in a way of its own, and where every run fails.
    """
    if not stepper.can.nonlinear or any(match.what == "spectrum" or match.start == "own" for match in found.matches):
        return found
    kept, apart, known = [], [], []
    for match in found.matches:
        error, best = deviation(match, stepper), match
        if error > noise.match:
            others = [(deviation(other, stepper), other) for other in with_other_values(match, free, noise)]
            error, best = min([(error, match), *others], key=lambda one: one[0])
        known += [] if np.isnan(error) else [error]
        if error > noise.match:
            apart.append((match, error))
        else:
            kept.append(best)
    if not known:
        return found
    return replace(found, nonlinear=min(known), **({"matches": tuple(kept), "apart": tuple(apart)} if kept else {}))


def deviation(match: Match, stepper: Stepper) -> float:
    """The largest deviation of u, and of v where it is the scheme's, over its largest value.

    NaN where nothing could be compared; the scheme is kept then.
    """
    kinds, found = (0, 1) if match.what == "matrix" else (0,), []
    for Omega in OMEGAS:
        theirs, ours = _theirs(stepper, Omega), _ours(match.scheme, Omega, start=match.start)
        for kind in kinds:
            n = min(_small(theirs[:, kind]), _small(ours[:, kind]))
            if n > 2:
                found.append(float(np.abs(theirs[:n, kind] - ours[:n, kind]).max() / np.abs(theirs[:n, kind]).max()))
    return max(found, default=np.nan)


def spring(Omega: float) -> Spring:
    """The spring of an Omega: twice as hard at u = 1 as without its cubic part."""
    stiffness = (Omega / STEP) ** 2
    return Spring(stiffness, stiffness)


def _theirs(stepper: Stepper, Omega: float) -> Array:
    omega = Omega / STEP
    try:
        return stepper.histories(omega, 0.0, STEP, STEPS, START[0], START[1] * omega, None, Load(), force=spring(Omega))
    except RunFailed:
        return np.full((1, 3), np.nan)


def _ours(scheme: Scheme, Omega: float, start: str) -> Array:
    """The same motion by the scheme's plan."""
    force, omega = spring(Omega), Omega / STEP
    given: Mapping[str, float] = {"a0": 0.0} if start == "zero" else {}
    oscillator = structure(
        np.eye(1),
        internal_force=force,
        tangent=lambda u: np.diag(force.slope(u)),
        potential=lambda u: float(np.sum(force.potential(u))),
        u0=START[0],
        v0=START[1] * omega,
        **given,
    )
    with np.errstate(all="ignore"):
        r = oscillator.march(scheme, dt=STEP, t_end=STEP * STEPS, account=False, progress=False)
    return np.column_stack([r.u, r.v, r.a])


def _small(history: Array) -> int:
    """How many rows there are before one that is too large, or none."""
    good = np.abs(history) < LARGEST * max(abs(float(history[0])), 1.0)
    return len(good) if good.all() else int(np.argmin(good))
