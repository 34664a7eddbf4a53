"""The fixed text of laws' modules and of their index; every {field} is filled."""

LAW = '''"""{name}: {reference}

{equations}
"""

import numpy as np
from numba import njit

# (name, low, high, low excluded, high excluded, default or None) of each parameter
PARAMETERS = {parameters}
# what the law remembers, with the energy that it has dissipated last, where it keeps account of it
MEMORY = {memory}
# whether the force depends on the rate of the elongation
OF_RATE = {of_rate}
'''

UNSTRAINED = '''

def unstrained({arguments}):
    """What the law remembers before it is strained."""
    return {values}
'''

EVALUATE = '''

def evaluate(count, parameters, e, e_dot, memory, elapsed, force, tangent, damping, new, stored):
    """Of so many springs the force at elongations e, its slopes by these and by their rates e_dot, ...

    ... the memory `new` that a commit there would keep, and the energy stored. parameters: in the order of PARAMETERS
    each of all springs; memory: so what was last committed, elapsed s before. It is called by its address.
    """
    for i in range(count):
{read}
{body}
'''

LAWS = '''"""The laws of the catalogue by name: their modules have everything else about them."""

LAWS = {laws}
'''
