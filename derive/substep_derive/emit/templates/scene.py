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

# contract: a product and a sum may become one operation; sums keep their order
_compile = njit(cache=True, nogil=True, error_model="numpy", fastmath={{"contract"}})
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
{largest}
            if largest <= near_{balance}:
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
{imports}
SCENES = {scenes}
'''

BLOCK = '''

# lanes of a block at most. A row holds one variable of all lanes; the rows of a step stay in the first cache
WIDTH = {width}


@_compile
def _block({arguments}):
    """At most WIDTH lanes, which fill vector registers abreast; the last one is repeated to fill the last register."""
    rows = np.zeros(({rows}, WIDTH + 16))
    begin = -(rows.ctypes.data // 8) & 7  # on a cache line
    end = begin + 8 * ((h.size + 7) // 8)
{allocate}
    for j in range(begin, end):
        lane = min(j - begin, h.size - 1)
{read}
{constants}    for lane in range(h.size):
        status[lane], n_done[lane] = COMPLETED, n[lane]
        running[begin + lane] = np.nan  # the correction that no iteration has made; 0.0 once the lane stops
    last, ends = n.max(), first
    for i in range(first, last):
        if i == ends:
            ends = last
            for lane in range(h.size):
                if n[lane] <= i:
                    running[begin + lane], bound_[begin + lane] = 0.0, np.nan
                else:
                    ends = min(ends, n[lane])
{counted}{steps}        stopped = 0
        for j in range(begin, end):
{told}
            total = {sum}
            now = energy + (total - total)  # NaN unless all are finite
            seen[j] = now
            good = now <= bound_[j]
            stopped = stopped if good else 1
            top = peak_[j]
{read_shift}
            peak_[j] = now if good & (now > top) else top
{shift}
        if stopped > 0:
            stopped = 0
            for j in range(begin, end):
                stopped += (running[j] != 0.0) & (not seen[j] <= bound_[j])
        if stopped > 0:
            for lane in range(h.size):
                j = begin + lane
                if running[j] != 0.0 and not seen[j] <= bound_[j]:
                    n_done[lane], status[lane] = i, ENERGY_BOUND if seen[j] > bound_[j] else NON_FINITE
                    running[j], bound_[j] = 0.0, np.nan
        if (i + 1) // stride < out.shape[1] and (i + 1) % stride == 0:
            for lane in range(h.size):
                j = begin + lane
                if seen[j] <= bound_[j]:
                    row = out[lane, (i + 1) // stride]
{store}
    for lane in range(h.size):
        j = begin + lane
        peak[lane] = peak_[j]
{write_state}


@_compile
def march_block({arguments}):
    """As march, WIDTH lanes at a time."""
    for lane in range(0, h.size, WIDTH):
        _block({calls})
'''

BLOCK_NEWTON = """
        if counted:
            iterations[:, i, {balance}] = 0
        for _ in range(50):
            if counted:
                for lane in range(h.size):
                    iterations[lane, i, {balance}] += not size[begin + lane] <= near_{balance}[begin + lane]
            left = 0
            for j in range(begin, end):
                going = not size[j] <= near_{balance}[j]
{iteration}
                size[j] = largest
                left = left if largest <= near_{balance}[j] else 1
            if left == 0:
                break
        if left > 0:
            for lane in range(h.size):
                j = begin + lane
                if running[j] != 0.0 and not size[j] <= near_{balance}[j]:
                    n_done[lane], status[lane] = i, NEWTON_FAILED
                    running[j], bound_[j] = 0.0, np.nan"""
