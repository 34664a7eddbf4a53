"""Peaks of spectral oscillators under a record: at its samples, or in finer steps where these are too long."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core.arrays import Array
from ..core.loads import Record
from ..core.schemes import Scheme
from ..exact.oscillator import exact_peaks
from ..marching.linear import march_linear
from ..marching.oscillators import Oscillators

UNSTABLE = 1.0 + 1e-6  # largest spectral radius of a stable step; it may have only half its digits near 1
GOOD = 0.01  # largest relative error of a value that is called good
INSTANTS = 200  # a period, at least, at which the exact response is looked at: its peaks rise by 0.05 % between
MOST = 2**24  # samples, at most, of a refined record: 128 MiB


class Peaks(NamedTuple):
    """Of P oscillators: largest |u|, |v|, |2 xi omega v + omega^2 u| (3, P), by the scheme and exact.

    The scheme's are inf where it is not stable. exact is None where no errors are wanted. factor (P,): the scheme's
    steps from sample to sample.
    """

    found: Array
    exact: Array | None
    factor: NDArray[np.int64]


def peaks_at_samples(s: Scheme, omega: Array, xi: Array, load: Record, errors: bool = True) -> Peaks:
    """Both at the samples alone, by which the scheme steps; omega in rad/s, xi (P,)."""
    exact = exact_peaks(omega, xi, load) if errors else None
    return Peaks(_found(s, omega, xi, load), exact, np.ones(len(omega), np.int64))


def peaks_refined(s: Scheme, omega: Array, xi: Array, load: Record) -> Peaks:
    """The scheme's, in steps that are halved until all three are within GOOD of the exact ones, at whatever time.

    The record stays the same function of time, linear between its samples. Steps are halved as long as the record then
    has at most MOST samples; an oscillator that would need shorter ones keeps its error.
    """
    exact, found = np.empty((3, len(omega))), np.empty((3, len(omega)))
    enough = _powers_of_2(INSTANTS * load.dt * omega / (2.0 * np.pi), load)
    for k in np.unique(enough):
        lanes = enough == k
        exact[:, lanes] = exact_peaks(omega[lanes], xi[lanes], refined(load, int(k)))
    factor, bad, k = np.ones(len(omega), np.int64), np.arange(len(omega)), 1
    while len(bad) and (k == 1 or k * len(load.samples) <= MOST):
        found[:, bad], factor[bad] = _found(s, omega[bad], xi[bad], refined(load, k)), k
        bad = bad[(np.abs(relative(found[:, bad], exact[:, bad])) > GOOD).any(axis=0)]
        k *= 2
    return Peaks(found, exact, factor)


def _powers_of_2(least: Array, load: Record) -> NDArray[np.int64]:
    """The smallest powers of 2 that are not below `least` (P,), as far as MOST allows."""
    most = max(int(np.log2(MOST / len(load.samples))), 0)
    return 2 ** np.clip(np.ceil(np.log2(least)), 0, most).astype(np.int64)


def refined(load: Record, factor: int) -> Record:
    """The same function of time until its last sample, with `factor` steps in place of each."""
    if factor == 1:
        return load
    before, rise = load.samples[:-1, None], np.diff(load.samples)[:, None]
    inner = before + rise * (np.arange(factor) / factor)
    return Record(load.dt / factor, np.append(inner, load.samples[-1]))


def is_stable(s: Scheme, omega: Array, xi: ArrayLike, dt: float) -> NDArray[np.bool_]:
    """Where the scheme is stable in steps of dt (P,), for omega (P,) in rad/s and xi."""
    return s.spectral_radius(omega * dt, xi) <= UNSTABLE


def at_rest(omega: Array, xi: Array, load: Record) -> Oscillators:
    """Oscillators (P,) of unit mass at rest, with the acceleration of the record's first sample, and its step."""
    start = np.zeros((3, len(omega)))
    start[2] = load.samples[0]
    return Oscillators(omega, xi, np.ones(len(omega)), np.full(len(omega), load.dt), start)


def relative(found: Array, exact: Array) -> Array:
    """found/exact - 1; 0 where both are equal, also to 0; inf where only exact is 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(found == exact, 0.0, found / exact - 1.0)


def _found(s: Scheme, omega: Array, xi: Array, load: Record) -> Array:
    """The scheme's peaks (3, P) at the samples, inf where it is not stable or overflows."""
    peaks = np.full((3, len(omega)), np.inf)
    stable = is_stable(s, omega, xi, load.dt)
    some = at_rest(omega[stable], xi[stable], load)
    peaks[:, stable] = march_linear(s, some, len(load.samples) - 1, load, keep="peak_absolute").peak
    peaks[:, ~np.isfinite(peaks).all(axis=0)] = np.inf
    return peaks
