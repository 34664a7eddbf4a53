"""The fixed text of scenes' modules and of the kernels of scheme x scene; every {field} is filled."""

SCENE_HEADER = '''"""{name}: {reference}

{closed_forms}
"""

import numpy as np
'''

# branch-free, so that it serves numbers and arrays: beyond 20 the slope is 1 to the last digit
LOG_COSH = '''

{decorator}def _log_cosh(x):
    """log(cosh(x)) without overflow and with all digits near 0."""
    near = np.minimum(abs(x), 20.0)
    return np.log1p(2.0 * np.sinh(0.5 * near) ** 2) + (abs(x) - near)
'''

SCENE_FUNCTION = '''

def {name}({arguments}):
    """{docstring}"""
{body}
    return {value}
'''

PAIR_HEADER = '''"""{scheme} on {scene}: all steps of a run, one lane after the other.

{closed_forms}
"""

import numpy as np
from numba import njit

SCHEME = "{scheme}"
SCENE = "{scene}"
# arguments of march, in order; those of SCALARS hold one number a lane
ARGUMENTS = {arguments}
SCALARS = {scalars}
START_ARGUMENTS = {start_arguments}
# the state, row by row: u, v or a, and how many steps before t_n
STATE = {state}
REPORTED = "{reported}"
# arithmetic operations of a step, and of one iteration of each balance that has one
OPERATIONS = {operations}
COMPLETED, NEWTON_FAILED, NON_FINITE, ENERGY_BOUND = 0, 1, 2, 3

_compile = njit(cache=True, nogil=True, error_model="numpy")
'''

SINC = '''

@_compile
def _sinc(x):
    """sin(x)/x."""
    return np.sin(x) / x if x != 0.0 else 1.0
'''

SINC_SLOPE = '''

@_compile
def _sinc_slope(x):
    """Derivative of sin(x)/x; near 0, where (cos(x) - sin(x)/x)/x loses its digits, by its series."""
    if abs(x) < 0.3:
        y = x * x
        return x * (-1.0 / 3.0 + y * (1.0 / 30.0 + y * (-1.0 / 840.0 + y * (1.0 / 45360.0 - y / 3991680.0))))
    return (np.cos(x) - np.sin(x) / x) / x
'''

DIFFERENCE = '''

@_compile
def _{g}_difference(old, new):
    """({g}(new) - {g}(old))/(new - old), by Taylor's series where the difference would cancel."""
    d, m = new - old, 0.5 * (old + new)
    if abs(d) <= {near}:
{series}
        if abs(last) <= 1e-15 * abs(difference):
            return difference
    return ({at_new} - {at_old}) / d


@_compile
def _{g}_difference_slope(old, new):
    """Its derivative by new."""
    d, m = new - old, 0.5 * (old + new)
    if abs(d) <= {near}:
{slope_series}
        if abs(last) <= 1e-15 * abs(difference):
            return slope
    return ({slope_at_new} - _{g}_difference(old, new)) / d
'''

LANE = '''

@_compile
def _lane({lane_arguments}):
    """One run; returns its status, steps completed and the largest energy of them."""
{read_state}
{constants}
    status, done, peak = COMPLETED, n, -np.inf
    for i in range(first, n):
{forces}{steps}
{told}
        if not np.isfinite({sum}):
            status, done = NON_FINITE, i
            break
        if energy > bound:
            status, done = ENERGY_BOUND, i
            break
        peak = max(peak, energy)
{shift}
        if (i + 1) % stride == 0 and (i + 1) // stride < out.shape[0]:
            row = out[(i + 1) // stride]
{store}
{write_state}
    return status, done, peak
'''

NEWTON = """
{before}
{first}
        for count in range(1, 51):
{moving}
{iteration}
{change}
{update}
            if {converged}:
                break
        else:
            status, done = NEWTON_FAILED, i
            break
        if i < iterations.shape[0]:
            iterations[i, {balance}] = count
{after}"""

MARCH = '''

@_compile
def march({arguments}):
    """{title}

{docstring}
    """
    for lane in range(h.size):
        status[lane], n_done[lane], peak[lane] = _lane({lane_call})
'''

START = '''

@_compile
def _start({lane_arguments}):
    """State of one lane at t = 0."""
{body}


@_compile
def start({arguments}):
    """State (lanes, {m}, {d}) at t = 0 from u, v, a (lanes, {d}) there.{more}"""
    for lane in range(h.size):
        _start({lane_call})
'''

STENCIL = '''

def stencil({parameters}):
    """Instants at which a step takes the load, in steps after t_n."""
    return {instants}


def start_stencil({parameters}):
    """Instants at which the start takes it, in steps."""
    return {start_instants}
'''

SCENES = '''"""What scenes there are, as plain data: read without importing numba or SymPy.

Of each: coordinates with their units; parameters as (name, low, high, low excluded, high excluded, default
or None); start as a function of the parameters: u, v, and a or None for consistent; the length that Newton's
tolerance is relative to and, where the start has no energy, an energy scale, as functions of them too; named
outputs; whether there is an angular momentum and whether the user gives the load; of a linear oscillator
its circular frequency, damping ratio and mass, as functions of the parameters, None of any other scene.
"""

SCENES = {scenes}
'''

BLOCK = '''

# lanes of a block: the arrays of a step, all rows of one, stay in the first cache, and LLVM sees that none overlap
WIDTH = {width}


@_compile
def march_block({arguments}):
    """As march, for at most WIDTH lanes, which fill vector registers abreast."""
    numbers = np.zeros(({rows}, WIDTH))
    flags = np.zeros(({flag_rows}, WIDTH), dtype=np.int64)
{allocate}
    last = first
    for j in range(h.size):
        status[j], n_done[j], peak[j] = COMPLETED, n[j], -np.inf
        last = max(last, n[j])
        alive[j] = 1
{read}
{constants}    for i in range(first, last):
        for j in range(h.size):
            alive[j] = alive[j] & (i < n[j])
{loops}
        for j in range(WIDTH):
{told}
            total[j] = {sum}
            finite = total[j] - total[j] == 0.0
            went[j] = alive[j] & {unfailed}finite & (energy[j] <= bound_[j])
            peak_[j] = max(peak_[j], energy[j]) if went[j] else peak_[j]
        stopped = 0
        for j in range(WIDTH):
            stopped += alive[j] - went[j]
{shift}
        if stopped > 0:
            for j in range(h.size):
                if alive[j] & ~went[j]:
                    n_done[j] = i
                    status[j] = {why}
                    alive[j] = 0
        if (i + 1) % stride == 0 and (i + 1) // stride < out.shape[1]:
            for j in range(h.size):
                if went[j]:
                    row = out[j, (i + 1) // stride]
{store}
    for j in range(h.size):
        peak[j] = peak_[j]
{write_state}
'''

BLOCK_NEWTON = """
        for j in range(WIDTH):
{before}
{first}
            busy[j] = alive[j] & ~failed[j]
            count[j] = 0
        for _ in range(50):
            left = 0
            for j in range(WIDTH):
{iteration}
                count[j] += busy[j]
                busy[j] = busy[j] & ~({near})
                left += busy[j]
            if left == 0:
                break
        for j in range(WIDTH):
            failed[j] = failed[j] | busy[j]
{after}
        if i < iterations.shape[1]:
            for j in range(h.size):
                iterations[j, i, {balance}] = count[j]"""
