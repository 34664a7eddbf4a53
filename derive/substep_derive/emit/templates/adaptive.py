"""The fixed text of the module that marches a scheme on a scene in steps of chosen length; every {field} is filled."""

IMPORTS = """import numpy as np
from numba import njit"""

IMPORTS_OF_DEVICE = """import math

from numba import cuda"""

ADAPTIVE_HEADER = '''"""{scheme} on {scene}: steps that are chosen from the estimated local error.

{errors}
"""

{imports}

SCHEME = "{scheme}"
SCENE = "{scene}"
# numbers of a lane, in order: parameters, weights of the estimate's terms, what is asked of the run
SCALARS = {scalars}
# places in a lane's control and counts
(TIME, PROPOSED, BEFORE, LAST, SPEED, PEAK, SMALLEST, LARGEST, BASE, HELD, MADE), CONTROL = range(11), 11
(BEGUN, TARGET, ROWS, GRID, ACCEPTED, REJECTED, FAILED, PAUSES), COUNTS = range(8), 8
BALANCES = {balances}
# rows of the state: the scheme's, and what an estimate reads of the step before
STATE = {state}
# powers of t that the interpolant reproduces
DEGREE = {degree}
# arithmetic operations of a step, the estimate included, and of one iteration of each balance that has one
OPERATIONS = {operations}
# ratio of the lengths between which steps move, 0.0 for any length; and the work of a change of length, in steps
RUNG, CHANGE = {rung}, {change}
COMPLETED, NON_FINITE, ENERGY_BOUND, STEP_TOO_SMALL, BUFFER_FULL, PAUSED = 0, 2, 3, 4, 5, 6
# contract: a product and a sum may become one operation; sums keep their order
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
    """Length of a step of which nothing is known before it; start: u, v, a at t. And the speed that it is scaled by."""
{numbers}
{first}
    fast = max({fastest}, np.sqrt(length * {steepest}))
{scales}
    d0 = {d0}
    d1 = {d1}
    trial = _trial(d0, d1, length, fast)
{moved}
    t += trial
{second}
    if fast == 0.0:  # complete rest: only the load tells how fast the motion will be
        fast = np.sqrt(length * {moving})
{more}
    d2 = {d2} / trial
    return _first_length(d1, d2, trial, power), fast
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
{steps}{reported}
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
def _copy(rows, to):
    """Store rows in others."""
    for k in range(rows.shape[0]):
        for i in range(rows.shape[1]):
            to[k, i] = rows[k, i]


@_inner
def _lane(
    numbers, start, load, samples, targets, grid, state, here, control, counts, newton, times, out, extremes, iterations
):
    """March one lane until it ends or its rows are full; returns its status."""
{numbers}
{initial}
{once}
    if counts[BEGUN] == 0:
        counts[BEGUN] = 1
        _copy(start, here)
        middle = 0.5 * (t_begin + targets[0])
{begin}
        control[TIME], control[LAST], control[PEAK], control[SMALLEST] = t_begin, np.nan, -np.inf, np.inf
        control[BEFORE], control[LARGEST], control[MADE] = -1.0, 0.0, np.nan
        control[PROPOSED], control[SPEED] = _first(numbers, start, t_begin, load, samples, middle)
        if dt_first > 0.0:
            control[PROPOSED] = dt_first
        control[BASE] = control[HELD] = control[PROPOSED]
        if times.size > 0 and grid.size == 0:
            times[0], counts[ROWS] = t_begin, 1
            _copy(start, out[0])
        while counts[GRID] < grid.size and grid[counts[GRID]] <= t_begin:
            times[counts[GRID]] = t_begin
            _copy(start, out[counts[GRID]])
            counts[GRID] += 1
{read_state}
{first_old}
    t, proposed, before, last = control[TIME], control[PROPOSED], control[BEFORE], control[LAST]
    speed, peak, smallest, longest = control[SPEED], control[PEAK], control[SMALLEST], control[LARGEST]
    at, row, place, accepted = counts[TARGET], counts[ROWS], counts[GRID], counts[ACCEPTED]
    held, base, made = control[HELD], control[BASE], control[MADE]
    low = _kept_from(rung, power)
    known, middle, status = np.nan, np.nan, COMPLETED
{no_step}    while t < t_end:
        if row == times.size and row > 0 and grid.size == 0:
            status = BUFFER_FULL
            break
        if targets[at] <= t or middle != middle:
            while targets[at] <= t:
                at += 1
            middle = 0.5 * (targets[at] + (targets[at - 1] if at > 0 else t_begin))
        wanted, spared = proposed, False
        if proposed != held and rung > 1.0:
            wanted, spared = _on_ladder(proposed, held, base, rung, t_end - t, dt_min, CHANGE)
        h, landing = _reaching(min(wanted, dt_max), targets[at] - t)
        if counts[PAUSES] == 1 and (spared or (at + 1 == targets.size and (landing or h < min(wanted, dt_max)))):
            status = PAUSED
            break
        proposed = held = wanted
        if not proposed >= dt_min or proposed <= 1e-15 * t:
            status = STEP_TOO_SMALL
            break
        end = targets[at] if landing else t + h
        if h != known:
            known = h
{changing}
        h = known  # the same number, but not computed from the last step's error: the processor need not wait for it
{adapted}{uneven}{steps}{reported}
        size = 0.0
{size}
        if not np.isfinite({sum} + size):
            counts[REJECTED] += 1
            proposed, before = _shorter(h, np.nan, power), -1.0
            continue
        if size > 1.0:
            counts[REJECTED] += 1
            proposed, before = _shorter(h, size, power), -1.0
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
{jump}        if extremes.shape[0] > 0:
{extremes}
        if row < times.size and grid.size == 0:
            times[row] = t
{store}
            row += 1
        proposed = _next(h, proposed, size, before, last, low, rung, power, {measured})
        before, last, made = size, h, h
{restart}        smallest, longest = min(smallest, h), max(longest, h)
{write_state}
{old_back}
    control[TIME], control[PROPOSED], control[BEFORE], control[LAST] = t, proposed, before, last
    control[SPEED], control[PEAK], control[HELD], control[MADE] = speed, peak, held, made
    control[SMALLEST], control[LARGEST] = smallest, longest
    counts[TARGET], counts[ROWS], counts[GRID], counts[ACCEPTED] = at, row, place, accepted
    return status
'''

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
    numbers, start, load, samples, targets, grid, state, here, control, counts, newton, times, out, extremes,
    iterations, status,
):
    """March every lane in steps of chosen length until t_end, a failure, or full rows; call again to go on.

    With counts[:, PAUSES] = 1 it pauses before the first step whose length t_end changes; with 0 it goes on from there.
    numbers (lanes, SCALARS); start (lanes, {rows}, {d}): u, v, a at t_begin; load (lanes or 1, 4), samples of a record;
    targets (lanes or 1, n): times on which steps end, ascending, the last t_end; grid (n,): times at which rows are
    wanted, none for a row at the start and after each step. counts[:, BEGUN] = 0 begins a run. state (lanes, STATE,
    {d}), here (lanes, {rows}, {d}): the state, and u, v, a, at the time control[:, TIME]; where a run has failed,
    control[:, PROPOSED] is the length of the step that did. newton (lanes, 2, balances): iterations of the accepted
    steps, their sum and the most in one. times (lanes, rows) and out (lanes, rows, {rows}, {d}): u, v, a, and what
    laws remember; no rows for none; extremes (lanes, 3 or 0, {d}): the largest |u|, |v|, |a| so far; iterations
    (lanes, rows, balances). A step is accepted if the root of the mean square of the estimated errors over their
    scales, atol + rtol*|.|, is at most 1; the scale of v has share_v times the largest |v| so far besides.
    """
    for k in range(numbers.shape[0]):
        status[k] = _lane(
            numbers[k], start[k], load[k % load.shape[0]], samples, targets[k % targets.shape[0]], grid, state[k],
            here[k], control[k], counts[k], newton[k], times[k], out[k], extremes[k],
            iterations[k],
        )
