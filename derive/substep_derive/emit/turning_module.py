"""TurningStep -> text of the module that holds the equations of a step on a stiff bar that turns, as numbers."""

from ..declare.names import printed
from ..motion.turning import TurningStep
from .printing import KernelPrinter, block, fill, literal_tuple, wrapped

TURNING = '''"""The equations of a step of {scheme} on a stiff bar that turns."""

import numpy as np

# of the relations; how many symbols and forces are new; of what is kept, the column it becomes; kinds and instants of
# the old symbols; columns of u_1 and v_1
ROWS, COLUMNS = {rows}, {columns}
OF_NEW = {of_new}
AFTER = {after}
STATE = {state}
ENDS = {ends}
PARAMETERS = {parameters}


def numbers({arguments}):
    """Entries of the relations row by row, then of the places, then the instants of the forces."""
{body}
    return {entries}
'''


def turning_module(step: TurningStep) -> str:
    """Text of the module."""
    names = {s.name: printed(s).name for s in step.scheme.values}
    entries = [*step.relations, *step.places, *step.instants]
    outputs = {f"entry_{k}": e for k, e in enumerate(entries) if e.free_symbols}
    w = KernelPrinter(names)
    texts = [f"entry_{k}" if e.free_symbols else w.doprint(e) for k, e in enumerate(entries)]
    return fill(
        TURNING,
        scheme=step.scheme.name,
        rows=step.relations.rows,
        columns=step.relations.cols,
        of_new=step.of_new,
        after=step.after,
        state=step.state,
        ends=step.ends,
        parameters=literal_tuple(f'"{name}"' for name in names),
        arguments=", ".join(names.values()),
        body=block([*outputs.items()], 1, w)[0],
        entries=wrapped(texts),
    )
