"""The modified energy of a scene at states in numbers: what a scheme keeps there, and the rate at which it does not."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..core.arrays import Array
from ..core.jets import Space, solved
from ..core.scenes import Scene
from ..core.schemes import Scheme
from ..derived.simple_fraction import printed_fraction

BLOCK = 256  # states at once, whose derivatives along all trees are kept


@dataclass(frozen=True)
class ModifiedEnergy:
    """Of a scene with these values of its parameters: functions of states (2 d, P), coordinates and rates.

    motion: a `substep_derive.ModifiedMotion`.
    """

    motion: Any
    values: list[float]

    @classmethod
    def of(cls, given: Scene, s: Scheme) -> "ModifiedEnergy":
        """Of a scheme on a scene.

        Raises ValueError for a load and for lanes, DeclarationError where there is none: see `energy_drift`.
        """
        from ..derived import facade  # noqa: PLC0415 (SymPy, and all facts)

        if given.load is not None or given.u0.ndim > 1:
            what = "a load" if given.load is not None else "lanes"
            raise ValueError(f"expected {given.name} without {what}, for the energy that a scheme loses; leave it out")
        exact = tuple((name, printed_fraction(float(value))) for name, value in s.given.items())
        motion = facade.modified_motion(s.info.source, given.info.source, exact)
        return cls(motion, [float(x) for x in given.parameters.values()])

    def kept(self, states: Array) -> dict[int, Array]:
        """Power of h -> (P,), what stands beside it in the energy that is kept, besides T + V."""
        return self._everywhere(states, lambda motion: motion.kept)

    def rates(self, states: Array) -> dict[int, Array]:
        """Power of h -> (P,), what stands beside it in the rate at which that energy is not kept."""
        return self._everywhere(states, lambda motion: motion.energy_rates)

    def _everywhere(self, states: Array, of: Callable[[Any], dict[int, Array]]) -> dict[int, Array]:
        blocks = (states[:, k : k + BLOCK] for k in range(0, states.shape[1], BLOCK))
        parts = [of(replace(self.motion, place=_OnStates(self.motion, self.values, x))) for x in blocks]
        return {power: np.concatenate([part[power] for part in parts]) for power in parts[0]}


class _OnStates:
    """A place of trees: they are vectors (d, P) at states (2 d, P) of a scene with these values of its parameters."""

    def __init__(self, motion: Any, values: list[float], states: Array) -> None:
        d, P = len(states) // 2, states.shape[1]
        self.state, self.number = (states[:d], states[d:]), motion.decimal
        self._motion, self._at, self._d = motion, [*values, *states], d
        self._space = Space(2 * d if motion.equation.of.rates else d, motion.equation.top)
        variables = self._space.variables_at(states[: self._space.variables])
        with_series = [*values, *variables, *states[len(variables) :]]
        self._matrix, right = (motion.in_numbers(e)(*with_series) for e in motion.system)
        self._series = {(): solved(self._matrix, [x for (x,) in right], self._space, P)}

    def along(self, branches: tuple[int, ...], value: Callable[[int], Array]) -> Array:
        """The force's derivative along these trees (d, P)."""
        return self._along(branches, value)[:, 0]

    def _along(self, branches: tuple[int, ...], value: Callable[[int], Array]) -> Array:
        if branches not in self._series:
            *shorter, last = branches
            series, first = self._along(tuple(shorter), value), self._d if last < 0 else 0
            self._series[branches] = self._space.along(series, value(max(last, ~last)), first)
        return self._series[branches]

    def operator(self, kind: str, x: Array) -> Array:
        """No scene that keeps its energy has one."""
        raise NotImplementedError(kind)

    def weighed(self, x: Array) -> Array:
        """A constant mass times a vector."""
        return np.array(self._matrix, dtype=float) @ x

    def of(self, e: Any) -> Array:
        """A vector of expressions (d, P)."""
        rows: list[list[Any]] = self._motion.in_numbers(e)(*self._at)
        return np.array([np.broadcast_to(x, self.state[0][0].shape) for (x,) in rows])

    def dot(self, x: Array, y: Array) -> Array:
        """The scalar product (P,)."""
        return (x * y).sum(axis=0)
