"""The fixed text of the linear march's kernels; every {field} is filled by `emit`."""

MARCH_HEADER = '''"""The linear march, for every scheme of one shape: x1 = x0 + D x0 + B h^2 f, y1 = O x0 + P h^2 f.

u, h*v, h^2*a of the new step are {reported}. Lanes are marched in blocks of {width}, steps in the outer loop, lanes in
the inner one. All numbers of a block are in one array s, with a row of {width} for each number of a lane. The number at
the end of a function's name is the number of load instants a step.

march_... marches p lanes from step start to step n. C: a row for each entry of D, B, O, P, then scales of what is
reported. x ({m}, p): the state at step start, replaced by that at step n. F0, ... (n,): the load at each instant of a
step where all lanes share it; forces: where each has its own; both may be longer, and the one not used is empty. out
and peaks are those of more lanes, of which these are the ones from `begin` on. out (n // stride + 1, 3, P): u, v, a
every stride steps, rows up to step start left to the caller; or (0, 3, P). peak_u, peak_v, peak_a (P,): take the
largest |u|, |v|, |a| of these steps and of `before` (3, p); or (0,). Returns how many numbers of x are not finite.

run_... marches one lane n steps; out (n, 3): u, v, a of each. What a number of x changes by is added to its own share
of the step: no sum waits for a longer chain of others.
"""

import numpy as np
from numba import njit
{imports}
WIDTH = {width}  # lanes of a block
BLOCKS = {blocks}  # blocks whose histories are stored side by side, so that rows of many lanes are written in one go
AHEAD = {ahead}  # steps of one lane whose loads are multiplied by their coefficients before it marches through them
FAR = 1 << 50  # beyond any index; loops are vectorised if their first index is known to lie from 0 to FAR

'''

STRETCH = '''

@_inner
def {name}({arguments}):
    """{docstring}"""
    widest()
{begin}    whole = i + n - n % {steps_at_once}
    for i in range(i, whole, {steps_at_once}):
        for j in range({width}):
            {moving} = {places}
            for k in range({steps_at_once}):
                {f} = {f_at_k}
{step}
            {places} = {moving}
    for i in range(whole, whole + n % {steps_at_once}):
        {f} = {f_at_i}
        for j in range({width}):
            {moving} = {places}
{step_alone}
            {places} = {moving}
'''

