"""The fixed text of scenes' modules and of the kernels of scheme x scene; every {field} is filled."""

SCENE_HEADER = '''"""{name}: {reference}

{equations}
"""

import numpy as np
'''

# without a branch, so that it takes numbers and arrays; beyond 20 its slope is 1 to the last digit
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

SCENE_STEP_HEADER = '''"""{scheme} on {scene}: all steps of a run, lane by lane or in blocks of lanes.

{residuals}
"""

import numpy as np
from numba import njit
{imports}
SCHEME = "{scheme}"
SCENE = "{scene}"
# arguments of march, in order; those of SCALARS hold one number for each lane
ARGUMENTS = {arguments}
SCALARS = {scalars}
START_ARGUMENTS = {start_arguments}
# rows of the state: u, v or a, and how many steps before t_n
STATE = {state}
REPORTED = "{reported}"
# arithmetic operations of a step, and of one iteration of each balance that has one
OPERATIONS = {operations}
COMPLETED, NEWTON_FAILED, NON_FINITE, ENERGY_BOUND = 0, 1, 2, 3

# contract: a product and a sum may become one operation; sums keep their order
_compile = njit(cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True, fastmath={{"contract"}})
# called by kernels alone: not from Python, and so without the code for that
_inner = njit(nogil=True, error_model="numpy", no_cfunc_wrapper=True, no_cpython_wrapper=True, fastmath={{"contract"}})
'''

SINC = '''

@_inner
def _sinc(x):
    """sin(x)/x."""
    return np.sin(x) / x if x != 0.0 else 1.0
'''

SINC_SLOPE = '''

@_inner
def _sinc_slope(x):
    """Derivative of sin(x)/x; near 0, where (cos(x) - sin(x)/x)/x loses its digits, by its series."""
    if abs(x) < 0.3:
        y = x * x
        return x * (-1.0 / 3.0 + y * (1.0 / 30.0 + y * (-1.0 / 840.0 + y * (1.0 / 45360.0 - y / 3991680.0))))
    return (np.cos(x) - np.sin(x) / x) / x
'''

DIFFERENCE = '''

@_inner
def _{g}_difference(old, new):
    """({g}(new) - {g}(old))/(new - old), by Taylor's series where the difference would cancel."""
    d, m = new - old, 0.5 * (old + new)
    if abs(d) <= {near}:
{series}
        if abs(last) <= 1e-15 * abs(difference):
            return difference
    return ({at_new} - {at_old}) / d


@_inner
def _{g}_difference_slope(old, new):
    """Derivative of `_{g}_difference` with respect to new."""
    d, m = new - old, 0.5 * (old + new)
    if abs(d) <= {near}:
{slope_series}
        if abs(last) <= 1e-15 * abs(difference):
            return slope
    return ({slope_at_new} - _{g}_difference(old, new)) / d
'''

LANE = '''

@_inner
def _lane({lane_arguments}):
    """March one lane; returns its status, steps completed and their largest energy."""
{read_state}
{constants}
    status, done, peak = COMPLETED, n, -np.inf
{count_none}    for i in range(first, n):
{forces}{steps}
{reported}
        if not np.isfinite({sum}):
            status, done = NON_FINITE, i
            break
        if energy > bound:
            status, done = ENERGY_BOUND, i
            break
        peak = max(peak, energy)
{count}{shift}
        if (i + 1) % stride == 0 and (i + 1) // stride < out.shape[0]:
            row = out[(i + 1) // stride]
{store}
{write_state}
    return status, done, peak
'''

NEWTON = """
{before}
{first}
        for taken_{balance} in range(1, 51):
{moving}
{iteration}
{change}
{update}
{largest}
            if largest <= near_{balance}:
                break
        else:
{failed}
{after}"""

FAILED = "status, done = NEWTON_FAILED, i\nbreak"

COUNT_NONE = """    newton[:] = 0
"""

COUNT = """        newton[0, {balance}] += taken_{balance}
        newton[1, {balance}] = max(newton[1, {balance}], taken_{balance})
        if i < iterations.shape[0]:
            iterations[i, {balance}] = taken_{balance}
"""

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

@_inner
def _start({lane_arguments}):
    """State of one lane at t = 0."""
{body}


@_compile
def start({arguments}):
    """Compute state (lanes, {m}, {d}) from u, v, a (lanes, {d}) at t = 0.{more}"""
    for lane in range(h.size):
        _start({lane_call})
'''

STENCIL = '''

def stencil({parameters}):
    """Instants at which a step takes the load, in steps after t_n."""
    return {instants}


def start_stencil({parameters}):
    """Instants at which the start takes the load, in steps."""
    return {start_instants}
