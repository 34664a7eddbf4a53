"""The internal force of a nonlinear structure, given by functions of the user's, in the free degrees of freedom."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ...core.arrays import Array, dot
from ...core.errors import float_array, real_number
from ..solvers.matrices import Matrix, checked, reduced
from .memory import Recalled

ROUNDING = 64 * np.finfo(np.float64).eps  # of a force, within which two of its values are the same


@dataclass(eq=False)
class InternalForce:
    """N(t, u, v) (n,), its tangent (n, n) and its potential, if given, from functions of all N displacements T q.

    The last two forces are kept: a scheme that takes the force at both ends of a step computes each but once. A
    potential is that of the force at rest, N(t, u, 0); the rest of the force is its damping.
    """

    T: Matrix
    force: Callable[..., Any]
    tangent: Callable[..., Any] | None
    potential: Callable[..., Any] | None
    kept: list[tuple[float, Array, Array, Array]] = field(default_factory=list, repr=False)
    evaluations: int = 0
    remembers: bool = False

    def __call__(self, t: float, u: Array, v: Array, recalled: Recalled | None = None) -> Array:
        """The internal force. Raises ValueError for a function that returns another shape."""
        for at, old_u, old_v, found in self.kept:
            if (
                np.array_equal(old_u, u)
                and (self.reads < 2 or np.array_equal(old_v, v))
                and (self.reads < 3 or at == t)
            ):
                return found
        self.evaluations += 1
        N = float_array("what internal_force returns", self._called(self.force, t, u, v))
        if N.shape != (self.T.shape[0],):
            raise ValueError(
                f"expected internal_force to return {self.T.shape[0]} numbers, one for each degree of freedom, got "
                f"shape {N.shape}; return an array"
            )
        found = self.T.T @ N
        self.kept = [(t, u.copy(), v.copy(), found), *self.kept[:1]]
        return found

    @cached_property
    def reads(self) -> int:
        """1 for N(u), 2 for N(u, v), 3 for N(t, u, v)."""
        return _arguments(self.force)

    def damping(self, t: float, u: Array, v: Array) -> Array:
        """What velocities add to the force (n,): N(t, u, v) - N(t, u, 0)."""
        if self.reads < 2:
            return np.zeros_like(u)
        at_rest = self(t, u, np.zeros_like(v))
        return self(t, u, v) - at_rest

    def damps(self, t: float, u: Array, v: Array) -> bool:
        """Whether the force is another one for v than at rest, by more than rounding."""
        added = float(np.abs(self.damping(t, u, v)).max())
        return added > ROUNDING * float(np.abs(self(t, u, v)).max())

    def at_start(self, u: Array, v: Array) -> tuple[Matrix, Matrix | None]:
        """What coefficients of schemes and Rayleigh damping know: `stiffness` at the start."""
        return self.stiffness(0.0, u, v)

    def stiffness(self, t: float, u: Array, v: Array, recalled: Recalled | None = None) -> tuple[Matrix, Matrix | None]:
        """The derivative of the force by u, and that by v where the user's function gives a pair."""
        assert self.tangent is not None  # schemes that need one were refused without
        found = self._called(self.tangent, t, u, v)
        parts = found if isinstance(found, tuple) else (found, None)
        K, C = (None if x is None else reduced(checked("the tangent", x, self.T.shape[0]), self.T) for x in parts)
        return K, C

    def energy(self, u: Array) -> float:
        """The potential. Raises ValueError where none was given."""
        if self.potential is None:
            raise ValueError(
                "expected potential= for this structure, got none; give the function whose slope the force is"
            )
        return real_number("what potential returns", self.potential(self.T @ u))

    def discrete_gradient(self, t: float, old: Array, new: Array, v: Array, mass: Matrix) -> Array:
        """Gonzalez (1996): the force at the midpoint, corrected along M (new - old): its work is the potential's.

        That is the force at rest; the damping at the midpoint, for v, is added to it.
        """
        change, half = new - old, 0.5 * (old + new)
        added = self.damping(t, half, v)
        middle = self(t, half, np.zeros_like(v))
        weight = mass @ change
        square = dot(change, weight)
        if square != 0.0:
            middle = middle + (self.energy(new) - self.energy(old) - dot(middle, change)) / square * weight
        return middle + added

    def _called(self, function: Callable[..., Any], t: float, u: Array, v: Array) -> Any:
        given = (t, self.T @ u, self.T @ v)
        return function(*{1: given[1:2], 2: given[1:], 3: given}[_arguments(function)])


def needed_arguments(function: Callable[..., Any]) -> int:
    """How many arguments a function cannot be called without."""
    kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    return sum(p.kind in kinds and p.default is p.empty for p in inspect.signature(function).parameters.values())


def _arguments(function: Callable[..., Any]) -> int:
    """How many of u, or u and v, or t, u and v a function takes."""
    needed = needed_arguments(function)
    if needed not in (1, 2, 3):
        raise ValueError(f"expected a function of u, of u and v, or of t, u and v, got one of {needed} arguments")
    return needed