'''

# the arguments of a thread are those of a lane
ADAPTIVE_THREADS = '''

@_compile
def march(
    numbers, start, load, samples, targets, grid, state, here, control, counts, newton, times, out, extremes,
    iterations, status,
):
    """March every lane, with the arguments of `march` in the module for a CPU; `iterations` has no rows."""
    k = cuda.grid(1)
    if k < status.size:
        status[k] = _lane(
            numbers[k], start[k], load[k % load.shape[0]], samples, targets[k % targets.shape[0]], grid, state[k],
            here[k], control[k], counts[k], newton[k], times[k], out[k], extremes[k],
            iterations[k],
        )
'''

LOCAL_ERROR = '''"""The estimate of the local error of {scheme}."""

import numpy as np

# of u, then of v, then where it is checked of the acceleration at the end: symbol and power of h of each term
TERMS = {terms}
# whether each step needs the third, or only one that has none before it
ALWAYS = {always}
# of each symbol: where its value is known, and its name there, u, v, a or as in the scheme's plan on a structure
SOURCES = {sources}
ORDER = {order}
# power of h with which an acceleration of the state differs from the motion's own
LAG = {lag}
PARAMETERS = {parameters}


def weights({arguments}):
    """The factors of the terms, in their order."""
    return {weights}
'''
