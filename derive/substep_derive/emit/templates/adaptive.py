"""The fixed text of the module that marches a scheme on a scene in steps of chosen length; every {field} is filled."""

ADAPTIVE_HEADER = '''"""{scheme} on {scene}: steps that are chosen from the estimated local error.

{errors}
"""

import numpy as np
from numba import njit

SCHEME = "{scheme}"
SCENE = "{scene}"
# numbers of a lane, in order: parameters, weights of the estimate's terms, what is asked of the run
SCALARS = {scalars}
# places in a lane's control and counts
(TIME, PROPOSED, BEFORE, LAST, SPEED, PEAK, SMALLEST, LARGEST, BASE, HELD), CONTROL = range(10), 10
(BEGUN, TARGET, ROWS, GRID, ACCEPTED, REJECTED, FAILED), COUNTS = range(7), 7
BALANCES = {balances}
# rows of the state: the scheme's, and what an estimate reads of the step before
STATE = {state}
# powers of t that the interpolant reproduces
DEGREE = {degree}
# arithmetic operations of a step, the estimate included, and of one iteration of each balance that has one
OPERATIONS = {operations}
# ratio of the lengths between which steps move, 0.0 for any length; and the work of a change of length, in steps
RUNG, CHANGE = {rung}, {change}
COMPLETED, NON_FINITE, ENERGY_BOUND, STEP_TOO_SMALL, BUFFER_FULL = 0, 2, 3, 4, 5
# squares of weighted errors: the one that is aimed at, and the largest with which a step keeps its length; it keeps it
# too where it could be longer by less than a third, so that what depends on it need not be computed again
AIM, KEPT = 0.16, 0.5

# contract: a product and a sum may become one operation; sums keep their order
_compile = njit(cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True, fastmath={{"contract"}})
# called by kernels alone: not from Python, and so without the code for that
_inner = njit(nogil=True, error_model="numpy", no_cfunc_wrapper=True, no_cpython_wrapper=True, fastmath={{"contract"}})


@_inner
def _load(load, samples, middle, t):
    """The load at t: load holds its kind and up to three parameters.

    middle: a time between the same two break points, which decides where the load jumps on which side of it t is.
    """
    if load[0] == 1.0:
        return load[1] * np.sin(load[2] * t + load[3])
    if load[0] == 2.0:
        return load[1] if middle >= load[2] else 0.0
    if load[0] == 3.0:
        return load[1] * np.sin(np.pi * t / load[2]) if 0.0 <= middle and middle <= load[2] else 0.0
    if load[0] == 4.0:
        k = np.int64(np.floor(middle / load[1]))
        if k < 0 or k >= samples.size - 1:
            return 0.0
        share = t / load[1] - k
        return samples[k] * (1.0 - share) + samples[k + 1] * share
    return 0.0


@_inner
def _factor(size, before, ratio, power):
    """The factor for the next step's length: Soderlind's digital filter H211b with b = 4, limited to 0.2 and 2.7.

    size, before: squares of this step's error and of the one before, weighted; ratio: of the lengths of these steps;
    power: 1/(2 p + 2) where the error is O(h^(p + 1)). Soderlind, ACM Trans. Math. Softw. 29 (2003) 1-26.
    """
    wanted = -0.25 * power * np.log(max(size, 1e-30) * max(before, 1e-30) / (AIM * AIM))
    if ratio != 1.0:
        wanted -= 0.25 * np.log(ratio)
    return np.exp(min(max(wanted, -1.6), 1.0))


@_inner
def _on_ladder(wanted, held, base, rung, left, dt_min):
    """The longest base * rung**k that is at most the wanted length; the one held where a longer one saves too little.

    left: the time to go, in which a longer step has to save more steps than its change costs.
    """
    found = base * rung ** np.floor(np.log(wanted / base) / np.log(rung) + 1e-9)
    if found < dt_min and dt_min <= wanted:
        return dt_min
    if found > held and left * (1.0 / held - 1.0 / found) <= CHANGE:
        return held
    return found
'''

ACCELERATION = '''

@_inner
def _acceleration({arguments}):
    """Acceleration from the equation of motion."""
{body}
    return {value}
'''

