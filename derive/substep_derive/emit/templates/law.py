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

@_compile
def evaluate(parameters, e, e_dot, memory, elapsed, force, tangent, damping, new, stored):
    """Of n springs: the force (n,) at elongations e (n,), its slopes by these and by their rates e_dot (n,), ...

    ... the memory `new` (n, k) that a commit there would keep, and the energy stored (n,). parameters (n, p): in the
    order of PARAMETERS; memory (n, k): that last committed, elapsed s before.
    """
    for i in range(e.size):
{read}
{body}
'''

LAWS = '''"""The laws of the catalogue by name: their modules have everything else about them."""

LAWS = {laws}
'''
