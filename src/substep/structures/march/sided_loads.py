"""Loads of a structure on either side of the times at which they jump, for steps that end there."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...core.arrays import Array
from ...core.loads import break_points, one_sided
from ..model.memory import Memory
from ..model.model import Model
from .steps import StructureSteps


@dataclass(frozen=True, eq=False)
class Forces:
    """The loads of a structure from t_begin to t_end, on either side of where they jump; targets: ends of steps."""

    structure: Model
    t_begin: float
    t_end: float

    @cached_property
    def targets(self) -> Array:
        """Break points of the loads within (t_begin, t_end), and t_end."""
        found = [break_points(g, self.t_end) for _, g in self.structure.loads]
        every = np.unique(np.concatenate([np.empty(0), *found]))
        return np.append(every[every > self.t_begin], self.t_end)

    @cached_property
    def functions(self) -> list[Callable[[float, float], float]]:
        """Of each load, its value at a time, seen from a time between the same two break points."""
        return [one_sided(g) for _, g in self.structure.loads]

    def factors(self, t: float, middle: float) -> Array:
        """g (J,)."""
        return np.array([g(t, middle) for g in self.functions])

    def acceleration(self, t: float, middle: float, u: Array, v: Array, memory: Memory | None = None) -> Array:
        """From the equation of motion (n,), with the load on the side of `middle`; memory: see `Model.acceleration`."""
        return self.structure.acceleration(t, u, v, self.structure.loaded(self.factors(t, middle)), memory)

    def over(self, march: StructureSteps, t: float, middle: float) -> tuple[list[Array], list[float]]:
        """Of each system of a step from t, what `StructureSteps.complete` takes: the loads (J,), and their instant."""
        h, systems = march.run.h, march.steps.systems
        none = np.zeros(len(self.structure.loads))
        loads = [sum([w * self.factors(t + tau * h, middle) for w, tau in x.loads], none) for x in systems]
        return loads, [t + x.instant * h for x in systems]
