"""The fixed text of scenes' modules and of their index; every {field} is filled."""

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

SCENES = '''"""The scenes of the catalogue as plain data, which can be read without importing numba or SymPy.

Each scene has: coordinates with their units; parameters as (name, low, high, low excluded, high excluded, default
or None); start, a function of the parameters: u, v, and a or None if it follows from the equation of motion;
length, to which Newton's tolerance is relative, a function of the parameters; and where it is from. Some have:
energy_scale, of a scene that starts without energy, a function of the parameters; names of outputs; an angular
momentum; sampled, where the user gives the load; damped, where its velocity causes a force, and conserves, where
that does no work; oscillator, of a linear oscillator its circular frequency, damping ratio and mass as functions of
the parameters. One whose laws have a memory has its names, and `unstrained`, a function of the parameters: its values
before anything is strained.
"""
{imports}
SCENES = {scenes}
'''
