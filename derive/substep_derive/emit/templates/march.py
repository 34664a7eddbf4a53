"""The fixed text of the linear march's kernels; every {field} is filled by `emit_march`."""

MARCH_HEADER = '''"""The linear march, for every scheme of one shape: x1 = x0 + D x0 + B h^2 f, y1 = O x0 + P h^2 f.

u, h*v, h^2*a of the new step are {reported}. A block of {width} lanes: time outside, lanes inside, all it needs in
one stretch s of memory, a row of {width} for each number. The number that ends a name is that of load instants a step.
"""

import numpy as np
from numba import njit

WIDTH = {width}  # lanes of a block
FAR = 1 << 50  # beyond all places in memory; one known to be neither negative nor this far lets loops fill registers

_compile = njit(cache=True, nogil=True, error_model="numpy", fastmath={{"contract"}})
'''

MARCH = '''

@_compile
def _final_{K}(s, {F}, i, n):
    """A block's state and outputs n steps after step i."""
    whole = i + n - n % {turns}
    for i in range(i, whole, {turns}):
        for j in range({width}):
            {xy} = {at_xy}
            for k in range({turns}):
                {f} = {f_at_k}
{step}
            {at_xy} = {xy}
    for i in range(whole, whole + n % {turns}):
        {f} = {f_at_i}
        for j in range({width}):
            {xy} = {at_xy}
{step_alone}
            {at_xy} = {xy}


@_compile
def _peaks_{K}(s, {F}, i, n):
    """The same, and the largest moduli on the way."""
    whole = i + n - n % {turns}
    for i in range(i, whole, {turns}):
        for j in range({width}):
            {xyt} = {at_xyt}
            for k in range({turns}):
                {f} = {f_at_k}
{step}
                {t} = {largest}
            {at_xyt} = {xyt}
    for i in range(whole, whole + n % {turns}):
        {f} = {f_at_i}
        for j in range({width}):
            {xyt} = {at_xyt}
{step_alone}
            {t} = {largest}
            {at_xyt} = {xyt}


@_compile
def _own_{K}(s):
    """`_peaks_{K}` for one step whose loads are in the block, of every lane its own."""
    for j in range({width}):
        {xyt} = {at_xyt}
        {f} = {f_of_lane}
{step_own}
        {t} = {largest}
        {at_xyt} = {xyt}


@_compile
def _history_{K}(s, {F}, i, n, u, v, a, row):
    """All steps of a full block; u, v, a: from its first lane after step i on, a step being row numbers further."""
    for i in range(i, n):
        {f} = {f_at_i}
        for j in range({width}):
            {xy} = {at_xy}
{step_alone}
            {at_xy} = {xy}
            u[j], v[j], a[j] = {scaled}
        u, v, a = u[row:], v[row:], a[row:]


@_compile
def march_{K}(C, x, {F}, forces, start, n, stride, out, peak, begin, end):
    """March the lanes from begin to end, from step start to step n.

    C ({given}, P): D, B, O, P, a row for each entry, and {scales_told}. x ({m}, P): the state there, overwritten by
    the last. {F} (n,): the load of all lanes at each instant of a step; or forces ({K}, n, P), its own of each; both
    may be longer, and what is not used is empty. out (n // stride + 1, 3, P) or (0, 3, P): u, v, a every stride steps
    of all n, rows up to the start the caller's. peak (3, P) or (3, 0): largest |u|, |v|, |a| after the start.
    """
    room = np.empty({rows} * {width} + 8)
    s = room[-(room.ctypes.data >> 3) & 7 :]  # from the start of a cache line
    lanes, steps_loaded = x.shape[1], forces.shape[1]
    given, state, loads = C.reshape(-1), x.reshape(-1), forces.reshape(-1)
    values, largest = out.reshape(-1), peak.reshape(-1)
    for first in range(begin, end, {width}):
        size = min({width}, end - first)
        s[:] = 0.0
        for r in range({m}):
            for j in range(size):
                s[r * {width} + j] = state[r * lanes + first + j]
        for r in range({given}):
            for j in range(size):
                s[({before} + r) * {width} + j] = given[r * lanes + first + j]
        i = start
        if stride == 1 and size == {width} and values.size > 0 and largest.size == 0 and loads.size == 0:
            u = values[3 * lanes * (i + 1) + first :]
            _history_{K}(s, {F}, i, n, u, u[lanes:], u[2 * lanes :], 3 * lanes)
            i = n
        while i < n:
            steps, at = min(stride - i % stride, n - i), 3 * lanes * (i // stride + 1) + first
            if loads.size > 0:
                for k in range(i, i + steps):
                    for r in range({K}):
                        place = min(max((r * steps_loaded + k) * lanes + first, 0), FAR)
                        for j in range(size):
                            s[({own} + r) * {width} + j] = loads[place + j]
                    _own_{K}(s)
            elif largest.size > 0:
                _peaks_{K}(s, {F}, i, steps)
            else:
                _final_{K}(s, {F}, i, steps)
            i += steps
            if values.size > 0 and i % stride == 0:
{takes}
        for r in range({m}):
            for j in range(size):
                state[r * lanes + first + j] = s[r * {width} + j]
        if largest.size > 0:
            for r in range(3):
                for j in range(size):
                    largest[r * lanes + first + j] = s[({peaks} + r) * {width} + j]


@_compile
def run_{K}(C, x, {F}, out):
    """One lane, C ({given},), all steps into out (n, 3), {F} (n,): two at once, D and E = (1 + D)^2 - 1 abreast."""
    {coefficients} = C
{squares}
    {x}, n = {at_x}, out.shape[0]
    for i in range(0, n - 1, 2):
{two}
    if n % 2:
        i = n - 1
{one}
    {at_x} = {x}
'''
PAIRS = '''
_exact = njit(nogil=True, error_model="numpy")  # no fastmath: the tails are what rounding took


@_exact
def _plus(a, b):
    """a + b and what its rounding took."""
    head = a + b
    rest = head - a
    return head, (a - (head - rest)) + (b - rest)


@_exact
def _plus_one(a, b, b_):
    """The same for a double and a pair."""
    head, tail = _plus(a, b)
    tail += b_
    total = head + tail
    return total, tail - (total - head)


@_exact
def _plus_two(a, a_, b, b_):
    """The same for two pairs."""
    head, tail = _plus(a, b)
    tail += a_ + b_
    total = head + tail
    return total, tail - (total - head)


@_exact
def _times(a, b):
    """a*b and what its rounding took, from halves whose products are exact."""
    head, c, d = a * b, 134217729.0 * a, 134217729.0 * b
    a1, b1 = c - (c - a), d - (d - b)
    a2, b2 = a - a1, b - b1
    return head, ((a1 * b1 - head) + a1 * b2 + a2 * b1) + a2 * b2


@_exact
def _times_one(a, b, b_):
    """The same for a double and a pair."""
    head, tail = _times(a, b)
    tail += a * b_
    total = head + tail
    return total, tail - (total - head)


@_exact
def _times_two(a, a_, b, b_):
    """The same for two pairs."""
    head, tail = _times(a, b)
    tail += a * b_ + a_ * b
    total = head + tail
    return total, tail - (total - head)


@_exact
def _over(a, a_, b, b_):
    """The double next to a/b."""
    head = a / b
    product, tail = _times(head, b)
    return head + ((a - product) - tail + a_ - head * b_) / b
'''