'''

SCENES = '''"""The scenes of the catalogue as plain data, which can be read without importing numba or SymPy.

Each scene has: coordinates with their units; parameters as (name, low, high, low excluded, high excluded, default
or None); start, a function of the parameters: u, v, and a or None if it follows from the equation of motion;
length, to which Newton's tolerance is relative, and energy_scale, of a scene that starts without energy, both
functions of the parameters; names of outputs; whether it has an angular momentum; sampled, whether the user gives
the load; damped, whether its velocity causes a force; oscillator, for a linear oscillator its circular frequency,
damping ratio and mass as functions of the parameters, None for any other scene.
"""
{imports}
SCENES = {scenes}
'''

BLOCK = '''

# most lanes of a block. A row holds one variable of all its lanes; the rows of a step stay in the first-level cache
WIDTH = {width}


@_inner
def _leave({leaving}):
    """Hand over the results of lanes that leave, and put a copy of one that stays in their place; whether one does."""
    other = -1
    for j in range(begin, end):
        if runs[j] and leaves[j] == 0.0:
            other = j
        elif runs[j]:
            runs[j], lane = False, j - place
{results}
    if other >= 0:
        for j in range(begin, end):
            if leaves[j] > 0.0:
                of_lane[j] = of_lane[other]
                for r in range(rows.shape[0]):
                    rows[r, j] = rows[r, other]
    return other >= 0


@_inner
def _block(lane0, lane1, {arguments}):
    """March lanes lane0 to lane1, at most WIDTH, in vector registers.

    Every column of the rows is marched: behind the last lane, and where a lane has left, stand copies of others.
    """
    _widest()
    rows = np.zeros(({rows}, WIDTH + 16))
    begin = -(rows.ctypes.data // 8) & 7  # at a cache line
    end = begin + 8 * ((lane1 - lane0 + 7) // 8)
    place = begin - lane0  # a lane stands in column place + lane
    of_lane = np.zeros(WIDTH + 16, dtype=np.int64)  # whose numbers a column has
    runs = np.zeros(WIDTH + 16, dtype=np.bool_)  # whether they are its own lane's
{counts}{allocate}
    for j in range(begin, end):
        lane = of_lane[j] = min(j - place, lane1 - 1)
        runs[j] = j - place == lane
        n_done[lane], status[lane] = n[lane], COMPLETED
{read}
{constants}    i, ends, left = first, first, 0
    while True:
        if i == ends or left > 0:
            ends = n[lane0:lane1].max()
            for j in range(begin, end):
                if n[of_lane[j]] > i:
                    ends = min(ends, n[of_lane[j]])
                else:
                    leaves[j] = 1.0
            if not {leave}:
                return
            left = 0
{waiting}{steps}        bad = 0
        for j in range(begin, end):
{reported}
            now = energy + 0.0 * ({sum})  # NaN unless all are finite
            seen[j] = now
            good = now <= bound_row[j]
            bad = bad if good else 1
            top = peak_row[j]
{read_shift}
            peak_row[j] = now if good & (now > top) else top
{shift}
        if bad > 0:
            for j in range(begin, end):
                if not seen[j] <= bound_row[j]:
                    leaves[j], lane = 1.0, of_lane[j]
                    n_done[lane], status[lane] = i, ENERGY_BOUND if seen[j] > bound_row[j] else NON_FINITE
            if not {leave}:
                return
{count}        if (i + 1) // stride < out.shape[1] and (i + 1) % stride == 0:
            for j in range(begin, end):
                if runs[j]:
                    row = out[j - place, (i + 1) // stride]
{store}
        i += 1


@_compile
def march_block({arguments}):
    """The same results as march, WIDTH lanes at a time."""
    for lane in range(0, h.size, WIDTH):
        _block(lane, min(lane + WIDTH, h.size), {arguments})
'''

# Newton's correction is taken times go: 0 for lanes that have converged and wait for others of their block
BLOCK_NEWTON = """
        for passes_{balance} in range(1, 51):
            if 0 < left < end - begin:
                waited = True
                for j in range(begin, end):
                    go_{balance}[j] = 0.0 if size[j] <= near_{balance}[j] else 1.0
                    idle_{balance}[j] += 1.0 - go_{balance}[j]
            left = 0
            for j in range(begin, end):
{iteration}
                size[j] = largest
                left += 0 if largest <= near_{balance}[j] else 1
            if left == 0:
                break
        if left > 0:
            for j in range(begin, end):
                if not size[j] <= near_{balance}[j]:
                    leaves[j], lane = 1.0, of_lane[j]
                    n_done[lane], status[lane] = i, NEWTON_FAILED
{again}
            continue  # the others begin the step again
"""

BLOCK_COUNTS = """    # Newton's iterations of steps in which all lanes took the same number: their sum, and the most
    common = np.zeros((2, {balances}), dtype=np.int64)
"""

BLOCK_COUNT = """        if i < iterations.shape[1]:
            for j in range(begin, end):
                if runs[j]:
{store}
        if waited:
            for j in range(begin, end):
{own}
        else:
{common}
"""