MARCH = '''

@_inner
def _own_loads_{K}(s):
    """One step of `_peaks_{K}`, for lanes each of which has its own loads, in the block."""
    widest()
    for j in range({width}):
        {xyt} = {at_xyt}
        {f} = {f_of_lane}
{step_with_peaks}
        {at_xyt} = {xyt}


@_inner
def _history_{K}(s, rows, {F}, i):
    """March a block {steps_at_once} steps from step i on; u, v, a of each step go into rows of BLOCKS blocks."""
    widest()
    for j in range({width}):
        {x} = {at_x_in_block}
        for k in range({steps_at_once}):
            {f} = {f_at_k}
{step}
            {staged} = {scaled}
        {at_x_in_block} = {x}


@_compile
def march_{K}(C, x, before, {F}, forces, start, n, stride, out, peak_u, peak_v, peak_a, begin):
    """March lanes; C ({given}, p) ends with {scales}; {F} (n,), forces ({K}, n, p)."""
    lanes, p, steps_loaded, loaded = out.shape[2], x.shape[1], forces.shape[1], forces.shape[2]
    given, state, loads, values = C.reshape(-1), x.reshape(-1), forces.reshape(-1), out.reshape(-1)
    earlier, largest, followed, failed = before.reshape(-1), (peak_u, peak_v, peak_a), 3 if peak_u.size > 0 else 0, 0
    all_steps = stride == 1 and values.size > 0 and followed == 0 and loads.size == 0
    room = np.empty(BLOCKS * ({rows} + 3 * {steps_at_once}) * {width} + 8)
    blocks = room[-(room.ctypes.data >> 3) & 7 :]  # from the start of a cache line
    rows = blocks[BLOCKS * {rows} * {width} :]
    for side in range(0, p, BLOCKS * {width}):
        beyond, i = min(side + BLOCKS * {width}, p), start
        blocks[:] = 0.0
        for first in range(side, beyond, {width}):
            s, size = blocks[(first - side) * {rows} :], min({width}, p - first)
            for r in range({m}):
                for j in range(size):
                    s[r * {width} + j] = state[r * p + first + j]
            for r in range({given}):
                for j in range(size):
                    s[({before} + r) * {width} + j] = given[r * p + first + j]
            for r in range(followed):
                for j in range(size):
                    s[({peaks} + r) * {width} + j] = abs(earlier[r * p + first + j])
        while all_steps and i + {steps_at_once} <= n:
            for first in range(0, beyond - side, {width}):
                _history_{K}(blocks[first * {rows} :], rows[first:], {F}, i)
            for r in range(3 * {steps_at_once}):
                at = (BLOCKS * {rows} + r * BLOCKS) * {width}
                store(values, (3 * (i + 1) + r) * lanes + begin + side, blocks, at, beyond - side)
            i += {steps_at_once}
        then = i
        for first in range(side, beyond, {width}):
            s, size, i = blocks[(first - side) * {rows} :], min({width}, p - first), then
            while i < n:
                steps, at = min(stride - i % stride, n - i), 3 * lanes * (i // stride + 1) + begin + first
                if loads.size > 0:
                    for k in range(i, i + steps):
                        for r in range({K}):
                            place = min(max((r * steps_loaded + k) * loaded + first, 0), FAR)
                            for j in range(size):
                                s[({own} + r) * {width} + j] = loads[place + j]
                        _own_loads_{K}(s)
                elif followed > 0:
                    _peaks_{K}(s, {F}, i, steps)
                else:
                    _final_{K}(s, {F}, i, steps)
                i += steps
                if values.size > 0 and i % stride == 0:
{takes}
            for r in range({m}):
                for j in range(size):
                    state[r * p + first + j] = s[r * {width} + j]
                    failed += 1 if s[r * {width} + j] - s[r * {width} + j] != 0.0 else 0
            for r in range(followed):
                for j in range(size):
                    largest[r][begin + first + j] = s[({peaks} + r) * {width} + j]
    return failed
'''

RUN = '''

@_compile
def run_{K}(C, x, {F}, out):
    """March one lane; C ({given},), {F} (n,)."""
    {coefficients} = C
    {x} = {at_x}
    for i in range(out.shape[0]):
        {f} = {f_at_i}
{one}
    {at_x} = {x}
'''

RUN_AHEAD = '''

@_compile
def run_{K}(C, x, {F}, out):
    """March one lane; C ({given},), {F} (n,). What the loads add is computed first, AHEAD steps in vector registers."""
    {coefficients} = C
    {x} = {at_x}
    loaded = np.empty({sums} * AHEAD)
    for first in range(0, out.shape[0], AHEAD):
        rows = out[first : first + AHEAD]
        {f} = {f_ahead}
        for i in range(rows.shape[0]):
{ahead}
        for i in range(rows.shape[0]):
{one}
    {at_x} = {x}
'''

FILTER_HEADER = '''"""Peaks of oscillators from rest under one load, linear between steps, by a digital filter.

Each lane has its filter, from `transfer` of a scheme's module. The outer loop is over steps, the inner one over a block
of {whole} lanes, in two halves so that one is computed while the other waits for results. The numbers at the end of a
function's name are the filter's order and how many of u, v, a are followed. For a there is one row more than `transfer`
has, the factor of q, which is 0 for the relative acceleration and not for the absolute one.
"""

import numpy as np
from numba import njit
{imports}
WIDTH = {whole}  # lanes of a block

'''

FILTER = '''

@_compile
def peaks_{d}_{followed}(T, f, peak, begin, end):
    """Peaks ({followed}, P) of the lanes from begin to end; T: rows of `transfer`; f (n + 1,), f[0] = 0."""
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
