"""The fixed text of the module of a scheme's plan on a structure."""

PLAN_HEADER = '''"""{name} on a structure M a + C v + N(u) = f: vectors, and the systems that give them.

{equations}

`step` returns, for numbers h and parameters: the operations in their order; the new state; what is reported. `start`,
where the state at t = 0 is not made of u_0, v_0, a_0, returns the same for it. A row is a dictionary vector ->
coefficient. An operation is ("combine", vector, row), or ("solve", vector, slots), where the slots are rows for M, C
and K0, triples (w, row, instant in steps after t_n) for N, triples (w, row, row) for N_discrete, pairs (w, instant) for
f, and the vector solves M*.. + C*.. + K0*.. + w*N(..) = w*f(..); commit are triples (row of u, row of v, instant) where
a sub-step ends with it, at which an internal force with a memory is committed. NO_MEMORY: why the scheme takes no such
force, empty where it does.
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
