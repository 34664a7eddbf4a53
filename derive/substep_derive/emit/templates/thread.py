"""The fixed text of modules whose kernels run in the threads of a GPU, a lane each; every {field} is filled."""

# math's functions give NaN on a device, as NumPy's do, which are fewer there
COMPILE_KERNEL = """_compile = cuda.jit(cache=True)  # products and sums may become one operation, as on a CPU
"""

COMPILE_THREADS = f"""{COMPILE_KERNEL}_inner = cuda.jit(device=True)
"""

PAIR_THREADS_HEADER = '''"""{scheme} on {scene}: all steps of a run, each lane in a thread of a GPU."""

import math

from numba import cuda

COMPLETED, NEWTON_FAILED, NON_FINITE, ENERGY_BOUND = 0, 1, 2, 3

'''

SIGN = '''

@_inner
def _sign(x):
    """1.0, 0.0 or -1.0."""
    return 1.0 if x > 0.0 else -1.0 if x < 0.0 else 0.0
'''

LANE_OF_THREAD = '''

@_compile
def march({arguments}):
    """March every lane n steps of {scheme}; the arguments are those of `march` in the pair's module."""
    lane = cuda.grid(1)
    if lane < status.size:
        status[lane], n_done[lane], peak[lane] = _lane({lane_call})
'''

MARCH_THREADS = '''"""The linear march of one shape, each lane in a thread of a GPU; see the module for a CPU."""

from numba import cuda

{compiled}

@_compile
def march(C, x, forces, start, n, stride, out, peak):
    """March the lanes of x ({m}, P) from step start to step n, with their numbers in registers.

    C ({given}, P) ends with {scales}; forces ({K}, n or more, P or 1); out and peak as on a CPU, or without numbers.
    """
    lane = cuda.grid(1)
    if lane < x.shape[1]:
        own, peaks, rows = lane % forces.shape[2], peak.shape[1] > 0, out.shape[0] > 0
{read}
        t0, t1, t2 = 0.0, 0.0, 0.0
        for i in range(start, n):
            {f} = {f_at_i}
{step}
            if peaks:
{largest}
            if rows and (i + 1) % stride == 0:
{store}
{write}
        if peaks:
            peak[0, lane], peak[1, lane], peak[2, lane] = t0, t1, t2
'''

FILTER_THREADS = '''"""Peaks of oscillators from rest by a digital filter, each lane in a thread of a GPU."""

import math

from numba import cuda

{compiled}

@_compile
def peaks(T, f, peak):
    """Peaks ({followed}, P) of all lanes; T: rows of `transfer`; f (n + 1,), f[0] = 0. One that overflows has inf."""
    lane = cuda.grid(1)
    if lane < peak.shape[1]:
{read}
        {moving} = {zeros}
        for i in range(1, f.size):
            f0 = f[i]
{step}
        if not math.isfinite(q):
            t0 = math.inf
        peak[0, lane] = t0 * abs(S)
{write}
'''
