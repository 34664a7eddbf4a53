"""A peer that marches structures: OpenSees on the box of linear elasticity."""

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

import substep as ss

from .peers import peer

CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))  # of an element's lower face, in OpenSees' order


def opensees_solid(
    cells: int, step: float, rayleigh: ss.Rayleigh, force: ss.Harmonic, n: int, rounds: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """`substep.structures.examples.solid` of cells**3 elements in openseespy, under Newmark's average acceleration.

    Returns the displacement of the loaded corner along the load (n + 1,), and CPU seconds of a step in later rounds of
    n steps (rounds,). This is the fastest way that OpenSees has here: factors of SparseSYM in the order of RCM, kept by
    `Linear -factorOnce`. To be called in a process of its own: where MKL's library was loaded first, OpenSees
    crashes.
    """
    ops, corner = _model(cells, rayleigh, force)

    def run(n: int) -> None:
        if ops.analyze(n, step):
            raise RuntimeError("openseespy: Newmark failed")

    found = [0.0]
    for _ in range(n):
        run(1)
        found.append(float(ops.nodeDisp(corner, 3)))
    seconds = np.empty(rounds)
    for turn in range(rounds):
        began = time.process_time()
        run(n)
        seconds[turn] = (time.process_time() - began) / n
    return np.array(found), seconds


def _model(cells: int, rayleigh: ss.Rayleigh, force: ss.Harmonic) -> tuple[Any, int]:
    """OpenSees with the model and its analysis, and the node that is loaded."""
    ops: Any = peer("openseespy.opensees")
    n = cells + 1
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 3)

    def node(i: int, j: int, k: int) -> int:
        return 1 + i + n * (j + n * k)

    for k, j, i in np.ndindex(n, n, n):
        ops.node(node(i, j, k), i / cells, j / cells, k / cells)
        if i == 0:
            ops.fix(node(i, j, k), 1, 1, 1)
    ops.nDMaterial("ElasticIsotropic", 1, 200e9, 0.3, 8000.0)
    for e, (k, j, i) in enumerate(np.ndindex(cells, cells, cells)):
        nodes = [node(i + a, j + b, k + c) for c in (0, 1) for a, b in CORNERS]
        ops.element("stdBrick", e + 1, *nodes, 1, 0.0, 0.0, 0.0)
    ops.rayleigh(rayleigh.alpha, rayleigh.beta, 0.0, 0.0)
    ops.timeSeries("Trig", 1, 0.0, 1e9, 2.0 * np.pi / force.omega)
    ops.pattern("Plain", 1, 1)
    ops.load(node(cells, cells, cells), 0.0, 0.0, force.amplitude)
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("SparseSYM")
    ops.algorithm("Linear", "-factorOnce")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    return ops, node(cells, cells, cells)