FIRST = '''

@_inner
def _first(numbers, start, t, load, samples, middle):
    """Length of a step of which nothing is known before it; start: u, v, a at t. And the speed that it is scaled by.

    Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), II.4.
    """
{numbers}
{first_acceleration}
    size = np.empty((3, start.shape[1]))
    fast = np.abs(start[1]).max()
    fast = max(fast, np.sqrt(length * max(np.abs(start[2]).max(), {largest_first})))
    u_scale = atol_u + rtol * np.abs(start[0]) + 1e-300
    v_scale = atol_v + share_v * fast + rtol * np.abs(start[1]) + 1e-300
{a_first}
    d0 = np.sqrt(np.mean((start[0] / u_scale) ** 2 + (start[1] / v_scale) ** 2))
    d1 = np.sqrt(np.mean((start[1] / u_scale) ** 2 + (size[0] / v_scale) ** 2))
    trial = 0.01 * d0 / d1 if d0 > 1e-5 and d1 > 1e-5 else 1e-6 * t_end
    trial = min(trial, t_end)
    size[1] = start[0] + trial * start[1]
    size[2] = start[1] + trial * size[0]
    t += trial
{second_acceleration}
{a_second}
    if fast == 0.0:  # complete rest: only the load tells how fast the motion will be
        fast = np.sqrt(length * np.abs(size[1]).max())
        v_scale = v_scale + share_v * fast
    d2 = np.sqrt(np.mean(((size[2] - start[1]) / u_scale) ** 2 + ((size[1] - size[0]) / v_scale) ** 2)) / trial
    steepest = max(d1, d2)
    found = (0.01 / steepest) ** (2.0 * power) if steepest > 1e-15 else max(1e-6 * t_end, 1e-3 * trial)
    return min(100.0 * trial, found), fast
'''

HALVES = '''

@_inner
def _halved({arguments}):
    """u and v after two steps of h from a state at t; NaN where an iteration does not converge."""
{numbers}
{initial}
{constants}
{state}
    for _ in range(2):
{forces}{steps}
{reported}
{shift}
        t += h
    return {result}
'''

# an acceleration that differs from the motion's own by a power of the length of the step that led to it
ADAPTED = """        if h != made and made == made:
            ratio = (h / made) ** {lag}
            made = h
{rows}
"""

UNEVEN = """        if h != at_h or last != at_last:
            at_h, at_last, kappa = h, last, last / h
{uneven}
"""

# what a first step's estimate could not see has to be seen before a step is longer
UNMEASURED = """        if last != last:
            proposed = min(proposed, h)
"""

# the motion before a break point of the load tells nothing of that after it
RESTART = """        if landing and at + 1 < targets.size:
            before, last = -1.0, np.nan
{again}"""

AGAIN = """            middle = 0.5 * (targets[at] + targets[at + 1])
{old_back}
            proposed = min(proposed, _first(numbers, here, t, load, samples, middle)[0])
"""

ADAPTIVE_LANE = '''

@_inner
def _lane(numbers, start, load, samples, targets, grid, state, here, control, counts, newton, times, out, iterations):
    """March one lane until it ends or its rows are full; returns its status."""
{numbers}
{initial}
{once}
    if counts[BEGUN] == 0:
        counts[BEGUN] = 1
        here[:] = start
        middle = 0.5 * targets[0]
{begin}
        control[TIME], control[LAST], control[PEAK], control[SMALLEST] = 0.0, np.nan, -np.inf, np.inf
        control[BEFORE], control[LARGEST] = -1.0, 0.0
        control[PROPOSED], control[SPEED] = _first(numbers, start, 0.0, load, samples, middle)
        if dt_first > 0.0:
            control[PROPOSED] = dt_first
        control[BASE] = control[HELD] = control[PROPOSED]
        if times.size > 0 and grid.size == 0:
            times[0], counts[ROWS] = 0.0, 1
            out[0] = start
        while counts[GRID] < grid.size and grid[counts[GRID]] <= 0.0:
            times[counts[GRID]] = 0.0
            out[counts[GRID]] = start
            counts[GRID] += 1
{read_state}
{first_old}
    t, proposed, before, last = control[TIME], control[PROPOSED], control[BEFORE], control[LAST]
    speed, peak, smallest, longest = control[SPEED], control[PEAK], control[SMALLEST], control[LARGEST]
    at, row, place, accepted = counts[TARGET], counts[ROWS], counts[GRID], counts[ACCEPTED]
    held, base = control[HELD], control[BASE]
    low = AIM * max(rung, 1.35) ** (-1.0 / power)
    known, middle, status, made = np.nan, np.nan, COMPLETED, last
{no_step}    while t < t_end:
        if row == times.size and row > 0 and grid.size == 0:
            status = BUFFER_FULL
            break
        if targets[at] <= t or middle != middle:
            while targets[at] <= t:
                at += 1
            middle = 0.5 * (targets[at] + (targets[at - 1] if at > 0 else 0.0))
        if proposed != held:
            if rung > 1.0:
                proposed = _on_ladder(proposed, held, base, rung, t_end - t, dt_min)
            held = proposed
        if not proposed >= dt_min or proposed <= 1e-15 * t:
            status = STEP_TOO_SMALL
            break
        h, left = min(proposed, dt_max), targets[at] - t
        landing = h >= left * (1.0 - 1e-9)
        if landing:
            h = left
        elif h > 0.5 * left:
            h = 0.5 * left
        end = targets[at] if landing else t + h
        if h != known:
            known = h
{changing}
        h = known  # the same number, but not computed from the last step's error: the processor need not wait for it
{adapted}{uneven}{forces}{steps}
{reported}
        size = 0.0
{size}
        if not np.isfinite({sum} + size):
            counts[REJECTED] += 1
            proposed, before = 0.1 * h, -1.0
            continue
        if size > 1.0:
            counts[REJECTED] += 1
            proposed, before = h * max(0.1, min(0.9, (AIM / size) ** power)), -1.0
            continue
        if energy > bound:
            status, proposed = ENERGY_BOUND, h
            break
        peak = max(peak, energy)
        accepted += 1
{count}        while place < grid.size and grid[place] <= end:
            share = (grid[place] - t) / h
            times[place] = grid[place]
{dense}
            place += 1
{remember}
{shift}
        t = end
{jump}        if row < times.size and grid.size == 0:
            times[row] = t
{store}
            row += 1
        full = proposed
        if size >= low and size <= KEPT and before >= 0.0:
            proposed = h
        elif before < 0.0 or rung > 1.0:
            proposed = h * min(max((AIM / max(size, 1e-30)) ** power, 0.2), 2.7)
        else:
            proposed = h * _factor(size, before, h / last, power)
{unmeasured}        if h < full:
            proposed = max(proposed, full) if size <= KEPT else proposed
        before, last, made = size, h, h
{restart}        smallest, longest = min(smallest, h), max(longest, h)
{write_state}
{old_back}
    control[TIME], control[PROPOSED], control[BEFORE], control[LAST] = t, proposed, before, last
    control[SPEED], control[PEAK], control[HELD] = speed, peak, held
    control[SMALLEST], control[LARGEST] = smallest, longest
    counts[TARGET], counts[ROWS], counts[GRID], counts[ACCEPTED] = at, row, place, accepted
    return status
'''

