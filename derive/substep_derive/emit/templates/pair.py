"""The fixed text of the module that marches a scheme on a scene lane by lane; every {field} is filled."""

PAIR_HEADER = '''"""{scheme} on {scene}: all steps of a run, lane by lane or in blocks of lanes.

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
'''

LANE = '''

@_inner
def _lane({lane_arguments}):
    """March one lane; returns its status, steps completed and their largest energy."""
{read_state}
{constants}
    status, done, peak = COMPLETED, n, -np.inf
{no_counts}    for i in range(first, n):
{steps}{reported}
        if not np.isfinite({sum}):
            status, done = NON_FINITE, i
            break
        if energy > bound:
            status, done = ENERGY_BOUND, i
            break
        peak = max(peak, energy)
{count}{shift}
        if (i + 1) % stride == 0:
{extremes}
            if (i + 1) // stride < out.shape[0]:
                row = out[(i + 1) // stride]
{store}
{write}
    return status, done, peak
'''

LANES = '''

@_compile
def march({arguments}):
    """March every lane n steps of {scheme}.

{docstring}
    """
    for lane in range(h.size):
        status[lane], n_done[lane], peak[lane] = _lane({lane_call})
'''

COUNT_OF_LANE = """        sum_{balance} += taken_{balance}
        most_{balance} = max(most_{balance}, taken_{balance})
        if i < iterations.shape[0]:
            iterations[i, {balance}] = taken_{balance}
"""

COUNT = """        newton[0, {balance}] += taken_{balance}
        newton[1, {balance}] = max(newton[1, {balance}], taken_{balance})
        if {row} < iterations.shape[0]:
            iterations[{row}, {balance}] = taken_{balance}
"""

START = '''

@_inner
def _start({arguments}):
    """State of one lane at t = 0."""
{read}
{body}


@_compile
def start({arguments}):
    """Compute state (lanes, {m}, {d}) from u, v, a (lanes, {d}) at t = 0.{more}"""
    for lane in range(h.size):
        _start({lane_call})
'''

HELD_FIRST = '''

def held_first({parameters}):
    """Of the displacement that the reactions of these constraints at the start hold: factors of u, v, a; instant, s."""
    return ({factors}), {instant}, {constraints}
'''

STENCIL = '''

def stencil({parameters}):
    """Instants at which a step takes the load, in steps after t_n."""
    return {instants}


def start_stencil({parameters}):
    """Instants at which the start takes the load, in steps."""
    return {start_instants}
'''
