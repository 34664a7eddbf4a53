"""Peaks of many oscillators from rest under one record with a sample at each step, without their histories.

Under a load that is linear within each step, a linear scheme is a recursive digital filter from the samples to the
response, whose coefficients are derived with the scheme. It needs half the operations of the march.
"""

from collections.abc import Callable

import numpy as np

from ..core import device, single
from ..core.arrays import Array, alike
from ..core.coefficients import transfer_rows
from ..core.loads import Load, Record
from ..core.schemes import Scheme
from ..core.threads import spread
from .oscillators import Oscillators

NANOSECONDS = 0.125  # for a step of a lane


def peaks_from_rest(
    scheme: Scheme,
    o: Oscillators,
    n: int,
    load: Load | None,
    followed: int,
    absolute: bool = False,
    consistent: bool = False,
) -> Array | None:
    """Largest |u| (1, P), or |u|, |v|, |a| (3, P), over n steps; followed: 1 or 3; None without a filter.

    absolute: |2 xi omega v + omega^2 u| in place of |a|. consistent: as for `march_linear`.
    """
    T = filter_of(scheme, o, n, load, consistent)
    if T is None or not isinstance(load, Record):
        return None
    if absolute:  # in which u = scale*(q + k0 e0 + k1 e1 + ...)
        order = scheme.kernels.FILTER
        of_u, scale, of_v, of_a = np.split(T, [order, 2 * order, 2 * order + 1, 3 * order + 1])[1:]
        of_a[-1] = o.omega**2 * scale
        of_a[:-1] = of_a[-1] * of_u + 2.0 * o.xi * o.omega * of_v
    return filter_peaks(T, scheme.kernels.FILTER, load.samples[: n + 1], followed)


def filter_of(scheme: Scheme, o: Oscillators, n: int, load: Load | None, consistent: bool = False) -> Array | None:
    """The filter (4*order + 2, P) from the load f, not h^2 f / mass, to u, v, a; None where none gives n steps.

    There is none for a scheme of high order (FILTER is 0), for one that another scheme starts, and for one that takes a
    load at the start or outside of a step. There is none for another start than rest with a load of 0, for a load that
    is not a `Record` with a sample at each of the n + 1 instants, and for lanes with different steps. The rows are
    those of `transfer` of the scheme's module, and the factor of q in a, which is 0.
    """
    order, dt = scheme.kernels.FILTER, float(o.dt[0]) if len(o.dt) else 1.0
    if not order or not isinstance(load, Record) or load.dt != dt or len(load.samples) <= n or load.samples[0] != 0.0:
        return None
    if (
        scheme.info.start == "scheme"
        or any(scheme.kernels.START_STENCIL)
        or any(x.any() for x in o.start[: 2 if consistent else 3])  # the load begins with 0, and so a at rest
        or not alike(o.dt)
        or not scheme.loaded_within
    ):
        return None
    T = np.concatenate([transfer_rows(scheme, o.omega * dt, o.xi), np.zeros((1, len(o.omega)))])
    T[2 * order] *= dt**2 / o.mass
    T[2 * order + 1 : 3 * order + 1] *= dt / o.mass
    T[3 * order + 1 :] /= o.mass
    return T


def filter_peaks(T: Array, order: int, f: Array, followed: int) -> Array:
    """Largest |u| (1, P), or |u|, |v|, |a| (3, P), of filters T (4*order + 2, P) of the load f (n + 1,), f[0] = 0."""
    P, n = T.shape[1], len(f) - 1
    peak = np.empty((followed, P))
    if device.is_on():
        device.peaks_of_filter(order, followed)(T, f, peak, 0, P)
        return peak
    kernel, width = _kernel(order, followed)
    f = single.rounded(f)

    def part(first: int, last: int) -> None:
        kernel(T, f, peak, first, last)

    spread(part, P, width, nanoseconds=P * n * NANOSECONDS)
    return peak


def _kernel(order: int, followed: int) -> tuple[Callable[..., None], int]:
    """The kernel for a filter of that order that follows u, or u, v and a; and how many lanes it takes at once."""
    from substep_kernels.marches import linear_filter  # noqa: PLC0415 (numba on first use)

    return getattr(single.here(linear_filter), f"peaks_{order}_{followed}"), linear_filter.WIDTH
