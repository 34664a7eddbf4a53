"""The fixed text of the module of a scheme's plan on a structure."""

PLAN_HEADER = '''"""{name} on a structure M a + C v + N(u) = f: vectors, and the systems that give them.

{equations}

`step` returns, for numbers h and parameters: the operations in their order; the new state; what is reported. `start`,
where the state at t = 0 is not made of u_0, v_0, a_0, returns the same for it: see `substep_derive.emit.plan_module`.
"""

NAME = "{name}"
PARAMETERS = {parameters}
STATE = {state}
NO_MEMORY = {no_memory}
'''

PLAN_FUNCTION = '''

def {name}({arguments}):
    """{doc}"""
    operations = {operations}
    out = {out}
    report = {report}
    return operations, out, report
'''
