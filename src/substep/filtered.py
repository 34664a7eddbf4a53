"""Peaks of many oscillators from rest under one record with a sample at each step: the fastest march there is."""

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from .loads import Record
from .schemes import Array, Scheme
from .threads import spread

if TYPE_CHECKING:
    from .linear import Load, Oscillators

BLOCK = 96  # lanes that the kernels march abreast; threads take whole blocks
WORTH_THREADS = 8_000_000  # lane-steps, about a millisecond


def peaks_from_rest(scheme: Scheme, o: "Oscillators", n: int, load: "Load | None", followed: int) -> Array | None:
    """Largest |u| (1, P), or |u|, |v|, |a| (3, P), over n steps; None where no filter tells them.

    That is for another start than rest, another load, and schemes that begin otherwise or take the load outside a step.
    """
    T = filter_of(scheme, o, n, load)
    if T is None or not isinstance(load, Record):
        return None
    return filter_peaks(T, scheme.kernels.FILTER, load.samples[: n + 1], followed)


def filter_of(scheme: Scheme, o: "Oscillators", n: int, load: "Load | None") -> Array | None:
    """The rows of the scheme's `transfer` from f, not h^2 f, to u, v, a; None where no filter tells n steps."""
    order, dt = scheme.kernels.FILTER, float(o.dt[0]) if len(o.dt) else 1.0
    if not order or not isinstance(load, Record) or load.dt != dt or len(load.samples) <= n or load.samples[0] != 0.0:
        return None
    if (
        scheme.start not in ("given", "start")
        or any(scheme.kernels.START_STENCIL)
        or o.start.any()
        or (o.dt != dt).any()
    ):
        return None
    T = scheme.transfer_rows(o.omega * dt, o.xi)
    T[2 * order] *= dt**2
    T[2 * order + 1 : 3 * order + 1] *= dt
    return T


def filter_peaks(T: Array, order: int, f: Array, followed: int) -> Array:
    """Largest |u| (1, P), or |u|, |v|, |a| (3, P), of filters T (4*order + 1, P) of the load f (n + 1,), f[0] = 0."""
    P, n = T.shape[1], len(f) - 1
    peak, kernel = np.empty((followed, P)), _kernel(order, followed)

    def part(first: int, last: int) -> None:
        kernel(T, f, peak, first, last)

    spread(part, P, BLOCK, worth=P * n > WORTH_THREADS)
    return peak


@cache
def _kernel(order: int, followed: int) -> Callable[..., None]:
    from substep_kernels import linear_filter  # noqa: PLC0415 (numba on first use)

    return getattr(linear_filter, f"peaks_{order}_{followed}")