BY_BLOCKS = '''

@_compile
def _{name}(s):
    """Of a block of lanes, whose {told} stand in its first rows."""
    for j in range({width}):
        {arguments} = {at_arguments}
{lines}
        {at_entries} = {entries}


@_compile
def {name}({arguments}, out):
    """{doc}"""
    s = np.ones({all_rows} * {width})
    for first in range(0, out.shape[1], {width}):
        size = min({width}, out.shape[1] - first)
        for j in range(size):
            {at_arguments} = {arguments_at}
        _{name}(s)
        for r in range({rows}):
            for j in range(size):
                out[r, first + j] = s[({given} + r) * {width} + j]
'''

COEFFICIENTS = """D, B, O, P of {march}, x1 = x0 + D x0 + B h^2 f and y1 = O x0 + P h^2 f, row by row.

    D (m, m), rounded once; B (m, {K}) and P have zeros in columns beyond the stencil; out ({rows}, n).
    """

TRANSFER = """From a load linear between steps to the response from rest, see linear_filter; out ({rows}, n).

    P, g, and k of u, S, k of h*v and of h^2*a: e0 = h^2 f + g1 e1 + ... - P q, u = S (q + k0 e0 + k1 e1 + ...).
    """

FILTER_HEADER = '''"""Peaks of oscillators from rest under one load, linear between steps: a digital filter a lane.

See a scheme's `transfer`. Time outside, a block of {whole} lanes inside, its two halves abreast. The numbers that
end a name are the filter's order and how many of u, h*v, h^2*a are followed.
"""

import numpy as np
from numba import njit

WIDTH = {whole}  # lanes of a block

_compile = njit(cache=True, nogil=True, error_model="numpy", fastmath={{"contract"}})
'''

FILTER = '''

@_compile
def _filter_{d}_{followed}(s, f):
    """All steps of a block; s: q, differences and peaks, then the filter."""
    n = f.size - 1
    whole = 1 + n - n % 2
    for i in range(1, whole, 2):
        for j in range({width}):
            {moving} = {at_moving}
            for k in range(2):
                f0 = f[i + k]
{step}
            {at_moving} = {moving}
    for i in range(whole, n + 1):
        f0 = f[i]
        for j in range({width}):
            {moving} = {at_moving}
{step_alone}
            {at_moving} = {moving}


@_compile
def peaks_{d}_{followed}(T, f, peak, begin, end):
    """Peaks ({followed}, P) of the lanes from begin to end; T (.., P): of `transfer`; f (n + 1,), its first 0."""
    room = np.empty({rows} * {whole} + 8)
    s = room[-(room.ctypes.data >> 3) & 7 :]  # from the start of a cache line
    for first in range(begin, end, {whole}):
        size = min({whole}, end - first)
        s[:] = 0.0
        for r in range({given}):
            for j in range(size):
                s[({moved} + r) * {whole} + j] = T[r, first + j]
        _filter_{d}_{followed}(s, f)
        for r in range({followed}):
            for j in range(size):
                peak[r, first + j] = s[({peaks} + r) * {whole} + j]
        for j in range(size):
            peak[0, first + j] *= abs(s[{scale} + j])
'''