NOT_CONVERGED = """counts[FAILED] += 1
counts[REJECTED] += 1
proposed, before = 0.25 * h, -1.0
continue"""

COUNT_STEP = """        newton[0, {balance}] += taken_{balance}
        newton[1, {balance}] = max(newton[1, {balance}], taken_{balance})
        if row < iterations.shape[0]:
            iterations[row, {balance}] = taken_{balance}
"""

DENSE = """            if grid[place] == end:
{at_end}
            else:
{between}"""

JUMP = """        if landing and at + 1 < targets.size:
            jump = _load(load, samples, 0.5 * (targets[at] + targets[at + 1]), t) - _load(load, samples, middle, t)
            if jump != 0.0:
{jumps}
"""

ADAPTIVE_MARCH = '''

@_compile
def march(
    numbers, start, load, samples, targets, grid, state, here, control, counts, newton, times, out, iterations, status
):
    """March every lane in steps of chosen length until t_end, a failure, or full rows; call again to go on.

    numbers (lanes, SCALARS); start (lanes, 3, {d}): u, v, a at t = 0; load (lanes or 1, 4), samples of a record;
    targets (lanes or 1, n): times on which steps end, ascending, the last t_end; grid (n,): times at which rows are
    wanted, none for a row at the start and after each step. counts[:, BEGUN] = 0 begins a run. state (lanes, STATE,
    {d}), here (lanes, 3, {d}): the state, and u, v, a, at the time control[:, TIME]; where a run has failed,
    control[:, PROPOSED] is the length of the step that did. newton (lanes, 2, balances): iterations of the accepted
    steps, their sum and the most in one. times (lanes, rows) and out (lanes, rows, 3, {d}): u, v, a; no rows for none;
    iterations (lanes, rows, balances). A step is accepted if the root of the mean square of the estimated errors over
    their scales, atol + rtol*|.|, is at most 1; the scale of v has share_v times the largest |v| so far besides.
    """
    for k in range(numbers.shape[0]):
        status[k] = _lane(
            numbers[k], start[k], load[k % load.shape[0]], samples, targets[k % targets.shape[0]], grid, state[k],
            here[k], control[k], counts[k], newton[k], times[k], out[k], iterations[k],
        )
'''

LOCAL_ERROR = '''"""The estimate of the local error of {scheme}."""

import numpy as np

# of u, then of v: symbol and power of h of each term
TERMS = {terms}
ORDER = {order}
PARAMETERS = {parameters}


def weights({arguments}):
    """The factors of the terms of u, then of v."""
    return {weights}
'''
