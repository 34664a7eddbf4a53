"""The yield strengths of a spectrum: given, a part of the elastic strength, or those of a ductility."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Array
from ..core.loads import Record
from ..core.schemes import Scheme
from .constant_ductility import strengths_of
from .peaks import peaks_at_samples
from .yielding import Yielding, peaks


class Asked(NamedTuple):
    """What a spectrum is of: `kept`, a key of KEPT, is constant at `values`, () or (K,); the rest as its arguments."""

    record: Record
    scheme: Scheme
    xi: float
    kept: str
    values: Array
    law: str
    hardening: float
    tolerance: float


class Found(NamedTuple):
    """Strengths (K, P), m/s^2, NaN where none is found, and of K ductilities how many there are; elastic: (P,).

    marched: how many oscillators it took to find them.
    """

    strength: Array
    elastic: Array
    solutions: NDArray[np.int64] | None
    marched: int


def strengths(asked: Asked, omega: Array) -> Found:
    """The strengths of oscillators omega (P,), rad/s, that give what is asked for."""
    every = np.full(len(omega), asked.xi)
    displacement = peaks_at_samples(asked.scheme, omega, every, asked.record, errors=False).found[0]
    elastic = np.where(np.isfinite(displacement), omega**2 * displacement, np.nan)  # NaN where the scheme is unstable
    values = np.atleast_1d(asked.values)[:, None]
    if asked.kept != "ductility":
        strength = values + 0.0 * elastic if asked.kept == "strength" else elastic / values
        return Found(np.where(strength > 0.0, strength, np.nan), elastic, None, strength.size)
    loaded = np.flatnonzero(elastic > 0.0)
    reduction, solutions = np.full((2, len(values), len(omega)), np.nan)
    solutions[:] = 0
    beyond, marched = values[:, 0] > 1.0, 0
    reduction[~beyond], solutions[~beyond] = 1.0, 1
    if beyond.any() and len(loaded):

        def ductility(i: NDArray[np.int64], R: Array) -> Array:
            of, first_yield = loaded[i], displacement[loaded[i]] / R
            o = Yielding(omega[of], every[of], elastic[of] / R, asked.hardening, asked.law)
            return peaks(asked.scheme, o, asked.record) / first_yield

        r = strengths_of(ductility, values[beyond, 0], len(loaded), asked.tolerance)
        where = np.ix_(beyond, loaded)
        reduction[where], solutions[where], marched = r.reduction, r.solutions, r.lanes
    reduction[:, ~(elastic > 0.0)], solutions[:, ~(elastic > 0.0)] = np.nan, 0
    solutions[np.isnan(reduction)] = 0
    return Found(elastic / reduction, elastic, solutions.astype(np.int64), marched + reduction.size)
