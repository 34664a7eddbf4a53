"""Whether a program does the same when the defaults of its arguments, as its manual has them, are written out."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .causes import Deviation
from .identify import Match, identify
from .noise import QUIET, Noise
from .probes import DRIVEN, LOADS, RATIOS, Measured, measure, oscillators, own_runs
from .stepper import Stepper


@dataclass(frozen=True)
class WrittenOut:
    """The defaults; how far the steps with them written out are off those without; and the scheme that they then are.

    deviation: see `Measured.deviation`. allowed: what noise may cause. instead: "" where none is found.
    """

    defaults: Mapping[str, Any]
    deviation: float
    allowed: float
    instead: str = ""

    @property
    def same(self) -> bool:
        """Whether they are the same but for noise."""
        return self.deviation <= self.allowed

    @property
    def text(self) -> str:
        """In words."""
        given = ", ".join(
            f"{name} = {value:.6g}" if isinstance(value, float) else f"{name} = {value}"
            for name, value in self.defaults.items()
        )
        if self.same:
            return f"the same with {given} written out, to {self.deviation:.0e}"
        then = f": it is then {self.instead}" if self.instead else ""
        return f"with its defaults written out ({given}) it does something else{then}, off by {self.deviation:.0e}"

    @property
    def deviations(self) -> tuple[Deviation, ...]:
        """What is to be reported: swapped arguments, defaults that are not those of the manual, or few digits."""
        return () if self.same else (Deviation("arguments", self.text),)


def written_out(stepper: Stepper, best: Match | None, noise: Noise = QUIET) -> WrittenOut | None:
    """None for a stepper whose arguments have no defaults, or whose noise hides them. best: what it is without them."""
    if stepper.written_out is None or noise.hides:
        return None
    explicit = replace(stepper, run=stepper.written_out, written_out=None)
    here, there = noise.over(_runs(stepper)), noise.over(_runs(explicit))
    off = np.concatenate([one.deviation(other.rows).ravel() for one, other in zip(here, there, strict=True)])
    found = WrittenOut(stepper.can.defaults, float(np.nanmax(np.abs(off), initial=0.0)), noise.rounding)
    if found.same or best is None:
        return found
    free = [run for run in there if run.load.kind == "none"]
    matches = identify(free, free, best.scheme, noise).matches
    return replace(found, instead=matches[0].text) if matches else found


def _runs(stepper: Stepper) -> list[Measured]:
    """Free runs, and a driven one."""
    at = oscillators(stepper, DRIVEN, RATIOS[:2])
    driven = [] if stepper.can.load == "none" else [measure(stepper, at, (0.0, 0.0, None), LOADS["cosine"])]
    return [*own_runs(stepper, DRIVEN, RATIOS[:2]), *driven]
