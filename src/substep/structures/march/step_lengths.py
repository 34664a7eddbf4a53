"""Lengths of chosen steps with their factorizations, and what estimated errors are measured by."""

import math
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ...core.arrays import Array
from ...core.loads import peak, values_at
from ..model.model import Model
from ..solvers.factorization import SingularMatrix, factorize
from .going_on import tangent_arrays, tangents_in
from .linear import Factors
from .newton import NonlinearSystem, Tangent
from .scheme_plan import step_of
from .steps import Run, StructureSteps

LENGTHS = 6  # of steps, whose factorizations are kept
SAME = 1e-9  # lengths that differ by less are one
INSTANTS = 1025  # at which loads are looked at for their largest values


@dataclass
class Lengths:
    """Steps of each of the last few lengths, ready to be solved."""

    run: Run
    known: OrderedDict[float, StructureSteps | list[Tangent | None]] = field(default_factory=OrderedDict)

    def of(self, h: float) -> StructureSteps:
        """Those of this length, or of one that differs by rounding."""
        found, length = list[Tangent | None](), h
        for other, steps in self.known.items():
            if abs(h - other) <= SAME * h:
                self.known.move_to_end(other)
                if isinstance(steps, StructureSteps):
                    return steps
                found, length = steps, other
                break
        else:
            while len(self.known) >= LENGTHS:
                self.known.popitem(last=False)
        run = replace(self.run, h=length, factors=Factors())
        self.known[length] = march = run.prepared(step_of(run.scheme, length))
        for solver, tangent in zip(march.systems, found, strict=False):
            if tangent is not None and isinstance(solver, NonlinearSystem):
                solver.keep(tangent)
        return march

    @property
    def arrays(self) -> dict[str, Array]:
        """What `recall` takes: the lengths, and of each the tangents in use."""
        found = {"lengths": np.array(list(self.known))}
        for j, steps in enumerate(self.known.values()):
            kept = steps
            if isinstance(steps, StructureSteps):
                kept = [solver.tangent if getattr(solver, "solve", None) else None for solver in steps.systems]
            found |= tangent_arrays(kept, f"{j} ")
        return found

    def recall(self, arrays: Mapping[str, Array]) -> None:
        """Have the lengths of another march, which are prepared when they are first used."""
        for j, h in enumerate(arrays.get("lengths", np.empty(0)).tolist()):
            self.known[h] = tangents_in(arrays, f"{j} ")


def rms(x: Array) -> float:
    """The root of the mean square."""
    return math.sqrt(float(np.einsum("i,i->", x, x)) / len(x))


def reach(structure: Model, t_end: float, u: Array, v: Array) -> float:
    """What small displacements are measured by, as `rms`: the start's, or the static ones under the largest loads.

    A body that is not held has none, nor is one known without a tangent: then those of free motion under the mean loads
    until t_end. u, v (n,): at the start. With neither a displacement nor a load, those for which the springs store the
    energy that the start has.
    """
    instants, found = np.linspace(0.0, t_end, INSTANTS), rms(u)
    sizes = [np.abs(values_at(g, instants)) for _, g in structure.loads]
    largest, mean = (
        sum((shape * x for (shape, _), x in zip(structure.loads, of, strict=True)), np.zeros(structure.size))
        for of in ([peak(g, x) for (_, g), x in zip(structure.loads, sizes, strict=True)], [x.mean() for x in sizes])
    )
    if not largest.any():
        return found or _swing(structure, t_end, u, v)
    if structure.K is not None:
        try:
            return max(found, rms(factorize(structure.K, structure.solver)(largest)))
        except SingularMatrix:
            pass
    return max(found, 0.5 * t_end**2 * rms(structure.solve_mass(mean)))


def _swing(structure: Model, t_end: float, u: Array, v: Array) -> float:
    """The root of the mean square of displacements along v with the energy of v, at most those of free flight.

    The stiffness is that of the force itself, for the tangent need not be its derivative.
    """
    flight, brief = t_end * rms(v), 1e-6 * t_end
    if structure.internal is None:
        stored = float(v @ (structure.K @ v))
    else:
        stored = float(v @ (structure.restoring(0.0, u + brief * v, v) - structure.restoring(0.0, u, v))) / brief
    return min(flight, math.sqrt(float(v @ (structure.M @ v)) / stored) * rms(v)) if stored > 0.0 else flight


@dataclass
class Scales:
    """What errors are divided by: atol + share * (the largest RMS so far) + rtol * |.|, of each component."""

    rtol: float
    atol: tuple[float, float]
    share: tuple[float, float]
    largest: list[float]

    def of(self, kind: int, old: Array, new: Array) -> Array:
        """Of u (kind 0) or v (1), from the values at both ends of a step."""
        return self.over(kind, rms(new), np.maximum(np.abs(old), np.abs(new)))

    def over(self, kind: int, largest: float, sizes: Array) -> Array:
        """Of components of these sizes, where the RMS at the end of a step is `largest`."""
        return self.atol[kind] + self.share[kind] * max(self.largest[kind], largest) + 1e-300 + self.rtol * sizes

    def saw(self, rows: Array) -> None:
        """Take account of u and v that were reached."""
        self.largest = [max(x, rms(row)) for x, row in zip(self.largest, rows, strict=False)]
