"""Nonlinear constraints of a structure: d functions g(u) of its displacements that reactions keep at 0."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ..solvers.matrices import Matrix
from .contacts import Named
from .internal_force import needed_arguments

KEPT = 1e-9  # of a gradient times the displacements, or the velocities: how far a start may be off the constraints
DEPENDENT = 1e-10  # of the largest singular value of the directions of gradients: with a smaller one they are dependent
NEAR = 1e-6  # of the displacements, or 1, to ask for gradients beside the start
ROUNDED = 1e-13  # of a gradient: a change within it is rounding
STATES, BESIDE = 2, 0.01  # how many displacements constraints are recognised by, and how far these are from the start
TURNED = 1e-5  # share by which gradients turn along the velocity, to find their rate by central differences
Given = Callable[[Array], Any]


@dataclass(frozen=True, eq=False)
class Held(Named):
    """d constraints g(u) = 0, with multipliers: the force of reactions is -G^T lambda, G = dg/du.

    functions: of each constraint, from the displacements (N,) of all degrees of freedom to g, a number or (s,), and G
    (N,) or (s, N). T (N, n): as in `Model`. names: of each its rows. length: over which gradients turn, 0 where none
    does; rounding of g is relative to it where displacements are small.
    """

    functions: tuple[Given, ...]
    T: Matrix
    names: Mapping[str, int | slice]
    size: int
    length: float
    kind = "constraints"
    remembered = True  # the acceleration that a scheme keeps is with that of the reactions

    def at(self, u: Array) -> tuple[Array, Array]:
        """The values g (d,) and gradients G (d, n) at u (n,) of the free degrees of freedom."""
        whole, values, gradients = self.T @ u, np.empty(self.size), np.empty((self.size, len(u)))
        for function, where in zip(self.functions, self.names.values(), strict=True):
            value, gradient = function(whole.copy())
            values[where], gradients[where] = value, gradient @ self.T
        return values, gradients

    def described(self, u: Array) -> tuple[Any, ...]:
        """What distinguishes them from others: values and gradients at the start u (n,) and beside it."""
        return repr(dict(self.names)), *(x for at in self._around(u) for x in self.at(at))

    def touched(self, u: Array) -> NDArray[np.bool_]:
        """Which degrees of freedom (n,) a gradient at the start u (n,), or beside it, has."""
        return np.any([self.at(at)[1].any(axis=0) for at in self._around(u)], axis=0)

    def _around(self, u: Array) -> list[Array]:
        random = np.random.default_rng(0)
        return [u, *(u + BESIDE * (self.length or 1.0) * random.normal(size=u.shape) for _ in range(STATES))]

    def gaps(self, u: Array) -> Array:
        """The values g (d,) at u (n,)."""
        return self.at(u)[0]

    def forces(self, u: Array, multipliers: Array) -> Array:
        """The force (n,) of multipliers (d,) at u (n,)."""
        return -multipliers @ self.at(u)[1]

    def multipliers(self, u: Array, v: Array, free: Array, solve_mass: Callable[[Array], Array]) -> Array:
        """Those (d,) with which the acceleration keeps g = 0 at u, v (n,), which without them is `free`.

        They follow from G a = -(dG/dt) v. solve_mass: M^-1 times vectors (n, d).
        """
        G = self.at(u)[1]
        return np.linalg.solve(G @ solve_mass(G.T), G @ free + self._turning(u, v))

    def _turning(self, u: Array, v: Array) -> Array:
        """(dG/dt) v (d,) along u + t v."""
        if not v.any():
            return np.zeros(self.size)

        def change(h: float) -> Array:
            return (self.at(u + h * v)[1] - self.at(u - h * v)[1]) / (2.0 * h)

        if self.length == 0.0:
            return np.zeros(self.size)
        return change(TURNED * self.length / float(np.abs(v).max())) @ v

    def require_kept(self, u: Array, v: Array) -> None:
        """Raises ValueError for a start off the constraints, or that leaves them, and for dependent constraints."""
        values, G = self.at(u)
        lengths = np.linalg.norm(G, axis=1)
        for what, found, of in (("g(u0) = 0", values, u), ("G v0 = 0", G @ v, v)):
            size = max(self.length if of is u else 0.0, float(np.abs(of).max()))
            if (off := np.flatnonzero(np.abs(found) > KEPT * lengths * size)).size:
                k = int(off[0])
                raise ValueError(
                    f"expected a start with {what} of constraint '{self.name_of(k)}', got {found[k]:.3g}; give u0 and "
                    "v0 that keep it"
                )
        for k in range(self.size):
            values = np.linalg.svd(G[: k + 1] / np.maximum(lengths[: k + 1, None], 1e-300), compute_uv=False)
            if len(values) <= k or values[-1] <= DEPENDENT * values[0]:
                raise ValueError(
                    f"expected independent constraints, got '{self.name_of(k)}' whose gradient at the start follows "
                    "from those before it, or is 0; leave it out"
                )


def held_of(given: Mapping[Any, Any], T: Matrix, u: Array) -> Held:
    """Constraints from what `structure` takes; u (n,): where a structure starts, T: of a `Model`.

    Raises ValueError for names and functions that are none, for functions of more than the displacements, for values
    or gradients of other shapes or not finite, and for a gradient that is not that of the values.
    """
    where, functions, first, whole = dict[str, int | slice](), list[Given](), 0, T @ u
    for name, function in given.items():
        if not isinstance(name, str) or not callable(function):
            raise ValueError(
                f"expected constraint {name!r} as a name with a function of the displacements, got "
                f"{type(function).__name__}; give such as {{'rod': lambda u: (u @ u - 1.0, 2.0 * u)}}"
            )
        if (needed := needed_arguments(function)) != 1:
            raise ValueError(
                f"expected constraint '{name}' as a function of the displacements, got one of {needed} arguments; what "
                "moves with time is the motion of a support, or a constraint of a scene"
            )
        value = _asked(name, function, whole)
        count = value.size
        where[name] = first if value.ndim == 0 else slice(first, first + count)
        functions.append(function)
        first += count
    found = Held(tuple(functions), T, where, first, 0.0)
    found = replace(found, length=_length(found, u))
    _require_gradients(found, u)
    return found


def _length(found: Held, u: Array) -> float:
    """The longest distance over which the gradient of a constraint turns by as much as it is; 0 where none turns."""
    direction = _direction(len(u))
    h = NEAR * max(1.0, float(np.abs(u).max()))
    (_, plus), (_, minus) = found.at(u + h * direction), found.at(u - h * direction)
    sizes, turned = np.linalg.norm(plus, axis=1), np.linalg.norm(plus - minus, axis=1)
    seen = turned > ROUNDED * sizes
    return float((2.0 * h * sizes[seen] / turned[seen]).max(initial=0.0))


def _direction(n: int) -> Array:
    """A direction (n,) that no constraint is likely to have, of unit length."""
    found = np.cos(1.0 + np.arange(float(n)))
    return found / np.linalg.norm(found)


def _asked(name: str, function: Given, u: Array) -> Array:
    found = function(u.copy())
    if not isinstance(found, tuple) or len(found) != 2:
        raise ValueError(
            f"expected constraint '{name}' to return its value and its gradient, got {type(found).__name__}; return "
            "(g, G)"
        )
    value, gradient = (np.asarray(x, dtype=float) for x in found)
    if value.ndim > 1 or gradient.shape != (*value.shape, len(u)):
        raise ValueError(
            f"expected constraint '{name}' to return a number and a gradient ({len(u)},), or (s,) and (s, {len(u)}), "
            f"got shapes {value.shape} and {gradient.shape}; return these"
        )
    if not (np.isfinite(value).all() and np.isfinite(gradient).all()):
        raise ValueError(f"expected finite values of constraint '{name}' at the start, got others; correct it there")
    return value


def _require_gradients(found: Held, u: Array) -> None:
    """Raises ValueError where a gradient is not the values' slope along one direction, by central differences."""
    direction, h = _direction(len(u)), NEAR * (max(found.length, float(np.abs(u).max())) or 1.0)
    (plus, _), (minus, _), gradients = found.at(u + h * direction), found.at(u - h * direction), found.at(u)[1]
    wrong = np.abs((plus - minus) / (2.0 * h) - gradients @ direction) > 1e-5 * np.linalg.norm(gradients, axis=1)
    if wrong.any():
        raise ValueError(
            f"expected constraint '{found.name_of(int(wrong.argmax()))}' to return the gradient of its value, got one "
            "that is not its slope at the start; correct it"
        )
