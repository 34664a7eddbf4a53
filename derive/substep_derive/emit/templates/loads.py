"""Fixed text of the module that evaluates loads."""

from .decorators import INLINE
from .registers import WIDEST

LOADS = (
    '''"""Values of loads at many times: a record between its samples, the sine, and sines of lanes."""

import numpy as np
from numba import njit
'''
    + WIDEST
    + """
AT_ONCE = 256  # times whose places in a record are found before its samples are read, which is not done in vectors
FAR = 1 << 30  # beyond it the place in a record is not found as an integer of 32 bits, as CPUs with AVX2 do in vectors

_exact = njit(cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True)
_fused = njit(cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True, fastmath={"contract"})
"""
    + INLINE
    + '''

@_exact
def interpolate(samples, dt, t, out):
    """A record of step dt at times t (n,), linear between its samples (m,), m >= 2, and 0 beyond its ends; out (n,).

    A time that differs from a sample's by at most 1e-9 dt counts as the sample's.
    """
    widest()
    last, later = samples.size - 1, samples[1:]
    place, share = np.empty(AT_ONCE, np.uint64), np.empty(AT_ONCE)
    for first in range(0, t.size, AT_ONCE):
        time, value = t[first : first + AT_ONCE], out[first : first + AT_ONCE]
        for i in range(time.size):
            position = time[i] / dt
            before = np.floor(position + 1e-9)
            position = position if position - before > 1e-9 else before
            inside = 0.0 <= position and position <= last
            position = position if inside else 0.0
            before = np.floor(min(position, last - 1.0))
            place[i] = np.int64(before)
            share[i] = position - before
            value[i] = 1.0 if inside else 0.0
        for i in range(time.size):
            value[i] *= samples[place[i]] * (1.0 - share[i]) + later[place[i]] * share[i]


@_exact
def interpolate_steps(samples, dt, h, tau, first, out):
    """What `interpolate` gives at the times (first + i + tau) h, to the last bit, without an array of them; out (n,).

    Where many of them lie between the first sample and the last but one, these need not be looked for one by one.
    """
    widest()
    most, later = min(samples.size - 2, FAR), samples[1:]
    place, share, t = np.empty(AT_ONCE, np.uint32), np.empty(AT_ONCE), np.empty(AT_ONCE)
    for begin in range(0, out.size, AT_ONCE):
        value, step = out[begin : begin + AT_ONCE], np.float64(first + begin)
        if step + tau >= 0.0 and (step + value.size + tau) * h / dt < most:
            for i in range(value.size):
                position = (step + np.float64(np.int32(i)) + tau) * h / dt
                before = np.floor(position + 1e-9)
                place[i] = np.int32(before)
                share[i] = position - before if position - before > 1e-9 else 0.0
            for i in range(value.size):
                value[i] = samples[place[i]] * (1.0 - share[i]) + later[place[i]] * share[i]
        else:
            for i in range(value.size):
                t[i] = (step + np.float64(i) + tau) * h
            interpolate(samples, dt, t[: value.size], value)


@_inline
def _sine(x):
    """Its sine to 2 units in the last place, for |x| <= 1e6.

    pi k, the nearest multiple, is taken from x in three parts, the first two of 33 bits, so that k times each is exact;
    the sine of the rest r is r + r^3 times a polynomial in r^2 of nearly least maximal error.
    """
    k = np.rint(x * 0.3183098861837907)
    r = ((x - k * 3.1415926534682512) - k * 1.2154201012607932e-10) - k * 4.044532497591901e-21
    z = r * r
    p = 1.6058977292642743e-10 + z * (-7.643969663988074e-13 + z * 2.7314368769379893e-15)
    p = 2.7557319219160833e-06 + z * (-2.505210761669045e-08 + z * p)
    p = 0.008333333333333316 + z * (-0.00019841269841254966 + z * p)
    p = r + r * z * (-0.16666666666666666 + z * p)
    odd = k - 2.0 * np.floor(0.5 * k)
    return p - 2.0 * odd * p


@_fused
def sine(x):
    """Replace x (n,) by its sine to 2 units in the last place; returns False, with x as it was, if any |x| > 1e6."""
    widest()
    far = 0
    for i in range(x.size):
        far += abs(x[i]) > 1e6
    if far > 0:
        return False
    for i in range(x.size):
        x[i] = _sine(x[i])
    return True


@_fused
def harmonic(x, parameters):
    """Replace times x (n, m) by a sin(omega x + phase); returns False, with x as it was, if any angle is beyond 1e6.

    parameters: a, omega, phase of each row (3, n, 1), or of each column (3, 1, m) if m > 1. The sine has the digits of
    `sine`.
    """
    widest()
    rows, columns = x.shape
    of_rows, far = parameters.shape[2] == 1, 0
    for i in range(rows):
        if of_rows:
            omega, phase = parameters[1, i, 0], parameters[2, i, 0]
            for j in range(columns):
                far += abs(omega * x[i, j] + phase) > 1e6
        else:
            for j in range(columns):
                far += abs(parameters[1, 0, j] * x[i, j] + parameters[2, 0, j]) > 1e6
    if far > 0:
        return False
    for i in range(rows):
        if of_rows:
            a, omega, phase = parameters[0, i, 0], parameters[1, i, 0], parameters[2, i, 0]
            for j in range(columns):
                x[i, j] = a * _sine(omega * x[i, j] + phase)
        else:
            for j in range(columns):
                x[i, j] = parameters[0, 0, j] * _sine(parameters[1, 0, j] * x[i, j] + parameters[2, 0, j])
    return True
'''
)
