"""Peaks of many oscillators from rest under one record with a sample at each step: the fastest march there is."""

from collections.abc import Callable
from functools import cache

import numpy as np

from ..core.loads import Load, Record
from ..core.schemes import Array, Scheme
from ..core.threads import spread
from .oscillators import Oscillators

NANOSECONDS = 0.125  # of a step of a lane


def peaks_from_rest(scheme: Scheme, o: Oscillators, n: int, load: Load | None, followed: int) -> Array | None:
    """Largest |u| (1, P), or |u|, |v|, |a| (3, P), over n steps; None where no filter tells them.

    That is for another start than rest, another load, and schemes that begin otherwise or take the load outside a step.
    """
    T = filter_of(scheme, o, n, load)
    if T is None or not isinstance(load, Record):
        return None
    return filter_peaks(T, scheme.kernels.FILTER, load.samples[: n + 1], followed)


def filter_of(scheme: Scheme, o: Oscillators, n: int, load: Load | None) -> Array | None:
    """The rows of the scheme's `transfer` from f, not h^2 f, to u, v, a; None where no filter tells n steps."""
    order, dt = scheme.kernels.FILTER, float(o.dt[0]) if len(o.dt) else 1.0
    if not order or not isinstance(load, Record) or load.dt != dt or len(load.samples) <= n or load.samples[0] != 0.0:
        return None
    if (
        scheme.start not in ("given", "start")
        or any(scheme.kernels.START_STENCIL)
        or o.start.any()
        or (o.dt != dt).any()
        or not scheme.loaded_within
    ):
        return None
    T = scheme.transfer_rows(o.omega * dt, o.xi)
    T[2 * order] *= dt**2
    T[2 * order + 1 : 3 * order + 1] *= dt
    return T


def filter_peaks(T: Array, order: int, f: Array, followed: int) -> Array:
    """Largest |u| (1, P), or |u|, |v|, |a| (3, P), of filters T (4*order + 1, P) of the load f (n + 1,), f[0] = 0."""
    P, n = T.shape[1], len(f) - 1
    peak, (kernel, width) = np.empty((followed, P)), _kernel(order, followed)

    def part(first: int, last: int) -> None:
        kernel(T, f, peak, first, last)

    spread(part, P, width, nanoseconds=P * n * NANOSECONDS)
    return peak


@cache
def _kernel(order: int, followed: int) -> tuple[Callable[..., None], int]:
    """Of the filter's order and how many of u, v, a are followed; and how many lanes its blocks have."""
    from substep_kernels import linear_filter  # noqa: PLC0415 (numba on first use)

    return getattr(linear_filter, f"peaks_{order}_{followed}"), linear_filter.WIDTH
