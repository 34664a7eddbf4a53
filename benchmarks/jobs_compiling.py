"""CPU seconds that compiling takes: what all schemes share, and what each scheme and each pair has of its own."""

import numpy as np

import substep as ss

from .job import Job, Table
from .jobs_startup import compiling
from .timing import Measured

NAME = "compiling"
FIRST = "import substep as ss; ss.scheme('{}').stability(0.1)"
STABILITY = "ss.scheme('{}').stability(0.1)"
PAIR = "ss.march(ss.scene('elastic_pendulum', EA=1e4), ss.scheme('{}'), dt=1e-4, t_end=2e-4)"
PRINTED = "newmark_bdf2", "bathe"  # whose pairs with the elastic pendulum are committed


def job(quick: bool, full: bool = False) -> Job:
    """One scheme of each kind besides the first, or all of them."""
    found = Job(NAME, "Compiling, CPU seconds in new processes, nothing cached")
    kinds: dict[str, list[str]] = {}
    for name in ss.schemes():
        if not ss.scheme(name).info.fixed:
            kinds.setdefault(ss.scheme(name).kernels.EIGENVALUES, []).append(name)
    shared = [_row(kind, "", FIRST.format(names[0])) for kind, names in kinds.items()]
    found.tables.append(Table("NumPy, numba and what a kind of schemes shares, with its first scheme", "kind", shared))
    chosen = [(names[0], name) for names in kinds.values() for name in (names[1:] if full else names[-1:])]
    rows = [_row(name, FIRST.format(first), STABILITY.format(name)) for first, name in chosen if name != first]
    found.tables.append(Table("stability functions of a further scheme", "scheme", rows))
    loaded = FIRST.format("newmark")
    pairs = [_row(name, loaded, PAIR.format(name)) for name in PRINTED[: 1 if quick else None]]
    found.tables.append(Table("march on the elastic pendulum, of committed pairs", "pair", pairs))
    found.below("compiling the stability functions of a scheme", 1.0, [row.seconds for row in rows], "s")
    found.below("compiling a pair of scheme and scene", 0.8, [row.seconds for row in pairs], "s")
    return found


def _row(name: str, before: str, call: str) -> Measured:
    return Measured(name, "substep", np.array([compiling(before, call)]), {})
